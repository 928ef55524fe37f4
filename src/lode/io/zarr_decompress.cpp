#include "lode/io/zarr_decompress.h"

#include <blosc.h>
#include <zstd.h>

#include <cstring>
#include <limits>

#include "lode/io/crc32c.h"
#include "lode/io/inflate.h"

namespace lode::io {
namespace {

Result<void> expect_size(const std::string& name, std::size_t expected, std::uint64_t n) {
  if (n == expected) return {};
  return fail("{}: expected a chunk of {} bytes, got {}", name, expected, n);
}

Result<void> decode_zstd(const std::string& name, std::span<const std::byte> stored,
                         std::span<std::byte> out) {
  const std::size_t n = ZSTD_decompress(out.data(), out.size(), stored.data(), stored.size());
  if (ZSTD_isError(n) != 0)
    return fail("{}: expected a chunk of {} bytes in zstd, got damaged or other data: {}", name,
                out.size(), ZSTD_getErrorName(n));
  return expect_size(name, out.size(), n);
}

Result<void> decode_blosc(const std::string& name, std::span<const std::byte> stored,
                          std::span<std::byte> out) {
  std::size_t n_bytes = 0;
  if (blosc_cbuffer_validate(stored.data(), stored.size(), &n_bytes) != 0)
    return fail("{}: expected {} bytes of Blosc data, got a header that says otherwise", name,
                stored.size());
  LODE_CHECK(expect_size(name, out.size(), n_bytes));
  // The function with its own context: the others share one behind a lock.
  const int n = blosc_decompress_ctx(stored.data(), out.data(), out.size(), 1);
  if (n <= 0)
    return fail("{}: expected a chunk of {} bytes in Blosc, got damaged data (error {})", name,
                out.size(), n);
  return expect_size(name, out.size(), static_cast<std::uint64_t>(n));
}

Result<void> decompress(const std::string& name, ZarrBytesCodec codec,
                        std::span<const std::byte> stored, std::span<std::byte> out) {
  switch (codec) {
    case ZarrBytesCodec::gzip:
    case ZarrBytesCodec::zlib: return inflate_block(stored, name, out);
    case ZarrBytesCodec::zstd: return decode_zstd(name, stored, out);
    case ZarrBytesCodec::blosc: return decode_blosc(name, stored, out);
    case ZarrBytesCodec::crc32c: break;
  }
  LODE_EXPECTS(codec != ZarrBytesCodec::crc32c);
  return {};
}

}  // namespace

Result<std::span<const std::byte>> without_checksum(const std::string& name,
                                                    std::span<const std::byte> stored) {
  if (stored.size() < kChecksumBytes)
    return fail("{}: expected a checksum of {} bytes, got {}", name, kChecksumBytes, stored.size());
  const auto content = stored.first(stored.size() - kChecksumBytes);
  std::uint32_t expected = 0;
  for (std::size_t i = 0; i < kChecksumBytes; ++i)
    expected |= std::to_integer<std::uint32_t>(stored[content.size() + i]) << (8 * i);
  const std::uint32_t sum = crc32c(content);
  if (sum != expected)
    return fail("{}: expected data with the CRC-32C {:08x}, got {:08x}", name, expected, sum);
  return content;
}

std::uint64_t max_decoded_bytes(ZarrBytesCodec codec, std::uint64_t n_stored) {
  // deflate: 258 bytes from 2 bits. zstd: a block of 128 KiB from 4 bytes; Blosc may hold such.
  const bool is_deflate = codec == ZarrBytesCodec::gzip || codec == ZarrBytesCodec::zlib;
  const std::uint64_t ratio = is_deflate ? 1032 : 32768;
  return n_stored < std::numeric_limits<std::uint64_t>::max() / ratio
             ? n_stored * ratio
             : std::numeric_limits<std::uint64_t>::max();
}

Result<void> decode_bytes(const std::string& name, std::span<const ZarrBytesCodec> codecs,
                          std::span<const std::byte> stored, std::span<std::byte> out) {
  while (!codecs.empty()) {
    const ZarrBytesCodec codec = codecs.back();
    codecs = codecs.first(codecs.size() - 1);
    if (codec == ZarrBytesCodec::crc32c) {
      LODE_TRY(stored, without_checksum(name, stored));
      continue;
    }
    if (codecs.empty()) return decompress(name, codec, stored, out);
    // All that is left are checksums.
    std::vector<std::byte> summed(out.size() + kChecksumBytes * codecs.size());
    LODE_CHECK(decompress(name, codec, stored, summed));
    return decode_bytes(name, codecs, summed, out);
  }
  LODE_CHECK(expect_size(name, out.size(), stored.size()));
  std::memcpy(out.data(), stored.data(), out.size());
  return {};
}

}  // namespace lode::io

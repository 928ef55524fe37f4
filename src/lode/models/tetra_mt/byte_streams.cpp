#include "lode/models/tetra_mt/byte_streams.h"

#include <algorithm>

#include "lode/store/codec.h"

namespace lode::tetra_mt {

void StreamWriter::add(std::span<const std::uint8_t> column) {
  std::vector<std::byte> packed;
  std::span<const std::byte> stored = std::as_bytes(column);
  if (std::ranges::all_of(column, [](std::uint8_t byte) { return byte == 0; })) {
    stored = {};
  } else {
    packed = store::zstd_compress(stored);
    if (packed.size() < stored.size()) stored = packed;
  }
  std::size_t size = stored.size();
  for (; size > 0x7F; size >>= 7) bytes_.push_back(static_cast<std::byte>(size | 0x80));
  bytes_.push_back(static_cast<std::byte>(size));
  bytes_.insert(bytes_.end(), stored.begin(), stored.end());
}

Result<std::vector<std::uint8_t>> StreamReader::read(std::size_t n) {
  std::size_t size = 0;
  constexpr int kMaxBits = 35;
  for (int shift = 0;; shift += 7) {
    if (at_ == bytes_.size() || shift > kMaxBits)
      return fail("{}: expected the size of a column at byte {}, got none", what_, at_);
    const auto byte = static_cast<std::size_t>(bytes_[at_++]);
    size |= (byte & 0x7F) << shift;
    if (byte <= 0x7F) break;
  }
  if (size > n || size > bytes_.size() - at_)
    return fail("{}: expected a column of up to {} bytes at byte {}, got {}", what_,
                std::min(n, bytes_.size() - at_), at_, size);
  const auto stored = bytes_.subspan(at_, size);
  at_ += size;
  std::vector<std::uint8_t> column(n, 0);
  const auto out = std::as_writable_bytes(std::span(column));
  if (size == n) {
    std::ranges::copy(stored, out.begin());
  } else if (size > 0) {
    if (auto done = store::zstd_decompress(stored, out); !done)
      return fail("{}: column up to byte {}: {}", what_, at_, done.error().message);
  }
  return column;
}

Result<void> StreamReader::expect_end() const {
  if (at_ == bytes_.size()) return {};
  return fail("{}: expected the end at byte {}, got {} more bytes", what_, at_,
              bytes_.size() - at_);
}

}  // namespace lode::tetra_mt

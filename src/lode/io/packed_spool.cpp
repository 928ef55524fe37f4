#include "lode/io/packed_spool.h"

#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

#include "lode/core/expects.h"

namespace lode::io {
namespace {

/// The fastest that still finds what scans repeat.
constexpr int kLevel = 1;

}  // namespace

struct PackedSpool::Coder {
  Coder() : compressor(ZSTD_createCCtx()), decompressor(ZSTD_createDCtx()) {
    if (compressor == nullptr || decompressor == nullptr) {
      free();
      throw std::bad_alloc();
    }
  }
  Coder(const Coder&) = delete;
  Coder& operator=(const Coder&) = delete;
  ~Coder() { free(); }

  void free() const {
    ZSTD_freeCCtx(compressor);
    ZSTD_freeDCtx(decompressor);
  }

  ZSTD_CCtx* compressor;
  ZSTD_DCtx* decompressor;
};

Result<PackedSpool> PackedSpool::create(const std::string& directory, IoTallyPtr tally) {
  LODE_TRY(SpoolFile file, SpoolFile::create(directory, std::move(tally)));
  return PackedSpool(std::move(file), std::make_unique<Coder>());
}

PackedSpool::PackedSpool(SpoolFile file, std::unique_ptr<Coder> coder)
    : file_(std::move(file)), coder_(std::move(coder)) {
  last_.reserve(kBlockBytes);
  joined_.reserve(kBlockBytes);
  cached_.reserve(kBlockBytes);
  packed_.resize(ZSTD_compressBound(kBlockBytes));
}

PackedSpool::PackedSpool(PackedSpool&& other) noexcept = default;
PackedSpool::~PackedSpool() = default;

Result<void> PackedSpool::append(std::span<const std::byte> bytes) {
  while (last_.size() + bytes.size() >= kBlockBytes) {
    const std::size_t n = kBlockBytes - last_.size();
    if (last_.empty()) {
      LODE_CHECK(write_block(bytes.first(n)));
    } else {
      joined_ = last_;
      joined_.insert(joined_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n));
      LODE_CHECK(write_block(joined_));
      last_.clear();
    }
    bytes = bytes.subspan(n);
  }
  last_.insert(last_.end(), bytes.begin(), bytes.end());
  return {};
}

/// A block that does not shrink is written as it is.
Result<void> PackedSpool::write_block(std::span<const std::byte> block) {
  const std::size_t n = ZSTD_compressCCtx(coder_->compressor, packed_.data(), packed_.size(),
                                          block.data(), block.size(), kLevel);
  if (ZSTD_isError(n) != 0) throw std::bad_alloc();  // all else has room
  if (ends_.size() == ends_.capacity()) ends_.reserve(2 * ends_.size() + 64);
  LODE_CHECK(file_.append(n < block.size() ? std::span<const std::byte>(packed_).first(n) : block));
  ends_.push_back(file_.size());
  return {};
}

Result<void> PackedSpool::read(std::uint64_t offset, std::span<std::byte> out) {
  LODE_EXPECTS(offset <= size() && out.size() <= size() - offset);
  while (!out.empty()) {
    const auto block = static_cast<std::size_t>(offset / kBlockBytes);
    const auto begin = static_cast<std::size_t>(offset % kBlockBytes);
    const std::size_t n = std::min(out.size(), kBlockBytes - begin);
    if (block == ends_.size()) {
      std::memcpy(out.data(), last_.data() + begin, n);
    } else if (n_packed(block) == kBlockBytes) {
      LODE_CHECK(file_.read(begin_of(block) + begin, out.first(n)));
    } else if (n == kBlockBytes) {
      LODE_CHECK(read_block(block, out.first(n)));
    } else {
      if (cached_.empty() || cached_block_ != block) {
        cached_.resize(kBlockBytes);
        auto status = read_block(block, cached_);
        if (!status) {
          cached_.clear();
          return status;
        }
        cached_block_ = block;
      }
      std::memcpy(out.data(), cached_.data() + begin, n);
    }
    offset += n;
    out = out.subspan(n);
  }
  return {};
}

/// One that was compressed.
Result<void> PackedSpool::read_block(std::size_t block, std::span<std::byte> out) {
  const std::span<std::byte> packed = std::span(packed_).first(n_packed(block));
  LODE_CHECK(file_.read(begin_of(block), packed));
  const std::size_t n = ZSTD_decompressDCtx(coder_->decompressor, out.data(), out.size(),
                                            packed.data(), packed.size());
  if (n != out.size()) return fail("a spool file does not have what was written to it");
  return {};
}

}  // namespace lode::io

#include "lode/io/spool_buffer.h"

#include <algorithm>
#include <cstring>

#include "lode/core/expects.h"

namespace lode::io {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;

/// The part of a patch that lies in a piece which starts at `offset`.
void apply(const std::span<const std::byte> patch, std::uint64_t at, std::uint64_t offset,
           std::span<std::byte> piece) {
  const std::uint64_t begin = std::max(at, offset);
  const std::uint64_t end = std::min(at + patch.size(), offset + piece.size());
  if (begin < end) std::memcpy(&piece[begin - offset], &patch[begin - at], end - begin);
}

}  // namespace

Result<void> SpoolBuffer::write(std::span<const std::byte> bytes) {
  if (!file_ && size_ + bytes.size() > memory_bytes_) {
    LODE_TRY(SpoolFile file, SpoolFile::create(directory_, std::make_shared<IoTally>()));
    for (const auto& chunk : chunks_) LODE_CHECK(file.append(chunk));
    chunks_ = {};
    file_.emplace(std::move(file));
  }
  size_ += bytes.size();
  if (file_) return file_->append(bytes);
  while (!bytes.empty()) {
    if (chunks_.empty() || chunks_.back().size() == kChunkBytes)
      chunks_.emplace_back().reserve(kChunkBytes);
    std::vector<std::byte>& chunk = chunks_.back();
    const auto n = static_cast<std::ptrdiff_t>(std::min(bytes.size(), kChunkBytes - chunk.size()));
    chunk.insert(chunk.end(), bytes.begin(), bytes.begin() + n);
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return {};
}

void SpoolBuffer::replace(std::uint64_t offset, std::span<const std::byte> bytes) {
  LODE_EXPECTS(bytes.size() <= kMostReplaced);
  Patch& patch = patches_.emplace_back();
  patch.offset = offset;
  patch.n_bytes = static_cast<std::uint32_t>(bytes.size());
  std::ranges::copy(bytes, patch.bytes.begin());
}

Result<void> SpoolBuffer::read_at(std::uint64_t offset, std::span<std::byte> out) const {
  if (file_) return file_->read(offset, out);
  while (!out.empty()) {
    const std::vector<std::byte>& chunk = chunks_[offset / kChunkBytes];
    const std::size_t begin = offset % kChunkBytes;
    const std::size_t n = std::min(out.size(), chunk.size() - begin);
    std::memcpy(out.data(), &chunk[begin], n);
    out = out.subspan(n);
    offset += n;
  }
  return {};
}

Result<void> SpoolBuffer::read(
    std::size_t record_bytes,
    const std::function<Result<void>(std::span<const std::byte>)>& use) const {
  std::vector<const Patch*> patches;
  patches.reserve(patches_.size());
  for (const Patch& patch : patches_) patches.push_back(&patch);
  std::sort(patches.begin(), patches.end(),
            [](const Patch* a, const Patch* b) { return a->offset < b->offset; });
  std::vector<std::byte> piece(std::max(kChunkBytes / record_bytes, std::size_t{1}) * record_bytes);
  auto patch = patches.begin();
  for (std::uint64_t offset = 0; offset < size_; offset += piece.size()) {
    piece.resize(std::min<std::uint64_t>(piece.size(), size_ - offset));
    LODE_CHECK(read_at(offset, piece));
    for (; patch != patches.end() && (*patch)->offset < offset + piece.size(); ++patch) {
      apply(std::span((*patch)->bytes).first((*patch)->n_bytes), (*patch)->offset, offset, piece);
      if ((*patch)->offset + (*patch)->n_bytes > offset + piece.size()) break;  // the rest
    }
    LODE_CHECK(use(piece));
  }
  return {};
}

}  // namespace lode::io

#include "lode/io/patched_spool.h"

#include <algorithm>
#include <cstring>

#include "lode/core/expects.h"

namespace lode::io {
namespace {

/// The part of a patch that lies in a piece which starts at `offset`.
void apply(const std::span<const std::byte> patch, std::uint64_t at, std::uint64_t offset,
           std::span<std::byte> piece) {
  const std::uint64_t begin = std::max(at, offset);
  const std::uint64_t end = std::min(at + patch.size(), offset + piece.size());
  if (begin < end) std::memcpy(&piece[begin - offset], &patch[begin - at], end - begin);
}

}  // namespace

Result<void> PatchedSpool::write(std::span<const std::byte> bytes) {
  if (bytes.empty()) return {};
  if (!file_) {
    LODE_TRY(SpoolFile file, SpoolFile::create(directory_, std::make_shared<IoTally>()));
    file_.emplace(std::move(file));
  }
  size_ += bytes.size();
  return file_->append(bytes);
}

void PatchedSpool::replace(std::uint64_t offset, std::span<const std::byte> bytes) {
  LODE_EXPECTS(bytes.size() <= kMostReplaced && offset + bytes.size() <= size_);
  Patch& patch = patches_.emplace_back();
  patch.offset = offset;
  patch.n_bytes = static_cast<std::uint32_t>(bytes.size());
  std::ranges::copy(bytes, patch.bytes.begin());
}

Result<void> PatchedSpool::read(
    std::size_t record_bytes,
    const std::function<Result<void>(std::span<const std::byte>)>& use) const {
  constexpr std::size_t kPieceBytes = std::size_t{1} << 20;
  std::vector<const Patch*> patches;
  patches.reserve(patches_.size());
  for (const Patch& patch : patches_) patches.push_back(&patch);
  std::sort(patches.begin(), patches.end(),
            [](const Patch* a, const Patch* b) { return a->offset < b->offset; });
  std::vector<std::byte> piece(std::max(kPieceBytes / record_bytes, std::size_t{1}) * record_bytes);
  auto patch = patches.begin();
  for (std::uint64_t offset = 0; offset < size_; offset += piece.size()) {
    piece.resize(std::min<std::uint64_t>(piece.size(), size_ - offset));
    LODE_CHECK(file_->read(offset, piece));
    for (; patch != patches.end() && (*patch)->offset < offset + piece.size(); ++patch) {
      apply(std::span((*patch)->bytes).first((*patch)->n_bytes), (*patch)->offset, offset, piece);
      if ((*patch)->offset + (*patch)->n_bytes > offset + piece.size()) break;  // the rest
    }
    LODE_CHECK(use(piece));
  }
  return {};
}

}  // namespace lode::io

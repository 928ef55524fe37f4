#include "lode/io/vtk_xml_blocks.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <utility>

#include "lode/io/inflate.h"

namespace lode::io {
namespace {

/// VTK's own blocks have 32 KiB. A box of some hundred rows reads a multiple of this from a slice,
/// so that blocks at its rim are a small part of what is decoded.
constexpr std::uint64_t kMaxSmall = std::uint64_t{1} << 18;

std::uint64_t count_in(std::span<const std::byte> bytes, ByteOrder order) {
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const std::size_t at = order == ByteOrder::big ? i : bytes.size() - 1 - i;
    count = count << 8 | static_cast<std::uint64_t>(bytes[at]);
  }
  return count;
}

/// A part of another stream.
class PartStream final : public ByteStream {
 public:
  PartStream(ByteStream& whole, std::uint64_t n_bytes, std::string path)
      : whole_(whole), n_left_(n_bytes), path_(std::move(path)) {}

  Result<void> read(std::span<std::byte> out) override {
    if (out.size() > n_left_)
      return fail("{}: expected {} more bytes of a compressed block, got {}", path_, out.size(),
                  n_left_);
    LODE_CHECK(whole_.read(out));
    n_left_ -= out.size();
    return {};
  }

  std::uint64_t n_left() const override { return n_left_; }

 private:
  ByteStream& whole_;
  std::uint64_t n_left_;
  std::string path_;
};

class BlockStream final : public ByteStream {
 public:
  BlockStream(std::unique_ptr<ByteStream> compressed, VtkBlocks blocks)
      : compressed_(std::move(compressed)), blocks_(std::move(blocks)) {}

  Result<void> read(std::span<std::byte> out) override {
    LODE_EXPECTS(out.size() <= n_left());
    while (!out.empty()) {
      if (!inflated_) start_block();
      const std::uint64_t n_decoded = blocks_.n_decoded(block_);
      const auto n = static_cast<std::size_t>(
          std::min<std::uint64_t>(out.size(), n_decoded - n_done_in_block_));
      LODE_TRY(const std::size_t n_read, inflated_->read_some(out.first(n)));
      n_done_in_block_ += n_read;
      n_done_ += n_read;
      if (n_read < n)
        return fail("{}: expected a compressed block of {} bytes, got {} bytes", blocks_.path,
                    n_decoded, n_done_in_block_);
      out = out.subspan(n);
      if (n_done_in_block_ == n_decoded) LODE_CHECK(end_block());
    }
    return {};
  }

  std::uint64_t n_left() const override { return blocks_.n_bytes - n_done_; }

 private:
  void start_block() {
    auto part =
        std::make_unique<PartStream>(*compressed_, blocks_.n_compressed(block_), blocks_.path);
    part_ = part.get();
    inflated_ = std::make_unique<InflateStream>(std::move(part), blocks_.path);
    n_done_in_block_ = 0;
  }

  Result<void> end_block() {
    std::array<std::byte, 1> extra;
    LODE_TRY(const std::size_t n_extra, inflated_->read_some(extra));
    if (n_extra > 0)
      return fail("{}: expected a compressed block of {} bytes, got more bytes", blocks_.path,
                  blocks_.n_decoded(block_));
    LODE_CHECK(compressed_->skip(part_->n_left()));
    inflated_.reset();
    ++block_;
    return {};
  }

  std::unique_ptr<ByteStream> compressed_;
  VtkBlocks blocks_;
  std::size_t block_ = 0;
  std::unique_ptr<InflateStream> inflated_;  ///< Of this block; none between blocks.
  const PartStream* part_ = nullptr;         ///< What inflated_ reads from.
  std::uint64_t n_done_in_block_ = 0;
  std::uint64_t n_done_ = 0;
};

class BlockStore final : public SampleStore {
 public:
  BlockStore(InputFilePtr file, std::uint64_t offset, VtkBlocks blocks)
      : file_(std::move(file)), offset_(offset), blocks_(std::move(blocks)) {}

  Result<void> read(std::uint64_t offset, std::span<std::byte> out) override {
    LODE_EXPECTS(offset <= blocks_.n_bytes && out.size() <= blocks_.n_bytes - offset);
    while (!out.empty()) {
      const auto block = static_cast<std::size_t>(
          std::min<std::uint64_t>(offset / blocks_.n_bytes_each, blocks_.ends.size() - 1));
      const auto n_decoded = static_cast<std::size_t>(blocks_.n_decoded(block));
      const auto skipped = static_cast<std::size_t>(offset - block * blocks_.n_bytes_each);
      const std::size_t n = std::min(out.size(), n_decoded - skipped);
      if (n == n_decoded) {
        LODE_CHECK(decode(block, out.first(n)));
      } else {
        LODE_CHECK(remember(block));
        std::memcpy(out.data(), decoded_.data() + skipped, n);
      }
      out = out.subspan(n);
      offset += n;
    }
    return {};
  }

 private:
  Result<void> decode(std::size_t block, std::span<std::byte> out) {
    compressed_.resize(static_cast<std::size_t>(blocks_.n_compressed(block)));
    LODE_CHECK(file_->read(offset_ + blocks_.begin_of(block), compressed_));
    return inflate_block(compressed_, blocks_.path, out);
  }

  Result<void> remember(std::size_t block) {
    if (remembered_ == block) return {};
    remembered_.reset();
    decoded_.resize(static_cast<std::size_t>(blocks_.n_decoded(block)));
    LODE_CHECK(decode(block, decoded_));
    remembered_ = block;
    return {};
  }

  InputFilePtr file_;
  std::uint64_t offset_;
  VtkBlocks blocks_;
  std::vector<std::byte> compressed_;
  std::vector<std::byte> decoded_;
  std::optional<std::size_t> remembered_;  ///< The block in decoded_.
};

/// The compressed sizes, summed up.
Result<std::vector<std::uint64_t>> read_ends(const std::string& path, ByteStream& stream,
                                             VtkCounts counts, std::uint64_t n_blocks) {
  std::vector<std::byte> table(static_cast<std::size_t>(n_blocks) * counts.n_bytes);
  LODE_CHECK(stream.read(table));
  std::vector<std::uint64_t> ends(static_cast<std::size_t>(n_blocks));
  std::uint64_t end = 0;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const std::uint64_t n =
        count_in(std::span(table).subspan(i * counts.n_bytes, counts.n_bytes), counts.byte_order);
    if (n > stream.n_left() - end)
      return fail("{}: expected a compressed block of {} bytes, but only {} follow", path, n,
                  stream.n_left() - end);
    end += n;
    ends[i] = end;
  }
  return ends;
}

}  // namespace

bool VtkBlocks::are_small() const {
  const auto is_small = [](std::uint64_t n) { return n > 0 && n <= kMaxSmall; };
  if (!is_small(n_bytes_each) || !is_small(n_bytes_last)) return false;
  // zlib makes incompressible blocks longer by much less than half.
  for (std::size_t i = 0; i < ends.size(); ++i)
    if (n_compressed(i) > kMaxSmall / 2 * 3) return false;
  return true;
}

Result<std::uint64_t> read_vtk_count(ByteStream& stream, VtkCounts counts) {
  std::array<std::byte, 8> bytes{};
  const auto used = std::span(bytes).first(counts.n_bytes);
  LODE_CHECK(stream.read(used));
  return count_in(used, counts.byte_order);
}

Result<VtkBlocks> read_vtk_blocks(const std::string& path, ByteStream& stream, VtkCounts counts,
                                  std::uint64_t n_bytes) {
  LODE_TRY(const std::uint64_t n_blocks, read_vtk_count(stream, counts));
  LODE_TRY(const std::uint64_t block, read_vtk_count(stream, counts));
  LODE_TRY(const std::uint64_t partial, read_vtk_count(stream, counts));
  const std::uint64_t n_full = n_blocks - (partial > 0 && n_blocks > 0 ? 1 : 0);
  const bool fits =
      n_blocks > 0 && partial <= n_bytes && (n_full == 0 || block <= n_bytes / n_full);
  if (!fits || n_full * block + partial != n_bytes)
    return fail("{}: expected compressed blocks of {} bytes in all, got {} of {} and {} more", path,
                n_bytes, n_full, block, partial);
  if (n_blocks > stream.n_left() / counts.n_bytes)
    return fail("{}: expected {} compressed blocks, but only {} bytes follow", path, n_blocks,
                stream.n_left());
  VtkBlocks blocks{.path = path,
                   .ends = {},
                   .n_bytes_each = block,
                   .n_bytes_last = partial > 0 ? partial : block,
                   .n_bytes = n_bytes};
  LODE_TRY(blocks.ends, read_ends(path, stream, counts, n_blocks));
  LODE_CHECK(check_inflated_size(path, n_bytes, blocks.ends.back()));
  return blocks;
}

std::unique_ptr<ByteStream> make_vtk_block_stream(std::unique_ptr<ByteStream> compressed,
                                                  VtkBlocks blocks) {
  return std::make_unique<BlockStream>(std::move(compressed), std::move(blocks));
}

std::unique_ptr<SampleStore> make_vtk_block_store(InputFilePtr file, std::uint64_t offset,
                                                  VtkBlocks blocks) {
  LODE_EXPECTS(blocks.are_small());
  return std::make_unique<BlockStore>(std::move(file), offset, std::move(blocks));
}

}  // namespace lode::io

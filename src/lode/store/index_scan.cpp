#include "lode/store/index_scan.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "lode/store/block_index.h"
#include "lode/store/checksum.h"
#include "lode/store/codec.h"

namespace lode::store {
namespace {

constexpr std::uint64_t kWindowBytes = std::uint64_t{1} << 20;

/// Finds marks from one place to the next, reading each byte once.
class MarkFinder {
 public:
  explicit MarkFinder(const IndexedFile& file) : file_(file) {}

  /// The first mark at `from` or later that has room for a head; `from` never goes down.
  std::optional<std::uint64_t> find(std::uint64_t from) {
    const auto mark = std::as_bytes(std::span(kIndexMark));
    while (from + kIndexHeadBytes <= file_.size) {
      if (from < begin_ || from + mark.size() > begin_ + window_.size()) load(from);
      const auto first = window_.begin() + static_cast<std::ptrdiff_t>(from - begin_);
      const auto at = std::search(first, window_.end(), mark.begin(), mark.end());
      if (at != window_.end()) {
        from = begin_ + static_cast<std::uint64_t>(at - window_.begin());
        if (from + kIndexHeadBytes > file_.size) return std::nullopt;
        return from;
      }
      // A mark may begin in the last bytes.
      from = begin_ + window_.size() - (mark.size() - 1);
    }
    return std::nullopt;
  }

 private:
  void load(std::uint64_t from) {
    begin_ = from;
    window_.resize(static_cast<std::size_t>(std::min(kWindowBytes, file_.size - from)));
    // Where nothing can be read there is no mark.
    if (!file_.read_at(from, window_)) std::ranges::fill(window_, std::byte{0});
  }

  const IndexedFile& file_;
  std::uint64_t begin_ = 0;
  std::vector<std::byte> window_;
};

/// Reads indexes. Whatever heads say, the frames that are read are no longer than the file
/// together, and what is decoded of them takes no more than the memory limit.
class IndexReader {
 public:
  explicit IndexReader(const IndexedFile& file)
      : file_(file), n_stored_left_(file.size), memory_left_(file.memory_limit) {}

  /// The index that lies there, if a whole one does.
  std::optional<Directory> read(std::uint64_t offset) {
    std::array<std::byte, kIndexHeadBytes> bytes{};
    if (offset + bytes.size() > file_.size || !file_.read_at(offset, bytes)) return std::nullopt;
    const auto head = decode_index_head(bytes);
    if (!head || head->offset != offset) return std::nullopt;
    const std::uint64_t begin = offset + kIndexHeadBytes;
    if (head->stored_size > std::min(file_.size - begin, n_stored_left_) ||
        head->raw_size > memory_left_ || head->raw_size / kMaxZstdRatio > head->stored_size)
      return std::nullopt;
    n_stored_left_ -= head->stored_size;
    std::vector<std::byte> stored(static_cast<std::size_t>(head->stored_size));
    if (!file_.read_at(begin, stored) || checksum(stored) != head->checksum) return std::nullopt;
    return decode(*head, stored);
  }

 private:
  std::optional<Directory> decode(const IndexHead& head, std::span<const std::byte> stored) {
    std::vector<std::byte> raw(static_cast<std::size_t>(head.raw_size));
    if (!zstd_decompress(stored, raw)) return std::nullopt;
    auto run = decode_run(raw, {.path = file_.path,
                                .blocks_begin = head.offset + kIndexHeadBytes + stored.size(),
                                .blocks_end = UINT64_MAX,
                                .memory_limit = memory_left_});
    if (!run || run->blocks.empty()) return std::nullopt;
    memory_left_ -= run->blocks.size() * kEntryMemory;
    return std::move(*run);
  }

  const IndexedFile& file_;
  std::uint64_t n_stored_left_;
  std::uint64_t memory_left_;
};

/// Of blocks with the same key the first stays.
void remove_repeated(std::vector<BlockEntry>& blocks) {
  const std::vector<std::size_t> order = order_by_key(blocks);
  std::vector<bool> is_repeated(blocks.size(), false);
  for (std::size_t i = 1; i < order.size(); ++i)
    is_repeated[order[i]] = blocks[order[i - 1]].key == blocks[order[i]].key;
  std::size_t n = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i)
    if (!is_repeated[i]) blocks[n++] = blocks[i];
  blocks.resize(n);
}

}  // namespace

Directory scan_indexes(const IndexedFile& file) {
  Directory all;
  MarkFinder marks(file);
  IndexReader indexes(file);
  std::optional<std::uint64_t> at = kHeaderBytes;
  while (at && *at < file.size) {
    auto run = indexes.read(*at);
    if (!run) {
      at = marks.find(*at + 1);
      continue;
    }
    at = end_of(run->blocks);  // where the next one lies in a whole file
    if (all.blocks.empty())
      all = std::move(*run);
    else if (run->model == all.model && run->metadata == all.metadata)
      all.blocks.insert(all.blocks.end(), run->blocks.begin(), run->blocks.end());
  }
  remove_repeated(all.blocks);
  return all;
}

}  // namespace lode::store

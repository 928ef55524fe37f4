#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "lode/store/reader.h"

namespace lode::store {

/// Decoded blocks of a file, those used last: at most so many bytes of them beside what its users
/// hold. Safe from many threads.
class BlockCache {
 public:
  using Bytes = std::shared_ptr<const std::vector<std::byte>>;

  /// `reader` must outlive it.
  BlockCache(const Reader& reader, std::uint64_t max_bytes)
      : reader_(reader), max_bytes_(max_bytes) {}

  [[nodiscard]] const Reader& reader() const { return reader_; }
  /// Block i of the file, which is read, checked and decoded unless it is there.
  [[nodiscard]] Result<Bytes> block(std::size_t i);

  /// Block i will be asked for soon; returns at once.
  void will_need(std::size_t i) const;

  /// Stored bytes read so far, and how many blocks they were.
  [[nodiscard]] std::uint64_t n_bytes_read() const;
  [[nodiscard]] std::uint64_t n_blocks_read() const;

 private:
  using Place = std::list<std::pair<std::size_t, Bytes>>::iterator;

  void put(std::size_t i, const Bytes& bytes);

  const Reader& reader_;
  std::uint64_t max_bytes_;
  mutable std::mutex mutex_;
  std::list<std::pair<std::size_t, Bytes>> blocks_;  ///< Used last first.
  std::unordered_map<std::size_t, Place> places_;
  std::uint64_t n_bytes_ = 0;
  std::uint64_t n_bytes_read_ = 0;
  std::uint64_t n_blocks_read_ = 0;
};

}  // namespace lode::store

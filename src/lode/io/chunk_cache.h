#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

namespace lode::io {

/// Decoded chunks that later reads will want, up to a number of bytes. All members may be called
/// from any thread. What one read used or added is not evicted during that read: where the chunks
/// of a slab do not all fit, some stay for the next one instead of each driving out another.
class ChunkCache {
 public:
  using Bytes = std::shared_ptr<const std::vector<std::byte>>;

  explicit ChunkCache(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  /// From here on, what came before may be evicted.
  void begin_read();
  /// Null where the chunk is not held.
  [[nodiscard]] Bytes find(std::int64_t chunk);
  /// Keeps the chunk if there is, or can be made, room for it.
  void add(std::int64_t chunk, Bytes bytes);

 private:
  struct Entry {
    std::int64_t chunk;
    Bytes bytes;
    std::uint64_t last_read;
  };
  [[nodiscard]] bool make_room(std::size_t n_bytes);

  std::mutex mutex_;
  std::size_t max_bytes_;
  std::size_t n_bytes_ = 0;
  std::uint64_t read_ = 0;
  std::list<Entry> entries_;  ///< The last used one first.
  std::map<std::int64_t, std::list<Entry>::iterator> places_;
};

}  // namespace lode::io

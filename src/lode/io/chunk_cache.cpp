#include "lode/io/chunk_cache.h"

namespace lode::io {

void ChunkCache::begin_read() {
  const std::lock_guard lock(mutex_);
  ++read_;
}

ChunkCache::Bytes ChunkCache::find(std::int64_t chunk) {
  const std::lock_guard lock(mutex_);
  const auto found = places_.find(chunk);
  if (found == places_.end()) return nullptr;
  found->second->last_read = read_;
  entries_.splice(entries_.begin(), entries_, found->second);
  return found->second->bytes;
}

void ChunkCache::add(std::int64_t chunk, Bytes bytes) {
  const std::lock_guard lock(mutex_);
  if (places_.contains(chunk) || !make_room(bytes->size())) return;
  decltype(entries_) entry{{chunk, std::move(bytes), read_}};
  places_.try_emplace(chunk, entry.begin());
  entries_.splice(entries_.begin(), entry);  // nothing can fail any more
  n_bytes_ += entries_.front().bytes->size();
}

bool ChunkCache::make_room(std::size_t n_bytes) {
  if (n_bytes > max_bytes_) return false;
  while (n_bytes_ + n_bytes > max_bytes_) {
    if (entries_.back().last_read == read_) return false;
    n_bytes_ -= entries_.back().bytes->size();
    places_.erase(entries_.back().chunk);
    entries_.pop_back();
  }
  return true;
}

}  // namespace lode::io

#include "lode/store/block_cache.h"

namespace lode::store {

Result<BlockCache::Bytes> BlockCache::block(std::size_t i) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = places_.find(i); found != places_.end()) {
      blocks_.splice(blocks_.begin(), blocks_, found->second);
      return found->second->second;
    }
  }
  LODE_TRY(auto decoded, reader_.read_block(i));
  const Bytes bytes = std::make_shared<const std::vector<std::byte>>(std::move(decoded));
  put(i, bytes);
  return bytes;
}

void BlockCache::will_need(std::size_t i) const {
  {
    const std::lock_guard lock(mutex_);
    if (places_.contains(i)) return;
  }
  reader_.will_read(i);
}

void BlockCache::put(std::size_t i, const Bytes& bytes) {
  const std::lock_guard lock(mutex_);
  n_bytes_read_ += reader_.blocks()[i].stored_size;
  ++n_blocks_read_;
  if (places_.contains(i)) return;      // another thread was first
  decltype(blocks_) block{{i, bytes}};  // joins the others once nothing can fail
  places_.try_emplace(i, block.begin());
  blocks_.splice(blocks_.begin(), block);
  n_bytes_ += bytes->size();
  while (n_bytes_ > max_bytes_ && !blocks_.empty()) {
    n_bytes_ -= blocks_.back().second->size();
    places_.erase(blocks_.back().first);
    blocks_.pop_back();
  }
}

std::uint64_t BlockCache::n_bytes_read() const {
  const std::lock_guard lock(mutex_);
  return n_bytes_read_;
}

std::uint64_t BlockCache::n_blocks_read() const {
  const std::lock_guard lock(mutex_);
  return n_blocks_read_;
}

}  // namespace lode::store

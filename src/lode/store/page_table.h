#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace lode::store {

/// Numbered pages in memory. Pages that somebody holds stay; of the others those that were let go
/// first go first when room is made. One thread puts and removes pages, all others may hold them.
template <typename T>
class PageTable {
 public:
  using Page = std::uint32_t;

  void resize(std::size_t n_pages) {
    owned_.resize(n_pages);
    pages_ = std::vector<std::atomic<const T*>>(n_pages);
    n_holders_ = std::vector<std::atomic<std::uint32_t>>(n_pages);
    idle_.resize(n_pages + 1);
    for (std::size_t i = 0; i < idle_.size(); ++i)
      idle_[i] = {static_cast<Page>(i), static_cast<Page>(i)};
  }
  [[nodiscard]] std::size_t size() const { return pages_.size(); }

  /// Null if it is not there. Who reads it must hold it.
  [[nodiscard]] const T* at(Page page) const {
    return pages_[page].load(std::memory_order_acquire);
  }
  /// False if it is not there; else it stays until let_go().
  [[nodiscard]] bool hold(Page page) const {
    // Sequential order: either remove() sees the holder, or the holder sees that it has gone.
    n_holders_[page].fetch_add(1, std::memory_order_seq_cst);
    if (pages_[page].load(std::memory_order_seq_cst) != nullptr) return true;
    // Put in the meantime, it may have been passed over as held.
    if (n_holders_[page].fetch_sub(1, std::memory_order_seq_cst) == 1 &&
        pages_[page].load(std::memory_order_seq_cst) != nullptr)
      list_idle(page);
    return false;
  }
  void let_go(Page page) const {
    if (n_holders_[page].fetch_sub(1, std::memory_order_seq_cst) != 1) return;
    list_idle(page);
  }

  // For the one thread.

  [[nodiscard]] bool has(Page page) const { return owned_[page].page != nullptr; }
  [[nodiscard]] std::size_t n_bytes() const { return n_bytes_; }
  void put(Page page, std::unique_ptr<const T> content, std::size_t n_bytes) {
    owned_[page] = {std::move(content), n_bytes};
    n_bytes_ += n_bytes;
    pages_[page].store(owned_[page].page.get(), std::memory_order_seq_cst);
    list_idle(page);
  }
  /// Removes pages that nobody holds until all take at most max_bytes, or none is left. `leaves`
  /// is told of each before it goes, `stays` if somebody has taken hold of it meanwhile.
  template <typename Leaves, typename Stays>
  void shrink(std::size_t max_bytes, const Leaves& leaves, const Stays& stays) {
    while (n_bytes_ > max_bytes) {
      Page page = 0;
      {
        const std::lock_guard lock(mutex_);
        page = idle_.back().next;
        if (page == size()) return;
        unlink(page);
      }
      // Held ones come again when they are let go.
      if (!has(page) || n_holders_[page].load(std::memory_order_seq_cst) > 0) continue;
      leaves(page);
      pages_[page].store(nullptr, std::memory_order_seq_cst);
      if (n_holders_[page].load(std::memory_order_seq_cst) > 0) {
        pages_[page].store(owned_[page].page.get(), std::memory_order_seq_cst);
        stays(page);
        list_idle(page);  // who saw it gone lets nothing go
        continue;
      }
      n_bytes_ -= owned_[page].n_bytes;
      owned_[page] = {};
    }
  }

 private:
  struct Owned {
    std::unique_ptr<const T> page;
    std::size_t n_bytes = 0;
  };

  struct Link {
    Page previous = 0;
    Page next = 0;
  };

  /// Behind all others, wherever it was.
  void list_idle(Page page) const {
    const std::lock_guard lock(mutex_);
    unlink(page);
    const auto end = static_cast<Page>(size());
    const Page last = idle_[end].previous;
    idle_[page] = {last, end};
    idle_[last].next = page;
    idle_[end].previous = page;
  }
  void unlink(Page page) const {
    const Link link = idle_[page];
    idle_[link.previous].next = link.next;
    idle_[link.next].previous = link.previous;
    idle_[page] = {page, page};
  }

  std::vector<Owned> owned_;                  ///< By number.
  std::vector<std::atomic<const T*>> pages_;  ///< The same, for all.
  mutable std::vector<std::atomic<std::uint32_t>> n_holders_;
  std::size_t n_bytes_ = 0;
  mutable std::mutex mutex_;
  /// A list of pages in the order in which they were let go; some are held again. The last link is
  /// its two ends; a page that is not listed has itself beside it. Letting go takes no memory.
  mutable std::vector<Link> idle_;
};

}  // namespace lode::store

#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "lode/core/out_of_memory.h"
#include "lode/core/uninitialized_array.h"
#include "lode/models/diamond/lattice_field.h"
#include "lode/models/diamond/persist.h"
#include "lode/models/diamond/read_region.h"
#include "lode/store/fetcher.h"
#include "lode/store/page_table.h"

namespace lode::diamond {

/// One block of a level's grid: the samples at all its points, also those of coarser levels, and
/// but for level 0 the attributes of its nodes, side by side: error, low, high, world error.
template <int D>
struct LevelPage {
  Index<D> lower;                                 ///< Grid point of the first sample,
  Index<D> dims;                                  ///< how many there are,
  std::array<std::size_t, as_size(D)> strides{};  ///< and how far apart along each axis.
  UninitializedArray<std::byte> samples;          ///< Of the storage type.
  UninitializedArray<std::byte> attributes;

  /// Grid point q must be in it.
  [[nodiscard]] std::size_t index_of(const Index<D>& q) const {
    std::size_t index = 0;
    for (std::size_t i = 0; i < as_size(D); ++i) index += as_size(q[i] - lower[i]) * strides[i];
    return index;
  }
  /// Whether it holds q and all points up to `reach` away along each axis.
  [[nodiscard]] bool holds_round(const Index<D>& q, std::int32_t reach) const {
    for (std::size_t i = 0; i < as_size(D); ++i)
      if (q[i] - reach < lower[i] || q[i] + reach >= lower[i] + dims[i]) return false;
    return true;
  }
};

/// A volume in a .lode file whose samples and attributes are read when they are wanted, page by
/// page, coarse before fine, and go again beyond a limit unless somebody holds them. Which coarse
/// simplices holes remove is only known of those that have a finite error.
///
/// Const members are safe from many threads, and see every page that they hold.
template <int D>
class PagedModel : public LatticeField<D, PagedModel<D>> {
 public:
  using Page = store::Fetcher::Page;

  /// Reads the levels that are one page each. `reader` must outlive it.
  [[nodiscard]] static Result<std::unique_ptr<PagedModel>> open(const store::Reader& reader,
                                                                const Metadata& metadata,
                                                                Progress& progress);

  /// As Model's, where pages have been fetched (see missing()); beyond a level's grid that of its
  /// nearest point.
  [[nodiscard]] double value(Index<D> p) const;
  [[nodiscard]] static bool has_attributes(const Diamond<D>& node) { return node.level > 0; }
  [[nodiscard]] StoredAttributes attributes(const Diamond<D>& node) const;
  /// 0 where the file has none.
  [[nodiscard]] WorldCode world_error(const Diamond<D>& node) const;
  [[nodiscard]] const std::string& path() const { return reader_.path(); }
  /// Files of before have none.
  [[nodiscard]] bool has_worlds() const { return has_worlds_; }
  void prefetch(const Diamond<D>& node) const;
  /// See NearSamples.
  template <typename Near>
  void find_near(Near& near, const Index<D>& centre, std::int32_t reach, int level) const {
    const Index<D> q = on_grid(centre, level);
    const LevelPage<D>* page = page_at(level, q);
    if (page == nullptr || !page->holds_round(q, reach)) return;
    std::array<std::ptrdiff_t, as_size(D)> steps{};
    for (std::size_t i = 0; i < as_size(D); ++i)
      steps[i] = static_cast<std::ptrdiff_t>(page->strides[i]);
    using T = std::remove_cvref_t<decltype(near.at(q))>;
    near.found(reinterpret_cast<const T*>(page->samples.data()) + page->index_of(q), steps);
  }

  /// Calls body(page) for the pages that refining a node takes: samples round it, and what is known
  /// of its children.
  template <typename Body>
  void for_each_page(const Diamond<D>& node, const Body& body) const {
    LatticeBox<D> box{node.centre, node.centre};
    for (std::size_t i = 0; i < as_size(D); ++i) {
      box.lower[i] -= kPageReach * node.h();
      box.upper[i] += kPageReach * node.h();
    }
    for_each_page(node.level, box, body);
    if (node.tier == D - 1 && node.level > 0) for_each_page(node.level - 1, box, body);
  }
  [[nodiscard]] const store::PageTable<LevelPage<D>>& pages() const { return pages_; }
  /// What a page takes in memory.
  [[nodiscard]] std::uint64_t n_bytes(Page page) const;
  /// What all pages would take.
  [[nodiscard]] std::uint64_t n_bytes_of_all() const { return n_bytes_of_all_; }
  /// How much of the limit a client of the fetcher may hold.
  [[nodiscard]] std::uint64_t quota() const {
    return memory_limit_ / std::max<std::size_t>(1, fetcher_.n_clients());
  }
  /// Of all pages together; unlimited at first. But for what the clients hold it is kept, and they
  /// see to their quotas. A few pages are always allowed.
  void set_memory_limit(std::uint64_t n_bytes) const;
  [[nodiscard]] store::Fetcher& fetcher() const { return fetcher_; }
  /// Why one of these pages could not be read, and never is.
  template <typename Pages>
  [[nodiscard]] std::optional<Error> fault_of(const Pages& pages) const {
    if (!has_fault_.load(std::memory_order_acquire)) return {};
    const std::lock_guard lock(fault_mutex_);
    for (const Page page : pages) {
      if (const auto fault = faults_.find(page); fault != faults_.end()) return fault->second;
      if (lacks_memory_[page]) return out_of_memory("read a page", reader_.path());
    }
    return {};
  }

  /// The page that holds a point of a level's grid, null if it has not been fetched.
  [[nodiscard]] const LevelPage<D>* page_at(int level, const Index<D>& q) const {
    return pages_.at(number_of(level, block_of(level, q)));
  }

 private:
  struct Level {
    Index<D> dims;  ///< Of the grid, in points.
    Index<D> n_blocks;
    Page first = 0;  ///< Number of its first page; x fastest.
  };

  PagedModel(const store::Reader& reader, const Metadata& metadata);
  [[nodiscard]] static Index<D> on_grid(Index<D> p, int level) {
    for (std::int32_t& x : p.v) x >>= level;
    return p;
  }
  [[nodiscard]] Index<D> block_of(int level, Index<D> q) const {
    for (std::size_t i = 0; i < as_size(D); ++i)
      q[i] = std::min(q[i] / kBlockEdge<D>, levels_[as_size(level)].n_blocks[i] - 1);
    return q;
  }
  [[nodiscard]] Page number_of(int level, const Index<D>& block) const {
    const Level& l = levels_[as_size(level)];
    return l.first + static_cast<Page>(linear_index<D>(l.n_blocks, block));
  }
  /// Those of a level that have points in a box.
  template <typename Body>
  void for_each_page(int level, const LatticeBox<D>& box, const Body& body) const {
    Index<D> first;
    Index<D> last;
    const Index<D>& dims = levels_[as_size(level)].dims;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      first[i] = std::clamp(box.lower[i] >> level, 0, dims[i] - 1);
      last[i] = std::clamp(box.upper[i] >> level, 0, dims[i] - 1);
    }
    first = block_of(level, first);
    last = block_of(level, last);
    if (first == last) return body(number_of(level, first));
    const Index<D> n = last - first + all_equal<D>(1);
    for (std::size_t i = 0; i < n_points<D>(n); ++i)
      body(number_of(level, first + point_of<D>(n, i)));
  }
  [[nodiscard]] Region<D> region_of(Page page) const;
  void fetch(Page page);
  [[nodiscard]] Result<void> load_page(Page number);
  [[nodiscard]] Result<void> load(const Region<D>& region, LevelPage<D>& page) const;
  [[nodiscard]] Result<void> load_samples(const Region<D>& region, LevelPage<D>& page) const;
  [[nodiscard]] Result<void> load_attributes(const Region<D>& region, LevelPage<D>& page) const;
  void add_coarser(const Region<D>& region, LevelPage<D>& page) const;
  /// Of all of a node's attributes.
  [[nodiscard]] std::size_t attributes_size() const;

  /// Grid steps round a node's centre that refining it may look at: the simplices of its star,
  /// their neighbours for gradients, and finest nodes below it with theirs.
  static constexpr std::int32_t kPageReach = 4;

  const store::Reader& reader_;
  bool has_worlds_;
  std::vector<Level> levels_;
  std::uint64_t n_bytes_of_all_ = 0;
  mutable std::atomic<std::uint64_t> memory_limit_{std::numeric_limits<std::uint64_t>::max()};
  store::PageTable<LevelPage<D>> pages_;
  mutable std::mutex fault_mutex_;
  std::unordered_map<Page, Error> faults_;
  std::vector<bool> lacks_memory_;  ///< By page: said without taking any.
  std::atomic<bool> has_fault_{false};
  mutable store::Fetcher fetcher_;  ///< Last: its thread uses the others.
};

extern template class PagedModel<2>;
extern template class PagedModel<3>;

}  // namespace lode::diamond

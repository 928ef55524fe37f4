#include "lode/models/tetra_mt/midpoint/label_order.h"

#include <algorithm>
#include <array>
#include <utility>

#include "lode/models/tetra_mt/space_curve.h"

namespace lode::tetra_mt::midpoint {
namespace {

/// Growth of bands, and how many nodes the first one has at most; decision 0063.
constexpr std::size_t kGrowth = 2;
constexpr std::size_t kSmallest = 1024;

class LabelOrderer {
 public:
  LabelOrderer(const TetraMesh& mesh, const Scales& scales, std::vector<PositionCode> codes,
               std::span<const EdgeCollapse> collapses, LiveTetrahedra live)
      : scales_(scales),
        codes_(std::move(codes)),
        collapses_(collapses),
        live_(std::move(live)),
        curve_(mesh.positions),
        n_leaves_(static_cast<std::uint32_t>(mesh.positions.size())),
        n_nodes_(static_cast<std::uint32_t>(collapses.size())) {
    for (const Vec3d& p : mesh.positions) keys_.push_back(curve_(p));
  }

  LabelOrder run() {
    find_bands();
    find_trees();
    fill_pages();
    find_levels();
    return number();
  }

 private:
  /// Of both the mesh's vertices and what collapses make, by their order.
  using Vertex = std::uint32_t;

  struct Level {
    std::uint32_t epoch = 0;
    std::uint32_t in_epoch = 0;
    auto operator<=>(const Level&) const = default;
  };

  [[nodiscard]] bool is_leaf(Vertex v) const { return v < n_leaves_; }
  [[nodiscard]] std::uint32_t collapse_of(Vertex v) const { return v - n_leaves_; }

  /// 0 is that of the collapses that were first.
  void find_bands() {
    std::vector<std::size_t>
        ends;  // by band from the last collapse on: how many are in it or after
    for (std::size_t end = n_nodes_; end > kSmallest; end /= kGrowth) ends.push_back(end / kGrowth);
    bands_.resize(n_nodes_);
    for (std::uint32_t k = 0; k < n_nodes_; ++k) {
      std::uint32_t band = 0;
      while (band < ends.size() && n_nodes_ - 1 - k < ends[band]) ++band;
      bands_[k] = band;
    }
  }

  void find_trees() {
    std::vector<Vertex> there(n_leaves_);
    for (std::uint32_t v = 0; v < n_leaves_; ++v) there[v] = v;
    parents_.assign(std::size_t{n_leaves_} + n_nodes_, kNone);
    for (std::uint32_t k = 0; k < n_nodes_; ++k) {
      const EdgeCollapse& collapse = collapses_[k];
      children_.push_back({there[collapse.kept], there[collapse.removed]});
      for (const Vertex child : children_[k]) parents_[child] = n_leaves_ + k;
      codes_[collapse.kept] =
          merged(codes_[collapse.kept], codes_[collapse.removed], collapse.position);
      keys_.push_back(curve_(scales_.position(codes_[collapse.kept])));
      there[collapse.kept] = n_leaves_ + k;
    }
  }

  /// By band, the last collapses first; in each by curve.
  void fill_pages() {
    std::vector<std::vector<std::uint32_t>> roots(n_nodes_ > 0 ? bands_.back() + std::size_t{1}
                                                               : 0);
    std::vector<std::uint32_t> sizes(n_nodes_, 1);
    page_of_.resize(n_nodes_);
    for (std::uint32_t k = 0; k < n_nodes_; ++k) {
      const Vertex parent = parents_[n_leaves_ + k];
      if (parent != kNone && bands_[collapse_of(parent)] == bands_[k])
        sizes[collapse_of(parent)] += sizes[k];
      else
        roots[bands_[k]].push_back(k);
    }
    for (std::size_t band = roots.size(); band-- > 0;) {
      std::ranges::sort(roots[band], {},
                        [&](std::uint32_t k) { return std::pair(keys_[n_leaves_ + k], k); });
      if (!pages_.empty() && !pages_.back().empty()) pages_.emplace_back();
      for (const std::uint32_t root : roots[band]) add_tree(root, sizes[root]);
    }
  }
  /// A tree that does not fit begins a page; one that is larger than a page goes on in others.
  void add_tree(std::uint32_t root, std::uint32_t size) {
    if (pages_.empty() || (size <= kPageNodes && pages_.back().size() + size > kPageNodes))
      pages_.emplace_back();
    std::vector<std::uint32_t> waiting{root};
    while (!waiting.empty()) {
      const std::uint32_t k = waiting.back();
      waiting.pop_back();
      if (pages_.back().size() == kPageNodes) pages_.emplace_back();
      pages_.back().push_back(k);
      page_of_[k] = static_cast<std::uint32_t>(pages_.size() - 1);
      for (const Vertex child : children_[k])
        if (!is_leaf(child) && bands_[collapse_of(child)] == bands_[k])
          waiting.push_back(collapse_of(child));
    }
  }

  /// Of a level and an epoch all are above those beside them that were there before: of an epoch
  /// those of the pages that are earlier are above.
  void find_levels() {
    std::vector<Vertex> there(n_leaves_);
    for (std::uint32_t v = 0; v < n_leaves_; ++v) there[v] = v;
    levels_.assign(n_nodes_, {});
    for (std::uint32_t k = 0; k < n_nodes_; ++k) {
      const EdgeCollapse& collapse = collapses_[k];
      for (const std::uint32_t end : {collapse.kept, collapse.removed})
        for (const std::uint32_t slot : live_.star(end))
          for (const std::uint32_t v : live_.corners(slot))
            if (v != live_.outside() && !is_leaf(there[v])) raise_above(k, collapse_of(there[v]));
      there[collapse.kept] = n_leaves_ + k;
      live_.collapse(collapse.removed, collapse.kept);
    }
    for (auto& [first_end, second_end] : children_)
      if (is_below(first_end, second_end)) std::swap(first_end, second_end);
  }
  void raise_above(std::uint32_t k, std::uint32_t beside) {
    Level least = levels_[beside];
    if (page_of_[k] == page_of_[beside])
      ++least.in_epoch;
    else
      least = {least.epoch + (page_of_[k] < page_of_[beside] ? 0 : 1), 0};
    levels_[k] = std::max(levels_[k], least);
  }
  /// Whether a vertex has the smaller label, where both are of one page.
  [[nodiscard]] bool is_below(Vertex a, Vertex b) const {
    if (is_leaf(a) || is_leaf(b)) return is_leaf(a) && (!is_leaf(b) || a < b);
    return std::pair(levels_[collapse_of(a)], a) < std::pair(levels_[collapse_of(b)], b);
  }

  LabelOrder number() {
    LabelOrder order;
    order.nodes.resize(n_nodes_);
    order.leaves.resize(n_leaves_);
    std::vector<std::pair<std::uint64_t, Vertex>> alone;
    for (Vertex v = 0; v < n_leaves_; ++v)
      if (parents_[v] == kNone) alone.emplace_back(keys_[v], v);
    std::ranges::sort(alone);
    std::uint32_t n_leaves = 0;
    for (const auto& [key, v] : alone) order.leaves[v] = n_leaves++;
    std::vector<PageCounts> counts;
    for (std::uint32_t number = 0; number < pages_.size(); ++number) {
      std::vector<std::uint32_t>& page = pages_[number];
      sort_page(number);
      PageCounts& made = counts.emplace_back();
      for (const std::uint32_t k : page)
        for (std::size_t end = 2; end-- > 0;)
          if (is_leaf(children_[k][end])) {
            order.leaves[children_[k][end]] = n_leaves++;
            ++made.n_leaves;
          }
      std::ranges::stable_sort(page, {}, [&](std::uint32_t k) { return levels_[k]; });
      order.levels.push_back(count_levels(page, made));
    }
    order.pages = PageTable(static_cast<std::uint32_t>(alone.size()), counts);
    order.counts = std::move(counts);
    for (std::uint32_t page = 0; page < pages_.size(); ++page)
      for (std::uint32_t place = 0; place < pages_[page].size(); ++place)
        order.nodes[pages_[page][place]] = n_leaves_ + order.pages.node_at(page, place);
    return order;
  }
  /// Of how many nodes each level has; `made`: gets those of epochs.
  [[nodiscard]] std::vector<std::uint32_t> count_levels(const std::vector<std::uint32_t>& page,
                                                        PageCounts& made) const {
    std::vector<std::uint32_t> counts;
    for (std::size_t i = 0; i < page.size(); ++i) {
      const Level& level = levels_[page[i]];
      if (i == 0 || levels_[page[i - 1]] != level) counts.push_back(0);
      if (i == 0 || levels_[page[i - 1]].epoch != level.epoch)
        made.groups.push_back({level.epoch, 0});
      ++counts.back();
      ++made.groups.back().n;
    }
    return counts;
  }
  /// Trees by their roots' levels, each from its root down, the second end first.
  void sort_page(std::uint32_t number) {
    std::vector<std::uint32_t>& page = pages_[number];
    const auto is_here = [&](Vertex v) {
      return v != kNone && !is_leaf(v) && page_of_[collapse_of(v)] == number;
    };
    std::vector<std::uint32_t> roots;
    for (const std::uint32_t k : page)
      if (!is_here(parents_[n_leaves_ + k])) roots.push_back(k);
    std::ranges::stable_sort(roots, {}, [&](std::uint32_t k) { return levels_[k]; });
    page.clear();
    for (const std::uint32_t root : roots) {
      std::vector<std::uint32_t> waiting{root};
      while (!waiting.empty()) {
        const std::uint32_t k = waiting.back();
        waiting.pop_back();
        page.push_back(k);
        for (const Vertex child : children_[k])
          if (is_here(child)) waiting.push_back(collapse_of(child));
      }
    }
  }

  const Scales& scales_;
  std::vector<PositionCode> codes_;
  std::span<const EdgeCollapse> collapses_;
  LiveTetrahedra live_;
  SpaceCurve curve_;
  std::uint32_t n_leaves_;
  std::uint32_t n_nodes_;
  std::vector<std::uint64_t> keys_;                ///< By vertex: its place along the curve.
  std::vector<std::uint32_t> bands_;               ///< By collapse,
  std::vector<Level> levels_;                      ///< likewise,
  std::vector<std::array<Vertex, 2>> children_;    ///< and its ends: of larger label, then smaller.
  std::vector<Vertex> parents_;                    ///< By vertex.
  std::vector<std::vector<std::uint32_t>> pages_;  ///< Collapses.
  std::vector<std::uint32_t> page_of_;             ///< By collapse.
};

}  // namespace

LabelOrder order_labels(const TetraMesh& mesh, const Scales& scales,
                        std::vector<PositionCode> codes, std::span<const EdgeCollapse> collapses,
                        LiveTetrahedra live) {
  return LabelOrderer(mesh, scales, std::move(codes), collapses, std::move(live)).run();
}

}  // namespace lode::tetra_mt::midpoint

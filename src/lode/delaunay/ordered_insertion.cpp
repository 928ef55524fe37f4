#include "lode/delaunay/ordered_insertion.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "lode/core/expects.h"
#include "lode/delaunay/triangle_judge.h"

namespace lode::delaunay {
namespace {

/// Finds triangles that hold nodes, from corners near them. Parts of the domain may meet at corners
/// alone, which are in triangles of several parts.
class NodeFinder {
 public:
  explicit NodeFinder(const LatticeMesh& mesh) : mesh_(mesh) {
    find_parts();
    for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) note(t, part(t));
  }

  /// Of a triangle; part_of_ is empty where there is one.
  [[nodiscard]] std::uint32_t part(std::uint32_t t) const {
    return part_of_.empty() ? 0 : part_of_[t];
  }
  /// A triangle is new in its slot.
  void note(std::uint32_t t, std::uint32_t part) {
    if (!part_of_.empty()) {
      part_of_.resize(std::max<std::size_t>(t + 1, part_of_.size()));
      part_of_[t] = part;
    }
    for (const std::uint32_t corner : mesh_.triangles()[t].corner) {
      if (corner >= triangle_of_.size())
        triangle_of_.resize(std::max<std::size_t>(corner + 1, 2 * triangle_of_.size()));
      triangle_of_[corner] = t;
      if (part_of_.empty()) continue;
      if (const auto shared = shared_.find(corner); shared != shared_.end())
        shared->second[part] = t;
    }
  }
  [[nodiscard]] std::uint32_t find(const OrderedNode& wanted) {
    const LatticePoint p = mesh_.nodes().unpack(wanted.node);
    open_.clear();
    if (const auto shared = shared_.find(wanted.near); shared != shared_.end())
      for (const auto& [part, t] : shared->second) open_.push_back(t);
    else
      open_.push_back(triangle_of_[wanted.near]);
    for (const std::uint32_t start : open_)
      if (const auto found = walk(start, p)) return *found;
    return search(p);
  }

 private:
  /// Towards p; nothing where the outline is in the way, or it takes long.
  [[nodiscard]] std::optional<std::uint32_t> walk(std::uint32_t t, LatticePoint p) const {
    constexpr int kMostSteps = 64;
    for (int step = 0; step < kMostSteps; ++step) {
      const std::uint32_t edge = edge_towards(t, p);
      if (edge == 3) return t;
      const std::uint32_t twin = mesh_.triangles()[t].twin[edge];
      if (twin == kNoHalfEdge) return {};
      t = twin >> 2;
    }
    return {};
  }
  /// Of all that come of those that are open, the nearest in triangles first.
  [[nodiscard]] std::uint32_t search(LatticePoint p) {
    is_seen_.assign(mesh_.triangles().size(), false);
    for (const std::uint32_t start : open_) is_seen_[start] = true;
    for (std::size_t i = 0; i < open_.size(); ++i) {
      const std::uint32_t t = open_[i];
      if (edge_towards(t, p) == 3) return t;
      open_neighbours(t);
    }
    LODE_EXPECTS(false);  // the node is outside the domain
    return open_.front();
  }
  void open_neighbours(std::uint32_t t) {
    for (const std::uint32_t twin : mesh_.triangles()[t].twin) {
      if (twin == kNoHalfEdge || is_seen_[twin >> 2]) continue;
      is_seen_[twin >> 2] = true;
      open_.push_back(twin >> 2);
    }
  }
  /// Parts are connected by edges; insertions leave them as they are.
  void find_parts() {
    const auto n = static_cast<std::uint32_t>(mesh_.triangles().size());
    std::vector<std::uint32_t> part_of(n);
    std::uint32_t n_parts = 0;
    is_seen_.assign(n, false);
    for (std::uint32_t first = 0; first < n; ++first) {
      if (is_seen_[first]) continue;
      is_seen_[first] = true;
      open_.assign(1, first);
      for (std::size_t i = 0; i < open_.size(); ++i) {
        part_of[open_[i]] = n_parts;
        open_neighbours(open_[i]);
      }
      ++n_parts;
    }
    if (n_parts < 2) return;
    part_of_ = std::move(part_of);
    std::unordered_map<std::uint32_t, std::uint32_t> first_part;
    for (std::uint32_t t = 0; t < n; ++t)
      for (const std::uint32_t corner : mesh_.triangles()[t].corner)
        if (first_part.try_emplace(corner, part_of_[t]).first->second != part_of_[t])
          shared_.try_emplace(corner);
  }
  /// An edge that p lies behind; 3: none, the triangle holds it.
  [[nodiscard]] std::uint32_t edge_towards(std::uint32_t t, LatticePoint p) const {
    const auto& corner = mesh_.triangles()[t].corner;
    for (std::uint32_t i = 0; i < 3; ++i)
      if (doubled_area(mesh_.nodes().unpack(corner[i]), mesh_.nodes().unpack(corner[(i + 1) % 3]),
                       p) < 0)
        return i;
    return 3;
  }

  const LatticeMesh& mesh_;
  std::vector<std::uint32_t> triangle_of_;  ///< By node that is a corner.
  std::vector<std::uint32_t> part_of_;      ///< By triangle; empty: there is one part.
  /// Of corners in several parts, a triangle in each.
  std::unordered_map<std::uint32_t, std::map<std::uint32_t, std::uint32_t>> shared_;
  std::vector<std::uint32_t> open_;
  std::vector<bool> is_seen_;
};

}  // namespace

template <typename T>
Result<void> insert_in_order(LatticeMesh& mesh, const SampleRows<T>& rows, HeightRange range,
                             std::span<const OrderedNode> order, InsertionObserver& observer,
                             Progress& progress) {
  constexpr std::size_t kPerReport = 1U << 14;
  if (mesh.triangles().size() + 2 * order.size() > kMostTriangles)
    return fail("expected up to {} triangles, got {} samples to insert", kMostTriangles,
                order.size());
  // No error is beyond this, so that all are found as they are.
  const TriangleJudge<T> judge(rows, nullptr, range.lower, range.upper,
                               std::numeric_limits<double>::infinity(), &observer);
  judge.judge_all(mesh);
  NodeFinder finder(mesh);
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i % kPerReport == 0) {
      if (progress.is_cancelled()) return cancelled_error();
      progress.report("inserting", static_cast<double>(i) / static_cast<double>(order.size()));
    }
    const std::uint32_t t = finder.find(order[i]);
    const std::uint32_t part = finder.part(t);
    mesh.triangle(t).candidate = order[i].node;
    for (const std::uint32_t made : judge.insert(mesh, t)) finder.note(made, part);
  }
  return {};
}

template Result<void> insert_in_order(LatticeMesh&, const SampleRows<std::int16_t>&, HeightRange,
                                      std::span<const OrderedNode>, InsertionObserver&, Progress&);
template Result<void> insert_in_order(LatticeMesh&, const SampleRows<std::uint16_t>&, HeightRange,
                                      std::span<const OrderedNode>, InsertionObserver&, Progress&);
template Result<void> insert_in_order(LatticeMesh&, const SampleRows<float>&, HeightRange,
                                      std::span<const OrderedNode>, InsertionObserver&, Progress&);
template Result<void> insert_in_order(LatticeMesh&, const SampleRows<double>&, HeightRange,
                                      std::span<const OrderedNode>, InsertionObserver&, Progress&);

}  // namespace lode::delaunay

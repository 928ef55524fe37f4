#include "lode/delaunay/ordered_insertion.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "lode/core/expects.h"
#include "lode/delaunay/triangle_judge.h"

namespace lode::delaunay {
namespace {

/// Finds triangles that hold nodes, from corners near them.
class NodeFinder {
 public:
  explicit NodeFinder(const LatticeMesh& mesh) : mesh_(mesh) {
    for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) note(t);
  }

  /// A triangle is new in its slot.
  void note(std::uint32_t t) {
    for (const std::uint32_t corner : mesh_.triangles()[t].corner) {
      if (corner >= triangle_of_.size())
        triangle_of_.resize(std::max<std::size_t>(corner + 1, 2 * triangle_of_.size()));
      triangle_of_[corner] = t;
    }
  }
  [[nodiscard]] std::uint32_t find(const OrderedNode& wanted) {
    const LatticePoint p = mesh_.nodes().unpack(wanted.node);
    const std::uint32_t start = triangle_of_[wanted.near];
    const auto found = walk(start, p);
    return found ? *found : search(start, p);
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
  /// Of all, the nearest in triangles first.
  [[nodiscard]] std::uint32_t search(std::uint32_t start, LatticePoint p) {
    open_.assign(1, start);
    is_seen_.assign(mesh_.triangles().size(), false);
    is_seen_[start] = true;
    for (std::size_t i = 0; i < open_.size(); ++i) {
      const std::uint32_t t = open_[i];
      if (edge_towards(t, p) == 3) return t;
      for (const std::uint32_t twin : mesh_.triangles()[t].twin) {
        if (twin == kNoHalfEdge || is_seen_[twin >> 2]) continue;
        is_seen_[twin >> 2] = true;
        open_.push_back(twin >> 2);
      }
    }
    LODE_EXPECTS(false);  // the node is outside the domain
    return start;
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
  std::vector<std::uint32_t> open_;
  std::vector<bool> is_seen_;
};

}  // namespace

template <typename T>
Result<void> insert_in_order(LatticeMesh& mesh, const SampleRows<T>& rows, HeightRange range,
                             std::span<const OrderedNode> order, InsertionObserver& observer,
                             Progress& progress) {
  constexpr std::uint64_t kMostTriangles = (std::uint64_t{1} << 30) - 8;
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
    mesh.triangle(t).candidate = order[i].node;
    for (const std::uint32_t made : judge.insert(mesh, t)) finder.note(made);
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

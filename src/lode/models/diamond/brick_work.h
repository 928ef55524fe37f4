#pragma once

// What both ways of extracting an isosurface, from memory and from a file, begin with.

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "lode/mappers/simplex_isosurface.h"
#include "lode/mappers/stitch.h"
#include "lode/models/diamond/brick_traversal.h"
#include "lode/models/diamond/extract.h"
#include "lode/models/diamond/selection.h"

namespace lode::diamond {

/// Refuses a style that the data have none of.
template <int D>
[[nodiscard]] Result<void> check_style(const IsosurfaceQuery& query, const Shape<D>& shape) {
  if (D == 3 || query.style == SurfaceStyle::tetra || !shape.has_cells()) return {};
  return fail("style cubes: expected a volume, got data one sample thick");
}

/// The number of the chunk that a brick lies in.
template <int D>
std::size_t chunk_of_brick(const Shape<D>& shape, const Index<D>& brick) {
  const Index<D> n = chunk_counts<D>(shape);
  Index<D> chunk;
  for (std::size_t i = 0; i < as_size(D); ++i)
    chunk[i] = std::min(brick[i] / (kChunkEdge<D> / kBrickEdge<D>), n[i] - 1);
  return linear_index<D>(n, chunk);
}

/// The part of the cut above brick size, and which brick-size simplices it was refined down to.
template <int D>
struct CoarseCut {
  std::vector<ActiveSimplex<D>> leaves;
  std::vector<std::pair<std::size_t, Simplex<D>>> brick_simplices;  ///< By chunk, then brick.
  TraversalStats stats;
};

template <int D, typename Selected>
class CoarseTraversal {
 public:
  CoarseTraversal(const Selected& selection, CoarseCut<D>& out)
      : selection_(selection), out_(out), brick_dims_(brick_counts<D>(selection.model().shape)) {}

  void run() {
    const std::int32_t root = selection_.model().shape.root_side();
    for (const Simplex<D>& s : kuhn_simplices<D>({}, root)) visit(s);
    const auto place = [this](std::size_t brick) {
      return std::pair(chunk_of_brick<D>(selection_.model().shape, point_of<D>(brick_dims_, brick)),
                       brick);
    };
    std::stable_sort(out_.brick_simplices.begin(), out_.brick_simplices.end(),
                     [&](const auto& a, const auto& b) { return place(a.first) < place(b.first); });
  }

 private:
  void visit(const Simplex<D>& s) {
    const auto& model = selection_.model();
    const LatticeBox<D> box = bounds_of(s);
    if (!model.shape.overlaps_data(box)) return;
    if (s.tag == D && box.edge(0) <= kBrickEdge<D>) {
      Index<D> brick;
      for (std::size_t i = 0; i < as_size(D); ++i) brick[i] = box.lower[i] / kBrickEdge<D>;
      out_.brick_simplices.emplace_back(linear_index<D>(brick_dims_, brick), s);
      return;
    }
    ++out_.stats.nodes_visited;
    const Diamond<D> d = diamond_at<D>(s.bisection_point());
    const std::size_t at = selection_.index_of(d);
    if (!selection_.is_active(d.level, at)) return;
    if (selection_.exceeds_tolerance(selection_.error(d.level, at)) ||
        model.shape.reaches_across(d.centre, d.level) || selection_.is_wanted(d.centre)) {
      for (const Simplex<D>& half : bisect(s)) visit(half);
      return;
    }
    add_leaf(s, selection_.error(d.level, at));
  }

  /// Its error is finite: holes remove it with all its corners or not at all.
  void add_leaf(const Simplex<D>& s, ErrorCode error) {
    const auto& model = selection_.model();
    ActiveSimplex<D> leaf;
    leaf.vertex = s.v;
    bool is_crossed = false;
    for (std::size_t i = 0; i <= as_size(D); ++i) {
      leaf.value[i] = model.value_or_nan(s.v[i]);
      if (std::isnan(leaf.value[i])) return;
      is_crossed =
          is_crossed || selection_.side(leaf.value[i]) != selection_.side(leaf.value.front());
    }
    if (!is_crossed) return;
    out_.leaves.push_back(leaf);
    out_.stats.achieved = std::max(out_.stats.achieved, error);
  }

  const Selected& selection_;
  CoarseCut<D>& out_;
  Index<D> brick_dims_;
};

template <int D>
LatticeSimplex<D> to_lattice(const AxisMap<D>& axes,
                             const std::array<Index<D>, as_size(D) + 1>& vertex,
                             const std::array<double, as_size(D) + 1>& value) {
  LatticeSimplex<D> s;
  for (std::size_t i = 0; i <= as_size(D); ++i) s.vertex[i] = to_key(axes.to_grid(vertex[i]));
  s.value = value;
  return s;
}

/// Brick simplices as ranges, one per brick that has any.
template <int D>
struct BrickWork {
  std::size_t brick, begin, end;
};

template <int D>
std::vector<BrickWork<D>> work_of(const CoarseCut<D>& cut) {
  std::vector<BrickWork<D>> work;
  for (std::size_t i = 0; i < cut.brick_simplices.size(); ++i) {
    if (work.empty() || work.back().brick != cut.brick_simplices[i].first)
      work.push_back({cut.brick_simplices[i].first, i, i});
    work.back().end = i + 1;
  }
  return work;
}

/// A brick, and those of its Kuhn simplices that the cut has been refined down to.
template <int D>
struct CutBrick {
  Index<D> brick;
  std::vector<Simplex<D>> simplices;
};

/// `origin`: where the lattice begins that they are in, in the cut's; a brick's corner.
template <int D>
CutBrick<D> cut_brick(const CoarseCut<D>& cut, const Index<D>& brick_dims, const BrickWork<D>& work,
                      const Index<D>& origin = {}) {
  CutBrick<D> result{point_of<D>(brick_dims, work.brick), {}};
  for (std::size_t a = 0; a < as_size(D); ++a) result.brick[a] -= origin[a] / kBrickEdge<D>;
  result.simplices.reserve(work.end - work.begin);
  for (std::size_t s = work.begin; s < work.end; ++s) {
    Simplex<D>& simplex = result.simplices.emplace_back(cut.brick_simplices[s].second);
    for (Index<D>& v : simplex.v) v = v - origin;
  }
  return result;
}

/// Says of edges whether a vertex there may belong to a part other than its brick: its midpoint is
/// on the brick's border, or the edge joins two of its corners.
template <int D>
class OnBrickBorder {
 public:
  explicit OnBrickBorder(const AxisMap<D>& axes) {
    for (std::size_t i = 0; i < as_size(D); ++i) {
      const int shift = kKeyBits * axes.axis[i];
      doubled_[i] = LatticeKey{2 * kBrickEdge<D> - 1} << shift;
      single_ |= LatticeKey{kBrickEdge<D> - 1} << shift;
    }
  }
  [[nodiscard]] bool operator()(const EdgePoint& point) const {
    const LatticeKey sum = point.doubled_midpoint();
    bool is_on = ((point.first | point.second) & single_) == 0;
    for (const LatticeKey mask : doubled_) is_on = is_on || (sum & mask) == 0;
    return is_on;
  }

 private:
  std::array<LatticeKey, as_size(D)> doubled_;  ///< By axis: 0 of doubled coordinates on borders.
  LatticeKey single_ = 0;                       ///< 0 of bricks' corners.
};

/// Which part each brick has become: part i + 1 is that of work i, part 0 everything coarser.
template <int D>
class PartsOfBricks {
 public:
  PartsOfBricks() = default;
  PartsOfBricks(const AxisMap<D>& axes, const Index<D>& brick_dims,
                const std::vector<BrickWork<D>>& work)
      : axes_(axes), brick_dims_(brick_dims), part_of_(n_points<D>(brick_dims), 0) {
    for (std::size_t i = 0; i < work.size(); ++i)
      part_of_[work[i].brick] = static_cast<std::uint32_t>(i + 1);
  }

  /// What a brick has become; none: 0.
  [[nodiscard]] std::uint32_t of(const Index<D>& brick) const {
    return part_of_[linear_index<D>(brick_dims_, brick)];
  }

  /// The parts whose closed region contains a doubled midpoint: the coarse one, and up to 2^D
  /// bricks.
  void candidates(LatticeKey key, std::vector<std::uint32_t>& out) const {
    const Index3 doubled = to_point(key);
    out.push_back(0);
    for (int corner = 0; corner < (1 << D); ++corner) {
      Index<D> brick;
      bool exists = true;
      for (int i = 0; i < D; ++i) {
        const std::int32_t x = doubled[as_size(axes_.axis[as_size(i)])];
        const bool lower = ((corner >> i) & 1) == 0;
        brick[as_size(i)] = x / (2 * kBrickEdge<D>)-(lower ? 1 : 0);
        exists = exists && (!lower || x % (2 * kBrickEdge<D>) == 0) && brick[as_size(i)] >= 0 &&
                 brick[as_size(i)] < brick_dims_[as_size(i)];
      }
      if (!exists) continue;
      const std::uint32_t part = part_of_[linear_index<D>(brick_dims_, brick)];
      if (part != 0) out.push_back(part);
    }
    std::sort(out.begin(), out.end());
  }

 private:
  AxisMap<D> axes_;
  Index<D> brick_dims_;
  std::vector<std::uint32_t> part_of_;  ///< 0: none.
};

/// What margin and rounding may add to |F - isovalue|. Margin: along its edge. Rounding: up to
/// half a unit along each axis, where the field changes by at most twice the simplex's range a
/// step.
[[nodiscard]] inline double slack_of(const LatticeFrame& frame, double largest_step,
                                     double largest_snap) {
  return frame.margin * largest_snap + 4 * frame.rounding * largest_step;
}

/// The largest of the parts' steps and snaps.
struct LargestSteps {
  double step = 0;
  double snap = 0;

  template <int D>
  void add(const std::vector<StitchPart<D>>& parts) {
    for (const StitchPart<D>& part : parts) {
      step = std::max(step, part.part.largest_step);
      snap = std::max(snap, part.part.largest_snap);
    }
  }
};

/// All but the seconds.
inline IsosurfaceReport report_of(const LargestSteps& largest, const TraversalStats& stats,
                                  const LatticeFrame& frame) {
  IsosurfaceReport report;
  report.achieved_error = static_cast<double>(decode_error(stats.achieved));
  report.nodes_visited = stats.nodes_visited;
  report.coordinate_slack = slack_of(frame, largest.step, largest.snap);
  return report;
}

}  // namespace lode::diamond

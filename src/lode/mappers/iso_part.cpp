#include "lode/mappers/iso_part.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace lode {
namespace {

enum class Side : std::uint8_t { inside, on, outside };

Side side_of(double coordinate, double limit) {
  if (coordinate == limit) return Side::on;
  return coordinate < limit ? Side::inside : Side::outside;
}

/// Clips the cells of one part at one plane after another; each cut segment makes one vertex.
template <int D>
class DomainClipper {
 public:
  using Cell = std::array<std::uint32_t, static_cast<std::size_t>(D)>;

  DomainClipper(IsoPart<D>& part, const Vec3d& limits, std::uint32_t axis,
                std::vector<double>& snap)
      : part_(part), limits_(limits), axis_(axis), limit_(limits[axis]), snap_(snap) {}

  void run() {
    std::vector<Cell> kept;
    kept.reserve(part_.cells.size());
    for (const Cell& cell : part_.cells) clip(cell, kept);
    part_.cells = std::move(kept);
  }

 private:
  Side side(std::uint32_t v) const { return side_of(part_.positions[v][axis_], limit_); }

  std::uint32_t cut(std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    const auto [entry, is_new] =
        cuts_.try_emplace({a, b}, static_cast<std::uint32_t>(part_.positions.size()));
    if (!is_new) return entry->second;
    // From the lower end to the higher, whatever their numbers: every part that shares the segment
    // computes the same vertex.
    const auto [p, q] = std::minmax({part_.positions[a], part_.positions[b]});
    const double t = (limit_ - p[axis_]) / (q[axis_] - p[axis_]);
    Vec3d x;
    for (std::size_t i = 0; i < 3; ++i) x[i] = p[i] + t * (q[i] - p[i]);
    x[axis_] = limit_;
    const double snap = std::max(snap_[a], snap_[b]);
    for (std::size_t i = axis_ + 1; i < 3; ++i)
      if (std::abs(x[i] - limits_[i]) < snap) x[i] = limits_[i];
    snap_.push_back(snap);
    part_.positions.push_back(x);
    part_.clip_points.push_back({a, b, axis_});
    return entry->second;
  }

  void clip(const Cell& cell, std::vector<Cell>& kept) {
    bool is_any_inside = false;
    bool is_any_outside = false;
    for (const std::uint32_t v : cell) {
      is_any_inside = is_any_inside || side(v) == Side::inside;
      is_any_outside = is_any_outside || side(v) == Side::outside;
    }
    if (!is_any_inside) return;
    if (!is_any_outside) {
      kept.push_back(cell);
      return;
    }
    if constexpr (D == 2) {
      Cell line = cell;
      for (std::uint32_t& v : line)
        if (side(v) == Side::outside) v = cut(cell[0], cell[1]);
      kept.push_back(line);
    } else {
      std::array<std::uint32_t, 4> polygon{};
      std::size_t n = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t a = cell[i];
        const std::uint32_t b = cell[(i + 1) % 3];
        if (side(a) != Side::outside) polygon[n++] = a;
        const bool is_cut = (side(a) == Side::inside && side(b) == Side::outside) ||
                            (side(a) == Side::outside && side(b) == Side::inside);
        if (is_cut) polygon[n++] = cut(a, b);
      }
      for (std::size_t i = 2; i < n; ++i) kept.push_back({polygon[0], polygon[i - 1], polygon[i]});
    }
  }

  IsoPart<D>& part_;
  Vec3d limits_;
  std::uint32_t axis_;
  double limit_;
  std::vector<double>& snap_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> cuts_;
};

/// Length of a vertex's lattice edge along its longest axis, in steps.
double reach(const EdgePoint& point) {
  const Index3 d = to_point(point.second) - to_point(point.first);
  return std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])});
}

}  // namespace

template <int D>
void IsoPart<D>::clear() {
  points.clear();
  clip_points.clear();
  positions.clear();
  cells.clear();
  largest_step = 0;
  largest_snap = 0;
}

template <int D>
void clip_to_domain(IsoPart<D>& part, const Vec3d& limits, double snap) {
  std::vector<double> snaps(part.points.size());
  part.limits = limits;
  part.positions.resize(part.points.size());
  for (std::size_t v = 0; v < part.points.size(); ++v) {
    part.positions[v] = part.points[v].lattice_position();
    snaps[v] = snap * reach(part.points[v]);
    Vec3d& p = part.positions[v];
    for (std::size_t i = 0; i < 3; ++i)
      if (std::abs(p[i] - limits[i]) < snaps[v]) p[i] = limits[i];
  }
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    const bool is_crossed = std::any_of(part.positions.begin(), part.positions.end(),
                                        [&](const Vec3d& p) { return p[axis] > limits[axis]; });
    if (is_crossed) DomainClipper<D>(part, limits, axis, snaps).run();
  }
}

template struct IsoPart<2>;
template struct IsoPart<3>;
template void clip_to_domain<2>(IsoPart<2>&, const Vec3d&, double);
template void clip_to_domain<3>(IsoPart<3>&, const Vec3d&, double);

}  // namespace lode

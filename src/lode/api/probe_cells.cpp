#include "lode/api/probe_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "lode/locate/line_profile.h"
#include "lode/locate/point_location.h"

namespace lode {
namespace {

double next_below(double x) { return std::nextafter(x, -std::numeric_limits<double>::infinity()); }
double next_above(double x) { return std::nextafter(x, std::numeric_limits<double>::infinity()); }

/// Points that are no farther from a cell than so many roundings of distances are of it.
constexpr double kSnapRoundings = 4;

constexpr Range kNothing{1, -1};

/// Answers of cells that hold points.
class PointProbe {
 public:
  PointProbe(const ProbeCells& cells, Threads threads)
      : cells_(cells), locator_(cells.mesh.positions, cells.mesh.tetrahedra, threads) {
    for (std::size_t i = 0; i < cells.mesh.tetrahedra.size(); ++i)
      is_exact_.push_back(cells.has_exact(i) ? 1 : 0);
  }

  [[nodiscard]] const CellLocator& locator() const { return locator_; }
  [[nodiscard]] std::span<const std::uint8_t> is_exact() const { return is_exact_; }

  [[nodiscard]] ProbedPoint at(const Vec3d& p) const {
    if (const auto cell = find_cell(locator_, p, is_exact_)) return in(*cell, p, 0);
    const auto near = locator_.nearest_within(p, cells_.snap);
    return near ? snapped_to(*near, p) : beyond(p);
  }
  /// Of a point in the cell that is up to `distance` from p.
  [[nodiscard]] ProbedPoint in(std::uint32_t cell, const Vec3d& p, double distance) const {
    const SimplexMesh& mesh = cells_.mesh;
    std::array<double, 4> values{};
    for (std::size_t k = 0; k < 4; ++k) values[k] = mesh.values[mesh.tetrahedra[cell][k]];
    const RoundedValue made = value_in(locator_, cell, p, values, distance);
    ProbedPoint point{.point = p,
                      .is_inside = true,
                      .is_exact = is_exact_[cell] != 0,
                      .value = {made.value, made.low, made.high},
                      .error = static_cast<double>(mesh.errors[cell]),
                      .region = mesh.regions.empty() ? 0 : mesh.regions[cell]};
    if (!point.is_exact) bound(p, distance, made, point);
    return point;
  }

 private:
  /// Of the cell's nearest point. The reference may reach past the cut, to p and what is beyond.
  [[nodiscard]] ProbedPoint snapped_to(const NearestCell& near, const Vec3d& p) const {
    ProbedPoint point = in(near.cell, locator_.nearest_on_faces(near.cell, p), cells_.rounding);
    point.point = p;
    if (near.distance <= kSnapRoundings * cells_.rounding) return point;
    point.snapped = near.distance;
    const Range hidden = hidden_range(p);
    if (hidden.is_empty()) return point;
    point.is_exact = false;
    point.value.low = std::min(point.value.low, hidden.low);
    point.value.high = std::max(point.value.high, hidden.high);
    return point;
  }
  /// What F may be at a point beyond the cut, no farther than its boundary may be off.
  [[nodiscard]] Range hidden_range(const Vec3d& p) const {
    const double reach = cells_.boundary_deviation;
    if (!(reach > 0) || !cells_.range_off_cells) return kNothing;
    const Vec3d off{{reach, reach, reach}};
    return cells_.range_off_cells({p - off, p + off});
  }
  /// The reference may be there all the same.
  [[nodiscard]] ProbedPoint beyond(const Vec3d& p) const {
    ProbedPoint point{.point = p};
    const double reach = cells_.boundary_deviation;
    const Range range = hidden_range(p);
    if (range.is_empty()) return point;
    locator_.visit_near(p, reach, [&](std::uint32_t cell) {
      point.is_near_boundary =
          point.is_near_boundary ||
          (is_exact_[cell] == 0 && locator_.distance_to_faces(cell, p) <= reach);
    });
    if (point.is_near_boundary) point.value = {0, range.low, range.high};
    return point;
  }
  void bound(const Vec3d& p, double distance, const RoundedValue& made, ProbedPoint& point) const {
    BoundedNumber& value = point.value;
    if (cells_.range_in) {
      const Vec3d reach{{distance, distance, distance}};
      const Range range = cells_.range_in({p - reach, p + reach});
      value.low = std::min(range.low, value.low);
      value.high = std::max(range.high, value.high);
    }
    if (cells_.error_place == ErrorPlace::at_samples) return;
    const double low = next_below(made.low - point.error);
    const double high = next_above(made.high + point.error);
    value.low = cells_.range_in ? std::max(value.low, low) : low;
    value.high = cells_.range_in ? std::min(value.high, high) : high;
  }

  const ProbeCells& cells_;
  CellLocator locator_;
  std::vector<std::uint8_t> is_exact_;
};

bool is_finite_point(const Vec3d& p) {
  return std::ranges::all_of(p.v, [](double x) { return std::isfinite(x); });
}

}  // namespace

std::vector<ProbedPoint> probe_points_in(const ProbeCells& cells, std::span<const Vec3d> points,
                                         Threads threads) {
  const PointProbe probe(cells, threads);
  std::vector<ProbedPoint> found(points.size());
  parallel_for(points.size(), threads, 64,
               [&](std::size_t i, int) { found[i] = probe.at(points[i]); });
  return found;
}

std::vector<ProbedLinePoint> probe_line_in(const ProbeCells& cells, const Vec3d& begin,
                                           const Vec3d& end, Threads threads) {
  const PointProbe probe(cells, threads);
  const double size = length(end - begin);
  const auto knot = [&](std::uint32_t cell, double t, double rounding, std::uint32_t part) {
    const Vec3d p = t == 1 ? end : begin + (end - begin) * t;
    const double off = size * rounding + 0x1p-50 * (length(begin) + length(end));
    return ProbedLinePoint{probe.in(cell, p, off), size * t, part};
  };
  std::vector<ProbedLinePoint> knots;
  std::uint32_t n_parts = 0;
  for (const LinePiece& piece : line_profile(probe.locator(), begin, end, probe.is_exact())) {
    if (piece.starts_part) {
      knots.push_back(knot(piece.cell, piece.begin, piece.begin_rounding, n_parts));
      ++n_parts;
    }
    knots.push_back(knot(piece.cell, piece.end, piece.end_rounding, n_parts - 1));
  }
  return knots;
}

std::vector<Vec3d> points_on(const ProbedLine& line) {
  std::vector<Vec3d> points;
  const std::uint32_t n = std::max(line.n_points, 2U);
  for (std::uint32_t i = 0; i + 1 < n; ++i)
    points.push_back(line.begin + (line.end - line.begin) * (double{1} * i / (n - 1)));
  points.push_back(line.end);
  return points;
}

std::vector<ProbedLinePoint> on_line(const ProbedLine& line, std::span<const ProbedPoint> points) {
  std::vector<ProbedLinePoint> found;
  std::uint32_t n_parts = 0;
  bool was_inside = false;
  for (const ProbedPoint& point : points) {
    if (point.is_inside && !was_inside) ++n_parts;
    was_inside = point.is_inside;
    found.push_back({point, length(point.point - line.begin), std::max(n_parts, 1U) - 1});
  }
  return found;
}

Result<void> check_probe(std::span<const Vec3d> points, double max_error) {
  if (!(max_error >= 0)) return fail("tolerance: expected a number >= 0, got {}", max_error);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!is_finite_point(points[i]))
      return fail("point {}: expected finite coordinates, got {}, {}, {}", i + 1, points[i][0],
                  points[i][1], points[i][2]);
  return {};
}

void count_outside(std::span<const ProbedPoint> points, ProbeReport& report) {
  for (const ProbedPoint& point : points)
    if (!point.is_inside) ++(point.is_near_boundary ? report.n_near_boundary : report.n_outside);
}

Result<void> check_snap(double snap) {
  if (snap >= 0 && std::isfinite(snap)) return {};
  return fail("snap: expected a distance >= 0, got {}", snap);
}

Result<void> check_line(const ProbedLine& line) {
  if (!is_finite_point(line.begin) || !is_finite_point(line.end))
    return fail("line: expected finite coordinates, got others");
  const double size = length(line.end - line.begin);
  if (!(size > 0) || !std::isfinite(size))
    return fail("line: expected two points whose distance is a number above 0, got {}", size);
  if (line.n_points == 1) return fail("line: expected two points on it at least, got 1");
  return {};
}

}  // namespace lode

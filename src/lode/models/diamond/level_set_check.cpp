#include "lode/models/diamond/level_set_check.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "lode/models/diamond/cell_neighbours.h"
#include "lode/models/diamond/cell_pieces.h"
#include "lode/models/diamond/surface_coordinates.h"

namespace lode::diamond {
namespace {

constexpr std::size_t kSimplicesPerChunk = 1024;

void add(SimplexOffenders& offenders, std::uint32_t simplex) {
  if (offenders.count == 0 || simplex < offenders.first) offenders.first = simplex;
  ++offenders.count;
}

void merge(SimplexOffenders& offenders, const SimplexOffenders& other) {
  if (other.count == 0) return;
  if (offenders.count == 0 || other.first < offenders.first) offenders.first = other.first;
  offenders.count += other.count;
}

bool is_worse(const LevelSetReport& a, const LevelSetReport& b) {
  if (a.max_deviation != b.max_deviation) return a.max_deviation > b.max_deviation;
  return a.max_deviation > 0 && a.worst_simplex < b.worst_simplex;
}

void merge(LevelSetReport& report, const LevelSetReport& other) {
  report.n_pieces += other.n_pieces;
  report.n_caps += other.n_caps;
  if (is_worse(other, report)) {
    report.max_deviation = other.max_deviation;
    report.worst_simplex = other.worst_simplex;
    report.worst_point = other.worst_point;
  }
  merge(report.beyond_tolerance, other.beyond_tolerance);
  merge(report.outside, other.outside);
  merge(report.inside_removed, other.inside_removed);
  merge(report.ambiguous_isovalue, other.ambiguous_isovalue);
}

/// The isovalue a vertex belongs to: the one nearest to its attribute, which a file may have
/// rounded.
double isovalue_of(const Surface& surface, const std::vector<double>& isovalues,
                   std::uint32_t vertex) {
  if (isovalues.size() == 1 || surface.isovalues.size() <= vertex) return isovalues.front();
  const double attribute = surface.isovalues[vertex];
  return *std::min_element(isovalues.begin(), isovalues.end(), [&](double a, double b) {
    return std::abs(a - attribute) < std::abs(b - attribute);
  });
}

/// A point of the world with F - isovalue there.
struct ValuedPoint {
  Vec3d place;
  double value = 0;
};

using ValuedPolygon = std::vector<ValuedPoint>;

/// What of a convex polygon, on which values are linear, lies in a box (Sutherland and Hodgman).
ValuedPolygon clipped(ValuedPolygon polygon, const Box3d& box) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const double plane = side < 0 ? box.lower[axis] : box.upper[axis];
      const auto beyond = [&](const ValuedPoint& p) { return side * (p.place[axis] - plane); };
      ValuedPolygon left;
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const ValuedPoint& p = polygon[i];
        const ValuedPoint& q = polygon[(i + 1) % polygon.size()];
        const double of_p = beyond(p);
        const double of_q = beyond(q);
        if (of_p <= 0) left.push_back(p);
        if (!((of_p < 0 && of_q > 0) || (of_p > 0 && of_q < 0))) continue;
        const double t = of_p / (of_p - of_q);
        left.push_back({p.place * (1 - t) + q.place * t, p.value * (1 - t) + q.value * t});
      }
      polygon = std::move(left);
    }
  return polygon;
}

/// One worker's view: checks simplex after simplex and keeps the last cell it read.
class SimplexChecker {
 public:
  SimplexChecker(const FieldSamples& samples, const Surface& surface,
                 const LevelSetOptions& options, const SurfaceCoordinates& coordinates)
      : samples_(samples), surface_(surface), options_(options), coordinates_(coordinates) {}

  void check(std::uint32_t simplex, std::span<const std::uint32_t> vertices) {
    simplex_ = simplex;
    is_beyond_ = is_inside_removed_ = false;
    isovalue_ = isovalue_of(surface_, options_.isovalues, vertices[0]);
    for (const std::uint32_t vertex : vertices) {
      if (coordinates_.is_outside(vertex)) {
        add(report_.outside, simplex);
        return;
      }
      if (isovalue_of(surface_, options_.isovalues, vertex) != isovalue_) {
        add(report_.ambiguous_isovalue, simplex);
        return;
      }
    }
    is_cap_ = options_.caps == Caps::on_border &&
              (coordinates_.are_on_border(vertices) || coordinates_.are_on_clip(vertices));
    if (is_cap_) ++report_.n_caps;
    visit_cells(coordinates_.piece_of(vertices), samples_.grid().dims,
                [&](const Index3& cell, const Piece& piece) { check_piece(cell, piece); });
    if (is_beyond_) add(report_.beyond_tolerance, simplex);
    if (is_inside_removed_) add(report_.inside_removed, simplex);
  }

  [[nodiscard]] const LevelSetReport& report() const { return report_; }

 private:
  void enter(const Index3& cell) {
    if (field_.cell() != cell || field_.isovalue() != isovalue_)
      field_ = CellField(samples_, cell, isovalue_);
  }

  void check_piece(const Index3& cell, const Piece& piece) {
    enter(cell);
    if (field_.is_removed()) {
      // On the border of a present cell, give or take rounding, the field is that cell's.
      const auto present =
          find_near_cell(samples_, cell, piece, coordinates_.rounding(), CellState::present);
      if (!present) {
        is_inside_removed_ = true;
        return;
      }
      enter(*present);
    }
    Piece local;
    for (std::size_t i = 0; i < piece.size(); ++i) local.add(field_.to_local(piece[i]));
    visit_kuhn_simplices(local, [&](const Piece& part) { evaluate(part); });
  }

  /// Ties go to the lowest simplex, whatever order the workers take them in.
  [[nodiscard]] bool is_worst_yet(double deviation) const {
    if (deviation != report_.max_deviation) return deviation > report_.max_deviation;
    return deviation > 0 && simplex_ < report_.worst_simplex;
  }

  /// F is linear on the part, so also on what of it lies in a box.
  void evaluate(const Piece& part) {
    // Values are sums of four products with weights off by a few units, and by what rounding of
    // coordinates (up to 2^-52 of the largest) and of to_index moves their point.
    const double largest_index =
        static_cast<double>(std::max({field_.cell()[0], field_.cell()[1], field_.cell()[2]}) + 1);
    const double rounding =
        field_.magnitude() *
        (0x1p-49 + 6 * (coordinates_.check_rounding() + 0x1p-50 * largest_index));
    ValuedPolygon corners;
    for (std::size_t i = 0; i < part.size(); ++i)
      corners.push_back(
          {samples_.grid().to_world(field_.to_index(part[i])), field_.value_at(part[i])});
    if (options_.boxes.empty()) look_at(corners, rounding);
    for (const Box3d& box : options_.boxes) look_at(clipped(corners, box), rounding);
  }

  void look_at(const ValuedPolygon& corners, double rounding) {
    report_.n_pieces += corners.empty() ? 0 : 1;
    for (const auto& [place, value] : corners) {
      const double deviation = is_cap_ ? -value : std::abs(value);
      const double allowed = options_.tolerance + (is_cap_ ? options_.cap_tolerance : 0);
      is_beyond_ |= deviation > allowed + rounding;
      if (!is_worst_yet(deviation)) continue;
      report_.max_deviation = deviation;
      report_.worst_simplex = simplex_;
      report_.worst_point = place;
    }
  }

  const FieldSamples& samples_;
  const Surface& surface_;
  const LevelSetOptions& options_;
  const SurfaceCoordinates& coordinates_;
  LevelSetReport report_;
  CellField field_;
  double isovalue_ = 0;
  std::uint32_t simplex_ = 0;
  bool is_cap_ = false;
  bool is_beyond_ = false;
  bool is_inside_removed_ = false;
};

void check_simplex(const Surface& surface, std::size_t simplex, SimplexChecker& checker) {
  const auto number = static_cast<std::uint32_t>(simplex);
  if (surface.lines.empty())
    checker.check(number, surface.triangles[simplex]);
  else
    checker.check(number, surface.lines[simplex]);
}

}  // namespace

Result<LevelSetReport> check_level_set(const FieldSamples& samples, const Surface& surface,
                                       const LevelSetOptions& options, Progress& progress) {
  if (options.isovalues.empty()) return fail("level set check: expected an isovalue, got none");
  const SurfaceCoordinates coordinates(samples.grid(), surface, options.clip, options.threads);
  const std::size_t n = surface.lines.empty() ? surface.triangles.size() : surface.lines.size();
  std::vector<SimplexChecker> checkers(static_cast<std::size_t>(n_workers(options.threads)),
                                       SimplexChecker(samples, surface, options, coordinates));
  const std::size_t n_chunks = (n + kSimplicesPerChunk - 1) / kSimplicesPerChunk;
  std::atomic<std::size_t> n_done{0};
  parallel_for(n_chunks, options.threads, 1, [&](std::size_t chunk, int worker) {
    SimplexChecker& checker = checkers[static_cast<std::size_t>(worker)];
    const std::size_t end = std::min(n, (chunk + 1) * kSimplicesPerChunk);
    for (std::size_t i = chunk * kSimplicesPerChunk; i < end && !progress.is_cancelled(); ++i)
      check_simplex(surface, i, checker);
    progress.report("level set",
                    static_cast<double>(n_done.fetch_add(1) + 1) / static_cast<double>(n_chunks));
  });
  if (progress.is_cancelled()) return cancelled_error();
  LevelSetReport report;
  report.n_simplices = n;
  report.index_rounding = coordinates.rounding();
  for (const SimplexChecker& checker : checkers) merge(report, checker.report());
  return report;
}

}  // namespace lode::diamond

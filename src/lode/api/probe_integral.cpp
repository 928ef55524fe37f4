#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "lode/api/probe_cells.h"
#include "lode/api/probe_sums.h"
#include "lode/mappers/cell_part.h"

namespace lode {
namespace {

using probe_sums::Extremes;
using probe_sums::kEndless;
using probe_sums::PartialIntegral;

bool is_of_regions(const ProbeCells& cells, const IntegralOptions& options, std::size_t cell) {
  return options.regions.empty() || cells.mesh.regions.empty() ||
         std::ranges::find(options.regions, cells.mesh.regions[cell]) != options.regions.end();
}

class Integrator {
 public:
  /// `deviation`: a bound of the volume between the boundaries of cells and of the reference.
  Integrator(const ProbeCells& cells, const IntegralOptions& options, double deviation)
      : cells_(cells), options_(options), deviation_(deviation) {}

  void add(std::size_t cell, PartialIntegral& to) const {
    if (!is_of_regions(cells_, options_, cell)) return;
    std::array<Vec3d, 4> corners;
    std::array<double, 4> values{};
    for (std::size_t k = 0; k < 4; ++k) {
      corners[k] = cells_.mesh.positions[cells_.mesh.tetrahedra[cell][k]];
      values[k] = cells_.mesh.values[cells_.mesh.tetrahedra[cell][k]];
    }
    const CellPart part = part_in_box(corners, values, options_.box);
    const double error = static_cast<double>(cells_.mesh.errors[cell]);
    to.volume_rounding += part.volume_rounding;
    to.integral_rounding += part.integral_rounding;
    const double sign = sign_of(corners);
    to.volume.add(sign * part.volume);
    to.integral.add(sign * part.integral);
    to.estimate.add(error * part.volume);
    to.volume_bounds.add(sign * part.volume - part.volume_rounding,
                         sign * part.volume + part.volume_rounding);
    if (part.is_empty() && part.volume_rounding == 0) return;
    if (!part.is_empty()) ++to.n_cells;
    if (part.is_whole) ++to.n_whole;
    if (has_errors_everywhere(cell)) {
      const double off = cells_.has_exact(cell) ? 0 : error;
      add_integral_within(off, part, sign, to);
      add_extremes_within(off, part, corners, values, to.extremes);
    } else {
      const Range range = range_on(corners);
      add_integral(part, range, sign, to);
      add_extremes(part, range, to.extremes);
    }
    if (cells_.is_exact_at_vertices || cells_.has_exact(cell))
      add_vertices(corners, values, to.extremes);
  }

 private:
  /// Of a cell's volume: what the reference folds over other cells counts less there, so that sums
  /// are those of cuts, where it is gone.
  [[nodiscard]] static double sign_of(const std::array<Vec3d, 4>& p) {
    return dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]) < 0 ? -1 : 1;
  }
  [[nodiscard]] bool has_errors_everywhere(std::size_t cell) const {
    return cells_.has_exact(cell) || cells_.error_place == ErrorPlace::everywhere;
  }
  /// That F keeps on the cell's part in the box.
  [[nodiscard]] Range range_on(const std::array<Vec3d, 4>& corners) const {
    Box3d box{corners[0], corners[0]};
    for (std::size_t i = 0; i < 3; ++i) {
      for (const Vec3d& p : corners) {
        box.lower[i] = std::min(box.lower[i], p[i]);
        box.upper[i] = std::max(box.upper[i], p[i]);
      }
      if (options_.box) box.lower[i] = std::max(box.lower[i], options_.box->lower[i]);
      if (options_.box) box.upper[i] = std::min(box.upper[i], options_.box->upper[i]);
    }
    return cells_.range_in(box);
  }
  /// The box, a little larger or smaller than by what rounding may put a cell's cuts at it off
  /// by: 54 units of the cell's width (cell_part.cpp), and two of a plane's place.
  [[nodiscard]] Box3d moved_box(const std::array<Vec3d, 4>& corners, double sign) const {
    double width = 0;
    for (std::size_t k = 1; k < 4; ++k)
      for (std::size_t j = 0; j < k; ++j)
        for (const double x : (corners[k] - corners[j]).v) width = std::max(width, std::abs(x));
    Box3d box = *options_.box;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto off = [&](double at) { return sign * (0x1p-45 * width + 0x1p-51 * std::abs(at)); };
      box.lower[i] -= off(box.lower[i]);
      box.upper[i] += off(box.upper[i]);
    }
    return box;
  }
  static void add_integral_within(double error, const CellPart& part, double sign,
                                  PartialIntegral& to) {
    const double volume = part.volume + part.volume_rounding;
    const double off = part.integral_rounding + error * volume * (1 + 0x1p-50);
    to.integral_bounds.add(sign * part.integral - off, sign * part.integral + off);
  }
  /// Of a cell on which F is within `error` of F'. What a smaller box cuts out is in the box, and
  /// what a larger one does holds all that is.
  void add_extremes_within(double error, const CellPart& part, const std::array<Vec3d, 4>& corners,
                           const std::array<double, 4>& values, Extremes& to) const {
    add_of_cut(part, to);
    const bool is_cut = options_.box && !part.is_whole;
    const CellPart least = is_cut ? part_in_box(corners, values, moved_box(corners, -1)) : part;
    const CellPart most = is_cut ? part_in_box(corners, values, moved_box(corners, 1)) : part;
    const auto [low, high] = std::ranges::minmax(values);
    // A mean of values along an edge, up to six times.
    const double off = is_cut ? error + 0x1p-48 * std::max(std::abs(low), std::abs(high)) : error;
    const auto below = [off](double x) { return off > 0 ? std::nextafter(x - off, -kEndless) : x; };
    const auto above = [off](double x) { return off > 0 ? std::nextafter(x + off, kEndless) : x; };
    if (!most.is_empty()) {
      to.lowest = std::min(to.lowest, below(most.lowest));
      to.highest = std::max(to.highest, above(most.highest));
    }
    if (!least.is_empty()) {
      to.reached_low = std::min(to.reached_low, above(least.lowest));
      to.reached_high = std::max(to.reached_high, below(least.highest));
    }
  }
  static void add_integral(const CellPart& part, const Range& range, double sign,
                           PartialIntegral& to) {
    const double volume = part.volume + part.volume_rounding;
    const double least = std::max(0.0, part.volume - part.volume_rounding);
    constexpr double kWiden = 0x1p-50;
    double low = std::min(range.low * least, range.low * volume);
    double high = std::max(range.high * least, range.high * volume);
    if (sign < 0) low = -std::exchange(high, -low);
    to.integral_bounds.add(low - kWiden * std::abs(low), high + kWiden * std::abs(high));
  }
  static void add_of_cut(const CellPart& part, Extremes& to) {
    if (part.is_empty()) return;
    to.of_cut_low = std::min(to.of_cut_low, part.lowest);
    to.of_cut_high = std::max(to.of_cut_high, part.highest);
  }
  /// F is on some of the part, if that is more than can be outside of the reference.
  void add_extremes(const CellPart& part, const Range& range, Extremes& to) const {
    add_of_cut(part, to);
    to.lowest = std::min(to.lowest, range.low);
    to.highest = std::max(to.highest, range.high);
    if (part.volume > part.volume_rounding + deviation_) {
      to.reached_low = std::min(to.reached_low, range.high);
      to.reached_high = std::max(to.reached_high, range.low);
    }
  }
  /// Whose values F has.
  void add_vertices(const std::array<Vec3d, 4>& corners, const std::array<double, 4>& values,
                    Extremes& to) const {
    for (std::size_t k = 0; k < 4; ++k) {
      bool is_in = true;
      for (std::size_t i = 0; options_.box && i < 3; ++i)
        is_in = is_in && options_.box->lower[i] <= corners[k][i] &&
                corners[k][i] <= options_.box->upper[i];
      if (!is_in) continue;
      to.reached_low = std::min(to.reached_low, values[k]);
      to.reached_high = std::max(to.reached_high, values[k]);
    }
  }

  const ProbeCells& cells_;
  const IntegralOptions& options_;
  double deviation_;
};

/// A bound of the volume within a distance of a triangle.
double volume_near(const std::array<Vec3d, 3>& t, double distance) {
  const double area = length(cross(t[1] - t[0], t[2] - t[0])) / 2;
  const double round = length(t[1] - t[0]) + length(t[2] - t[1]) + length(t[0] - t[2]);
  return 1.001 * distance *
         (2 * area + std::numbers::pi * distance * (round / 2 + 4.0 / 3 * distance));
}

/// A bound of what lies between the boundary of what is wanted and that of the reference: all of it
/// is within the deviation of faces that one wanted cell alone has, which is not the reference's.
double volume_of_deviation(const ProbeCells& cells, const IntegralOptions& options) {
  const std::optional<Box3d>& box = options.box;
  const double deviation = cells.boundary_deviation;
  if (!(deviation > 0)) return 0;
  struct Face {
    std::array<std::uint32_t, 3> key;
    bool is_exact;
  };
  std::vector<Face> faces;
  for (std::size_t i = 0; i < cells.mesh.tetrahedra.size(); ++i) {
    if (!is_of_regions(cells, options, i)) continue;
    const auto& t = cells.mesh.tetrahedra[i];
    for (std::size_t k = 0; k < 4; ++k) {
      Face face{{t[(k + 1) % 4], t[(k + 2) % 4], t[(k + 3) % 4]}, cells.has_exact(i)};
      std::ranges::sort(face.key);
      faces.push_back(face);
    }
  }
  std::ranges::sort(faces, {}, &Face::key);
  double volume = 0;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const bool is_shared = (i > 0 && faces[i - 1].key == faces[i].key) ||
                           (i + 1 < faces.size() && faces[i + 1].key == faces[i].key);
    if (is_shared || faces[i].is_exact) continue;
    std::array<Vec3d, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = cells.mesh.positions[faces[i].key[k]];
    bool meets = true;
    for (std::size_t a = 0; box && a < 3; ++a) {
      const auto [low, high] = std::minmax({corners[0][a], corners[1][a], corners[2][a]});
      meets =
          meets && low <= box->upper[a] + 2 * deviation && box->lower[a] - 2 * deviation <= high;
    }
    if (meets) volume += volume_near(corners, deviation);
  }
  return volume * (1 + 1e-6);
}

/// Bounds of what two numbers divided may be.
BoundedNumber ratio(const BoundedNumber& a, const BoundedNumber& b) {
  BoundedNumber made{a.value / b.value, -kEndless, kEndless};
  if (!(b.low > 0)) return made;
  const auto [low, high] =
      std::minmax({a.low / b.low, a.low / b.high, a.high / b.low, a.high / b.high});
  made.low = std::nextafter(low, -kEndless);
  made.high = std::nextafter(high, kEndless);
  return made;
}

/// A bound of the volume of what a box has of the domain.
double largest_volume(const ProbeCells& cells, const std::optional<Box3d>& box) {
  double volume = 1 + 1e-12;
  for (std::size_t i = 0; i < 3; ++i) {
    double low = cells.domain.lower[i];
    double high = cells.domain.upper[i];
    if (box) low = std::max(low, box->lower[i]);
    if (box) high = std::min(high, box->upper[i]);
    volume *= std::max(0.0, high - low);
  }
  return volume;
}

/// What the boundary may be off by widens bounds; but no volume is larger than the box round it, no
/// value of F outside of its range, and no integral off their product.
void add_deviation(const ProbeCells& cells, const std::optional<Box3d>& box, double deviation,
                   IntegralReport& report) {
  BoundedNumber& volume = report.volume;
  volume.low = std::max(0.0, volume.low - deviation);
  // Of cells that lie over one another, more.
  volume.high =
      std::max(volume.high, std::min(volume.high + deviation, largest_volume(cells, box)));
  const double off =
      deviation * std::max(std::abs(cells.all.low), std::abs(cells.all.high)) * (1 + 1e-6);
  BoundedNumber& integral = report.integral;
  const double low = std::min(volume.low * cells.all.low, volume.high * cells.all.low);
  const double high = std::max(volume.low * cells.all.high, volume.high * cells.all.high);
  integral.low =
      std::max(integral.low - off, std::min(integral.value, low - 1e-15 * std::abs(low)));
  integral.high =
      std::min(integral.high + off, std::max(integral.value, high + 1e-15 * std::abs(high)));
  // Where errors hold everywhere boundaries stay, but for rounding.
  if (!cells.range_off_cells || cells.error_place == ErrorPlace::everywhere) return;
  const Range range = cells.range_off_cells(box ? *box : cells.domain);
  report.minimum.low = std::min(report.minimum.low, range.low);
  report.maximum.high = std::max(report.maximum.high, range.high);
}

/// In the stored range, as far as the cut's own value is.
void clamp_extreme(const Range& all, BoundedNumber& extreme) {
  extreme.low = std::max(extreme.low, std::min(all.low, extreme.value));
  extreme.high = std::min(extreme.high, std::max(all.high, extreme.value));
}

void fill_report(const PartialIntegral& sum, const ProbeCells& cells,
                 const std::optional<Box3d>& box, double deviation, IntegralReport& report) {
  report.n_cells = sum.n_cells;
  report.n_whole = sum.n_whole;
  report.is_empty = sum.n_cells == 0;
  if (report.is_empty) return;
  report.volume_rounding = sum.volume_rounding * (1 + 1e-6) + sum.volume.rounding();
  report.integral_rounding = sum.integral_rounding * (1 + 1e-6) + sum.integral.rounding();
  report.integral_estimate = sum.estimate.value();
  report.volume = sum.volume_bounds.around(sum.volume.value());
  report.volume.low = std::max(0.0, report.volume.low);
  report.integral = sum.integral_bounds.around(sum.integral.value());
  const Extremes& extremes = sum.extremes;
  report.minimum = {extremes.of_cut_low, std::min(extremes.lowest, extremes.of_cut_low),
                    std::max(extremes.reached_low, extremes.of_cut_low)};
  report.maximum = {extremes.of_cut_high, std::min(extremes.reached_high, extremes.of_cut_high),
                    std::max(extremes.highest, extremes.of_cut_high)};
  if (deviation > 0) add_deviation(cells, box, deviation, report);
  clamp_extreme(cells.all, report.minimum);
  clamp_extreme(cells.all, report.maximum);
  report.mean = ratio(report.integral, report.volume);
  report.mean.low = std::max(report.mean.low, report.minimum.low);
  report.mean.high = std::min(report.mean.high, report.maximum.high);
}

}  // namespace

Result<void> check_integral(const IntegralOptions& options) {
  LODE_CHECK(check_probe({}, options.max_error));
  for (std::size_t i = 0; options.box && i < 3; ++i)
    if (!std::isfinite(options.box->lower[i]) || !std::isfinite(options.box->upper[i]) ||
        options.box->lower[i] > options.box->upper[i])
      return fail("box: expected finite numbers, lower <= upper, got {} and {}",
                  options.box->lower[i], options.box->upper[i]);
  return {};
}

IntegralReport integrate_cells(const ProbeCells& cells, const IntegralOptions& options) {
  const double deviation = volume_of_deviation(cells, options);
  const Integrator integrator(cells, options, deviation);
  constexpr std::size_t kBlock = 1024;
  const std::size_t n = cells.mesh.tetrahedra.size();
  std::vector<PartialIntegral> parts((n + kBlock - 1) / kBlock);
  parallel_for(parts.size(), options.threads, 1, [&](std::size_t b, int) {
    for (std::size_t i = b * kBlock; i < std::min(n, (b + 1) * kBlock); ++i)
      integrator.add(i, parts[b]);
  });
  PartialIntegral sum;
  for (const PartialIntegral& part : parts) sum.add(part);
  IntegralReport report;
  fill_report(sum, cells, options.box, deviation, report);
  return report;
}

}  // namespace lode

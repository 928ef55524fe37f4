#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "lode/api/probe_cells.h"
#include "lode/api/probe_sums.h"
#include "lode/mappers/cell_part.h"

namespace lode {
namespace {

using probe_sums::Extremes;
using probe_sums::kEndless;
using probe_sums::PartialIntegral;

class Integrator {
 public:
  Integrator(const ProbeCells& cells, const IntegralOptions& options)
      : cells_(cells), options_(options) {}

  [[nodiscard]] bool is_wanted(std::size_t cell) const {
    return options_.regions.empty() || cells_.mesh.regions.empty() ||
           std::ranges::find(options_.regions, cells_.mesh.regions[cell]) != options_.regions.end();
  }

  void add(std::size_t cell, PartialIntegral& to) const {
    if (!is_wanted(cell)) return;
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
    to.volume.add(part.volume);
    to.integral.add(part.integral);
    to.estimate.add(error * part.volume);
    to.volume_bounds.add(part.volume - part.volume_rounding, part.volume + part.volume_rounding);
    if (part.is_empty() && part.volume_rounding == 0) return;
    if (!part.is_empty()) ++to.n_cells;
    if (part.is_whole) ++to.n_whole;
    const Range range = range_on(cell, corners, values);
    add_integral(cell, part, range, error, to);
    add_extremes(part, range, to.extremes);
    if (cells_.is_exact_at_vertices || cells_.has_exact(cell))
      add_vertices(corners, values, to.extremes);
  }

 private:
  [[nodiscard]] bool has_errors_everywhere(std::size_t cell) const {
    return cells_.has_exact(cell) || cells_.error_place == ErrorPlace::everywhere;
  }
  /// That F keeps on the cell's part in the box.
  [[nodiscard]] Range range_on(std::size_t cell, const std::array<Vec3d, 4>& corners,
                               const std::array<double, 4>& values) const {
    const auto [low, high] = std::ranges::minmax(values);
    if (has_errors_everywhere(cell)) {
      const double error = cells_.has_exact(cell) ? 0 : double{cells_.mesh.errors[cell]};
      if (error == 0) return {low, high};
      return {std::nextafter(low - error, -kEndless), std::nextafter(high + error, kEndless)};
    }
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
  void add_integral(std::size_t cell, const CellPart& part, const Range& range, double error,
                    PartialIntegral& to) const {
    const double volume = part.volume + part.volume_rounding;
    if (has_errors_everywhere(cell)) {
      const double off =
          part.integral_rounding + (cells_.has_exact(cell) ? 0 : error * volume * (1 + 0x1p-50));
      to.integral_bounds.add(part.integral - off, part.integral + off);
      return;
    }
    const double least = std::max(0.0, part.volume - part.volume_rounding);
    constexpr double kWiden = 0x1p-50;
    const double low = std::min(range.low * least, range.low * volume);
    const double high = std::max(range.high * least, range.high * volume);
    to.integral_bounds.add(low - kWiden * std::abs(low), high + kWiden * std::abs(high));
  }
  static void add_extremes(const CellPart& part, const Range& range, Extremes& to) {
    if (!part.is_empty()) {
      to.of_cut_low = std::min(to.of_cut_low, part.lowest);
      to.of_cut_high = std::max(to.of_cut_high, part.highest);
    }
    to.lowest = std::min(to.lowest, range.low);
    to.highest = std::max(to.highest, range.high);
    if (part.volume > part.volume_rounding) {
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
double volume_of_deviation(const ProbeCells& cells, const Integrator& wanted,
                           const std::optional<Box3d>& box) {
  const double deviation = cells.boundary_deviation;
  if (!(deviation > 0)) return 0;
  struct Face {
    std::array<std::uint32_t, 3> key;
    bool is_exact;
  };
  std::vector<Face> faces;
  for (std::size_t i = 0; i < cells.mesh.tetrahedra.size(); ++i) {
    if (!wanted.is_wanted(i)) continue;
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

void fill_report(const PartialIntegral& sum, const ProbeCells& cells, double deviation,
                 IntegralReport& report) {
  report.n_cells = sum.n_cells;
  report.n_whole = sum.n_whole;
  report.is_empty = sum.n_cells == 0;
  if (report.is_empty) return;
  report.volume_rounding = sum.volume_rounding * (1 + 1e-6) + sum.volume.rounding();
  report.integral_rounding = sum.integral_rounding * (1 + 1e-6) + sum.integral.rounding();
  report.integral_estimate = sum.estimate.value();
  report.volume = sum.volume_bounds.around(sum.volume.value());
  report.volume.low = std::max(0.0, report.volume.low - deviation);
  report.volume.high += deviation;
  report.integral = sum.integral_bounds.around(sum.integral.value());
  const double off = deviation * cells.largest_value * (1 + 1e-6);
  report.integral.low -= off;
  report.integral.high += off;
  const Extremes& extremes = sum.extremes;
  report.minimum = {extremes.of_cut_low, std::min(extremes.lowest, extremes.of_cut_low),
                    std::max(extremes.reached_low, extremes.of_cut_low)};
  report.maximum = {extremes.of_cut_high, std::min(extremes.reached_high, extremes.of_cut_high),
                    std::max(extremes.highest, extremes.of_cut_high)};
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
  const Integrator integrator(cells, options);
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
  fill_report(sum, cells, volume_of_deviation(cells, integrator, options.box), report);
  return report;
}

}  // namespace lode

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "lode/api/probe_cells.h"
#include "lode/api/probe_integrator.h"

namespace lode {
namespace {

using probe_sums::CellIntegrator;
using probe_sums::Extremes;
using probe_sums::IntegralCell;
using probe_sums::kEndless;
using probe_sums::PartialIntegral;

bool is_of_regions(const ProbeCells& cells, const IntegralOptions& options, std::size_t cell) {
  return options.regions.empty() || cells.mesh.regions.empty() ||
         std::ranges::find(options.regions, cells.mesh.regions[cell]) != options.regions.end();
}

IntegralCell cell_at(const ProbeCells& cells, std::size_t i) {
  IntegralCell cell{.error = static_cast<double>(cells.mesh.errors[i]),
                    .is_exact = cells.has_exact(i)};
  for (std::size_t k = 0; k < 4; ++k) {
    const std::uint32_t v = cells.mesh.tetrahedra[i][k];
    cell.corners[k] = cells.mesh.positions[v];
    cell.values[k] = cells.mesh.values[v];
  }
  return cell;
}

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

}  // namespace

IntegralReport probe_sums::to_report(const PartialIntegral& sum, const ProbeCells& cells,
                                     const std::optional<Box3d>& box, double deviation) {
  IntegralReport report;
  report.n_cells = sum.n_cells;
  report.n_whole = sum.n_whole;
  report.is_empty = sum.n_cells == 0;
  if (report.is_empty) return report;
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
  return report;
}

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
  const CellIntegrator integrator(cells, options, deviation);
  constexpr std::size_t kBlock = 1024;
  const std::size_t n = cells.mesh.tetrahedra.size();
  std::vector<PartialIntegral> parts((n + kBlock - 1) / kBlock);
  parallel_for(parts.size(), options.threads, 1, [&](std::size_t b, int) {
    for (std::size_t i = b * kBlock; i < std::min(n, (b + 1) * kBlock); ++i)
      if (is_of_regions(cells, options, i)) integrator.add(cell_at(cells, i), parts[b]);
  });
  PartialIntegral sum;
  for (const PartialIntegral& part : parts) sum.add(part);
  return probe_sums::to_report(sum, cells, options.box, deviation);
}

}  // namespace lode

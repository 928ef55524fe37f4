#include "lode/api/probe_integrator.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lode::probe_sums {
namespace {

void add_integral_within(double error, const CellPart& part, double sign, PartialIntegral& to) {
  const double volume = part.volume + part.volume_rounding;
  const double off = part.integral_rounding + error * volume * (1 + 0x1p-50);
  to.integral_bounds.add(sign * part.integral - off, sign * part.integral + off);
}

void add_integral(const CellPart& part, const Range& range, double sign, PartialIntegral& to) {
  const double volume = part.volume + part.volume_rounding;
  const double least = std::max(0.0, part.volume - part.volume_rounding);
  constexpr double kWiden = 0x1p-50;
  double low = std::min(range.low * least, range.low * volume);
  double high = std::max(range.high * least, range.high * volume);
  if (sign < 0) low = -std::exchange(high, -low);
  to.integral_bounds.add(low - kWiden * std::abs(low), high + kWiden * std::abs(high));
}

void add_of_cut(const CellPart& part, Extremes& to) {
  if (part.is_empty()) return;
  to.of_cut_low = std::min(to.of_cut_low, part.lowest);
  to.of_cut_high = std::max(to.of_cut_high, part.highest);
}

}  // namespace

void CellIntegrator::add(const IntegralCell& cell, PartialIntegral& to) const {
  const CellPart part = part_in_box(cell.corners, cell.values, options_.box);
  to.volume_rounding += part.volume_rounding;
  to.integral_rounding += part.integral_rounding;
  const double sign = sign_of(cell.corners);
  to.volume.add(sign * part.volume);
  to.integral.add(sign * part.integral);
  to.estimate.add(cell.error * part.volume);
  to.volume_bounds.add(sign * part.volume - part.volume_rounding,
                       sign * part.volume + part.volume_rounding);
  if (part.is_empty() && part.volume_rounding == 0) return;
  if (!part.is_empty()) ++to.n_cells;
  if (part.is_whole) ++to.n_whole;
  if (has_errors_everywhere(cell)) {
    const double off = cell.is_exact ? 0 : cell.error;
    add_integral_within(off, part, sign, to);
    add_extremes_within(off, part, cell, to.extremes);
  } else {
    const Range range = range_on(cell.corners);
    add_integral(part, range, sign, to);
    add_extremes(part, range, to.extremes);
  }
  if (cells_.is_exact_at_vertices || cell.is_exact) add_vertices(cell, to.extremes);
}

double CellIntegrator::sign_of(const std::array<Vec3d, 4>& p) {
  return dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]) < 0 ? -1 : 1;
}

Range CellIntegrator::range_on(const std::array<Vec3d, 4>& corners) const {
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

Box3d CellIntegrator::moved_box(const std::array<Vec3d, 4>& corners, double sign) const {
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

void CellIntegrator::add_extremes_within(double error, const CellPart& part,
                                         const IntegralCell& cell, Extremes& to) const {
  add_of_cut(part, to);
  const bool is_cut = options_.box && !part.is_whole;
  const auto part_in = [&](double sign) {
    return part_in_box(cell.corners, cell.values, moved_box(cell.corners, sign));
  };
  const CellPart least = is_cut ? part_in(-1) : part;
  const CellPart most = is_cut ? part_in(1) : part;
  const auto [low, high] = std::ranges::minmax(cell.values);
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

void CellIntegrator::add_extremes(const CellPart& part, const Range& range, Extremes& to) const {
  add_of_cut(part, to);
  to.lowest = std::min(to.lowest, range.low);
  to.highest = std::max(to.highest, range.high);
  if (part.volume > part.volume_rounding + deviation_) {
    to.reached_low = std::min(to.reached_low, range.high);
    to.reached_high = std::max(to.reached_high, range.low);
  }
}

void CellIntegrator::add_vertices(const IntegralCell& cell, Extremes& to) const {
  for (std::size_t k = 0; k < 4; ++k) {
    bool is_in = true;
    for (std::size_t i = 0; options_.box && i < 3; ++i)
      is_in = is_in && options_.box->lower[i] <= cell.corners[k][i] &&
              cell.corners[k][i] <= options_.box->upper[i];
    if (!is_in) continue;
    to.reached_low = std::min(to.reached_low, cell.values[k]);
    to.reached_high = std::max(to.reached_high, cell.values[k]);
  }
}

}  // namespace lode::probe_sums

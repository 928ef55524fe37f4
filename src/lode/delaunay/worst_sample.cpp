#include "lode/delaunay/worst_sample.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "lode/delaunay/triangle_error.h"
#include "lode/delaunay/triangle_rows.h"

namespace lode::delaunay {
namespace {

constexpr double kFloatUnit = 0x1p-24;   // half a unit in the last place of 1
constexpr double kDoubleUnit = 0x1p-53;  // of a double
constexpr double kSecondOrder = 1 + 0x1p-10;

/// Underflow: what a lane's smallest number times 2^24 columns or rows may come to, and more.
constexpr double kFloatUnderflow = 0x1p-120;
constexpr double kDoubleUnderflow = 0x1p-1040;

/// `unit` and `underflow`: of the arithmetic along rows.
RoundingSlack slack_of(double unit, double underflow, double lower, double upper) {
  const double size = std::max(std::abs(lower), std::abs(upper));
  const double range = upper - lower;
  return {kSecondOrder * (unit * (2 * size + 3 * range) + 4 * kDoubleUnit * size) + underflow,
          kSecondOrder * 64 * kDoubleUnit * range, kSecondOrder * 3 * unit};
}

struct Corners {
  LatticePoint a, b, c;
  std::int64_t area;

  Corners(const LatticePacking& packing, const std::array<std::uint32_t, 3>& packed)
      : a(packing.unpack(packed[0])),
        b(packing.unpack(packed[1])),
        c(packing.unpack(packed[2])),
        area(doubled_area(a, b, c)) {}

  [[nodiscard]] bool has(LatticePoint p) const { return p == a || p == b || p == c; }
  [[nodiscard]] double stretch() const {
    const auto width = std::max({a.x, b.x, c.x}) - std::min({a.x, b.x, c.x});
    const auto height = std::max({a.y, b.y, c.y}) - std::min({a.y, b.y, c.y});
    return static_cast<double>(width) * height / static_cast<double>(area);
  }
  /// Calls visit(point) for all nodes but the corners.
  template <typename Visit>
  void for_each_node(const Visit& visit) const {
    for (TriangleRows row(a, b, c); row.has_row(); row.next())
      for (LatticePoint p{row.first(), row.y()}; p.x <= row.last(); ++p.x)
        if (!has(p)) visit(p);
  }
};

/// Heights of 17 bits and 32 bits for a column and a row together: all fits in 53 bits.
template <typename T>
WorstSample find_in_integers(const SampleRows<T>& rows, const Corners& at) {
  const auto height = [&](LatticePoint p) {
    return static_cast<std::int64_t>(rows.samples[p.y * rows.stride + p.x]);
  };
  const std::int64_t za = height(at.a);
  const std::int64_t zb = height(at.b) - za;
  const std::int64_t zc = height(at.c) - za;
  const std::int64_t x_slope = zb * (at.c.y - at.a.y) - zc * (at.b.y - at.a.y);
  const std::int64_t y_slope = zc * (at.b.x - at.a.x) - zb * (at.c.x - at.a.x);
  std::int64_t worst = 0;
  std::uint32_t node = WorstSample::kNone;
  at.for_each_node([&](LatticePoint p) {
    const std::int64_t error =
        std::abs((height(p) - za) * at.area - x_slope * (p.x - at.a.x) - y_slope * (p.y - at.a.y));
    if (error <= worst) return;
    worst = error;
    node = rows.packing.pack(p);
  });
  return {divided_up(worst, at.area), node, 0};
}

/// Of nodes for which is_wanted(node).
template <typename T, typename IsWanted>
WorstSample find_in_doubles(const SampleRows<T>& rows, const RoundingSlack& slack,
                            const Corners& at, const IsWanted& is_wanted) {
  const double za = rows.height(at.a);
  const double zb = rows.height(at.b) - za;
  const double zc = rows.height(at.c) - za;
  const double scale = 1.0 / static_cast<double>(at.area);
  const double x_slope = (zb * (at.c.y - at.a.y) - zc * (at.b.y - at.a.y)) * scale;
  const double y_slope = (zc * (at.b.x - at.a.x) - zb * (at.c.x - at.a.x)) * scale;
  double worst = 0;
  std::uint32_t node = WorstSample::kNone;
  std::uint32_t first = WorstSample::kNone;
  at.for_each_node([&](LatticePoint p) {
    if (!is_wanted(p)) return;
    if (first == WorstSample::kNone) first = rows.packing.pack(p);
    const double plane = (za + y_slope * (p.y - at.a.y)) + x_slope * (p.x - at.a.x);
    const double error = std::abs(rows.height(p) - plane);
    if (error <= worst) return;
    worst = error;
    node = rows.packing.pack(p);
  });
  if (first == WorstSample::kNone) return {};
  // Of a level triangle only the last difference is rounded, and zero is exact.
  const bool is_level = zb == 0 && zc == 0;
  const double rounding = is_level ? worst * 2 * kDoubleUnit : slack.of(at.stretch());
  if (node == WorstSample::kNone && rounding > 0) node = first;
  return {worst + rounding, node, rounding};
}

}  // namespace

template <typename T>
RoundingSlack lane_slack(double lower, double upper) {
  if (std::is_same_v<T, double>) return double_slack(lower, upper);
  return slack_of(kFloatUnit, kFloatUnderflow, lower, upper);
}
template RoundingSlack lane_slack<std::int16_t>(double, double);
template RoundingSlack lane_slack<std::uint16_t>(double, double);
template RoundingSlack lane_slack<float>(double, double);
template RoundingSlack lane_slack<double>(double, double);

RoundingSlack double_slack(double lower, double upper) {
  return slack_of(kDoubleUnit, kDoubleUnderflow, lower, upper);
}

template <typename T>
WorstSample find_worst_exactly(const SampleRows<T>& rows, const RoundingSlack& slack,
                               const std::array<std::uint32_t, 3>& corners) {
  const Corners at(rows.packing, corners);
  if constexpr (std::is_integral_v<T>) return find_in_integers(rows, at);
  return find_in_doubles(rows, slack, at, [](LatticePoint /*node*/) { return true; });
}
template WorstSample find_worst_exactly(const SampleRows<std::int16_t>&, const RoundingSlack&,
                                        const std::array<std::uint32_t, 3>&);
template WorstSample find_worst_exactly(const SampleRows<std::uint16_t>&, const RoundingSlack&,
                                        const std::array<std::uint32_t, 3>&);
template WorstSample find_worst_exactly(const SampleRows<float>&, const RoundingSlack&,
                                        const std::array<std::uint32_t, 3>&);
template WorstSample find_worst_exactly(const SampleRows<double>&, const RoundingSlack&,
                                        const std::array<std::uint32_t, 3>&);

template <typename T>
WorstSample find_worst_inside(const SampleRows<T>& rows, const RoundingSlack& slack,
                              const std::array<std::uint32_t, 3>& corners,
                              const LatticePart& part) {
  return find_in_doubles(rows, slack, Corners(rows.packing, corners), [&](LatticePoint p) {
    return p.x > part.first.x && p.x < part.last.x && p.y > part.first.y && p.y < part.last.y;
  });
}
template WorstSample find_worst_inside(const SampleRows<float>&, const RoundingSlack&,
                                       const std::array<std::uint32_t, 3>&, const LatticePart&);
template WorstSample find_worst_inside(const SampleRows<double>&, const RoundingSlack&,
                                       const std::array<std::uint32_t, 3>&, const LatticePart&);

}  // namespace lode::delaunay

// Included again by Highway for each instruction set.
#include <algorithm>
#include <cmath>

#include "lode/delaunay/triangle_rows.h"
#include "lode/delaunay/worst_sample.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/delaunay/worst_sample_lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lode::delaunay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, 16>;
using Doubles = hn::CappedTag<double, 8>;

template <typename T>
HWY_INLINE hn::Vec<Floats> load(Floats d, const T* samples) {
  const hn::Rebind<std::int32_t, Floats> whole;
  return hn::ConvertTo(d, hn::PromoteTo(whole, hn::LoadU(hn::Rebind<T, Floats>(), samples)));
}
HWY_INLINE hn::Vec<Floats> load(Floats d, const float* samples) { return hn::LoadU(d, samples); }
HWY_INLINE hn::Vec<Doubles> load(Doubles d, const double* samples) { return hn::LoadU(d, samples); }

template <typename T>
struct TagOf {
  using Type = Floats;
};
template <>
struct TagOf<double> {
  using Type = Doubles;
};

/// z(x, y) = base + x_slope (x - origin.x) + y_slope (y - origin.y), in doubles.
struct Plane {
  LatticePoint origin;
  double base, x_slope, y_slope;
};

/// The worst of what has been seen, by lanes: the first of equals in each.
template <typename D>
class Worst {
 public:
  using Real = hn::TFromD<D>;
  using Node = hn::RebindToUnsigned<D>;
  using NodeT = hn::TFromD<Node>;

  HWY_INLINE Worst()
      : error_(hn::Zero(D())), node_(hn::Set(Node(), static_cast<NodeT>(WorstSample::kNone))) {}

  template <typename T>
  HWY_INLINE void see(const T* samples, std::int32_t n, std::uint32_t node, Real base, Real slope) {
    const D d;
    const Node dn;
    const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
    const auto bases = hn::Set(d, base);
    const auto slopes = hn::Set(d, slope);
    for (std::int32_t i = 0; i < n; i += lanes) {
      const auto step = hn::Add(hn::Iota(d, Real{0}), hn::Set(d, static_cast<Real>(i)));
      const auto plane = hn::Add(bases, hn::Mul(slopes, step));
      auto error = hn::Abs(hn::Sub(load(d, samples + i), plane));
      if (n - i < lanes)
        error = hn::IfThenElseZero(hn::FirstN(d, static_cast<std::size_t>(n - i)), error);
      const auto is_worse = hn::Gt(error, error_);
      error_ = hn::IfThenElse(is_worse, error, error_);
      const auto nodes = hn::Iota(dn, static_cast<NodeT>(node + static_cast<std::uint32_t>(i)));
      node_ = hn::IfThenElse(hn::RebindMask(dn, is_worse), nodes, node_);
    }
  }

  HWY_INLINE WorstSample of_all() const {
    const D d;
    const Node dn;
    HWY_ALIGN Real errors[hn::MaxLanes(D())];
    HWY_ALIGN NodeT nodes[hn::MaxLanes(D())];
    hn::Store(error_, d, errors);
    hn::Store(node_, dn, nodes);
    Real error = 0;
    NodeT node = WorstSample::kNone;
    for (std::size_t i = 0; i < hn::Lanes(d); ++i) {
      const bool is_worse = errors[i] > error || (errors[i] == error && nodes[i] < node);
      error = is_worse ? errors[i] : error;
      node = is_worse ? nodes[i] : node;
    }
    return {static_cast<double>(error), static_cast<std::uint32_t>(node), 0};
  }

 private:
  hn::Vec<D> error_;
  hn::Vec<Node> node_;
};

template <typename T>
WorstSample find(const SampleRows<T>& rows, const RoundingSlack& slack,
                 const std::array<std::uint32_t, 3>& corners) {
  using D = typename TagOf<T>::Type;
  using Real = hn::TFromD<D>;
  const LatticePoint a = rows.packing.unpack(corners[0]);
  const LatticePoint b = rows.packing.unpack(corners[1]);
  const LatticePoint c = rows.packing.unpack(corners[2]);
  const std::int64_t area = doubled_area(a, b, c);
  if (area == 1) return {};  // Pick's theorem: no nodes but the corners
  const double za = rows.height(a);
  const double zb = rows.height(b) - za;
  const double zc = rows.height(c) - za;
  const double scale = 1.0 / static_cast<double>(area);
  const Plane plane{a, za, (zb * (c.y - a.y) - zc * (b.y - a.y)) * scale,
                    (zc * (b.x - a.x) - zb * (c.x - a.x)) * scale};
  Worst<D> worst;
  const auto slope = static_cast<Real>(plane.x_slope);
  for (TriangleRows row(a, b, c); row.has_row(); row.next()) {
    const std::int32_t n = row.last() - row.first() + 1;
    if (n <= 0) continue;
    const double base =
        (plane.base + plane.y_slope * (row.y() - a.y)) + plane.x_slope * (row.first() - a.x);
    worst.see(rows.samples + row.y() * rows.stride + row.first(), n,
              rows.packing.pack({row.first(), row.y()}), static_cast<Real>(base), slope);
  }
  WorstSample found = worst.of_all();
  const auto width = std::max({a.x, b.x, c.x}) - std::min({a.x, b.x, c.x});
  const auto height = std::max({a.y, b.y, c.y}) - std::min({a.y, b.y, c.y});
  found.slack = slack.of(static_cast<double>(width) * height * scale);
  found.error += found.slack;
  return found;
}

// Functions, as only those are chosen by processor.
FindWorst<std::int16_t> find_int16() { return find<std::int16_t>; }
FindWorst<std::uint16_t> find_uint16() { return find<std::uint16_t>; }
FindWorst<float> find_float() { return find<float>; }
FindWorst<double> find_double() { return find<double>; }

}  // namespace lode::delaunay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::delaunay {

HWY_EXPORT(find_int16);
HWY_EXPORT(find_uint16);
HWY_EXPORT(find_float);
HWY_EXPORT(find_double);

template <>
FindWorst<std::int16_t> find_worst_sample<std::int16_t>() {
  return HWY_DYNAMIC_DISPATCH(find_int16)();
}
template <>
FindWorst<std::uint16_t> find_worst_sample<std::uint16_t>() {
  return HWY_DYNAMIC_DISPATCH(find_uint16)();
}
template <>
FindWorst<float> find_worst_sample<float>() {
  return HWY_DYNAMIC_DISPATCH(find_float)();
}
template <>
FindWorst<double> find_worst_sample<double>() {
  return HWY_DYNAMIC_DISPATCH(find_double)();
}

}  // namespace lode::delaunay
#endif

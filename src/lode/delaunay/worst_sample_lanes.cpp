// Included again by Highway for each instruction set.
#include <algorithm>
#include <cmath>
#include <type_traits>

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

/// As many samples as there are lanes.
template <typename D, typename T>
HWY_INLINE hn::Vec<D> load(D d, const T* samples) {
  if constexpr (std::is_integral_v<T>) {
    const hn::Rebind<std::int32_t, D> whole;
    return hn::ConvertTo(d, hn::PromoteTo(whole, hn::LoadU(hn::Rebind<T, D>(), samples)));
  } else {
    return hn::LoadU(d, samples);
  }
}

template <typename T>
struct TagOf {
  using Type = Floats;
};
template <>
struct TagOf<double> {
  using Type = Doubles;
};

/// A triangle and the plane of its heights, z = za + x_slope (x - a.x) + y_slope (y - a.y).
struct Slanted {
  LatticePoint a, b, c;
  std::int32_t left, right, low, high;
  double scale, za, x_slope, y_slope;

  [[nodiscard]] double at(LatticePoint p) const {
    return (za + y_slope * (p.y - a.y)) + x_slope * (p.x - a.x);
  }
  [[nodiscard]] double stretch() const {
    return static_cast<double>(right - left) * (high - low) * scale;
  }
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

  HWY_INLINE void see(hn::Vec<D> error, hn::Vec<Node> nodes) {
    const auto is_worse = hn::RebindMask(Node(), hn::Gt(error, error_));
    error_ = hn::Max(error, error_);
    node_ = hn::IfThenElse(is_worse, nodes, node_);
  }

  /// n samples in a row, nodes `apart` packed steps from one another; the plane is base there at
  /// first and changes by slope.
  template <typename T>
  HWY_INLINE void see_row(const T* samples, std::int32_t n, std::uint32_t node, NodeT apart,
                          Real base, Real slope) {
    const D d;
    const Node dn;
    const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
    const auto bases = hn::Set(d, base);
    const auto slopes = hn::Set(d, slope);
    const auto more = hn::Set(d, static_cast<Real>(lanes));
    const auto more_nodes = hn::Set(dn, static_cast<NodeT>(lanes) * apart);
    auto step = hn::Iota(d, Real{0});
    auto nodes =
        hn::Add(hn::Mul(hn::Iota(dn, NodeT{0}), hn::Set(dn, apart)), hn::Set(dn, NodeT{node}));
    std::int32_t i = 0;
    for (; i + lanes <= n; i += lanes) {
      see(hn::Abs(hn::Sub(load(d, samples + i), hn::Add(bases, hn::Mul(slopes, step)))), nodes);
      step = hn::Add(step, more);
      nodes = hn::Add(nodes, more_nodes);
    }
    if (i == n) return;
    const auto error =
        hn::Abs(hn::Sub(load(d, samples + i), hn::Add(bases, hn::Mul(slopes, step))));
    see(hn::IfThenElseZero(hn::FirstN(d, static_cast<std::size_t>(n - i)), error), nodes);
  }

  HWY_INLINE WorstSample of_all() const {
    if constexpr (sizeof(Real) == sizeof(float)) {
      const D d;
      const Node dn;
      const auto worst = hn::MaxOfLanes(d, error_);
      const auto nodes = hn::IfThenElse(hn::RebindMask(dn, hn::Eq(error_, worst)), node_,
                                        hn::Set(dn, static_cast<NodeT>(WorstSample::kNone)));
      return {static_cast<double>(hn::GetLane(worst)),
              static_cast<std::uint32_t>(hn::GetLane(hn::MinOfLanes(dn, nodes))), 0};
    } else {
      return of_each();
    }
  }

 private:
  /// Lane by lane: not all instruction sets find the smallest of 64 bits.
  HWY_INLINE WorstSample of_each() const {
    const D d;
    const Node dn;
    HWY_ALIGN Real errors[hn::MaxLanes(D())];
    HWY_ALIGN NodeT nodes[hn::MaxLanes(D())];
    hn::Store(error_, d, errors);
    hn::Store(node_, dn, nodes);
    Real error = errors[0];
    for (std::size_t i = 1; i < hn::Lanes(d); ++i) error = errors[i] > error ? errors[i] : error;
    NodeT node = WorstSample::kNone;
    for (std::size_t i = 0; i < hn::Lanes(d); ++i) {
      const NodeT own = errors[i] == error ? nodes[i] : NodeT{WorstSample::kNone};
      node = own < node ? own : node;
    }
    return {static_cast<double>(error), static_cast<std::uint32_t>(node), 0};
  }

  hn::Vec<D> error_;
  hn::Vec<Node> node_;
};

/// Boxes so small are looked at as a whole: most triangles' are, and rows would cost more than
/// samples. Not a number of lanes, on which results must not depend.
constexpr std::int32_t kSmallWidth = 8;
constexpr std::int32_t kSmallHeight = 16;

/// An edge p -> q: positive to its left; whole numbers, of which Real holds those of small boxes.
template <typename Real>
struct EdgeSide {
  Real here, x_step, y_step;

  EdgeSide(LatticePoint p, LatticePoint q, LatticePoint at)
      : here(static_cast<Real>((q.x - p.x) * (at.y - p.y) - (q.y - p.y) * (at.x - p.x))),
        x_step(static_cast<Real>(p.y - q.y)),
        y_step(static_cast<Real>(q.x - p.x)) {}
};

template <typename T>
HWY_INLINE WorstSample find_in_box(const SampleRows<T>& rows, const Slanted& t) {
  using D = hn::CappedTag<hn::TFromD<typename TagOf<T>::Type>, kSmallWidth>;
  using Real = hn::TFromD<D>;
  using NodeT = typename Worst<D>::NodeT;
  const D d;
  const typename Worst<D>::Node dn;
  Worst<D> worst;
  const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
  // Of a number that is not known when this is compiled Highway's Iota() goes through memory.
  const auto step = hn::Iota(d, Real{0});
  const auto node_step = hn::Iota(dn, NodeT{0});
  for (std::int32_t x = t.left; x <= t.right; x += lanes) {
    const LatticePoint at{x, t.low};
    const EdgeSide<Real> sides[3] = {{t.a, t.b, at}, {t.b, t.c, at}, {t.c, t.a, at}};
    const auto line = [&](const EdgeSide<Real>& side) HWY_ATTR {
      return hn::Add(hn::Set(d, side.here), hn::Mul(hn::Set(d, side.x_step), step));
    };
    auto u = line(sides[0]);
    auto v = line(sides[1]);
    auto w = line(sides[2]);
    const auto x_terms = hn::Mul(hn::Set(d, static_cast<Real>(t.x_slope)),
                                 hn::Add(hn::Set(d, static_cast<Real>(x - t.a.x)), step));
    const T* samples = rows.samples + t.low * rows.stride + x;
    for (std::int32_t y = t.low; y <= t.high; ++y, samples += rows.stride) {
      const auto y_term = static_cast<Real>(t.y_slope) * static_cast<Real>(y - t.a.y);
      const auto plane =
          hn::Add(hn::Set(d, static_cast<Real>(t.za)), hn::Add(x_terms, hn::Set(d, y_term)));
      const auto is_inside = hn::Ge(hn::Min(u, hn::Min(v, w)), hn::Zero(d));
      const auto error = hn::Abs(hn::Sub(load(d, samples), plane));
      worst.see(hn::IfThenElseZero(is_inside, error),
                hn::Add(hn::Set(dn, NodeT{rows.packing.pack({x, y})}), node_step));
      u = hn::Add(u, hn::Set(d, sides[0].y_step));
      v = hn::Add(v, hn::Set(d, sides[1].y_step));
      w = hn::Add(w, hn::Set(d, sides[2].y_step));
    }
  }
  return worst.of_all();
}

template <typename T>
WorstSample find_in_rows(const SampleRows<T>& rows, const Slanted& t) {
  using D = typename TagOf<T>::Type;
  using Real = hn::TFromD<D>;
  Worst<D> worst;
  for (TriangleRows row(t.a, t.b, t.c); row.has_row(); row.next()) {
    const LatticePoint first{row.first(), row.y()};
    const std::int32_t n = row.last() - first.x + 1;
    if (n <= 0) continue;
    worst.see_row(rows.samples + first.y * rows.stride + first.x, n, rows.packing.pack(first), 1,
                  static_cast<Real>(t.at(first)), static_cast<Real>(t.x_slope));
  }
  return worst.of_all();
}

/// Only nodes whose columns and rows are multiples of 2^spacing_bits, of which `rows` has samples.
template <typename T>
WorstSample find_in_sparse_rows(const SampleRows<T>& rows, const Slanted& t) {
  using D = typename TagOf<T>::Type;
  using Real = hn::TFromD<D>;
  const int bits = rows.spacing_bits;
  Worst<D> worst;
  for (SparseRows row(t.a, t.b, t.c, bits); row.has_row(); row.next()) {
    const std::int32_t n = row.last() - row.first() + 1;
    if (n <= 0) continue;
    const LatticePoint first{row.first() << bits, row.y() << bits};
    worst.see_row(rows.samples + row.y() * rows.stride + row.first(), n, rows.packing.pack(first),
                  typename Worst<D>::NodeT{1} << bits, static_cast<Real>(t.at(first)),
                  static_cast<Real>(t.x_slope * (1 << bits)));
  }
  return worst.of_all();
}

template <typename T>
WorstSample find(const SampleRows<T>& rows, const RoundingSlack& slack,
                 const std::array<std::uint32_t, 3>& corners, std::array<double, 3> z) {
  const LatticePoint a = rows.packing.unpack(corners[0]);
  const LatticePoint b = rows.packing.unpack(corners[1]);
  const LatticePoint c = rows.packing.unpack(corners[2]);
  const std::int64_t area = doubled_area(a, b, c);
  if (area == 1) return {};  // Pick's theorem: no nodes but the corners
  const double zb = z[1] - z[0];
  const double zc = z[2] - z[0];
  const double scale = 1.0 / static_cast<double>(area);
  const Slanted t{a,
                  b,
                  c,
                  std::min({a.x, b.x, c.x}),
                  std::max({a.x, b.x, c.x}),
                  std::min({a.y, b.y, c.y}),
                  std::max({a.y, b.y, c.y}),
                  scale,
                  z[0],
                  (zb * (c.y - a.y) - zc * (b.y - a.y)) * scale,
                  (zc * (b.x - a.x) - zb * (c.x - a.x)) * scale};
  const std::int32_t width = t.right - t.left;
  const std::int32_t height = t.high - t.low;
  const bool is_small = width < kSmallWidth && height < kSmallHeight;
  WorstSample found = rows.spacing_bits > 0 ? find_in_sparse_rows(rows, t)
                      : is_small            ? find_in_box(rows, t)
                                            : find_in_rows(rows, t);
  found.slack = slack.of(t.stretch());
  if (is_small)
    found.slack += slack.per_rise * (std::abs(t.x_slope) * width + std::abs(t.y_slope) * height);
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

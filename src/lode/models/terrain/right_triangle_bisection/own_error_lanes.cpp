// Included again by Highway for each instruction set.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "lode/delaunay/triangle_error.h"
#include "lode/models/terrain/right_triangle_bisection/own_errors.h"

#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/terrain/right_triangle_bisection/own_error_lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lode::bisection::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// What residuals are computed in, so many side by side: all times the side of a triangle's square,
/// which makes those of 16 bits whole numbers below 2^31 for sides up to 2^14.
template <typename T>
using Residual = std::conditional_t<std::is_integral_v<T>, std::int32_t, double>;
constexpr std::int32_t kMostWholeSide = 1 << 14;

template <typename S>
inline constexpr int kLanes = 64 / static_cast<int>(sizeof(S));
template <typename S>
using Tag = hn::CappedTag<S, 64 / sizeof(S)>;

template <typename S, typename T>
HWY_INLINE hn::Vec<Tag<S>> load(const T* samples) {
  const Tag<S> d;
  const hn::Rebind<T, Tag<S>> of_sample;
  if constexpr (std::is_same_v<S, T>) {
    return hn::LoadU(d, samples);
  } else if constexpr (std::is_same_v<S, double> && std::is_integral_v<T>) {
    const hn::Rebind<std::int32_t, Tag<S>> whole;
    return hn::PromoteTo(d, hn::PromoteTo(whole, hn::LoadU(of_sample, samples)));
  } else {
    return hn::PromoteTo(d, hn::LoadU(of_sample, samples));
  }
}

HWY_INLINE void raise(float& error, float to) {
  std::atomic_ref<float> shared(error);
  float known = shared.load(std::memory_order_relaxed);
  while (known < to && !shared.compare_exchange_weak(known, to, std::memory_order_relaxed)) {
  }
}

/// A triangle's heights along rows, times the side: dv more with each column.
template <typename S>
class Slope {
 public:
  using Vec = hn::Vec<Tag<S>>;
  explicit Slope(S dv) : dv_(dv), ramp_(hn::Mul(hn::Iota(Tag<S>(), S{0}), hn::Set(Tag<S>(), dv))) {}

  /// The largest of `worst` and the residuals of n samples, the first of which is v in the plane.
  template <typename T>
  HWY_INLINE Vec look(const T* z, std::int32_t n, S v, S side, Vec worst) const {
    const Tag<S> d;
    const auto step = static_cast<std::int32_t>(hn::Lanes(d));
    const Vec scale = hn::Set(d, side);
    std::int32_t i = 0;
    for (; i + step <= n; i += step) worst = hn::Max(worst, residual(z, i, v, scale));
    if (i < n) {
      const auto is_in = hn::FirstN(d, static_cast<std::size_t>(n - i));
      worst = hn::Max(worst, hn::IfThenElseZero(is_in, residual(z, i, v, scale)));
    }
    return worst;
  }

 private:
  template <typename T>
  HWY_INLINE Vec residual(const T* z, std::int32_t i, S v, Vec scale) const {
    const Tag<S> d;
    const Vec plane = hn::Add(ramp_, hn::Set(d, v + static_cast<S>(i) * dv_));
    return hn::Abs(hn::Sub(hn::Mul(load<S>(z + i), scale), plane));
  }

  S dv_;
  Vec ramp_;
};

/// A square of 2^k columns and rows, and what is to be looked at of it: rows [begin, end) of it.
template <typename S, typename T>
struct BigSquare {
  using Vec = hn::Vec<Tag<S>>;

  const RasterRows<T>& rows;
  LatticePoint last;
  std::int32_t x, y, side, begin, end;

  /// Whether all of its columns and rows are in the raster; the first half of them is.
  [[nodiscard]] bool fits_x() const { return x + side <= last.x; }
  [[nodiscard]] bool fits_y() const { return y + side <= last.y; }
  /// 0 beyond the raster.
  [[nodiscard]] S z(std::int32_t dx, std::int32_t dy) const {
    return x + dx <= last.x && y + dy <= last.y ? static_cast<S>(rows.row(y + dy)[x + dx]) : S{0};
  }
  [[nodiscard]] S whole() const { return static_cast<S>(side); }
  [[nodiscard]] static S worst_of(Vec worst) {
    return hn::GetLane(hn::MaxOfLanes(Tag<S>(), worst));
  }

  /// The node in its middle, whose hypotenuse goes up or down to the right.
  [[nodiscard]] S square_error() const {
    const S z00 = z(0, 0), z10 = z(side, 0), z01 = z(0, side), z11 = z(side, side);
    const bool runs_up = ((x / side + y / side) & 1) == 0;
    const Slope<S> left(runs_up ? z11 - z01 : z10 - z00);
    const Slope<S> right(runs_up ? z10 - z00 : z11 - z01);
    Vec worst = hn::Zero(Tag<S>());
    for (std::int32_t t = std::max(begin, 1); t < std::min(end, side); ++t) {
      const T* row = rows.row(y + t) + x;
      const S up = static_cast<S>(t);
      const std::int32_t cut = runs_up ? t : side - t;
      // Heights of the two planes at column 0.
      const S left_v = whole() * z00 + up * (z01 - z00);
      const S right_v = runs_up ? whole() * z00 + up * (z11 - z10)
                                : whole() * z10 + up * (z11 - z10) - whole() * (z11 - z01);
      const S left_dv = runs_up ? z11 - z01 : z10 - z00;
      const S right_dv = runs_up ? z10 - z00 : z11 - z01;
      worst = left.look(row + 1, cut, left_v + left_dv, whole(), worst);
      worst = right.look(row + cut + 1, side - 1 - cut,
                         right_v + right_dv * static_cast<S>(cut + 1), whole(), worst);
    }
    return worst_of(worst);
  }

  /// The nodes in the middles of its sides, from its half of their diamonds, as far as that is in
  /// the raster: lower, left, right, upper.
  HWY_INLINE void side_errors(S (&errors)[4]) const {
    const std::int32_t half = side / 2;
    const S z00 = z(0, 0), z10 = z(side, 0), z01 = z(0, side), z11 = z(side, side);
    const S middle = 2 * z(half, half);
    const S rise_lower = middle - z00 - z10, rise_left = middle - z00 - z01;
    const S rise_right = middle - z10 - z11, rise_upper = middle - z01 - z11;
    const Slope<S> lower(z10 - z00), left(rise_left), right(-rise_right), upper(z11 - z01);
    Vec worst[4] = {hn::Zero(Tag<S>()), hn::Zero(Tag<S>()), hn::Zero(Tag<S>()), hn::Zero(Tag<S>())};
    for (std::int32_t t = begin; t < end; ++t) {
      const T* row = rows.row(y + t) + x;
      const S up = static_cast<S>(t), down = static_cast<S>(side - t);
      const std::int32_t m = std::min(t, side - t);
      if (m > 0 && fits_y()) {
        worst[1] = left.look(row, m, whole() * z00 + up * (z01 - z00), whole(), worst[1]);
        const S first = whole() * z10 + up * (z11 - z10) + static_cast<S>(m - 1) * rise_right;
        if (fits_x()) worst[2] = right.look(row + side - m + 1, m, first, whole(), worst[2]);
      }
      if (!fits_x()) continue;
      const std::int32_t n = side - 2 * m - 1;
      const S columns = static_cast<S>(m + 1);
      const S of_lower = whole() * z00 + columns * (z10 - z00) + up * rise_lower;
      const S of_upper = whole() * z01 + columns * (z11 - z01) + down * rise_upper;
      if (t < half)
        worst[0] = lower.look(row + m + 1, n, of_lower, whole(), worst[0]);
      else if (fits_y())
        worst[3] = upper.look(row + m + 1, n, of_upper, whole(), worst[3]);
    }
    for (int i = 0; i < 4; ++i) errors[i] = worst_of(worst[i]);
  }
};

/// Of all squares with a side of `side` > kStripRows whose middles are in the raster.
template <typename S, typename T>
void add_big_squares(const RasterRows<T>& rows, const Lattice& lattice, std::int32_t y,
                     std::int32_t side, float* errors) {
  const LatticePoint last = lattice.last();
  const std::int32_t half = side / 2;
  const std::int32_t y0 = y / side * side;
  if (y0 + half > last.y) return;
  // The last row of all is nobody's lower side.
  const bool is_last = y + kStripRows >= last.y;
  const std::int32_t end = is_last ? last.y + 1 - y0 : y + kStripRows - y0;
  const double unit = 1.0 / side;
  const auto raise_at = [&](std::int32_t x, std::int32_t row, S residual) {
    raise(errors[lattice.index({x, row})],
          delaunay::to_float_above(static_cast<double>(residual) * unit));
  };
  for (std::int32_t x = 0; x + half <= last.x; x += side) {
    const BigSquare<S, T> square{rows, last, x, y0, side, y - y0, end};
    if (square.fits_x() && square.fits_y()) raise_at(x + half, y0 + half, square.square_error());
    S of_sides[4];
    square.side_errors(of_sides);
    raise_at(x + half, y0, of_sides[0]);
    raise_at(x, y0 + half, of_sides[1]);
    if (square.fits_x()) raise_at(x + side, y0 + half, of_sides[2]);
    if (square.fits_y()) raise_at(x + half, y0 + side, of_sides[3]);
  }
}

constexpr int kBlock = kStripRows;  ///< Columns and rows of a block of cells.

/// kLanes blocks side by side: heights, and errors times kBlock, of node (x, y) of each.
template <typename S>
struct Blocks {
  alignas(64) S z[kBlock + 1][kBlock + 1][kLanes<S>];
  alignas(64) S errors[kBlock + 1][kBlock + 1][kLanes<S>];
};

/// The same lanes of all blocks, from `lane` on.
template <typename S>
class BlockLanes {
 public:
  using Vec = hn::Vec<Tag<S>>;
  BlockLanes(Blocks<S>& blocks, std::size_t lane) : blocks_(blocks), lane_(lane) {}

  HWY_INLINE Vec z(int x, int y) const { return hn::Load(Tag<S>(), &blocks_.z[y][x][lane_]); }
  /// Raises errors of a node to a residual times `side`.
  HWY_INLINE void raise_error(int x, int y, Vec residual, int side) const {
    S* const at = &blocks_.errors[y][x][lane_];
    const Vec scaled =
        hn::Mul(residual, hn::Set(Tag<S>(), static_cast<S>(kBlock) / static_cast<S>(side)));
    hn::Store(hn::Max(hn::Load(Tag<S>(), at), scaled), Tag<S>(), at);
  }

  /// n samples of row y from column x on; the first is v, times the side, in the plane.
  template <int kSide>
  HWY_INLINE Vec look(int x, int y, int n, Vec v, Vec dv, Vec worst) const {
    for (int i = 0; i < n; ++i, v = hn::Add(v, dv))
      worst = hn::Max(worst, hn::Abs(hn::Sub(times<kSide>(z(x + i, y)), v)));
    return worst;
  }
  template <int kFactor>
  HWY_INLINE static Vec times(Vec v) {
    return hn::Mul(v, hn::Set(Tag<S>(), static_cast<S>(kFactor)));
  }

  template <int kSide>
  HWY_INLINE Vec square_up(int x, int y) const {
    const Vec z00 = z(x, y), z10 = z(x + kSide, y), z01 = z(x, y + kSide),
              z11 = z(x + kSide, y + kSide);
    const Vec bottom = hn::Sub(z10, z00), top = hn::Sub(z11, z01);
    const Vec left = hn::Sub(z01, z00), right = hn::Sub(z11, z10);
    Vec at_left = times<kSide>(z00), at_cut = at_left;  // On column 0, in either plane.
    Vec worst = hn::Zero(Tag<S>());
    Vec columns = bottom;  // (t + 1) * bottom.
    for (int t = 1; t < kSide; ++t) {
      at_left = hn::Add(at_left, left);
      at_cut = hn::Add(at_cut, right);
      columns = hn::Add(columns, bottom);
      worst = look<kSide>(x + 1, y + t, t, hn::Add(at_left, top), top, worst);
      worst = look<kSide>(x + t + 1, y + t, kSide - 1 - t, hn::Add(at_cut, columns), bottom, worst);
    }
    return worst;
  }

  template <int kSide>
  HWY_INLINE Vec square_down(int x, int y) const {
    const Vec z00 = z(x, y), z10 = z(x + kSide, y), z01 = z(x, y + kSide),
              z11 = z(x + kSide, y + kSide);
    const Vec bottom = hn::Sub(z10, z00), top = hn::Sub(z11, z01);
    const Vec left = hn::Sub(z01, z00), right = hn::Sub(z11, z10);
    Vec at_left = times<kSide>(z00), at_right = times<kSide>(z10);
    Vec worst = hn::Zero(Tag<S>());
    Vec back = hn::Zero(Tag<S>());  // (t - 1) * top.
    for (int t = 1; t < kSide; ++t) {
      at_left = hn::Add(at_left, left);
      at_right = hn::Add(at_right, right);
      const int cut = kSide - t;
      worst = look<kSide>(x + 1, y + t, cut, hn::Add(at_left, bottom), bottom, worst);
      worst = look<kSide>(x + cut + 1, y + t, t - 1, hn::Sub(at_right, back), top, worst);
      back = hn::Add(back, top);
    }
    return worst;
  }

  template <int kSide>
  HWY_INLINE void sides(int x, int y) const {
    constexpr int kHalf = kSide / 2;
    const Vec z00 = z(x, y), z10 = z(x + kSide, y), z01 = z(x, y + kSide),
              z11 = z(x + kSide, y + kSide);
    const Vec middle = times<2>(z(x + kHalf, y + kHalf));
    const Vec bottom = hn::Sub(z10, z00), top = hn::Sub(z11, z01);
    const Vec left = hn::Sub(z01, z00), right = hn::Sub(z11, z10);
    Vec worst_lower = hn::Zero(Tag<S>()), worst_upper = worst_lower;
    Vec worst_left = worst_lower, worst_right = worst_lower;
    // In each plane, one column inside of the diagonal, at row t or t rows below the top.
    Vec lower_v = hn::Add(times<kSide>(z00), bottom), upper_v = hn::Add(times<kSide>(z01), top);
    const Vec lower_step = hn::Add(hn::Sub(middle, hn::Add(z00, z10)), bottom);
    const Vec upper_step = hn::Add(hn::Sub(middle, hn::Add(z01, z11)), top);
    for (int t = 0; t < kHalf; ++t) {
      const int n = kSide - 2 * t - 1;
      worst_lower = look<kSide>(x + t + 1, y + t, n, lower_v, bottom, worst_lower);
      worst_upper = look<kSide>(x + t + 1, y + kSide - t, n, upper_v, top, worst_upper);
      lower_v = hn::Add(lower_v, lower_step);
      upper_v = hn::Add(upper_v, upper_step);
    }
    const Vec rise_left = hn::Sub(middle, hn::Add(z00, z01));
    const Vec rise_right = hn::Sub(middle, hn::Add(z10, z11));
    const Vec down_right = hn::Neg(rise_right);
    Vec left_v = times<kSide>(z00), right_v = times<kSide>(z10);
    Vec inside = hn::Zero(Tag<S>());  // (m - 1) * rise_right.
    for (int t = 1; t < kSide; ++t) {
      const int m = t < kSide - t ? t : kSide - t;
      left_v = hn::Add(left_v, left);
      right_v = hn::Add(right_v, right);
      worst_left = look<kSide>(x, y + t, m, left_v, rise_left, worst_left);
      worst_right = look<kSide>(x + kSide - m + 1, y + t, m, hn::Add(right_v, inside), down_right,
                                worst_right);
      if (t < kHalf)
        inside = hn::Add(inside, rise_right);
      else
        inside = hn::Sub(inside, rise_right);
    }
    raise_error(x + kHalf, y, worst_lower, kSide);
    raise_error(x, y + kHalf, worst_left, kSide);
    raise_error(x + kSide, y + kHalf, worst_right, kSide);
    raise_error(x + kHalf, y + kSide, worst_upper, kSide);
  }

  /// Squares of this side, in blocks that have several in a row.
  template <int kSide>
  HWY_INLINE void squares() const {
    for (int y = 0; y < kBlock; y += kSide)
      for (int x = 0; x < kBlock; x += kSide) {
        const bool runs_up = ((x + y) / kSide & 1) == 0;
        raise_error(x + kSide / 2, y + kSide / 2,
                    runs_up ? square_up<kSide>(x, y) : square_down<kSide>(x, y), kSide);
        sides<kSide>(x, y);
      }
  }

  /// The blocks themselves; whether the hypotenuse of the first goes up, the next goes down.
  HWY_INLINE void whole_blocks(bool is_first_up) const {
    alignas(64) S is_up[kLanes<S>];
    for (int i = 0; i < kLanes<S>; ++i) is_up[i] = static_cast<S>((i & 1) == (is_first_up ? 0 : 1));
    const Tag<S> d;
    const auto goes_up = hn::Ne(hn::Load(d, is_up + lane_), hn::Zero(d));
    raise_error(kBlock / 2, kBlock / 2,
                hn::IfThenElse(goes_up, square_up<kBlock>(0, 0), square_down<kBlock>(0, 0)),
                kBlock);
    sides<kBlock>(0, 0);
  }

 private:
  Blocks<S>& blocks_;
  std::size_t lane_;
};

/// Heights of blocks that begin at (x, y); beyond the raster those of its last column and row.
template <typename S, typename T>
void read_blocks(const RasterRows<T>& rows, LatticePoint last, std::int32_t x, std::int32_t y,
                 Blocks<S>& blocks) {
  const bool is_inside = x + kBlock * kLanes<S> <= last.x;
  for (int dy = 0; dy <= kBlock; ++dy) {
    const T* row = rows.row(std::min(y + dy, last.y));
    if (is_inside) {
      row += x;
      for (int lane = 0; lane < kLanes<S>; ++lane)
        for (int dx = 0; dx <= kBlock; ++dx)
          blocks.z[dy][dx][lane] = static_cast<S>(row[lane * kBlock + dx]);
    } else {
      for (int lane = 0; lane < kLanes<S>; ++lane)
        for (int dx = 0; dx <= kBlock; ++dx)
          blocks.z[dy][dx][lane] = static_cast<S>(row[std::min(x + lane * kBlock + dx, last.x)]);
    }
  }
}

template <typename S>
HWY_INLINE float error_of(S residual) {
  if constexpr (std::is_integral_v<S>)
    return static_cast<float>(residual) * (1.0F / kBlock);
  else
    return delaunay::to_float_above(residual * (1.0 / kBlock));
}

template <typename S>
void write_blocks(const Blocks<S>& blocks, const Lattice& lattice, std::int32_t x, std::int32_t y,
                  float* errors, float* upper) {
  const LatticePoint last = lattice.last();
  for (int dy = 0; dy <= std::min(kBlock, last.y - y); ++dy) {
    float* const row = dy < kBlock ? errors + (y + dy) * lattice.stride() : upper;
    for (int lane = 0; lane < kLanes<S> && x + lane * kBlock < last.x; ++lane) {
      const std::int32_t x0 = x + lane * kBlock;
      const int n = std::min(kBlock - 1, last.x - x0);
      float* const at = row + x0;
      for (int dx = 1; dx <= n; ++dx) at[dx] = error_of(blocks.errors[dy][dx][lane]);
      if (dy % kBlock == 0) continue;  // Corners are nodes of larger squares.
      // The left side has the other half of its nodes' diamonds in the block before.
      const float first = error_of(blocks.errors[dy][0][lane]);
      at[0] = x0 == 0 ? first : std::max(at[0], first);
      if (x0 + kBlock <= last.x) at[kBlock] = error_of(blocks.errors[dy][kBlock][lane]);
    }
  }
}

template <typename T>
void add_strip(const RasterRows<T>& rows, const Lattice& lattice, std::int32_t y, float* errors,
               float* upper) {
  using S = Residual<T>;
  Blocks<S> blocks;
  for (std::int32_t x = 0; x < lattice.last().x; x += kBlock * kLanes<S>) {
    read_blocks<S>(rows, lattice.last(), x, y, blocks);
    std::memset(blocks.errors, 0, sizeof blocks.errors);
    for (std::size_t lane = 0; lane < kLanes<S>; lane += hn::Lanes(Tag<S>())) {
      const BlockLanes<S> lanes(blocks, lane);
      lanes.template squares<2>();
      lanes.template squares<4>();
      lanes.template squares<8>();
      lanes.whole_blocks(((x / kBlock + y / kBlock) & 1) == 0);
    }
    write_blocks(blocks, lattice, x, y, errors, upper);
  }
  for (std::int32_t side = 2 * kStripRows; side <= lattice.side(); side *= 2)
    if (std::is_integral_v<T> && side > kMostWholeSide)
      add_big_squares<double>(rows, lattice, y, side, errors);
    else
      add_big_squares<S>(rows, lattice, y, side, errors);
}

AddStripErrors<std::int16_t> add_int16() { return &add_strip<std::int16_t>; }
AddStripErrors<std::uint16_t> add_uint16() { return &add_strip<std::uint16_t>; }
AddStripErrors<float> add_float() { return &add_strip<float>; }
AddStripErrors<double> add_double() { return &add_strip<double>; }

}  // namespace lode::bisection::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::bisection {

HWY_EXPORT(add_int16);
HWY_EXPORT(add_uint16);
HWY_EXPORT(add_float);
HWY_EXPORT(add_double);

template <>
AddStripErrors<std::int16_t> add_strip_errors<std::int16_t>() {
  return HWY_DYNAMIC_DISPATCH(add_int16)();
}
template <>
AddStripErrors<std::uint16_t> add_strip_errors<std::uint16_t>() {
  return HWY_DYNAMIC_DISPATCH(add_uint16)();
}
template <>
AddStripErrors<float> add_strip_errors<float>() {
  return HWY_DYNAMIC_DISPATCH(add_float)();
}
template <>
AddStripErrors<double> add_strip_errors<double>() {
  return HWY_DYNAMIC_DISPATCH(add_double)();
}

}  // namespace lode::bisection
#endif

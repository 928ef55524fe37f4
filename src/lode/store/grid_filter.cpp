#include "lode/store/grid_filter.h"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "lode/store/elements.h"

namespace lode::store {
namespace {

/// Rows that are restored side by side, each one point behind the one before it: so all that a
/// point is predicted from is there. Several vectors of them: one would wait for its last point.
template <typename T>
constexpr std::size_t kLanes = 64 / sizeof(T);

// By value and inlined, so that rows become minima and maxima of vectors.
template <typename T>
[[gnu::always_inline]] inline T lesser(T a, T b) {
  return a < b ? a : b;
}
template <typename T>
[[gnu::always_inline]] inline T greater(T a, T b) {
  return a < b ? b : a;
}

/// a + b - ab where that lies between a and b, else the nearer of them: exact in a plane, and
/// beside an edge the value on its own side (the predictor of JPEG-LS).
template <typename T>
[[gnu::always_inline]] inline T in_plane(T a, T b, T ab) {
  const T low = lesser(a, b);
  const T high = greater(a, b);
  return static_cast<T>(a + b - lesser(greater(ab, low), high));
}

/// The median of what the three planes say that meet in a point. x, y and z are the points before
/// it along one axis, xy, xz and yz those before it along two.
template <typename T>
[[gnu::always_inline]] inline T predict(T x, T y, T z, T xy, T xz, T yz) {
  const T a = in_plane(x, y, xy);
  const T b = in_plane(x, z, xz);
  const T c = in_plane(y, z, yz);
  return greater(lesser(a, b), lesser(greater(a, b), c));
}

/// A value by its distance from what is predicted, in zigzag; but 0 is code 0 wherever it occurs,
/// and the codes below its own move up. Many volumes are 0 outside an object, with edges at once,
/// and zeros would else be as many codes as there are values beside them.
template <typename T>
[[gnu::always_inline]] inline T encode_value(T value, T predicted) {
  const T code = zigzag(static_cast<T>(value - predicted));
  const T zero = zigzag(static_cast<T>(0 - predicted));
  const T moved = code < zero ? static_cast<T>(code + 1) : code;
  return value == 0 ? T{0} : moved;
}
template <typename T>
[[gnu::always_inline]] inline T decode_value(T code, T predicted) {
  const T zero = zigzag(static_cast<T>(0 - predicted));
  // Selected by arithmetic: GCC 12 makes no vectors of nested conditions.
  const T one = 1;
  const T none = 0;
  const T shift = code > zero ? none : one;
  const T value = static_cast<T>(predicted + unzigzag(static_cast<T>(code - shift)));
  const T is_any = static_cast<T>(0 - lesser(code, one));
  return static_cast<T>(value & is_any);
}

/// The first point of row (y, z) that has an element, and how far apart they are.
struct RowOfElements {
  std::size_t first = 0;
  std::size_t stride = 1;

  /// How many they are in a row of n points.
  [[nodiscard]] std::size_t count(std::size_t n) const { return (n - first + stride - 1) / stride; }
};

RowOfElements row_of(const ElementGrid& grid, std::size_t y, std::size_t z) {
  if (grid.lacks_even_points && ((y | z) & 1) == 0) return {1, 2};
  return {0, 1};
}

/// A row with its neighbours, all padded by a point in front that counts as 0.
template <typename T>
struct Rows {
  T* row;
  const T* y;   ///< The row before it in its plane,
  const T* z;   ///< in the plane before,
  const T* yz;  ///< and before that one there.
};

template <typename T>
void predict_row(const Rows<T>& rows, std::size_t n, T* out) {
  const T* const row = rows.row;
  const T* const y = rows.y;
  const T* const z = rows.z;
  const T* const yz = rows.yz;
  for (std::size_t x = 0; x < n; ++x)
    out[x] = predict(row[x], y[x + 1], z[x + 1], y[x], z[x], yz[x + 1]);
}

/// Calls body(i, x) for the row's elements, the i-th at point x; both strides are compiled, as a
/// known one makes vectors.
template <typename Body>
[[gnu::always_inline]] inline void for_each_element(const RowOfElements& at, std::size_t n,
                                                    const Body& body) {
  if (at.stride == 1)
    for (std::size_t i = 0; i < n; ++i) body(i, i);
  else
    for (std::size_t i = 0; i < n; ++i) body(i, 2 * i + 1);
}

template <typename T>
void predict_elements(std::span<const std::byte> raw, const ElementGrid& grid, T origin,
                      std::byte* planes) {
  const std::size_t nx = grid.n[0];
  const std::size_t ny = grid.n[1];
  const std::size_t n_all = raw.size() / sizeof(T);
  const std::size_t pitch = nx + 1;
  // This plane and the one before it, with a row and a column in front that count as 0.
  std::array<std::vector<T>, 2> plane;
  plane.fill(std::vector<T>(pitch * (ny + 1)));
  std::vector<T> predicted(nx);  // then the codes of the differences
  const std::byte* from = raw.data();
  for (std::size_t z = 0; z < grid.n[2]; ++z)
    for (std::size_t y = 0; y < ny; ++y) {
      T* row = plane[z % 2].data() + (y + 1) * pitch;
      const T* before = plane[1 - z % 2].data() + (y + 1) * pitch;
      const Rows<T> rows{row, row - pitch, before, before - pitch};
      const RowOfElements at = row_of(grid, y, z);
      const std::size_t n = at.count(nx);
      for_each_element(at, n, [&](std::size_t i, std::size_t x) {
        row[x + 1] = static_cast<T>(load_element<T>(from + i * sizeof(T)) - origin);
      });
      from += n * sizeof(T);
      predict_row(rows, nx, predicted.data());
      if (at.stride == 2) {
        // Points without elements are what they are predicted to be; the others see that.
        for (std::size_t x = 0; x < nx; x += 2) row[x + 1] = predicted[x];
        predict_row(rows, nx, predicted.data());
      }
      for (std::size_t x = 0; x < nx; ++x) predicted[x] = encode_value(row[x + 1], predicted[x]);
      for (std::size_t b = 0; b < sizeof(T); ++b)
        for_each_element(at, n, [&, to = planes + b * n_all](std::size_t i, std::size_t x) {
          to[i] = static_cast<std::byte>(predicted[x] >> (8 * b) & 0xFF);
        });
      planes += n;
    }
}

/// A plane of a grid, kLanes rows a strip. Step t of a strip holds point t - l of row l in lane l +
/// 1, and in lane 0 the point of the row before the strip that lane 1 needs next. Two steps come
/// before the first; what lies before a row is 0.
template <typename T>
class Strips {
 public:
  static constexpr std::size_t kPitch = kLanes<T> + 1;

  Strips(std::size_t nx, std::size_t ny)
      : nx_(nx), values_(n_steps() * kPitch * ((ny + kLanes<T> - 1) / kLanes<T>)) {}

  /// Steps of one strip, with the two in front.
  [[nodiscard]] std::size_t n_steps() const { return nx_ + kLanes<T> + 1; }
  [[nodiscard]] T* strip(std::size_t s) { return values_.data() + s * kPitch * n_steps(); }
  /// The first point of row y; the next ones are kPitch apart.
  [[nodiscard]] T* row(std::size_t y) {
    const std::size_t lane = y % kLanes<T>;
    return strip(y / kLanes<T>) + (lane + 2) * kPitch + lane + 1;
  }
  /// Before a strip is restored: nothing in it, but the row before it in lane 0.
  void begin(std::size_t s) {
    std::fill_n(strip(s), n_steps() * kPitch, T{0});
    if (s == 0) return;
    const T* from = row(s * kLanes<T> - 1);
    for (std::size_t x = 0; x < nx_; ++x) strip(s)[(x + 1) * kPitch] = from[x * kPitch];
  }

 private:
  std::size_t nx_;
  std::vector<T> values_;
};

/// Turns the codes in a strip into values. Where even points are left out, those of even rows, in
/// every other step, are what is predicted.
template <typename T>
void restore_strip(T* strip, const T* before, std::size_t n_steps, bool lacks_even_points) {
  constexpr std::size_t kPitch = Strips<T>::kPitch;
  for (std::size_t t = 2; t < n_steps; ++t) {
    T* at = strip + t * kPitch;
    const T* last = at - kPitch;
    const T* below = before + t * kPitch;
    std::array<T, kLanes<T>> predicted;
    for (std::size_t l = 0; l < kLanes<T>; ++l)
      predicted[l] = predict(last[l + 1], last[l], below[l + 1], (last - kPitch)[l],
                             (below - kPitch)[l + 1], (below - kPitch)[l]);
    std::array<T, kLanes<T>> values;
    for (std::size_t l = 0; l < kLanes<T>; ++l) values[l] = decode_value(at[l + 1], predicted[l]);
    if (lacks_even_points && t % 2 == 0)
      for (std::size_t l = 0; l < kLanes<T>; l += 2) values[l] = predicted[l];
    std::copy(values.begin(), values.end(), at + 1);
  }
}

template <typename T>
class Restoration {
 public:
  Restoration(std::span<const std::byte> planes, const ElementGrid& grid, std::byte* raw)
      : grid_(grid),
        n_all_(planes.size() / sizeof(T)),
        strips_{Strips<T>(grid.n[0], grid.n[1]), Strips<T>(grid.n[0], grid.n[1])},
        from_(planes.data()),
        to_(raw) {}

  /// All but for the origin.
  void run() {
    for (std::size_t z = 0; z < grid_.n[2]; ++z)
      for (std::size_t s = 0; s * kLanes<T> < grid_.n[1]; ++s) {
        Strips<T>& here = strips_[z % 2];
        here.begin(s);
        const std::size_t end = std::min<std::size_t>(grid_.n[1], (s + 1) * kLanes<T>);
        for (std::size_t y = s * kLanes<T>; y < end; ++y)
          take_row(here.row(y), row_of(grid_, y, z));
        restore_strip(here.strip(s), strips_[1 - z % 2].strip(s), here.n_steps(),
                      grid_.lacks_even_points && z % 2 == 0);
        for (std::size_t y = s * kLanes<T>; y < end; ++y) put_row(here.row(y), row_of(grid_, y, z));
      }
  }

 private:
  void take_row(T* row, const RowOfElements& at) {
    const std::size_t n = at.count(grid_.n[0]);
    for (std::size_t i = 0; i < n; ++i) {
      T code = 0;
      for (std::size_t b = 0; b < sizeof(T); ++b)
        code =
            static_cast<T>(code | static_cast<T>(static_cast<T>(from_[b * n_all_ + i]) << (8 * b)));
      row[(at.first + i * at.stride) * Strips<T>::kPitch] = code;
    }
    from_ += n;
  }

  void put_row(const T* row, const RowOfElements& at) {
    const std::size_t n = at.count(grid_.n[0]);
    for_each_element(at, n, [&](std::size_t i, std::size_t x) {
      store_element(to_ + i * sizeof(T), row[x * Strips<T>::kPitch]);
    });
    to_ += n * sizeof(T);
  }

  ElementGrid grid_;
  std::size_t n_all_;
  std::array<Strips<T>, 2> strips_;  ///< Of this plane and the one before.
  const std::byte* from_;
  std::byte* to_;
};

}  // namespace

std::uint64_t find_origin(std::span<const std::byte> raw, std::size_t element_size) {
  return visit_element(element_size, [&]<typename T>(T) -> std::uint64_t {
    constexpr T kSign = static_cast<T>(T{1} << (8 * sizeof(T) - 1));
    std::array<T, 2> low{std::numeric_limits<T>::max(), std::numeric_limits<T>::max()};
    std::array<T, 2> high{};
    for (std::size_t i = 0; i < raw.size() / sizeof(T); ++i) {
      const T value = load_element<T>(raw.data() + i * sizeof(T));
      const T moved = static_cast<T>(value ^ kSign);  // signed numbers, in their order
      low = {std::min(low[0], value), std::min(low[1], moved)};
      high = {std::max(high[0], value), std::max(high[1], moved)};
    }
    const bool is_signed = static_cast<T>(high[1] - low[1]) < static_cast<T>(high[0] - low[0]);
    return is_signed ? static_cast<T>(low[1] ^ kSign) : low[0];
  });
}

void predict_grid(std::span<const std::byte> raw, std::size_t element_size, const ElementGrid& grid,
                  std::uint64_t origin, std::span<std::byte> planes) {
  visit_element(element_size, [&]<typename T>(T) {
    predict_elements<T>(raw, grid, static_cast<T>(origin), planes.data());
  });
}

void restore_grid(std::span<const std::byte> planes, std::size_t element_size,
                  const ElementGrid& grid, std::uint64_t origin, std::span<std::byte> raw) {
  visit_element(element_size, [&]<typename T>(T) {
    Restoration<T>(planes, grid, raw.data()).run();
    for (std::byte* at = raw.data(); at < raw.data() + raw.size(); at += sizeof(T))
      store_element(at, static_cast<T>(load_element<T>(at) + origin));
  });
}

}  // namespace lode::store

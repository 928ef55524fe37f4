#include "lode/models/diamond/sample_bits.h"

#include <algorithm>
#include <cmath>

namespace lode::diamond {
namespace {

/// How near to a tetrahedron a sample counts as in it, in steps of the lattice.
constexpr double kNear = 1e-6;

/// What lies between two planes: n . p from `low` to `high`.
struct Slab {
  Vec3d normal;
  double low = 0;
  double high = 0;
};

/// A tetrahedron as what lies in four slabs, a little larger, relative to its first corner; right
/// for flat ones too.
std::array<Slab, 4> slabs_of(const std::array<Vec3d, 4>& corners, double largest) {
  std::array<Slab, 4> slabs;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3d a = corners[(i + 1) % 4] - corners[0];
    const Vec3d b = corners[(i + 2) % 4] - corners[0];
    const Vec3d c = corners[(i + 3) % 4] - corners[0];
    const Vec3d n = cross(b - a, c - a);
    const double at_face = dot(n, a);
    const double at_corner = dot(n, corners[i] - corners[0]);
    const double slack = kNear * length(n) + 1e-12 * largest * largest * largest;
    slabs[i] = {n, std::min(at_face, at_corner) - slack, std::max(at_face, at_corner) + slack};
  }
  return slabs;
}

struct Interval {
  double from;
  double to;

  /// What of it, on the row (y, z) relative to the slab's point, lies in the slab.
  void cut(const Slab& slab, double y, double z, double largest) {
    const double here = slab.normal[1] * y + slab.normal[2] * z;
    const double step = slab.normal[0];
    if (std::abs(step) * (largest + 1) < 1e-300) {
      if (here < slab.low || here > slab.high) to = from - 1;
      return;
    }
    const double one = (slab.low - here) / step;
    const double other = (slab.high - here) / step;
    from = std::max(from, std::min(one, other));
    to = std::min(to, std::max(one, other));
  }
};

}  // namespace

SampleBits::SampleBits(const Index<3>& dims)
    : dims_(dims),
      stride_(as_size(dims[0]) / 64 + 1),
      words_(stride_ * as_size(dims[1]) * as_size(dims[2]), 0) {}

std::uint64_t SampleBits::get(const std::uint64_t* row, std::int32_t first) const {
  const auto word = as_size(first) / 64;
  const int shift = first % 64;
  if (shift == 0) return row[word];
  return row[word] >> shift | (word + 1 < stride_ ? row[word + 1] << (64 - shift) : 0);
}

bool SampleBits::is_any_set(const std::uint64_t* row, std::int32_t first, std::int32_t last) {
  for (std::int32_t word = first >> 6; word <= last >> 6; ++word) {
    std::uint64_t bits = row[word];
    if (word == first >> 6) bits &= ~std::uint64_t{0} << (first & 63);
    if (word == last >> 6) bits &= ~std::uint64_t{0} >> (63 - (last & 63));
    if (bits != 0) return true;
  }
  return false;
}

bool SampleBits::has_cell(const Index<3>& cell) const {
  std::uint64_t all = 3;
  for (std::int32_t dz = 0; dz < 2; ++dz)
    for (std::int32_t dy = 0; dy < 2; ++dy) {
      const std::uint64_t* at = row(cell[1] + dy, cell[2] + dz);
      const std::int32_t x = cell[0];
      std::uint64_t bits = at[x >> 6] >> (x & 63);
      if ((x & 63) == 63) bits |= at[(x >> 6) + 1] << 1;
      all &= bits;
    }
  return all == 3;
}

bool SampleBits::meets(const std::array<Vec3d, 4>& tetrahedron) const {
  std::array<std::int32_t, 3> first{};
  std::array<std::int32_t, 3> last{};
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [low, high] =
        std::minmax({tetrahedron[0][i], tetrahedron[1][i], tetrahedron[2][i], tetrahedron[3][i]});
    const double end = static_cast<double>(dims_[i] - 1);
    first[i] = static_cast<std::int32_t>(std::clamp(std::ceil(low - kNear), 0.0, end + 1));
    last[i] = static_cast<std::int32_t>(std::clamp(std::floor(high + kNear), -1.0, end));
    if (first[i] > last[i]) return false;
    largest = std::max(largest, high - low);
  }
  std::array<Slab, 4> slabs;
  bool has_slabs = false;
  const Vec3d& origin = tetrahedron[0];
  for (std::int32_t z = first[2]; z <= last[2]; ++z)
    for (std::int32_t y = first[1]; y <= last[1]; ++y) {
      const std::uint64_t* at = row(y, z);
      if (!is_any_set(at, first[0], last[0])) continue;
      if (!has_slabs) slabs = slabs_of(tetrahedron, largest);
      has_slabs = true;
      Interval inside{static_cast<double>(first[0]) - origin[0],
                      static_cast<double>(last[0]) - origin[0]};
      for (const Slab& slab : slabs)
        inside.cut(slab, static_cast<double>(y) - origin[1], static_cast<double>(z) - origin[2],
                   largest);
      if (!(inside.from <= inside.to)) continue;
      const auto x0 = static_cast<std::int32_t>(std::ceil(inside.from + origin[0] - kNear));
      const auto x1 = static_cast<std::int32_t>(std::floor(inside.to + origin[0] + kNear));
      if (x0 <= x1 && is_any_set(at, std::max(x0, first[0]), std::min(x1, last[0]))) return true;
    }
  return false;
}

}  // namespace lode::diamond

#include "lode/mappers/simplex_isosurface.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "lode/mappers/march_simplex.h"

namespace lode {
namespace {

std::int64_t orientation(const LatticeSimplex<3>& s) {
  std::array<std::array<std::int64_t, 3>, 3> m{};
  const Index3 origin = to_point(s.vertex[0]);
  for (std::size_t i = 0; i < 3; ++i) {
    const Index3 d = to_point(s.vertex[i + 1]) - origin;
    m[i] = {d[0], d[1], d[2]};
  }
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

std::int64_t orientation(const LatticeSimplex<2>& s) {
  const Index3 a = to_point(s.vertex[1]) - to_point(s.vertex[0]);
  const Index3 b = to_point(s.vertex[2]) - to_point(s.vertex[0]);
  // The two lattice axes of a 2D field keep their order in the grid; the third is constant.
  const auto along = [](const Index3& d, std::size_t i) { return std::int64_t{d[i]}; };
  const std::int64_t xy = along(a, 0) * along(b, 1) - along(a, 1) * along(b, 0);
  const std::int64_t xz = along(a, 0) * along(b, 2) - along(a, 2) * along(b, 0);
  const std::int64_t yz = along(a, 1) * along(b, 2) - along(a, 2) * along(b, 1);
  return xy + xz + yz;
}

/// Only the top bits of the product depend on all of the key.
std::size_t slot_of(LatticeKey key, std::size_t n_slots) {
  return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >>
                                  (64 - std::bit_width(n_slots - 1)));
}

}  // namespace

template <int D>
SimplexIsosurface<D>::SimplexIsosurface(const LatticeFrame& frame, double isovalue,
                                        IsoPart<D>& part)
    : isovalue_(isovalue),
      margin_(frame.margin),
      is_mirrored_(frame.is_mirrored),
      part_(part),
      slots_(64, 0) {}

template <int D>
void SimplexIsosurface<D>::grow() {
  std::vector<std::uint32_t> larger(slots_.size() * 4, 0);
  const std::size_t mask = larger.size() - 1;
  for (std::uint32_t id = 0; id < part_.points.size(); ++id) {
    std::size_t slot = slot_of(part_.points[id].doubled_midpoint(), larger.size());
    while (larger[slot] != 0) slot = (slot + 1) & mask;
    larger[slot] = id + 1;
  }
  slots_ = std::move(larger);
}

template <int D>
std::uint32_t SimplexIsosurface<D>::vertex_on(const LatticeSimplex<D>& s, std::size_t i,
                                              std::size_t j) {
  const LatticeKey key = s.vertex[i] + s.vertex[j];
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = slot_of(key, slots_.size());
  for (; slots_[slot] != 0; slot = (slot + 1) & mask)
    if (part_.points[slots_[slot] - 1].doubled_midpoint() == key) return slots_[slot] - 1;
  const std::uint32_t id =
      part_.add_point(s.vertex[i], s.value[i], s.vertex[j], s.value[j], isovalue_, margin_);
  slots_[slot] = id + 1;
  if (part_.points.size() * 2 > slots_.size()) grow();
  return id;
}

template <int D>
void SimplexIsosurface<D>::add(const LatticeSimplex<D>& simplex) {
  constexpr std::size_t kAll = (std::size_t{1} << (D + 1)) - 1;
  std::size_t inside = 0;
  for (std::size_t i = 0; i <= static_cast<std::size_t>(D); ++i)
    if (simplex.value[i] >= isovalue_) inside |= std::size_t{1} << i;
  if (inside == 0 || inside == kAll) return;
  march_simplex<D>(
      inside, (orientation(simplex) < 0) != is_mirrored_,
      [&](std::size_t i, std::size_t j) { return vertex_on(simplex, i, j); },
      [&](const auto& cell) { part_.cells.push_back(cell); });
}

template class SimplexIsosurface<2>;
template class SimplexIsosurface<3>;

}  // namespace lode

#include "lode/mappers/simplex_isosurface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "lode/mappers/tetrahedron_cases.h"

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
std::uint32_t SimplexIsosurface<D>::make_vertex(LatticeKey p, double a, LatticeKey q, double b) {
  if (p > q) {
    std::swap(p, q);
    std::swap(a, b);
  }
  const double step = std::abs(b - a);
  const double t = (isovalue_ - a) / (b - a);
  const double kept = std::clamp(t, margin_, 1 - margin_);
  part_.largest_step = std::max(part_.largest_step, step);
  if (kept != t) part_.largest_snap = std::max(part_.largest_snap, step);
  part_.points.push_back({p, q, kept});
  part_.positions.push_back(part_.points.back().lattice_position());
  return static_cast<std::uint32_t>(part_.points.size() - 1);
}

template <int D>
std::uint32_t SimplexIsosurface<D>::vertex_on(const LatticeSimplex<D>& s, std::size_t i,
                                              std::size_t j) {
  const LatticeKey key = s.vertex[i] + s.vertex[j];
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = slot_of(key, slots_.size());
  for (; slots_[slot] != 0; slot = (slot + 1) & mask)
    if (part_.points[slots_[slot] - 1].doubled_midpoint() == key) return slots_[slot] - 1;
  const std::uint32_t id = make_vertex(s.vertex[i], s.value[i], s.vertex[j], s.value[j]);
  slots_[slot] = id + 1;
  if (part_.points.size() * 2 > slots_.size()) grow();
  return id;
}

template <int D>
void SimplexIsosurface<D>::add_triangles(const LatticeSimplex<D>& s, std::size_t inside) {
  const auto& o = kTetrahedronOrder[inside];
  const bool flip = (orientation(s) < 0) != is_mirrored_;
  const auto put = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if constexpr (D == 3) part_.cells.push_back({a, flip ? c : b, flip ? b : c});
  };
  const int n_inside = std::popcount(inside);
  if (n_inside == 2) {
    const std::uint32_t ik = vertex_on(s, o[0], o[2]);
    const std::uint32_t il = vertex_on(s, o[0], o[3]);
    const std::uint32_t jl = vertex_on(s, o[1], o[3]);
    const std::uint32_t jk = vertex_on(s, o[1], o[2]);
    put(ik, il, jl);
    put(ik, jl, jk);
    return;
  }
  const std::uint32_t ij = vertex_on(s, o[0], o[1]);
  const std::uint32_t ik = vertex_on(s, o[0], o[2]);
  const std::uint32_t il = vertex_on(s, o[0], o[3]);
  if (n_inside == 1)
    put(ij, ik, il);
  else
    put(ij, il, ik);
}

template <int D>
void SimplexIsosurface<D>::add_line(const LatticeSimplex<D>& s, std::size_t inside) {
  const bool is_single_inside = (inside & (inside - 1)) == 0;
  const std::size_t single = is_single_inside ? inside : 7 - inside;
  const std::size_t i = single == 1 ? 0 : single == 2 ? 1 : 2;
  std::uint32_t from = vertex_on(s, i, (i + 1) % 3);
  std::uint32_t to = vertex_on(s, i, (i + 2) % 3);
  const bool flip = ((orientation(s) < 0) != is_mirrored_) != !is_single_inside;
  if (flip) std::swap(from, to);
  if constexpr (D == 2) part_.cells.push_back({from, to});
}

template <int D>
void SimplexIsosurface<D>::add(const LatticeSimplex<D>& simplex) {
  constexpr std::size_t kAll = (std::size_t{1} << (D + 1)) - 1;
  std::size_t inside = 0;
  for (std::size_t i = 0; i <= static_cast<std::size_t>(D); ++i)
    if (simplex.value[i] >= isovalue_) inside |= std::size_t{1} << i;
  if (inside == 0 || inside == kAll) return;
  if constexpr (D == 3)
    add_triangles(simplex, inside);
  else
    add_line(simplex, inside);
}

template class SimplexIsosurface<2>;
template class SimplexIsosurface<3>;

}  // namespace lode

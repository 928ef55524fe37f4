#include "lode/render/cell_walk.h"

#include <bit>
#include <utility>

namespace lode {
namespace {

/// The first 26 bits: products of two such are exact.
double cut_bits(double a) {
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(a) & ~std::uint64_t{0x7ffffff});
}

/// A vertex relative to the line.
struct Offset {
  double u;
  double v;
};

Offset offset_of(const ViewVertex& vertex, const SightLine& line) {
  return {cut_bits(vertex.right - line.right - line.right_slope * vertex.depth),
          cut_bits(vertex.up - line.up - line.up_slope * vertex.depth)};
}

/// The sign of a x b where it is zero, were the line moved; two vertices at one place have the
/// order of their numbers.
[[gnu::noinline]] bool is_tie_negative(const Offset& a, const Offset& b, std::uint32_t vertex_a,
                                       std::uint32_t vertex_b) {
  if (a.v != b.v) return a.v < b.v;
  if (a.u != b.u) return a.u > b.u;
  return vertex_a > vertex_b;
}

}  // namespace

void CellWalk::place(const ViewVertex& vertex, const SightLine& line, std::size_t corner) {
  const Offset offset = offset_of(vertex, line);
  u_[corner] = offset.u;
  v_[corner] = offset.v;
  depths_[corner] = vertex.depth;
  levels_[corner] = vertex.level;
}

void CellWalk::meet_face() {
  const double sum = edges_[0] + edges_[1] + edges_[2];
  if (!(sum > 0)) return;  // Not even by ties: nothing moves.
  const double share = 1 / sum;
  depth_ = (edges_[0] * depths_[0] + edges_[1] * depths_[1] + edges_[2] * depths_[2]) * share;
  level_ = (edges_[0] * levels_[0] + edges_[1] * levels_[1] + edges_[2] * levels_[2]) * share;
}

bool CellWalk::enter(const VolumeView& view, const SightLine& line, std::uint32_t outer_face) {
  const CellLinks::OuterFace& face = view.links().outer_faces[outer_face];
  corners_ = face.corners;
  for (std::size_t i = 0; i < 3; ++i) place(view.vertices()[corners_[i]], line, i);
  std::array<bool, 3> is_negative{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const std::size_t k = (i + 2) % 3;
    edges_[i] = u_[j] * v_[k] - u_[k] * v_[j];
    is_negative[i] =
        edges_[i] != 0 ? edges_[i] < 0
                       : is_tie_negative({u_[j], v_[j]}, {u_[k], v_[k]}, corners_[j], corners_[k]);
  }
  if (is_negative[0] != is_negative[1] || is_negative[0] != is_negative[2]) return false;
  if (is_negative[0]) {
    for (double& edge : edges_) edge = -edge;
    for (auto* values : {&u_, &v_, &depths_, &levels_, &edges_})
      std::swap((*values)[1], (*values)[2]);
    std::swap(corners_[1], corners_[2]);
  }
  next_ = face.cell;
  depth_ = level_ = 0;
  meet_face();
  return true;
}

bool CellWalk::step(const VolumeView& view, const SightLine& line) {
  const LinkedCell& cell = view.links().cells[next_];
  const std::uint32_t apex = cell.corners[0] ^ cell.corners[1] ^ cell.corners[2] ^ cell.corners[3] ^
                             corners_[0] ^ corners_[1] ^ corners_[2];
  const ViewVertex& vertex = view.vertices()[apex];
  const Offset offset = offset_of(vertex, line);
  // On which side of the line from each corner to the apex.
  const std::array<double, 3> sides{u_[0] * offset.v - offset.u * v_[0],
                                    u_[1] * offset.v - offset.u * v_[1],
                                    u_[2] * offset.v - offset.u * v_[2]};
  unsigned negative = static_cast<unsigned>(sides[0] < 0) |
                      static_cast<unsigned>(sides[1] < 0) << 1U |
                      static_cast<unsigned>(sides[2] < 0) << 2U;
  if (sides[0] == 0 || sides[1] == 0 || sides[2] == 0) [[unlikely]] {
    for (unsigned i = 0; i < 3; ++i) {
      if (sides[i] == 0 && is_tie_negative({u_[i], v_[i]}, offset, corners_[i], apex))
        negative |= 1U << i;
    }
  }
  // The corner that the next face does not have: the one before the negative side that follows a
  // positive one. All alike cannot be.
  constexpr std::array<std::uint8_t, 8> kLeft{0, 2, 0, 0, 1, 2, 1, 0};
  const std::size_t left = kLeft[negative];
  const std::size_t one = left == 2 ? 0 : left + 1;
  const std::size_t two = 3 - left - one;
  const std::uint32_t gone = corners_[left];
  const std::size_t across = static_cast<std::size_t>(cell.corners[1] == gone) +
                             2 * static_cast<std::size_t>(cell.corners[2] == gone) +
                             3 * static_cast<std::size_t>(cell.corners[3] == gone);
  next_ = cell.across[across];
  edges_[one] = sides[two];
  edges_[two] = -sides[one];
  u_[left] = offset.u;
  v_[left] = offset.v;
  depths_[left] = vertex.depth;
  levels_[left] = vertex.level;
  corners_[left] = apex;
  meet_face();
  return next_ < CellLinks::kOuter;
}

}  // namespace lode

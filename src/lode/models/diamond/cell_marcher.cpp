#include "lode/models/diamond/cell_marcher.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace lode::diamond {
namespace {

constexpr std::size_t kFirstFaceDiagonal = CellEdges::kCubeEdges;

/// The axis along which two corners of a face do not differ.
unsigned axis_across(std::size_t a, std::size_t b) {
  return static_cast<unsigned>(std::countr_zero(7U & ~static_cast<unsigned>(a ^ b)));
}

}  // namespace

CellMarcher::CellMarcher(const LatticeFrame& frame) : frame_(frame) {
  const auto& ends = cell_edge_ends();
  for (std::size_t e = 0; e < ends.size(); ++e)
    edge_between_[ends[e][0]][ends[e][1]] = edge_between_[ends[e][1]][ends[e][0]] =
        static_cast<std::uint8_t>(e);
  for (unsigned parity = 0; parity < 8; ++parity)
    for (std::size_t e = 0; e < ends.size(); ++e) {
      // In three dimensions lattice axes are the grid's, and keys are ordered by z, y, x.
      unsigned first = ends[e][0] ^ parity;
      unsigned second = ends[e][1] ^ parity;
      if (first > second) std::swap(first, second);
      const Index<3> a = corner_steps<3>(first);
      const Index<3> b = corner_steps<3>(second);
      EdgePlace& edge = edges_[parity][e];
      edge = {static_cast<std::uint32_t>(BrickVertices<3>::place(a + b)),
              static_cast<std::uint32_t>(Model<3>::brick_offset(a)),
              static_cast<std::uint32_t>(Model<3>::brick_offset(b)), to_key(a), to_key(b)};
      if (e < kFirstFaceDiagonal) continue;
      const unsigned axis = axis_across(first, second);
      edge.face = static_cast<std::uint8_t>(2 * axis + (first >> axis & 1));
    }
}

void CellMarcher::march(const BrickNodes& nodes, BrickIsosurface<3>& mapper) {
  nodes_ = &nodes;
  mapper_ = &mapper;
  visit_storage_type(nodes.model().storage, [&]<typename T>() {
    for (std::int32_t z = 0; z < nodes.n_cells()[2]; ++z)
      for (std::int32_t y = 0; y < nodes.n_cells()[1]; ++y) {
        if (nodes.refined_cubes(as_size(y / 2), as_size(z / 2)) == 0) continue;
        const std::uint32_t crossed = nodes.crossed_cells(as_size(y), as_size(z));
        if (crossed != 0) march_row<T>(row_at(nodes, as_size(y), as_size(z)), crossed);
      }
  });
}

CellMarcher::Row CellMarcher::row_at(const BrickNodes& nodes, std::size_t y, std::size_t z) const {
  BrickVertices<3>& vertices = mapper_->vertices();
  Row row{.y = y,
          .z = z,
          .parity = static_cast<unsigned>((y & 1) << 1 | (z & 1) << 2),
          .corners = {},
          .axes = nodes.simplices_along(y, z),
          .data = nodes.data() +
                  brick_row(y, z) * as_size(kBrickSamples<3>) * nodes.model().sample_size(),
          .place = BrickVertices<3>::place(
              Index<3>{{0, static_cast<std::int32_t>(2 * y), static_cast<std::int32_t>(2 * z)}}),
          .key = vertices.key_of(0) + y * vertices.key_steps()[1] + z * vertices.key_steps()[2]};
  for (std::size_t i = 0; i < 4; ++i)
    row.corners[i] = nodes.inside(y + ((i & 1) ^ (y & 1)), z + ((i >> 1) ^ (z & 1)));
  return row;
}

template <typename T>
void CellMarcher::march_row(const Row& row, std::uint32_t crossed) {
  const std::uint64_t there = row.axes[0] | row.axes[1] | row.axes[2];
  const bool is_flipped = (std::popcount(row.parity) == 1) != mapper_->is_mirrored();
  for (std::uint64_t left = crossed & there; left != 0; left &= left - 1) {
    const auto x = static_cast<std::size_t>(std::countr_zero(left));
    Cell cell{.x = x,
              .parity = row.parity | static_cast<unsigned>(x & 1),
              .signs = 0,
              .is_flipped = is_flipped != ((x & 1) != 0)};
    for (std::size_t i = 0; i < 4; ++i) cell.signs |= (row.corners[i] >> x & 3) << (2 * i);
    if ((x & 1) != 0) cell.signs = (cell.signs & 0x55) << 1 | (cell.signs >> 1 & 0x55);
    if (cubes_ != nullptr) {
      const Index<3> at =
          nodes_->base() + Index<3>{{static_cast<std::int32_t>(x), static_cast<std::int32_t>(row.y),
                                     static_cast<std::int32_t>(row.z)}};
      const unsigned beside = cubes_beside(at);
      if (cubes_->contains(at)) {
        for (unsigned face = 0; face < 6; ++face)
          if ((beside >> face & 1) == 0 && has_cell_beside(at, face))
            cell.moved_faces |= 1U << face;
        march_cube<T>(row, cell);
        continue;
      }
      cell.moved_faces = beside;
    }
    march_simplices<T>(row, cell);
  }
}

template <typename T>
void CellMarcher::march_simplices(const Row& row, const Cell& cell) {
  const std::size_t there = (row.axes[0] >> cell.x & 1) | (row.axes[1] >> cell.x & 1) << 1 |
                            (row.axes[2] >> cell.x & 1) << 2;
  const CellCase& c = cell_cases_by_axes()[there * 256 + cell.signs];
  for (std::size_t i = 0; i < c.n_ends; i += 3)
    add({vertex_on<T>(row, cell, c.edge[i]), vertex_on<T>(row, cell, c.edge[i + 1]),
         vertex_on<T>(row, cell, c.edge[i + 2])},
        cell.is_flipped);
}

/// The cube's triangles; where a vertex on a face's diagonal stays, it splits the one at its side.
template <typename T>
void CellMarcher::march_cube(const Row& row, const Cell& cell) {
  const CellCase& c = cell_cases(SurfaceStyle::cubes)[cell.signs];
  InlineList<Triangle, 18> triangles;  // 12 at most, and one more for each face
  for (std::size_t i = 0; i < c.n_ends; i += 3)
    triangles.push_back({vertex_on<T>(row, cell, c.edge[i]), vertex_on<T>(row, cell, c.edge[i + 1]),
                         vertex_on<T>(row, cell, c.edge[i + 2])});
  const auto& ends = cell_edge_ends();
  for (std::size_t e = kFirstFaceDiagonal; e < ends.size(); ++e) {
    if ((cell.moved_faces >> edges_[cell.parity][e].face & 1) == 0 || !is_crossed(cell, e))
      continue;
    std::array<std::uint32_t, 2> side{};  // two of the face's edges are crossed
    std::size_t n = 0;
    for (const std::size_t edge : face_of(e).edges)
      if (is_crossed(cell, edge)) side[n++] = vertex_on<T>(row, cell, edge);
    split(triangles, side, vertex_on<T>(row, cell, e));
  }
  for (const Triangle& t : triangles) add(t, cell.is_flipped);
}

template <typename T>
std::uint32_t CellMarcher::vertex_on(const Row& row, const Cell& cell, std::size_t edge) {
  BrickVertices<3>& vertices = mapper_->vertices();
  const EdgePlace& e = edges_[cell.parity][edge];
  const std::size_t place = row.place + 2 * cell.x + e.place;
  std::uint32_t vertex = vertices[place];
  if (vertex != BrickVertices<3>::kNone) return vertex;
  if (edge >= kFirstFaceDiagonal && (cell.moved_faces >> e.face & 1) != 0) {
    vertex = add_moved<T>(row, cell, edge);
  } else {
    const LatticeKey key = row.key + cell.x * vertices.key_steps()[0];
    vertex = vertices.add(key + e.first_key, value<T>(row, cell, e.first_sample),
                          key + e.second_key, value<T>(row, cell, e.second_sample));
  }
  vertices.set(place, vertex);
  return vertex;
}

/// Where a face's diagonal meets the segment between the two of the face's edges that are crossed.
/// Both cells that have the face find the same: from its even corner, along its first axis.
template <typename T>
std::uint32_t CellMarcher::add_moved(const Row& row, const Cell& cell, std::size_t edge) {
  const Face face = face_of(edge);
  // From the even corner, where the face's edges are crossed: two of these.
  std::array<std::array<double, 2>, 2> p{};
  std::size_t n = 0;
  const auto crossing = [&](std::size_t from, std::size_t to) {
    return crossing_on<T>(row, cell, from, to);
  };
  if (is_crossed(cell, face.edges[0])) p[n++] = {crossing(face.even, face.first), 0};
  if (is_crossed(cell, face.edges[1])) p[n++] = {1, crossing(face.first, face.odd)};
  if (is_crossed(cell, face.edges[2])) p[n++] = {0, crossing(face.even, face.second)};
  if (is_crossed(cell, face.edges[3])) p[n++] = {crossing(face.second, face.odd), 1};
  const double across = (p[1][1] - p[0][1]) - (p[1][0] - p[0][0]);
  const double moved = (p[0][0] * p[1][1] - p[0][1] * p[1][0]) / across;
  const double t = std::clamp(moved, frame_.margin / 2, 1 - frame_.margin / 2);
  Vec3d diagonal;
  for (std::size_t i = 0; i < 3; ++i)
    if (((face.even ^ face.odd) >> i & 1) != 0) diagonal[i] = (cell.parity >> i & 1) != 0 ? -1 : 1;
  farthest_move_ = std::max(farthest_move_, std::abs(t - crossing(face.even, face.odd)) *
                                                length(frame_.to_world * diagonal));
  const EdgePlace& e = edges_[cell.parity][edge];
  BrickVertices<3>& vertices = mapper_->vertices();
  const LatticeKey key = row.key + cell.x * vertices.key_steps()[0];
  const bool is_first = (face.even ^ cell.parity) < (face.odd ^ cell.parity);
  return vertices.part().add_point(
      {key + e.first_key, key + e.second_key, is_first ? t : 1 - t},
      value<T>(row, cell, e.second_sample) - value<T>(row, cell, e.first_sample),
      frame_.margin / 2);
}

/// Where the edge between two corners is crossed, from the first.
template <typename T>
double CellMarcher::crossing_on(const Row& row, const Cell& cell, std::size_t from,
                                std::size_t to) const {
  const EdgePlace& e = edges_[cell.parity][edge_between_[from][to]];
  const double a = value<T>(row, cell, e.first_sample);
  const double b = value<T>(row, cell, e.second_sample);
  const double t =
      std::clamp((mapper_->vertices().isovalue() - a) / (b - a), frame_.margin, 1 - frame_.margin);
  return (from ^ cell.parity) < (to ^ cell.parity) ? t : 1 - t;
}

template <typename T>
double CellMarcher::value(const Row& row, const Cell& cell, std::uint32_t sample) const {
  return static_cast<double>(reinterpret_cast<const T*>(row.data)[cell.x + sample]);
}

bool CellMarcher::is_crossed(const Cell& cell, std::size_t edge) {
  const auto& ends = cell_edge_ends()[edge];
  return ((cell.signs >> ends[0] ^ cell.signs >> ends[1]) & 1) != 0;
}

CellMarcher::Face CellMarcher::face_of(std::size_t diagonal) const {
  Face face;
  face.even = cell_edge_ends()[diagonal][0];
  face.odd = cell_edge_ends()[diagonal][1];
  const std::size_t axes = face.even ^ face.odd;
  face.first = face.even | (axes & (~axes + 1));
  face.second = face.even ^ face.odd ^ face.first;
  face.edges = {edge_between_[face.even][face.first], edge_between_[face.first][face.odd],
                edge_between_[face.even][face.second], edge_between_[face.second][face.odd]};
  return face;
}

/// The one with this side, into two that have `between` on it.
void CellMarcher::split(InlineList<Triangle, 18>& triangles,
                        const std::array<std::uint32_t, 2>& side, std::uint32_t between) {
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    Triangle& t = triangles[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k];
      const std::uint32_t b = t[(k + 1) % 3];
      if (!(a == side[0] && b == side[1]) && !(a == side[1] && b == side[0])) continue;
      triangles.push_back({between, b, t[(k + 2) % 3]});
      t[(k + 1) % 3] = between;
      return;
    }
  }
  LODE_EXPECTS(false);  // the patch ends there
}

/// Bits, as EdgePlace::face.
unsigned CellMarcher::cubes_beside(const Index<3>& cell) const {
  unsigned faces = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const std::int32_t side : {0, 1}) {
      Index<3> other = cell;
      other[axis] += 2 * side - 1;
      if (cubes_->contains(other)) faces |= 1U << (2 * axis + as_size(side));
    }
  return faces;
}

bool CellMarcher::has_cell_beside(const Index<3>& cell, unsigned face) const {
  const std::int32_t at = cell[face / 2] + ((face & 1) != 0 ? 1 : -1);
  return at >= 0 && at < nodes_->model().shape.dims[face / 2] - 1;
}

void CellMarcher::add(const Triangle& ids, bool is_flipped) {
  mapper_->vertices().part().cells.push_back(is_flipped ? Triangle{ids[0], ids[2], ids[1]} : ids);
}

}  // namespace lode::diamond

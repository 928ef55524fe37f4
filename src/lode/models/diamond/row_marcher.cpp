#include "lode/models/diamond/row_marcher.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace lode::diamond {
RowMarcher::RowMarcher(const Selection<3>& selection, const LatticeFrame& frame)
    : selection_(selection),
      model_(selection.model()),
      slack_(rounding_slack<3>(model_)),
      nodes_(selection),
      cells_(frame) {
  const auto limit = static_cast<double>(decode_error(selection_.tolerance()));
  const bool is_halves = size_of(model_.storage) <= 2;
  largest_finest_ = encode_error(static_cast<float>(is_halves ? std::floor(2 * limit) / 2 : limit));
  for (std::size_t p = 0; p < steps_.size(); ++p)
    steps_[p] = corner_at(steps_of(static_cast<CubePoint>(p)));
}

bool RowMarcher::march(const BrickSamples<3>& samples, std::span<const Simplex<3>> simplices,
                       BrickIsosurface<3>& mapper, TraversalStats& stats) {
  samples_ = &samples;
  mapper_ = &mapper;
  if (!nodes_.open(samples, simplices)) return false;
  if (!nodes_.is_met()) return true;
  if (!nodes_.is_refined(nodes_.top(), {})) {
    march_top(simplices, stats);
    return true;
  }
  visit_storage_type(model_.storage, [&]<typename T>() {
    for (int level = nodes_.top(); level >= std::max(nodes_.finest(), 1); --level)
      march_level<T>(level, stats);
    if (nodes_.finest() == 0) march_finest_cubes<T>(stats);
  });
  if (nodes_.finest() == 0) cells_.march(nodes_, mapper);
  return true;
}

std::uint32_t RowMarcher::refined_octants(const Cube& cube) const {
  std::uint32_t bits = 0;
  for (unsigned octant = 0; octant < 8; ++octant)
    if (nodes_.is_refined(cube.level - 1, cube.at * 2 + corner_steps<3>(octant)))
      bits |= 1U << octant;
  return bits;
}

/// Which of its points are inside.
CubePoints RowMarcher::inside_of(const Cube& cube) const {
  const auto h = std::size_t{1} << cube.level;
  const std::size_t x = 2 * h * as_size(cube.at[0]);
  CubePoints inside = 0;
  for (std::size_t row = 0; row < 9; ++row) {
    const std::uint64_t word = nodes_.inside(h * (2 * as_size(cube.at[1]) + row % 3),
                                             h * (2 * as_size(cube.at[2]) + row / 3)) >>
                               x;
    inside |= static_cast<CubePoints>((word & 1) | (word >> h & 1) << 1 | (word >> 2 * h & 1) << 2)
              << (3 * row);
  }
  return inside;
}

void RowMarcher::march_top(std::span<const Simplex<3>> simplices, TraversalStats& stats) {
  for (const Simplex<3>& s : simplices) {
    BrickSimplex<3> leaf;
    bool is_crossed = false;
    bool is_removed = false;
    for (std::size_t i = 0; i < 4; ++i) {
      leaf.corner[i] = samples_->point(s.v[i] - samples_->base());
      leaf.corner[i].value = samples_->value(leaf.corner[i].offset);
      is_removed = is_removed || std::isnan(leaf.corner[i].value);
      is_crossed = is_crossed ||
                   selection_.side(leaf.corner[i].value) != selection_.side(leaf.corner[0].value);
    }
    if (!is_crossed || is_removed) continue;
    leaf.is_positive = dot(cross(s.v[1] - s.v[0], s.v[2] - s.v[0]), s.v[3] - s.v[0]) > 0;
    const Index<3> centre = all_equal<3>(std::int32_t{1} << nodes_.top());
    stats.achieved = std::max(stats.achieved, stored_error(nodes_.top(), centre));
    mapper_->add(leaf);
  }
}

template <typename T>
void RowMarcher::march_level(int level, TraversalStats& stats) {
  const std::int32_t n = (kBrickEdge<3> >> level) / 2;
  const CubePoints edge_nodes = CubeLeaves::of(0).edge_nodes;
  for (std::int32_t k = 0; k < n; ++k)
    for (std::int32_t j = 0; j < n; ++j) {
      std::uint32_t cubes = nodes_.refined_of(level, as_size(2 * j + 1), as_size(2 * k + 1)) &
                            static_cast<std::uint32_t>(BrickNodes::kOdd);
      for (; cubes != 0; cubes &= cubes - 1) {
        const std::int32_t x = std::countr_zero(cubes) - 1;
        const Cube cube = cube_at(level, {{x / 2, j, k}});
        CubePoints refined = 0;
        for (std::size_t row = 0; row < 9; ++row)
          refined |=
              (nodes_.refined_of(level, as_size(2 * j) + row % 3, as_size(2 * k) + row / 3) >> x &
               7)
              << (3 * row);
        const std::uint32_t octants = refined_octants(cube);
        ++stats.nodes_visited;
        if (octants == 0xFF && (refined & edge_nodes) == edge_nodes) continue;
        march_cube<T>(cube, refined, octants, stats);
      }
    }
}

/// Those with nodes that are not refined.
template <typename T>
void RowMarcher::march_finest_cubes(TraversalStats& stats) {
  for (std::size_t k = 0; k < BrickNodes::kCubes; ++k)
    for (std::size_t j = 0; j < BrickNodes::kCubes; ++j) {
      std::uint64_t cubes = nodes_.refined_cubes(j, k);
      if (cubes == 0) continue;
      stats.nodes_visited += static_cast<std::uint64_t>(std::popcount(cubes));
      const auto row = [&](std::size_t y, std::size_t z) {
        return nodes_.refined(2 * j + y, 2 * k + z);
      };
      const std::uint64_t along_x = row(0, 0) & row(2, 0) & row(0, 2) & row(2, 2);
      const std::uint64_t across = row(1, 0) & row(1, 2) & row(0, 1) & row(2, 1);
      cubes &= ~(along_x & across << 1 & across >> 1);
      for (; cubes != 0; cubes &= cubes - 1) {
        const int x = std::countr_zero(cubes) - 1;
        const Cube cube =
            cube_at(0, {{x / 2, static_cast<std::int32_t>(j), static_cast<std::int32_t>(k)}});
        CubePoints refined = 0;
        for (std::size_t r = 0; r < 9; ++r)
          refined |= static_cast<CubePoints>(row(r % 3, r / 3) >> x & 7) << (3 * r);
        march_cube<T>(cube, refined, 0, stats);
      }
    }
}

/// The simplices beside nodes that are not refined: of tiers 1 and 2, and, from level 1 on, those
/// of tier 0 of the next finer level. `octants`: which of the cubes these lie in are refined.
template <typename T>
void RowMarcher::march_cube(const Cube& cube, CubePoints refined, std::uint32_t octants,
                            TraversalStats& stats) {
  const CubePoints inside = inside_of(cube);
  constexpr CubePoints kAll = (CubePoints{1} << 27) - 1;
  if (inside == 0 || inside == kAll) return;
  const auto is_set = [&](CubePoint p) { return (refined >> p & 1) != 0; };
  for (const CubeLeaves::Face& face : CubeLeaves::of(nodes_.parity_of(cube.level, cube.at)).faces) {
    // A node of level 0 and tier 1 is refined where its own error or one below it asks for that.
    const bool is_split =
        cube.level > 0 ? is_set(face.node) : is_set(face.node) || (refined & face.edge_nodes) != 0;
    if (!is_split) {
      for (const CubeSimplex& s : face.simplices)
        march_simplex<T>(cube, s, inside, stats, [&] { return error_of<T>(face, cube); });
      continue;
    }
    for (const CubeLeaves::Edge& edge : face.edges) {
      if (!is_set(edge.node)) {
        march_simplex<T>(cube, edge.simplex, inside, stats,
                         [&] { return error_of<T>(edge, cube); });
        continue;
      }
      if (cube.level == 0) continue;
      for (const CubeLeaves::Finer& finer : edge.finer)
        if ((octants >> finer.octant & 1) == 0)
          march_simplex<T>(cube, finer.simplex, inside, stats, [&] {
            const std::int32_t h = std::int32_t{1} << cube.level;
            return stored_error(cube.level - 1, (cube.at * 2 + corner_steps<3>(finer.octant)) * h +
                                                    all_equal<3>(h / 2));
          });
    }
  }
}

template <typename T, typename NodeError>
void RowMarcher::march_simplex(const Cube& cube, const CubeSimplex& simplex, CubePoints inside,
                               TraversalStats& stats, const NodeError& error) {
  const CubePoints of_corners = inside & simplex.corners;
  if (of_corners == 0 || of_corners == simplex.corners) return;
  for (std::size_t i = 0; i < 3; ++i)
    if ((2 * cube.at[i] + simplex.lower[i]) << cube.level >= nodes_.n_cells()[i]) return;
  // Which side a hole is on means nothing; one that reaches beyond the data may have such corners.
  if (model_.has_holes())
    for (const CubePoint p : simplex.corner)
      if (model_.is_hole(value<T>(corner_of(cube, p).sample))) return;
  // Once there is an error as large as may be, others need not be known.
  if (cube.level > 0 || achieved_ < largest_finest_) achieved_ = std::max(achieved_, error());
  stats.achieved = std::max(stats.achieved, achieved_);
  std::array<Corner, 4> corners;
  std::size_t signs = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    corners[i] = corner_of(cube, simplex.corner[i]);
    signs |= (inside >> simplex.corner[i] & std::size_t{1}) << i;
  }
  BrickVertices<3>& vertices = mapper_->vertices();
  const auto vertex_on = [&](std::size_t i, std::size_t j) {
    const Corner& a = corners[i];
    const Corner& b = corners[j];
    const std::size_t place = a.place + b.place;
    std::uint32_t vertex = vertices[place];
    if (vertex != BrickVertices<3>::kNone) return vertex;
    vertex = a.key < b.key ? vertices.add(a.key, value<T>(a.sample), b.key, value<T>(b.sample))
                           : vertices.add(b.key, value<T>(b.sample), a.key, value<T>(a.sample));
    vertices.set(place, vertex);
    return vertex;
  };
  lode::march_simplex<3>(signs, simplex.is_positive == mapper_->is_mirrored(), vertex_on,
                         [&](const auto& cell) { vertices.part().cells.push_back(cell); });
}

RowMarcher::Corner RowMarcher::corner_at(const Index<3>& local) {
  return {static_cast<std::uint32_t>(BrickVertices<3>::place(local)),
          static_cast<std::uint32_t>(Model<3>::brick_offset(local)), to_key(local)};
}

RowMarcher::Corner RowMarcher::corner_of(const Cube& cube, CubePoint p) const {
  const Corner& steps = steps_[p];
  return {cube.first.place + (steps.place << cube.level),
          cube.first.sample + (steps.sample << cube.level),
          cube.first.key + (steps.key << cube.level)};
}

RowMarcher::Cube RowMarcher::cube_at(int level, const Index<3>& at) const {
  Cube cube{level, at, corner_at(at * (std::int32_t{2} << level))};
  cube.first.key += mapper_->vertices().key_of(0);
  return cube;
}

template <typename T>
double RowMarcher::value(std::uint32_t sample) const {
  return static_cast<double>(reinterpret_cast<const T*>(nodes_.data())[sample]);
}

ErrorCode RowMarcher::stored_error(int level, const Index<3>& local) const {
  return selection_.error(level, nodes_.stored_at(level, local));
}

template <typename T>
ErrorCode RowMarcher::error_of(const CubeLeaves::Edge& edge, const Cube& cube) const {
  if (cube.level > 0)
    return stored_error(cube.level,
                        (cube.at * 2 + steps_of(edge.node)) * (std::int32_t{1} << cube.level));
  const auto& ends = edge.simplex.corner;
  return encode_error(float_up(midpoint_error<T>(cube, edge.node, ends[0], ends[1]) + slack_));
}

template <typename T>
ErrorCode RowMarcher::error_of(const CubeLeaves::Face& face, const Cube& cube) const {
  if (cube.level > 0)
    return stored_error(cube.level,
                        (cube.at * 2 + steps_of(face.node)) * (std::int32_t{1} << cube.level));
  const auto& ends = face.simplices[0].corner;
  double error = midpoint_error<T>(cube, face.node, ends[0], ends[2]);
  for (const CubeLeaves::Edge& edge : face.edges)
    error = std::max(
        error, midpoint_error<T>(cube, edge.node, edge.simplex.corner[0], edge.simplex.corner[1]));
  return encode_error(float_up(error + slack_));
}

template <typename T>
double RowMarcher::midpoint_error(const Cube& cube, CubePoint node, CubePoint first,
                                  CubePoint second) const {
  const auto value_at = [&](CubePoint p) { return value<T>(corner_of(cube, p).sample); };
  return std::abs(value_at(node) - 0.5 * (value_at(first) + value_at(second)));
}

}  // namespace lode::diamond

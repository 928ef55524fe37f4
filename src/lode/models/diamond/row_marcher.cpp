#include "lode/models/diamond/row_marcher.h"

#include <algorithm>
#include <bit>

#include "lode/models/diamond/range_code.h"

namespace lode::diamond {
namespace {

constexpr std::uint64_t kOdd = 0xAAAAAAAAAAAAAAAAU;
constexpr std::uint64_t kEven = ~kOdd;
constexpr auto kRowSamples = as_size(kBrickSamples<3>);

/// The first n bits; n may be negative, or more than there are.
std::uint64_t first_bits(std::int32_t n) {
  return n <= 0 ? 0 : n >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << n) - 1;
}

/// The smallest float32 not below x: f < x and f >= x are what they are of that.
float float_up_of(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) >= x ? f : next_up(f);
}

Index<3> corner_steps(unsigned corner) {
  Index<3> steps;
  for (std::size_t i = 0; i < 3; ++i) steps[i] = static_cast<std::int32_t>((corner >> i) & 1);
  return steps;
}

std::size_t level_word(std::size_t y, std::size_t z) {
  return y + as_size(kBrickEdge<3> / 2 + 1) * z;
}

/// Which of n points first, first + 1, .. of a level's grid, along one axis, are closer to the
/// data's end than their nodes' simplices reach (see Shape::reaches_across()).
std::uint64_t forced_along(std::int32_t last, int level, std::int32_t first, std::int32_t n) {
  const std::int32_t h = std::int32_t{1} << level;
  if (last % (2 * h) == 0) return 0;
  std::uint64_t bits = 0;
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t reach = ((first + i) & 1) != 0 ? 3 * h : 2 * h;
    if (std::abs((first + i) * h - last) < reach) bits |= std::uint64_t{1} << i;
  }
  return bits;
}

}  // namespace

RowMarcher::RowMarcher(const Selection<3>& selection)
    : selection_(selection),
      model_(selection.model()),
      slack_(rounding_slack<3>(model_)),
      top_(std::min(kBrickLevel<3>, model_.shape.n_levels - 1)) {
  limits_ = {selection_.tolerance(), float_up_of(selection_.relative().above),
             float_up_of(selection_.relative().below)};
  const auto limit = static_cast<double>(decode_error(selection_.tolerance()));
  const bool is_halves = size_of(model_.storage) <= 2;
  largest_finest_ = encode_error(static_cast<float>(is_halves ? std::floor(2 * limit) / 2 : limit));
  for (std::size_t p = 0; p < steps_.size(); ++p)
    steps_[p] = corner_at(steps_of(static_cast<CubePoint>(p)));
  const auto& ends = cell_edge_ends();
  for (unsigned parity = 0; parity < 8; ++parity)
    for (std::size_t e = 0; e < ends.size(); ++e) {
      // In three dimensions lattice axes are the grid's, and keys are ordered by z, y, x.
      std::array<unsigned, 2> corner{ends[e][0] ^ parity, ends[e][1] ^ parity};
      if (corner[0] > corner[1]) std::swap(corner[0], corner[1]);
      const Corner a = corner_at(corner_steps(corner[0]));
      const Corner b = corner_at(corner_steps(corner[1]));
      edges_[parity][e] = {a.place + b.place, a.sample, b.sample, a.key, b.key};
    }
}

bool RowMarcher::march(const BrickSamples<3>& samples, std::span<const Simplex<3>> simplices,
                       BrickIsosurface<3>& mapper, TraversalStats& stats) {
  open(samples, mapper);
  const std::size_t whole = stored_at(top_, all_equal<3>(std::int32_t{1} << top_));
  if (selection_.error(top_, whole) == kInfiniteError) return false;
  if (simplices.empty() || !selection_.is_active(top_, whole)) return true;
  march_leaves(simplices, stats);
  return true;
}

void RowMarcher::march_leaves(std::span<const Simplex<3>> simplices, TraversalStats& stats) {
  // A part's lattice may begin at an odd multiple of a brick's side: its simplices know.
  top_parity_ = 0;
  for (std::size_t i = 0; i < 3; ++i)
    if (simplices[0].v[0][i] != base_[i]) top_parity_ |= 1U << i;
  visit_storage_type(model_.storage, [&]<typename T>() { find_inside_samples<T>(); });
  find_levels();
  if (finest_ == 0) visit_storage_type(model_.storage, [&]<typename T>() { find_finest<T>(); });
  if (!is_refined(top_, {})) {
    march_top(simplices, stats);
    return;
  }
  visit_storage_type(model_.storage, [&]<typename T>() {
    for (int level = top_; level >= std::max(finest_, 1); --level) march_level<T>(level, stats);
    if (finest_ > 0) return;
    march_finest_cubes<T>(stats);
    march_cells<T>();
  });
}

void RowMarcher::open(const BrickSamples<3>& samples, BrickIsosurface<3>& mapper) {
  samples_ = &samples;
  mapper_ = &mapper;
  base_ = samples.base();
  data_ = samples.data();
  is_whole_ = true;
  is_forced_ = false;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::int32_t left = model_.shape.dims[i] - 1 - base_[i];
    n_cells_[i] = std::min(left, kBrickEdge<3>);
    is_whole_ = is_whole_ && left >= kBrickEdge<3>;
    is_forced_ = is_forced_ || left < 2 * kBrickEdge<3>;
  }
}

template <typename T>
void RowMarcher::find_inside_samples() {
  const std::optional<T> threshold = threshold_of<T>(selection_.isovalue());
  if (threshold)
    find_inside(reinterpret_cast<const T*>(data_), *threshold, inside_);
  else
    inside_.fill(0);
}

void RowMarcher::find_levels() {
  for (finest_ = top_; finest_ > 0; --finest_)
    if (!find_level(finest_)) return;
}

bool RowMarcher::find_level(int level) {
  const std::int32_t n = (kBrickEdge<3> >> level) + 1;
  Index<3> first;
  for (std::size_t i = 0; i < 3; ++i) first[i] = base_[i] >> level;
  std::array<std::uint64_t, 3> forced{};
  for (std::size_t i = 0; is_forced_ && i < 3; ++i)
    forced[i] = forced_along(model_.shape.dims[i] - 1, level, first[i], n);
  const Index<3> dims = model_.shape.grid_dims(level);
  const std::int32_t n_x = std::min(n, dims[0] - first[0]);
  std::uint32_t any_of_tier_2 = 0;
  LevelBits& bits = levels_[as_size(level)];
  for (std::int32_t z = 0; z < n; ++z)
    for (std::int32_t y = 0; y < n; ++y) {
      std::uint32_t& row = bits[level_word(as_size(y), as_size(z))];
      row = 0;
      if (first[1] + y >= dims[1] || first[2] + z >= dims[2]) continue;
      const bool is_forced = ((forced[1] >> y) & 1) != 0 || ((forced[2] >> z) & 1) != 0;
      row = level_row(level, first + Index<3>{{0, y, z}}, n_x,
                      is_forced ? ~std::uint32_t{0} : static_cast<std::uint32_t>(forced[0]));
      const std::uint32_t n_odd = (as_size(y) & 1) + (as_size(z) & 1);
      if (n_odd == 0) row &= static_cast<std::uint32_t>(kOdd);
      if (n_odd < 2) any_of_tier_2 |= row & static_cast<std::uint32_t>(n_odd == 0 ? kOdd : kEven);
    }
  return any_of_tier_2 != 0;
}

/// `forced`: which are refined whatever their error.
std::uint32_t RowMarcher::level_row(int level, const Index<3>& first, std::int32_t n,
                                    std::uint32_t forced) const {
  if (selection_.has_wanted())
    for (std::int32_t x = 0; x < n; ++x)
      if (selection_.is_wanted((first + Index<3>{{x, 0, 0}}) * (std::int32_t{1} << level)))
        forced |= std::uint32_t{1} << x;
  if (selection_.is_full()) forced = ~std::uint32_t{0};
  const NodeLevel& nodes = model_.levels[as_size(level)];
  const std::size_t at = linear_index<3>(model_.shape.grid_dims(level), first);
  return find_refined({&nodes.error[at], &nodes.low[at], &nodes.high[at], as_size(n)}, limits_,
                      forced);
}

template <typename T>
void RowMarcher::find_finest() {
  BrickRows rows{};
  find_met_cubes(rows);
  if (selection_.is_full()) {
    refined_.fill(~std::uint64_t{0});
    for (std::size_t z = 0; z < kRowSamples; z += 2)
      for (std::size_t y = 0; y < kRowSamples; y += 2) refined_[brick_row(y, z)] = kOdd;
  } else {
    find_rough(reinterpret_cast<const T*>(data_), {decode_error(selection_.tolerance()), slack_},
               rows, refined_);
    if (is_forced_ || selection_.has_wanted()) add_forced(rows);
  }
  find_refined_cubes();
}

/// And the rows that meet these.
void RowMarcher::find_met_cubes(BrickRows& rows) {
  const std::uint64_t in_data = kOdd & first_bits(n_cells_[0] + 1);
  for (std::size_t k = 0; k < kCubes; ++k)
    for (std::size_t j = 0; j < kCubes; ++j) {
      std::uint64_t any = 0;
      std::uint64_t all = ~std::uint64_t{0};
      for (std::size_t z = 2 * k; z <= 2 * k + 2; ++z)
        for (std::size_t y = 2 * j; y <= 2 * j + 2; ++y) {
          any |= inside_[brick_row(y, z)];
          all &= inside_[brick_row(y, z)];
        }
      any |= any << 1 | any >> 1;
      all &= all << 1 & all >> 1;
      const bool exists = static_cast<std::int32_t>(2 * j) < n_cells_[1] &&
                          static_cast<std::int32_t>(2 * k) < n_cells_[2];
      const std::uint64_t met = exists ? any & ~all & in_data : 0;
      met_[j + kCubes * k] = met;
      if (met == 0) continue;
      for (std::size_t z = 2 * k; z <= 2 * k + 2; ++z) rows[z] |= std::uint64_t{7} << (2 * j);
    }
}

void RowMarcher::add_forced(const BrickRows& rows) {
  constexpr std::int32_t n = kBrickSamples<3>;
  std::array<std::uint64_t, 3> forced{};
  for (std::size_t i = 0; is_forced_ && i < 3; ++i)
    forced[i] = forced_along(model_.shape.dims[i] - 1, 0, base_[i], n);
  for (std::size_t z = 0; z < kRowSamples; ++z)
    for (std::size_t y = 0; y < kRowSamples; ++y) {
      if (((rows[z] >> y) & 1) == 0) continue;
      const bool is_forced = ((forced[1] >> y) & 1) != 0 || ((forced[2] >> z) & 1) != 0;
      std::uint64_t bits = is_forced ? ~std::uint64_t{0} : forced[0];
      if (selection_.has_wanted())
        bits |= selection_.wanted()->row(
            base_ + Index<3>{{0, static_cast<std::int32_t>(y), static_cast<std::int32_t>(z)}}, n);
      if (((y | z) & 1) == 0) bits &= kOdd;
      refined_[brick_row(y, z)] |= bits;
    }
}

void RowMarcher::find_refined_cubes() {
  for (std::size_t k = 0; k < kCubes; ++k)
    for (std::size_t j = 0; j < kCubes; ++j) {
      std::uint64_t& cubes = refined_cubes_[j + kCubes * k];
      cubes = met_[j + kCubes * k];
      if (cubes == 0) continue;
      std::uint64_t any = 0;
      for (std::size_t z = 2 * k; z <= 2 * k + 2; ++z)
        for (std::size_t y = 2 * j; y <= 2 * j + 2; ++y) any |= refined_[brick_row(y, z)];
      cubes &= any | any << 1 | any >> 1;
    }
}

bool RowMarcher::is_refined(int level, const Index<3>& cube) const {
  if (level < finest_) return false;
  const auto x = as_size(2 * cube[0] + 1);
  if (level == 0)
    return ((refined_cubes_[as_size(cube[1]) + kCubes * as_size(cube[2])] >> x) & 1) != 0;
  const std::size_t word = level_word(as_size(2 * cube[1] + 1), as_size(2 * cube[2] + 1));
  return ((levels_[as_size(level)][word] >> x) & 1) != 0;
}

std::uint32_t RowMarcher::refined_octants(const Cube& cube) const {
  std::uint32_t bits = 0;
  for (unsigned octant = 0; octant < 8; ++octant)
    if (is_refined(cube.level - 1, cube.at * 2 + corner_steps(octant))) bits |= 1U << octant;
  return bits;
}

/// Which of its points are inside.
CubePoints RowMarcher::inside_of(const Cube& cube) const {
  const auto h = std::size_t{1} << cube.level;
  const std::size_t x = 2 * h * as_size(cube.at[0]);
  CubePoints inside = 0;
  for (std::size_t row = 0; row < 9; ++row) {
    const std::uint64_t word = inside_[brick_row(h * (2 * as_size(cube.at[1]) + row % 3),
                                                 h * (2 * as_size(cube.at[2]) + row / 3))] >>
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
    for (std::size_t i = 0; i < 4; ++i) {
      leaf.corner[i] = samples_->point(s.v[i] - base_);
      leaf.corner[i].value = samples_->value(leaf.corner[i].offset);
      is_crossed = is_crossed ||
                   selection_.side(leaf.corner[i].value) != selection_.side(leaf.corner[0].value);
    }
    if (!is_crossed) continue;
    leaf.is_positive = dot(cross(s.v[1] - s.v[0], s.v[2] - s.v[0]), s.v[3] - s.v[0]) > 0;
    const std::int32_t h = std::int32_t{1} << top_;
    stats.achieved = std::max(stats.achieved, stored_error(top_, all_equal<3>(h)));
    mapper_->add(leaf);
  }
}

template <typename T>
void RowMarcher::march_level(int level, TraversalStats& stats) {
  const std::int32_t n = (kBrickEdge<3> >> level) / 2;
  const LevelBits& bits = levels_[as_size(level)];
  const CubePoints edge_nodes = CubeLeaves::of(0).edge_nodes;
  for (std::int32_t k = 0; k < n; ++k)
    for (std::int32_t j = 0; j < n; ++j) {
      std::uint32_t cubes = bits[level_word(as_size(2 * j + 1), as_size(2 * k + 1))] &
                            static_cast<std::uint32_t>(kOdd);
      for (; cubes != 0; cubes &= cubes - 1) {
        const std::int32_t x = std::countr_zero(cubes) - 1;
        const Cube cube = cube_at(level, {{x / 2, j, k}});
        CubePoints refined = 0;
        for (std::size_t row = 0; row < 9; ++row)
          refined |= (bits[level_word(as_size(2 * j) + row % 3, as_size(2 * k) + row / 3)] >> x & 7)
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
  for (std::size_t k = 0; k < kCubes; ++k)
    for (std::size_t j = 0; j < kCubes; ++j) {
      std::uint64_t cubes = refined_cubes_[j + kCubes * k];
      if (cubes == 0) continue;
      stats.nodes_visited += static_cast<std::uint64_t>(std::popcount(cubes));
      const auto row = [&](std::size_t y, std::size_t z) {
        return refined_[brick_row(2 * j + y, 2 * k + z)];
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
  unsigned parity = cube.level == top_ ? top_parity_ : 0;
  for (std::size_t i = 0; cube.level < top_ && i < 3; ++i)
    parity |= static_cast<unsigned>(cube.at[i] & 1) << i;
  const auto is_set = [&](CubePoint p) { return (refined >> p & 1) != 0; };
  for (const CubeLeaves::Face& face : CubeLeaves::of(parity).faces) {
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
            return stored_error(cube.level - 1, (cube.at * 2 + corner_steps(finer.octant)) * h +
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
  if (!is_whole_)
    for (std::size_t i = 0; i < 3; ++i)
      if ((2 * cube.at[i] + simplex.lower[i]) << cube.level >= n_cells_[i]) return;
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
  constexpr auto kEdge = static_cast<std::int32_t>(BrickVertices<3>::kEdge);
  return {static_cast<std::uint32_t>((local[2] * kEdge + local[1]) * kEdge + local[0]),
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
  return static_cast<double>(reinterpret_cast<const T*>(data_)[sample]);
}

/// Where a node's attributes are; its centre is given from the brick's lowest corner.
std::size_t RowMarcher::stored_at(int level, const Index<3>& local) const {
  std::size_t at = 0;
  for (std::size_t i = 0; i < 3; ++i)
    at += as_size((base_[i] + local[i]) >> std::max(level, 1)) * model_.strides[as_size(level)][i];
  return at;
}

ErrorCode RowMarcher::stored_error(int level, const Index<3>& local) const {
  return selection_.error(level, stored_at(level, local));
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

template <typename T>
void RowMarcher::march_cells() {
  for (std::int32_t z = 0; z < n_cells_[2]; ++z)
    for (std::int32_t y = 0; y < n_cells_[1]; ++y)
      if (refined_cubes_[as_size(y / 2) + kCubes * as_size(z / 2)] != 0)
        march_row<T>(as_size(y), as_size(z));
}

/// The unit cells of a row, of each the simplices whose parents, which have their middles beside
/// the cell's even corner, are refined.
template <typename T>
void RowMarcher::march_row(std::size_t y, std::size_t z) {
  const std::size_t odd_y = y & 1;
  const std::size_t odd_z = z & 1;
  // Rows of corners with even y and z first.
  std::array<std::uint64_t, 4> corners;
  for (std::size_t i = 0; i < 4; ++i)
    corners[i] = inside_[brick_row(y + ((i & 1) ^ odd_y), z + ((i >> 1) ^ odd_z))];
  std::uint64_t any = corners[0] | corners[1] | corners[2] | corners[3];
  std::uint64_t all = corners[0] & corners[1] & corners[2] & corners[3];
  const std::uint64_t crossed = (any | any >> 1) & ~(all & all >> 1) & first_bits(n_cells_[0]);
  if (crossed == 0) return;
  const std::uint64_t beside_x = refined_[brick_row(y + odd_y, z + odd_z)] & kOdd;
  const std::uint64_t beside_y = refined_[brick_row(y + (odd_y ^ 1), z + odd_z)] & kEven;
  const std::uint64_t beside_z = refined_[brick_row(y + odd_y, z + (odd_z ^ 1))] & kEven;
  const std::array<std::uint64_t, 3> axes{beside_x | beside_x >> 1, beside_y | beside_y >> 1,
                                          beside_z | beside_z >> 1};
  BrickVertices<3>& vertices = mapper_->vertices();
  const bool is_flipped = ((odd_y ^ odd_z) != 0) != mapper_->is_mirrored();
  const CellCase* const cases = cell_cases_by_axes();
  const auto& key_steps = vertices.key_steps();
  const LatticeKey row_key = vertices.key_of(0) + y * key_steps[1] + z * key_steps[2];
  const std::size_t row_place = (2 * z * BrickVertices<3>::kEdge + 2 * y) * BrickVertices<3>::kEdge;
  const T* const row = reinterpret_cast<const T*>(data_) + brick_row(y, z) * kRowSamples;
  auto& cells = vertices.part().cells;
  for (std::uint64_t left = crossed & (axes[0] | axes[1] | axes[2]); left != 0; left &= left - 1) {
    const auto x = static_cast<std::size_t>(std::countr_zero(left));
    const std::size_t odd_x = x & 1;
    std::size_t signs = 0;
    for (std::size_t i = 0; i < 4; ++i) signs |= (corners[i] >> x & 3) << (2 * i);
    if (odd_x != 0) signs = (signs & 0x55) << 1 | (signs >> 1 & 0x55);
    const std::size_t some = (axes[0] >> x & 1) | (axes[1] >> x & 1) << 1 | (axes[2] >> x & 1) << 2;
    const CellCase& c = cases[some * 256 + signs];
    const EdgePlaces& edges = edges_[odd_x | odd_y << 1 | odd_z << 2];
    const std::size_t second = is_flipped != (odd_x != 0) ? 2 : 1;
    for (std::size_t i = 0; i < c.n_ends; i += 3) {
      std::array<std::uint32_t, 3> ids;
      for (std::size_t k = 0; k < 3; ++k) {
        const EdgePlace& e = edges[c.edge[i + k]];
        const std::size_t place = row_place + 2 * x + e.place;
        ids[k] = vertices[place];
        if (ids[k] != BrickVertices<3>::kNone) continue;
        const LatticeKey key = row_key + x * key_steps[0];
        ids[k] = vertices.add(key + e.first_key, static_cast<double>(row[x + e.first_sample]),
                              key + e.second_key, static_cast<double>(row[x + e.second_sample]));
        vertices.set(place, ids[k]);
      }
      cells.push_back({ids[0], ids[second], ids[3 - second]});
    }
  }
}

}  // namespace lode::diamond

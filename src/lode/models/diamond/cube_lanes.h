#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

#include "lode/models/diamond/interpolant_kernel.h"
#include "lode/models/diamond/lane_rows.h"
#include "lode/models/diamond/leaf_attributes.h"
#include "lode/models/diamond/own_errors.h"

namespace lode::diamond {

/// Bricks that a pass goes through together, side by side in x: as many as its lanes have cubes.
template <int D, typename V>
inline constexpr std::size_t kBricksOf = std::max<std::size_t>(1, kLanesOf<V> /
                                                                      as_size(kPlansPerBrick<D>));

/// The plan's cubes of kBricksOf<D, V> bricks, kLanesOf<V> at a time, with the points of all lanes
/// side by side as the kernels want them.
template <int D, typename V>
class CubeLanes {
 public:
  static constexpr std::size_t kWidth = kLanesOf<V>;
  static constexpr std::size_t kBatches = kBricksOf<D, V> * as_size(kPlansPerBrick<D>) / kWidth;
  /// Lanes that belong to one brick, whatever V.
  static constexpr std::size_t kGroups = kWidth / kLanes;
  using Cubes = std::array<CanonicalCube<D>, kLanes>;
  using Used = std::array<bool, kLanes>;

  /// Of bricks first, first + 1, .. in x, each with its kLeafValues (null: there is none).
  using Values = std::array<const V*, kBricksOf<D, V>>;

  CubeLanes(const Shape<D>& shape, const Part<D>& part) : shape_(shape), part_(part) {}

  /// Which of the bricks a lane's cube lies in, and which of the brick's cubes it is.
  static std::size_t brick_of(std::size_t batch, std::size_t lane) {
    return (batch * kWidth + lane) / as_size(kPlansPerBrick<D>);
  }
  static CanonicalCube<D> cube_of(const Index<D>& brick, std::size_t batch, std::size_t lane) {
    const std::size_t number = (batch * kWidth + lane) % as_size(kPlansPerBrick<D>);
    const Index<D> per_edge = all_equal<D>(kBrickEdge<D> / kPlanEdge<D>);
    return CanonicalCube<D>(brick * kBrickEdge<D> + point_of<D>(per_edge, number) * kPlanEdge<D>,
                            kPlanEdge<D>);
  }

  /// Fills the lanes with a batch of cubes; false when none of them meets the data.
  bool gather(const Index<D>& first, const Values& values, std::size_t batch, bool has_holes) {
    bool is_any = false;
    bool is_whole = true;
    for (std::size_t l = 0; l < kWidth; ++l) {
      const std::size_t number = brick_of(batch, l);
      CanonicalCube<D>& cube = cubes_[l / kLanes][l % kLanes];
      bool& is_used = is_used_[l / kLanes][l % kLanes];
      Index<D> brick = first;
      brick[0] += static_cast<std::int32_t>(number);
      cube = cube_of(brick, batch, l);
      is_used = values[number] != nullptr;
      if (!is_used) continue;
      const Index<D> lower = cube.lowest_corner();
      for (std::size_t i = 0; i < as_size(D); ++i) {
        is_used = is_used && lower[i] >= part_.samples.lower[i] &&
                  lower[i] < std::min(part_.samples.upper[i], shape_.dims[i] - 1);
        is_whole = is_whole && lower[i] + kPlanEdge<D> < shape_.dims[i];
      }
      is_any = is_any || is_used;
    }
    if (!is_any) return false;
    vertices_.resize(kPlanPoints<D> * kWidth);
    copy_rows(values, batch);
    samples_ = vertices_.data();
    if (has_holes || !is_whole) {
      masked_ = vertices_;
      samples_ = masked_.data();
    }
    if (has_holes) mark_holes();
    if (!is_whole) mask_beyond_data();
    gaps_ = has_holes ? Gaps::holes : is_whole ? Gaps::none : Gaps::beyond_data;
    return true;
  }

  /// Leaves only cubes that no other part looks at, and takes them to the whole field's lattice.
  void keep_shares() {
    for (std::size_t l = 0; l < kWidth; ++l) {
      CanonicalCube<D>& cube = cubes_[l / kLanes][l % kLanes];
      bool& is_used = is_used_[l / kLanes][l % kLanes];
      const Index<D> lower = cube.lowest_corner();
      for (std::size_t i = 0; i < as_size(D); ++i)
        is_used = is_used && lower[i] >= part_.shares.lower[i] && lower[i] < part_.shares.upper[i];
      cube = CanonicalCube<D>(lower + part_.origin, kPlanEdge<D>);
    }
  }

  [[nodiscard]] bool is_used(std::size_t lane) const {
    return is_used_[lane / kLanes][lane % kLanes];
  }
  [[nodiscard]] const Cubes& cubes(std::size_t group) const { return cubes_[group]; }
  [[nodiscard]] const Used& used(std::size_t group) const { return is_used_[group]; }
  [[nodiscard]] Gaps gaps() const { return gaps_; }
  [[nodiscard]] const V* vertices() const { return vertices_.data(); }
  [[nodiscard]] const V* samples() const { return samples_; }

 private:
  /// The points of all lanes side by side. Rows of mirrored cubes run backwards.
  void copy_rows(const Values& values, std::size_t batch) {
    std::array<LaneCube<V>, kWidth> lanes;
    for (std::size_t l = 0; l < kWidth; ++l) {
      const CanonicalCube<D> cube = cube_of({}, batch, l);
      const V* const own = values[brick_of(batch, l)];
      lanes[l].origin = own != nullptr ? own : values[0];
      for (std::size_t i = 0; i < as_size(D); ++i) {
        const auto stride =
            static_cast<std::ptrdiff_t>(power(as_size(kLeafEdge<D>), static_cast<int>(i)));
        lanes[l].origin += (cube.even_corner[i] + 1) * stride;
        lanes[l].step[i] = cube.sign[i] * stride;
      }
    }
    constexpr std::size_t n = as_size(kPlanEdge<D> + 1);
    interleave_cubes(lanes, {n, n, D == 3 ? n : 1}, vertices_.data());
  }

  /// Holes count, unlike points beyond the data.
  void mark_holes() {
    if constexpr (std::is_floating_point_v<V>)
      for (V& sample : masked_)
        if (std::isnan(sample)) sample = std::numeric_limits<V>::infinity();
  }

  /// Points beyond the data do not count as samples.
  void mask_beyond_data() {
    for (std::size_t l = 0; l < kWidth; ++l) {
      const LatticeBox<D> inside = part_in_data(cubes_[l / kLanes][l % kLanes]);
      if (inside.lower == Index<D>{} && inside.upper == all_equal<D>(kPlanEdge<D> + 1)) continue;
      Index<D> rows = all_equal<D>(kPlanEdge<D> + 1);
      rows[0] = 1;
      V* row = masked_.data() + l;
      for (std::size_t r = 0; r < n_points<D>(rows); ++r, row += (kPlanEdge<D> + 1) * kWidth) {
        const Index<D> u = point_of<D>(rows, r);
        bool is_inside = true;
        for (std::size_t i = 1; i < as_size(D); ++i)
          is_inside = is_inside && u[i] >= inside.lower[i] && u[i] < inside.upper[i];
        const std::int32_t begin = is_inside ? inside.lower[0] : 0;
        const std::int32_t end = is_inside ? inside.upper[0] : 0;
        for (std::int32_t x = 0; x <= kPlanEdge<D>; ++x)
          if (x < begin || x >= end) row[as_size(x) * kWidth] = kNoSample<V>;
      }
    }
  }

  /// The points of a cube that are samples: lower <= u < upper, in its coordinates.
  [[nodiscard]] LatticeBox<D> part_in_data(const CanonicalCube<D>& cube) const {
    LatticeBox<D> part{{}, all_equal<D>(kPlanEdge<D> + 1)};
    for (std::size_t i = 0; i < as_size(D); ++i) {
      const std::int32_t beyond = shape_.dims[i] - cube.even_corner[i];  // first one, as u
      if (cube.sign[i] > 0)
        part.upper[i] = std::clamp(beyond, 0, kPlanEdge<D> + 1);
      else
        part.lower[i] = std::clamp(1 - beyond, 0, kPlanEdge<D> + 1);
    }
    return part;
  }

  const Shape<D>& shape_;
  const Part<D>& part_;
  std::array<Cubes, kGroups> cubes_;
  std::array<Used, kGroups> is_used_{};
  AlignedVector<V> vertices_, masked_;
  const V* samples_ = nullptr;  ///< vertices_, or masked_ where those say too little.
  Gaps gaps_ = Gaps::none;
};

}  // namespace lode::diamond

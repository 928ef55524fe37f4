#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "lode/core/vec.h"
#include "lode/models/tetra_mt/fan.h"
#include "lode/models/tetra_mt/star.h"
#include "lode/models/tetra_mt/value_distance.h"
#include "lode/refine/model.h"

namespace lode::tetra_mt {

/// A tetrahedron and one field.
struct ValuedCell {
  std::array<Vec3d, 4> corners;
  std::array<double, 4> values;
};

/// How far from `p` so many cells, of which there is one, have a value of a range; where they have
/// it nowhere, how far their farthest corner is. `first`: the cell that is looked at first;
/// `cell(i, found)`: fills it in, or false where there is none; `enough`: who asks does not care
/// how far below that it is.
template <typename CellAt>
[[nodiscard]] double distance_in_cells(std::size_t n, std::size_t first, const CellAt& cell,
                                       const Range& values, const Vec3d& p, double enough) {
  double least = std::numeric_limits<double>::infinity();
  ValuedCell found{};
  const auto look_at = [&](std::size_t i) {
    if (!cell(i, found)) return;
    least = std::min(least, distance_to_values(found.corners, found.values, values, p));
  };
  look_at(first);
  for (std::size_t i = 0; i < n && least > enough; ++i)
    if (i != first) look_at(i);
  if (std::isfinite(least)) return least;
  double farthest = 0;
  for (std::size_t i = 0; i < n; ++i)
    if (cell(i, found))
      for (const Vec3d& corner : found.corners) farthest = std::max(farthest, length(corner - p));
  return farthest;
}

/// The tetrahedra that come of a collapse, for one field: triangles of a star with the vertex that
/// is kept, or made.
struct ValuedFan {
  const Star& star;
  const Fan& fan;               ///< Says which triangles make none.
  std::span<const Vec3d> link;  ///< By link vertex.
  Vec3d apex;
  std::span<const double> values;  ///< By link vertex; anything of the one outside.
  double apex_value = 0;

  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(star.n_triangles); }
  [[nodiscard]] bool operator()(std::size_t i, ValuedCell& cell) const {
    if (fan.gaps[i] != 0) return false;
    const auto& t = star.triangles[i];
    cell.corners = {apex, link[t[0]], link[t[1]], link[t[2]]};
    cell.values = {apex_value, values[t[0]], values[t[1]], values[t[2]]};
    return true;
  }
};

/// What a fan's lane covers, and the values that count as its own.
struct FanSample {
  std::size_t lane;
  Range values;
  Vec3d place;
};

/// The largest distance_in_cells() of n samples. `sample_at(i)`: one.
template <typename SampleAt>
[[nodiscard]] double largest_distance(const ValuedFan& fan, std::size_t n,
                                      const SampleAt& sample_at) {
  double largest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const FanSample sample = sample_at(i);
    largest = std::max(largest, distance_in_cells(fan.size(), sample.lane, fan, sample.values,
                                                  sample.place, largest));
  }
  return largest;
}

}  // namespace lode::tetra_mt

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lode/core/vec.h"
#include "lode/models/tetra_mt/star.h"

namespace lode::tetra_mt {

/// A star's triangles side by side, relative to its vertex, padded; what fills up, and those with
/// the vertex outside, are all zero, so that they make no volume.
struct StarLanes {
  static constexpr std::size_t kPadding = 16;
  static constexpr std::size_t kMax = (Star::kMaxTriangles + kPadding - 1) / kPadding * kPadding;
  using Doubles = std::array<double, kMax>;
  using Floats = std::array<float, kMax>;

  std::size_t n = 0;  ///< With the padding.
  /// planes . p - heights is six times the volume to a point p, slacks what is too flat.
  alignas(64) std::array<Doubles, 3> planes;
  alignas(64) Doubles heights;
  alignas(64) Doubles slacks;
  alignas(64) std::array<std::array<Floats, 3>, 3> corners;  ///< By corner and axis.
  std::vector<std::array<Floats, 3>> values;                 ///< By field and corner.

  static constexpr double kFlat = 1e-6;  ///< Of a triangle's size times the star's.

  /// `link`: positions by link vertex, relative to the star's; link_values: by link vertex and
  /// field, likewise.
  void fill(const Star& star, const std::array<Vec3d, Star::kMaxLink>& link,
            const std::vector<float>& link_values, std::size_t n_fields);
};

/// What an error, as a share of the field's range, counts in the order of collapses: its square,
/// and twice that at a twenty-eighth of the range, so that no sample is given up for many others.
[[nodiscard]] inline double cost_of(double error) {
  constexpr double kOutlier = 800;
  const double square = error * error;
  return square * (1 + kOutlier * square);
}

/// Samples that a star covers, its vertex first; relative to that. Values are in units that make
/// fields alike.
struct StarSamples {
  std::vector<std::uint32_t> samples;
  std::vector<float> x;
  std::vector<float> y;
  std::vector<float> z;
  std::vector<float> values;       ///< By sample and field, above the vertex's.
  std::vector<float> link_values;  ///< By link vertex and field, likewise.
  std::size_t n_fields = 1;
  double cost = 0;  ///< cost_of() all errors, as they are covered now.
  /// Where distances in space count in place of errors: of these, what makes them shares of the
  /// mesh's size; else 0.
  float space_unit = 0;
};

/// The tetrahedra that come of a collapse, all with the vertex that is kept: lane by lane of the
/// star's, with gaps.
struct Fan {
  using Floats = StarLanes::Floats;

  std::array<float, 3> at;        ///< Of the vertex that is kept.
  std::vector<float> kept_value;  ///< By field.
  /// The weight of corner k at d from the kept vertex is rows[k] . d.
  alignas(64) std::array<std::array<Floats, 3>, 3> rows;
  alignas(64) Floats inverses;  ///< Of six times the volumes; 1 where there is none.
  alignas(64) Floats gaps;      ///< 0, or what is so small that no weight is smaller.
  std::vector<std::array<Floats, 3>> gradients;  ///< By field.

  /// F - F' at a sample that a lane covers.
  [[nodiscard]] float error(const StarSamples& samples, std::size_t sample, std::size_t field,
                            std::size_t lane) const;
  /// How far from there F' has the value of F, to first order, but no farther than kFarthest; times
  /// samples.space_unit.
  [[nodiscard]] float distance(const StarSamples& samples, std::size_t sample, std::size_t field,
                               std::size_t lane) const;

  static constexpr float kFarthest = 4;  ///< More than a star's size.
};

/// False where one of the tetrahedra is not of positive volume, by more than rounding. `at`: of the
/// vertex that is kept, relative to the star's; n_flat: of all lanes, those without a tetrahedron.
[[nodiscard]] bool make_fan(const StarLanes& star, const Vec3d& at, std::size_t n_flat, Fan& fan);

/// The sum of the costs of the samples' errors, or distances, or, as soon as it is above `limit`,
/// part of it.
[[nodiscard]] double cost_of(const Fan& fan, std::size_t n_lanes, const StarSamples& samples,
                             double limit);

/// Of a sample that the boundary has left outside, whose weights of a triangle's corners these are:
/// none below 0, and all four 1 together. What the tetrahedron is outside itself says nothing; thin
/// ones would say anything.
void clamp_weights(std::array<double, 3>& weights);

/// Which lane covers a sample: of all the one in which the smallest of the four weights is largest.
/// Where one holds the point it is that one, or shares a face with it that the point is near.
[[nodiscard]] std::size_t find_lane(const Fan& fan, std::size_t n_lanes, const StarSamples& samples,
                                    std::size_t sample);

}  // namespace lode::tetra_mt

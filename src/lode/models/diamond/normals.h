#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <span>

#include "lode/mappers/iso_part.h"
#include "lode/models/diamond/edge_normals.h"
#include "lode/models/diamond/model.h"
#include "lode/models/diamond/near_samples.h"

namespace lode::diamond {

/// Unit normals that point to lower values, at points on lattice edges: minus the gradient at the
/// edge's ends, mapped to world space. Zero where the gradient is.
///
/// The gradient is by central differences as far apart as the edge is long along its axes: a coarse
/// edge needs no finer samples than it has, and what it has lost does not darken it. At the border
/// and beside holes they are one-sided. T: the model's storage.
template <int D, typename T, typename Field = Model<D>>
class NormalSampler {
 public:
  explicit NormalSampler(const Field& model)
      : model_(model),
        to_world_(cofactors(model.info.grid.index_to_world_matrix())),
        sign_(determinant(model.info.grid.index_to_world_matrix()) < 0 ? 1 : -1) {}

  [[nodiscard]] Vec3f at(const EdgePoint& point) const {
    const Index3 first = to_point(point.first);
    const Index3 second = to_point(point.second);
    std::int32_t step = 0;
    for (std::size_t i = 0; i < 3; ++i) step = std::max(step, std::abs(first[i] - second[i]));
    return to_normal(gradient(first, step) * (1 - point.t) + gradient(second, step) * point.t);
  }
  /// How to_normal() does it.
  [[nodiscard]] NormalFrame frame() const { return {to_world_, sign_}; }
  /// What a gradient in grid axes becomes.
  [[nodiscard]] Vec3f to_normal(const Vec3d& gradient) const {
    const Vec3d n = normalized(to_world_ * gradient);
    Vec3f result;
    for (std::size_t i = 0; i < 3; ++i) result[i] = static_cast<float>(sign_ * n[i]);
    return result;
  }
  /// d value / d index at a lattice point whose coordinates `step` divides, in grid axes.
  [[nodiscard]] Vec3d gradient(const Index3& grid_point, std::int32_t step) const {
    Vec3d result;
    if (!model_.has_holes() && find_inner(grid_point, step, result)) return result;
    return general(grid_point, step);
  }

 private:
  /// Where all neighbours are samples of one brick or page, and no hole is about: most points.
  [[nodiscard]] bool find_inner(const Index3& grid_point, std::int32_t step,
                                Vec3d& gradient) const {
    Index<D> p;
    for (std::size_t i = 0; i < as_size(D); ++i) p[i] = grid_point[as_size(model_.axes.axis[i])];
    const int level = std::countr_zero(static_cast<std::uint32_t>(step));
    const NearSamples<D, T> near(model_, p, 1, level);
    if (!near.is_in_one()) return false;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      const auto [low, high] = near.beside(i);
      gradient[as_size(model_.axes.axis[i])] =
          (static_cast<double>(high) - static_cast<double>(low)) / (2 * step);
    }
    return true;
  }

  [[nodiscard]] Vec3d general(const Index3& grid_point, std::int32_t step) const {
    Index<D> p;
    for (std::size_t i = 0; i < as_size(D); ++i) p[i] = grid_point[as_size(model_.axes.axis[i])];
    Vec3d gradient;
    const double centre = model_.value_or_nan(p);
    if (std::isnan(centre)) return gradient;
    for (std::size_t i = 0; i < as_size(D); ++i)
      gradient[as_size(model_.axes.axis[i])] = slope(p, i, step, centre);
    return gradient;
  }

  /// Along an axis. Beyond the data lies its last sample again, which counts where it is.
  [[nodiscard]] double slope(const Index<D>& p, std::size_t axis, std::int32_t step,
                             double centre) const {
    const std::int32_t last = model_.shape.dims[axis] - 1;
    struct End {
      std::int32_t place;
      double value;
    };
    const auto end_at = [&](std::int32_t x) {
      Index<D> q = p;
      q[axis] = x;
      const End at_centre{std::min(p[axis], last), centre};
      const double value = x < 0 ? std::nan("") : model_.value_or_nan(q);
      return std::isnan(value) ? at_centre : End{std::min(x, last), value};
    };
    const bool is_beyond = p[axis] - step >= last;
    const End low = end_at(p[axis] - (is_beyond ? 2 : 1) * step);
    const End high = end_at(p[axis] + step);
    return high.place > low.place ? (high.value - low.value) / (high.place - low.place) : 0;
  }

  const Field& model_;
  Mat3 to_world_;
  double sign_;
};

/// The normals at all these points.
template <int D>
void compute_normals(const Model<D>& model, std::span<const EdgePoint> points, Threads threads,
                     std::span<Vec3f> normals);
template <>
void compute_normals<2>(const Model<2>& model, std::span<const EdgePoint> points, Threads threads,
                        std::span<Vec3f> normals);
template <>
void compute_normals<3>(const Model<3>& model, std::span<const EdgePoint> points, Threads threads,
                        std::span<Vec3f> normals);

}  // namespace lode::diamond

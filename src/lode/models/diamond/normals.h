#pragma once

#include <cstddef>
#include <span>

#include "lode/mappers/iso_part.h"
#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// Unit normals that point to lower values, at points on lattice edges: minus the gradient by
/// central differences of the full-resolution samples at the edge's ends (one-sided at the border
/// and beside holes), mapped to world space. Zero where the gradient is. T: the model's storage.
template <int D, typename T>
class NormalSampler {
 public:
  explicit NormalSampler(const Model<D>& model)
      : model_(model),
        to_world_(cofactors(model.info.grid.index_to_world_matrix())),
        sign_(determinant(model.info.grid.index_to_world_matrix()) < 0 ? 1 : -1) {}

  [[nodiscard]] Vec3f at(const EdgePoint& point) const {
    const Vec3d a = gradient(to_point(point.first));
    const Vec3d b = gradient(to_point(point.second));
    return to_normal(a * (1 - point.t) + b * point.t);
  }
  /// What a gradient in grid axes becomes.
  [[nodiscard]] Vec3f to_normal(const Vec3d& gradient) const {
    const Vec3d n = normalized(to_world_ * gradient);
    Vec3f result;
    for (std::size_t i = 0; i < 3; ++i) result[i] = static_cast<float>(sign_ * n[i]);
    return result;
  }
  /// d value / d index at a lattice point, in grid axes.
  [[nodiscard]] Vec3d gradient(const Index3& grid_point) const {
    Vec3d result;
    if (!model_.has_holes() && find_inner(grid_point, result)) return result;
    return one_sided(grid_point);
  }

 private:
  /// Where all neighbours are samples of one brick, and no hole is about: most points.
  [[nodiscard]] bool find_inner(const Index3& grid_point, Vec3d& gradient) const {
    Index<D> brick;
    Index<D> local;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      const std::int32_t p = grid_point[as_size(model_.axes.axis[i])];
      brick[i] = p / kBrickEdge<D>;
      local[i] = p % kBrickEdge<D>;
      if (local[i] == 0 || p + 1 >= model_.shape.dims[i]) return false;
    }
    const T* sample =
        reinterpret_cast<const T*>(model_.brick(linear_index<D>(model_.brick_dims, brick))) +
        Model<D>::brick_offset(local);
    std::ptrdiff_t stride = 1;
    for (std::size_t i = 0; i < as_size(D); ++i, stride *= kBrickSamples<D>)
      gradient[as_size(model_.axes.axis[i])] =
          (static_cast<double>(sample[stride]) - static_cast<double>(sample[-stride])) / 2;
    return true;
  }

  [[nodiscard]] Vec3d one_sided(const Index3& grid_point) const {
    Index<D> p;
    for (std::size_t i = 0; i < as_size(D); ++i) p[i] = grid_point[as_size(model_.axes.axis[i])];
    p = model_.clamped(p);
    const auto usable = [&](const Index<D>& q, double& value) {
      if (!model_.shape.is_sample(q)) return false;
      value = model_.value(q);
      return !model_.has_holes() || !model_.is_hole(value);
    };
    Vec3d gradient;
    double centre = 0;
    if (!usable(p, centre)) return gradient;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      Index<D> q = p;
      double low = centre;
      double high = centre;
      --q[i];
      const bool has_low = usable(q, low);
      if (!has_low) low = centre;
      q[i] += 2;
      const bool has_high = usable(q, high);
      if (!has_high) high = centre;
      const int n_steps = (has_low ? 1 : 0) + (has_high ? 1 : 0);
      if (n_steps > 0) gradient[as_size(model_.axes.axis[i])] = (high - low) / n_steps;
    }
    return gradient;
  }

  const Model<D>& model_;
  Mat3 to_world_;
  double sign_;
};

/// The normals at all these points.
template <int D>
void compute_normals(const Model<D>& model, std::span<const EdgePoint> points, Threads threads,
                     std::span<Vec3f> normals);

}  // namespace lode::diamond

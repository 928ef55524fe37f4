#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <span>

#include "lode/mappers/iso_part.h"
#include "lode/models/diamond/edge_normals.h"
#include "lode/models/diamond/edge_vertices.h"
#include "lode/models/diamond/model.h"
#include "lode/models/diamond/near_samples.h"

namespace lode::diamond {

/// Three numbers: the gradient where a point is. find(p, step, out): that at an end of its edge,
/// which is `step` long along its axes.
template <typename Find>
void put_gradient(const EdgePoint& point, const Find& find, double* out) {
  const Index3 first = to_point(point.first);
  const Index3 second = to_point(point.second);
  const std::int32_t step =
      std::max({std::abs(first[0] - second[0]), std::abs(first[1] - second[1]),
                std::abs(first[2] - second[2])});
  std::array<double, 3> a;
  std::array<double, 3> b;
  find(first, step, a.data());
  find(second, step, b.data());
  const double rest = 1 - point.t;
  out[0] = a[0] * rest + b[0] * point.t;
  out[1] = a[1] * rest + b[1] * point.t;
  out[2] = a[2] * rest + b[2] * point.t;
}

/// Normals at points [begin, end), of the gradients that put(i, out) gives, three numbers each.
template <typename Put>
void write_normals(std::size_t begin, std::size_t end, const NormalFrame& frame, Vec3f* normals,
                   const Put& put) {
  constexpr std::size_t kAtOnce = 512;
  std::array<double, 4 * kAtOnce + kEdgePadding> gradients;
  for (std::size_t first = begin; first < end; first += kAtOnce) {
    const std::size_t n = std::min(kAtOnce, end - first);
    for (std::size_t i = 0; i < n; ++i) put(first + i, gradients.data() + 4 * i);
    place_normals(gradients.data(), n, frame, normals + first, normals + first + n);
  }
}

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
    Vec3d gradient_there;
    put_gradient(
        point, [this](const Index3& p, std::int32_t step, double* out) { put(p, step, out); },
        gradient_there.v.data());
    return to_normal(gradient_there);
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
  /// The same as three numbers.
  void put(const Index3& grid_point, std::int32_t step, double* out) const {
    const Vec3d found = gradient(grid_point, step);
    std::copy(found.v.begin(), found.v.end(), out);
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

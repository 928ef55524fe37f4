#include "lode/models/diamond/normals.h"

namespace lode::diamond {
namespace {

/// d value / d index at a lattice point, in grid axes.
template <int D>
Vec3d gradient_at(const Model<D>& model, const Index3& grid_point) {
  Index<D> p;
  for (std::size_t i = 0; i < as_size(D); ++i) p[i] = grid_point[as_size(model.axes.axis[i])];
  p = model.clamped(p);
  const auto usable = [&](const Index<D>& q, double& value) {
    if (!model.shape.is_sample(q)) return false;
    value = model.value(q);
    return !model.has_holes() || !model.is_hole(value);
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
    if (n_steps > 0) gradient[as_size(model.axes.axis[i])] = (high - low) / n_steps;
  }
  return gradient;
}

}  // namespace

template <int D>
void compute_normals(const Model<D>& model, std::span<const EdgePoint> points, Threads threads,
                     std::span<Vec3f> normals) {
  const Mat3 matrix = model.info.grid.index_to_world_matrix();
  const Mat3 inverse_transpose = cofactors(matrix);
  const double sign = determinant(matrix) < 0 ? 1 : -1;
  constexpr std::size_t kChunk = 1 << 12;
  parallel_for((points.size() + kChunk - 1) / kChunk, threads, 1, [&](std::size_t chunk, int) {
    for (std::size_t v = chunk * kChunk; v < std::min(points.size(), (chunk + 1) * kChunk); ++v) {
      const Vec3d a = gradient_at<D>(model, to_point(points[v].first));
      const Vec3d b = gradient_at<D>(model, to_point(points[v].second));
      const Vec3d n = normalized(inverse_transpose * (a * (1 - points[v].t) + b * points[v].t));
      for (std::size_t i = 0; i < 3; ++i) normals[v][i] = static_cast<float>(sign * n[i]);
    }
  });
}

template void compute_normals<2>(const Model<2>&, std::span<const EdgePoint>, Threads,
                                 std::span<Vec3f>);
template void compute_normals<3>(const Model<3>&, std::span<const EdgePoint>, Threads,
                                 std::span<Vec3f>);

}  // namespace lode::diamond

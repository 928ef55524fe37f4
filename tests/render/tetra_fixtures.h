#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "lode/core/mesh.h"
#include "lode/render/lens.h"
#include "lode/render/mesh_volume.h"
#include "lode/render/volume_tracer.h"

namespace lode::test {

/// n^3 cubes over [0, 1]^3 of six tetrahedra each, of those that `is_kept`; the field is x + 2 y +
/// 4 z.
inline SimplexMesh cube_mesh(std::uint32_t n,
                             const std::function<bool(const Vec3d& middle)>& is_kept = {}) {
  SimplexMesh mesh;
  const std::uint32_t m = n + 1;
  const auto id = [m](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return (z * m + y) * m + x;
  };
  for (std::uint32_t z = 0; z < m; ++z)
    for (std::uint32_t y = 0; y < m; ++y)
      for (std::uint32_t x = 0; x < m; ++x) {
        const Vec3d p{{double{1} * x / n, double{1} * y / n, double{1} * z / n}};
        mesh.positions.push_back(p);
        mesh.values.push_back(p[0] + 2 * p[1] + 4 * p[2]);
        if (x == n || y == n || z == n) continue;
        const Vec3d middle = p + Vec3d{{0.5 / n, 0.5 / n, 0.5 / n}};
        if (is_kept && !is_kept(middle)) continue;
        const std::uint32_t a = id(x, y, z);
        const std::uint32_t b = id(x + 1, y + 1, z + 1);
        const std::array<std::uint32_t, 7> ring{
            id(x + 1, y, z), id(x + 1, y + 1, z), id(x, y + 1, z), id(x, y + 1, z + 1),
            id(x, y, z + 1), id(x + 1, y, z + 1), id(x + 1, y, z)};
        for (std::size_t i = 0; i < 6; ++i) mesh.tetrahedra.push_back({a, ring[i], ring[i + 1], b});
      }
  return mesh;
}

/// Inner vertices moved by up to a quarter of a cube, seeded; cells stay the right way round.
inline void shake(SimplexMesh& mesh, std::uint32_t n, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-0.15 / n, 0.15 / n);
  for (Vec3d& p : mesh.positions)
    for (double& c : p.v)
      if (c > 0 && c < 1) c += unit(random);
}

/// The ray through a point of a picture, in world coordinates; `direction` has length 1.
struct WorldRay {
  Vec3d eye;
  Vec3d direction;
};
inline WorldRay world_ray(const Camera& camera, const Lens& lens, const Lens::Point& point) {
  const CameraAxes axes = axes_of(camera);
  const Lens::Slopes slopes = lens.slopes_at(point.x, point.y);
  return {camera.eye, normalized(axes.forward + axes.right * slopes.right + axes.up * slopes.up)};
}

/// The part of a ray from its eye on that is in a tetrahedron, by its four planes.
inline double length_in_cell(const WorldRay& ray, const std::array<Vec3d, 4>& corners) {
  double begin = 0;
  double end = 1e300;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3d& a = corners[(i + 1) % 4];
    Vec3d normal = cross(corners[(i + 2) % 4] - a, corners[(i + 3) % 4] - a);
    const double inside = dot(normal, corners[i] - a);
    if (inside == 0) return 0;
    if (inside < 0) normal = normal * -1.0;
    const double height = dot(normal, ray.eye - a);
    const double rise = dot(normal, ray.direction);
    if (rise > 0) begin = std::max(begin, -height / rise);
    if (rise < 0) end = std::min(end, -height / rise);
    if (rise == 0 && height < 0) return 0;
  }
  return std::max(0.0, end - begin);
}

inline double length_in_mesh(const WorldRay& ray, const SimplexMesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.tetrahedra)
    sum += length_in_cell(ray, {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]],
                                mesh.positions[t[3]]});
  return sum;
}

/// A volume seen by a camera, ray by ray.
class VolumeProbe {
 public:
  VolumeProbe(const SimplexMesh& mesh, const TransferFunction& function, const Camera& camera,
              int size)
      : volume_(MeshVolume::build(mesh, {.count = 1}).value()),
        normalization_(normalization_of(volume_.bounds())),
        lens_(camera, normalization_, size, size),
        ramps_(function),
        view_(volume_, ramps_, lens_, normalization_, {size, size}, {.count = 1}) {}

  [[nodiscard]] RayLight at(const Lens::Point& point, double end_depth = 1e300) const {
    VolumeTracer tracer(view_, ramps_);
    const std::array<VolumeRay, 1> ray{{{point.x, point.y, end_depth}}};
    std::array<RayLight, 1> light;
    tracer.trace(static_cast<int>(point.x) / VolumeView::kTile,
                 static_cast<int>(point.y) / VolumeView::kTile, ray, light);
    return light[0];
  }
  [[nodiscard]] const Lens& lens() const { return lens_; }
  [[nodiscard]] const Normalization& normalization() const { return normalization_; }

 private:
  MeshVolume volume_;
  Normalization normalization_;
  Lens lens_;
  LightRamps ramps_;
  VolumeView view_;
};

}  // namespace lode::test

#include "lode/mappers/collapse_mesh.h"

#include <cmath>

namespace lode::simplification {

double mean_area(const Surface& surface) {
  double sum = 0;
  const std::size_t n = surface.triangles.size();
  const std::size_t step = n / 100'000 + 1;  // of those it is known well enough
  std::size_t count = 0;
  for (std::size_t i = 0; i < n; i += step, ++count) {
    const auto& t = surface.triangles[i];
    const Vec3d a = widened(surface.positions[t[0]]);
    sum += 0.5 * length(cross(widened(surface.positions[t[1]]) - a,
                              widened(surface.positions[t[2]]) - a));
  }
  return sum / static_cast<double>(count);
}

CollapseMesh make_mesh(const Surface& surface, Threads threads) {
  CollapseMesh mesh;
  const std::size_t n = surface.positions.size();
  mesh.positions.resize(n);
  mesh.next_point.resize(n);
  mesh.attached_to.resize(n);
  mesh.last.resize(n);
  mesh.triangles.resize(surface.triangles.size());
  mesh.collapses.reserve(2 * surface.triangles.size());  // only what is used comes into memory
  constexpr std::size_t kCopied = 1 << 16;
  parallel_for((n + kCopied - 1) / kCopied, threads, 1, [&](std::size_t chunk, int) {
    for (std::size_t v = chunk * kCopied; v < std::min(n, (chunk + 1) * kCopied); ++v) {
      mesh.positions[v] = surface.positions[v];
      mesh.attached_to[v] = kNone;
      mesh.last[v] = kNone;
    }
  });
  const std::size_t n_triangles = surface.triangles.size();
  parallel_for((n_triangles + kCopied - 1) / kCopied, threads, 1, [&](std::size_t chunk, int) {
    for (std::size_t t = chunk * kCopied; t < std::min(n_triangles, (chunk + 1) * kCopied); ++t)
      mesh.triangles[t] = {surface.triangles[t], kNone};
  });
  return mesh;
}

void attach_rest(std::span<const std::uint32_t> triangles, CollapseMesh& mesh) {
  for (const std::uint32_t t : triangles)
    for (const std::uint32_t v : mesh.triangles[t].v) {
      if (mesh.attached_to[v] != kNone) continue;
      mesh.attached_to[v] = t;
      mesh.next_point[v] = mesh.triangles[t].points;
      mesh.triangles[t].points = v;
    }
}

}  // namespace lode::simplification

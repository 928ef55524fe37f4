#include "lode/mappers/warp.h"

#include <atomic>
#include <vector>

#include "lode/core/parallel.h"

namespace lode {
namespace {

double volume_of(const SimplexMesh& mesh, std::size_t cell) {
  const auto& t = mesh.tetrahedra[cell];
  const Vec3d& origin = mesh.positions[t[0]];
  return dot(cross(mesh.positions[t[1]] - origin, mesh.positions[t[2]] - origin),
             mesh.positions[t[3]] - origin);
}

}  // namespace

std::uint64_t warp(SimplexMesh& mesh, const std::array<std::span<const double>, 3>& vector,
                   double scale, Threads threads) {
  constexpr std::size_t kGrain = 4096;
  std::vector<std::uint8_t> is_positive(mesh.tetrahedra.size());
  parallel_for(is_positive.size(), threads, kGrain,
               [&](std::size_t i, int) { is_positive[i] = volume_of(mesh, i) > 0 ? 1 : 0; });
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    for (std::size_t i = 0; i < 3; ++i) mesh.positions[v][i] += scale * vector[i][v];
  std::atomic<std::uint64_t> n_inverted{0};
  parallel_for(is_positive.size(), threads, kGrain, [&](std::size_t i, int) {
    if (is_positive[i] != 0 && !(volume_of(mesh, i) > 0)) ++n_inverted;
  });
  return n_inverted;
}

void warp(Surface& surface, const std::array<std::span<const double>, 3>& vector, double scale) {
  for (std::size_t v = 0; v < surface.positions.size(); ++v)
    for (std::size_t i = 0; i < 3; ++i)
      surface.positions[v][i] =
          static_cast<float>(static_cast<double>(surface.positions[v][i]) + scale * vector[i][v]);
  surface.normals.clear();
}

}  // namespace lode

#include "lode/mappers/surface_checks.h"

#include <cmath>
#include <cstddef>
#include <limits>

namespace lode {
namespace {

template <std::size_t N>
Result<void> check_indices(const std::vector<std::array<std::uint32_t, N>>& simplices,
                           std::size_t n_vertices, const char* kind) {
  for (std::size_t i = 0; i < simplices.size(); ++i)
    for (const std::uint32_t vertex : simplices[i])
      if (vertex >= n_vertices)
        return fail("{} {}: expected vertex indices below {}, got {}", kind, i, n_vertices, vertex);
  return {};
}

bool is_finite(const Vec3f& p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

}  // namespace

Result<void> check_well_formed(const Surface& surface) {
  constexpr std::size_t kMostIndices = std::numeric_limits<std::uint32_t>::max();
  if (surface.positions.size() > kMostIndices || surface.triangles.size() > kMostIndices / 3 ||
      surface.lines.size() > kMostIndices / 3)
    return fail("expected a surface of 32-bit indices, got {} vertices and {} triangles",
                surface.positions.size(), surface.triangles.size());
  if (!surface.triangles.empty() && !surface.lines.empty())
    return fail("expected either triangles or lines, got {} triangles and {} lines",
                surface.triangles.size(), surface.lines.size());
  for (std::size_t i = 0; i < surface.positions.size(); ++i) {
    const Vec3f& p = surface.positions[i];
    if (!is_finite(p))
      return fail("vertex {}: expected finite coordinates, got ({}, {}, {})", i, p[0], p[1], p[2]);
  }
  LODE_CHECK(check_indices(surface.triangles, surface.positions.size(), "triangle"));
  return check_indices(surface.lines, surface.positions.size(), "line");
}

}  // namespace lode

#include "lode/api/creased_caps.h"

#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <unordered_map>

#include "lode/models/diamond/surface_coordinates.h"

namespace lode {
namespace {

/// The border's plane that a triangle lies in, if there is one.
std::optional<unsigned> plane_of(const diamond::SurfaceCoordinates& coordinates,
                                 const std::array<std::uint32_t, 3>& triangle) {
  unsigned planes = ~0U;
  for (const std::uint32_t v : triangle) planes &= coordinates.border_planes(v);
  if (planes == 0) return std::nullopt;
  return static_cast<unsigned>(std::countr_zero(planes));
}

}  // namespace

void crease_caps(const RegularGrid& grid, Threads threads, Surface& surface) {
  const diamond::SurfaceCoordinates coordinates(grid, surface, std::nullopt, threads);
  std::unordered_map<std::uint64_t, std::uint32_t> copies;  // by vertex and plane
  for (auto& triangle : surface.triangles) {
    const std::optional<unsigned> plane = plane_of(coordinates, triangle);
    if (!plane) continue;
    const Vec3f a = surface.positions[triangle[0]];
    const Vec3f normal =
        normalized(cross(surface.positions[triangle[1]] - a, surface.positions[triangle[2]] - a));
    for (std::uint32_t& v : triangle) {
      const auto next = static_cast<std::uint32_t>(surface.positions.size());
      const auto [copy, is_new] = copies.try_emplace(std::uint64_t{v} << 3 | *plane, next);
      if (is_new) {
        surface.positions.push_back(Vec3f(surface.positions[v]));
        if (!surface.normals.empty()) surface.normals.push_back(normal);
        if (!surface.isovalues.empty()) surface.isovalues.push_back(double{surface.isovalues[v]});
      }
      v = copy->second;
    }
  }
}

}  // namespace lode

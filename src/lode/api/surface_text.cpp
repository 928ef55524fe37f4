#include "lode/api/surface_text.h"

#include <fmt/format.h>

namespace lode {

std::string describe_place(const Vec3d& world) {
  return fmt::format("({:.9g}, {:.9g}, {:.9g})", world[0], world[1], world[2]);
}

std::string describe_vertex(const Surface& surface, std::uint32_t vertex) {
  return fmt::format("vertex {} at {}", vertex, describe_place(surface.world_position(vertex)));
}

std::string describe_edge(const Surface& surface, std::uint32_t from, std::uint32_t to) {
  if (from == to) return "the end at " + describe_vertex(surface, from);
  return fmt::format("the edge from {} to {}", describe_vertex(surface, from),
                     describe_vertex(surface, to));
}

std::string describe_cell(const Surface& surface, std::uint32_t cell) {
  const bool is_line = !surface.lines.empty();
  const std::size_t n = is_line ? surface.lines.size() : surface.triangles.size();
  if (cell >= n) return "none";
  const std::uint32_t corner = is_line ? surface.lines[cell][0] : surface.triangles[cell][0];
  return fmt::format("{} {} at {}", is_line ? "line" : "triangle", cell,
                     describe_place(surface.world_position(corner)));
}

}  // namespace lode

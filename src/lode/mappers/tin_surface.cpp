#include "lode/mappers/tin_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace lode {
namespace {

bool is_float(double value) { return static_cast<double>(static_cast<float>(value)) == value; }

std::vector<Vec3d> place_vertices(const delaunay::Tin& tin, const HeightFrame& frame) {
  std::vector<Vec3d> places;
  places.reserve(tin.vertices.size());
  for (std::size_t i = 0; i < tin.vertices.size(); ++i) {
    const Vec<double, 2> at = frame.world(tin.vertices[i].x, tin.vertices[i].y);
    places.push_back({{at[0], at[1], tin.heights[i]}});
  }
  return places;
}

/// By axes: horizontally for both, as files have one origin for them.
Vec3d choose_origin(const std::vector<Vec3d>& places) {
  std::array<bool, 3> is_exact{true, true, true};
  Vec3d lower = places.front();
  Vec3d upper = places.front();
  for (const Vec3d& place : places)
    for (std::size_t i = 0; i < 3; ++i) {
      is_exact[i] = is_exact[i] && is_float(place[i]);
      lower[i] = std::min(lower[i], place[i]);
      upper[i] = std::max(upper[i], place[i]);
    }
  Vec3d origin{{0, 0, 0}};
  if (!is_exact[0] || !is_exact[1]) origin = {{lower[0], lower[1], 0}};
  // The middle, in whole units: floats are finest round it.
  if (!is_exact[2]) origin[2] = std::round(lower[2] + (upper[2] - lower[2]) / 2);
  return origin;
}

/// From above, by the positions that there are.
std::uint64_t count_turned(const Surface& surface) {
  const auto axis = [&](std::uint32_t v, std::size_t i) {
    return static_cast<double>(surface.positions[v][i]);
  };
  std::uint64_t n = 0;
  for (const auto& [a, b, c] : surface.triangles) {
    const double left = (axis(b, 0) - axis(a, 0)) * (axis(c, 1) - axis(a, 1));
    const double right = (axis(b, 1) - axis(a, 1)) * (axis(c, 0) - axis(a, 0));
    n += static_cast<std::uint64_t>(left <= right);
  }
  return n;
}

}  // namespace

TinSurface to_surface(const delaunay::Tin& tin, std::vector<Vec3d> places, TriangleTurns turns) {
  TinSurface made;
  Surface& surface = made.surface;
  if (tin.vertices.empty()) return made;
  surface.origin = choose_origin(places);
  surface.positions.reserve(places.size());
  surface.values.reserve(places.size());
  for (const Vec3d& place : places) {
    Vec3f position;
    std::array<double, 3> slack{};
    for (std::size_t i = 0; i < 3; ++i) {
      position[i] = static_cast<float>(place[i] - surface.origin[i]);
      slack[i] = std::abs(place[i] - (surface.origin[i] + static_cast<double>(position[i])));
    }
    made.position_slack = std::max({made.position_slack, slack[0], slack[1]});
    made.height_slack = std::max(made.height_slack, slack[2]);
    surface.positions.push_back(position);
    surface.values.push_back(place[2]);
  }
  surface.triangles = tin.triangles;
  if (turns == TriangleTurns::right)
    for (auto& triangle : surface.triangles) std::swap(triangle[1], triangle[2]);
  made.n_turned = count_turned(surface);
  made.places = std::move(places);
  return made;
}

TinSurface to_surface(const delaunay::Tin& tin, const HeightFrame& frame) {
  TinSurface made = to_surface(tin, place_vertices(tin, frame),
                               frame.is_mirrored() ? TriangleTurns::right : TriangleTurns::left);
  if (made.height_slack == 0) made.places = {};
  return made;
}

}  // namespace lode

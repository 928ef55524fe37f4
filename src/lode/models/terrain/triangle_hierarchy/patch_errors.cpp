#include "lode/models/terrain/triangle_hierarchy/patch_errors.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lode/delaunay/triangle_rows.h"

namespace lode::triangle_hierarchy {
namespace {

std::array<Place, 3> places_of(const Hierarchy& hierarchy, std::uint32_t triangle) {
  const auto& [a, b, c] = hierarchy.triangles[triangle].corner;
  return {{{hierarchy.vertices[a], hierarchy.heights[a]},
           {hierarchy.vertices[b], hierarchy.heights[b]},
           {hierarchy.vertices[c], hierarchy.heights[c]}}};
}

/// How far a place is from the plane of three others, above or below, rounding included: weights
/// are exact, and each of the seven operations on a term is off by 2^-53 of it at most.
double distance_from_plane(const std::array<Place, 3>& of, const Place& place, double rounding) {
  const auto area = static_cast<double>(delaunay::doubled_area(of[0].at, of[1].at, of[2].at));
  const auto b = static_cast<double>(delaunay::doubled_area(of[2].at, of[0].at, place.at));
  const auto c = static_cast<double>(delaunay::doubled_area(of[0].at, of[1].at, place.at));
  const double rise =
      (b * (of[1].height - of[0].height) + c * (of[2].height - of[0].height)) / area;
  return std::abs(place.height - (of[0].height + rise)) +
         rounding * (1 + (std::abs(b) + std::abs(c)) / area);
}

bool is_outside(const std::array<Place, 3>& of, LatticePoint node) {
  return delaunay::doubled_area(of[0].at, of[1].at, node) < 0 ||
         delaunay::doubled_area(of[1].at, of[2].at, node) < 0 ||
         delaunay::doubled_area(of[2].at, of[0].at, node) < 0;
}

/// Whether a node of the raster lies in a, b, c, whichever way these turn, and out of a triangle.
bool has_node_outside_of(const std::array<Place, 3>& triangle, LatticePoint a, LatticePoint b,
                         LatticePoint c, int bits) {
  if (delaunay::doubled_area(a, b, c) == 0) return false;
  for (delaunay::SparseRows rows(a, b, c, bits); rows.has_row(); rows.next())
    for (std::int32_t x = rows.first(); x <= rows.last(); ++x)
      if (is_outside(triangle, {x << bits, rows.y() << bits})) return true;
  return false;
}

}  // namespace

std::vector<double> MeasuredPatches::of(std::uint32_t /*triangle*/, const Patch& patch) const {
  std::vector<double> errors;
  for (const auto& [a, b, c] : patch.triangles) {
    double error =
        surface_.measure_samples({patch.places[a], patch.places[b], patch.places[c]}, kNoEdges)
            .closed;
    for (const auto& [from, to] : {std::array{a, b}, {b, c}, {c, a}})
      if ((from + 1) % patch.places.size() != to)
        error =
            std::max(error, surface_.worst_crossing(patch.places[from], patch.places[to]).error);
    errors.push_back(error + surface_.rounding());
  }
  return errors;
}

BoundedPatches::BoundedPatches(const Hierarchy& hierarchy) : hierarchy_(hierarchy), rounding_(0) {
  for (const double height : hierarchy.heights) rounding_ = std::max(rounding_, std::abs(height));
  rounding_ *= 0x1p-48;
}

std::vector<double> BoundedPatches::of(std::uint32_t triangle, const Patch& patch) const {
  std::vector<double> errors;
  if (has_node_outside(triangle, patch)) return errors;
  const std::array<Place, 3> corners = places_of(hierarchy_, triangle);
  std::vector<double> distances;  // By place.
  distances.reserve(patch.places.size());
  for (const Place& place : patch.places)
    distances.push_back(distance_from_plane(corners, place, rounding_));
  const auto own = static_cast<double>(hierarchy_.triangles[triangle].error);
  for (const auto& [a, b, c] : patch.triangles)
    errors.push_back(own + std::max({distances[a], distances[b], distances[c]}));
  return errors;
}

/// What the patch has outside of the triangle lies between an edge and its chain, so in triangles
/// from the edge's first end to the parts of the chain.
bool BoundedPatches::has_node_outside(std::uint32_t triangle, const Patch& patch) const {
  const std::array<Place, 3> corners = places_of(hierarchy_, triangle);
  // Nodes of the points' lattice are many, and few of them have a point.
  if (hierarchy_.is_of_points)
    return std::ranges::binary_search(hierarchy_.crowded, triangle) &&
           std::ranges::any_of(patch.places,
                               [&](const Place& place) { return is_outside(corners, place.at); });
  const std::size_t n = patch.places.size();
  std::size_t side = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const LatticePoint a = patch.places[i].at;
    const LatticePoint b = patch.places[(i + 1) % n].at;
    if (has_node_outside_of(corners, corners[side].at, a, b, hierarchy_.bits)) return true;
    if (side < 2 && b == corners[side + 1].at) ++side;
  }
  return false;
}

}  // namespace lode::triangle_hierarchy

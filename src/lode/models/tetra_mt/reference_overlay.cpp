#include "lode/models/tetra_mt/reference_overlay.h"

#include <algorithm>
#include <cmath>

namespace lode::tetra_mt {
namespace {

/// By how much weights may be below 0 for a point to count as in a triangle.
constexpr double kEdge = 0x1p-36;
/// How near to a triangle's plane a point is in it, against its distance from a corner.
constexpr double kPlane = 0x1p-44;
/// The smallest sine between two of a triangle's edges.
constexpr double kThin = 0x1p-30;

}  // namespace

/// A triangle's plane and weights, as linear functions of what is between a point and corner 0.
struct ReferenceOverlay::Triangle {
  std::array<std::uint32_t, 3> corners{};
  Vec3d origin;
  std::array<Vec3d, 2> edges{};
  Vec3d normal{};                    ///< Of length 1.
  std::array<Vec3d, 2> gradients{};  ///< Of the weights of corners 1 and 2.
  double plane = 0;                  ///< kPlane, for this shape.
  double slack = 0;
};

/// Corners of a tetrahedron as a triangle sees them.
struct ReferenceOverlay::Meeting {
  std::array<double, 4> distances;
  std::array<std::array<double, 3>, 4> weights;
  std::array<int, 4> sides;  ///< Of its plane; 0: in it.
};

ReferenceOverlay::ReferenceOverlay(const TetraMesh& mesh, double slack)
    : mesh_(mesh),
      slack_(slack),
      across_(find_across(mesh.tetrahedra)),
      star_begins_(mesh.positions.size() + 1),
      stars_(4 * mesh.tetrahedra.size()),
      is_on_boundary_(mesh.positions.size()) {
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (const std::uint32_t v : t) ++star_begins_[v + std::size_t{1}];
  for (std::size_t v = 1; v < star_begins_.size(); ++v) star_begins_[v] += star_begins_[v - 1];
  std::vector<std::uint64_t> ends(star_begins_.begin(), star_begins_.end() - 1);
  for (std::uint32_t i = 0; i < mesh.tetrahedra.size(); ++i)
    for (std::size_t k = 0; k < 4; ++k) {
      const Tetrahedron& t = mesh.tetrahedra[i];
      stars_[ends[t[k]]++] = i;
      if (across_[i][k] == kNone)
        for (const std::uint32_t v : others(t, k)) is_on_boundary_[v] = 1;
    }
  for (const MeshField& field : mesh.fields) {
    double& scale = scales_.emplace_back(0);
    for (const double value : field.values) scale = std::max(scale, std::abs(value));
  }
}

/// The tetrahedron at a corner that the triangle goes into, or kNone.
std::uint32_t ReferenceOverlay::find_first(const Triangle& triangle) const {
  constexpr double kOutside = -0x1p-20;
  const std::array<Vec3d, 3> points{triangle.origin, triangle.origin + triangle.edges[0],
                                    triangle.origin + triangle.edges[1]};
  // No edge nor face of a grid is likely to be in this direction.
  const Vec3d inside = triangle.edges[0] * 0.3719 + triangle.edges[1] * 0.2913;
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const std::uint32_t vertex = triangle.corners[corner];
    const Vec3d direction = triangle.origin + inside - points[corner];
    double best = kOutside;
    std::uint32_t found = kNone;
    for (std::uint64_t i = star_begins_[vertex]; i < star_begins_[vertex + std::size_t{1}]; ++i) {
      const Tetrahedron& t = mesh_.tetrahedra[stars_[i]];
      const auto place = static_cast<std::size_t>(std::ranges::find(t, vertex) - t.begin());
      std::array<Vec3d, 3> edges;
      for (std::size_t k = 0; k < 3; ++k)
        edges[k] = mesh_.positions[others(t, place)[k]] - mesh_.positions[vertex];
      std::array<double, 3> shares{dot(cross(edges[1], edges[2]), direction),
                                   dot(cross(edges[2], edges[0]), direction),
                                   dot(cross(edges[0], edges[1]), direction)};
      const double sum = std::abs(shares[0]) + std::abs(shares[1]) + std::abs(shares[2]);
      if (!(dot(cross(edges[0], edges[1]), edges[2]) > 0) || !(sum > 0)) continue;
      const double least = std::ranges::min(shares) / sum;
      if (least <= best) continue;
      best = least;
      found = stars_[i];
      if (least > 0) break;
    }
    if (found != kNone) return found;
  }
  return kNone;
}

/// All tetrahedra whose boxes meet the triangle's, with its slack.
void ReferenceOverlay::add_all_near(const Triangle& triangle,
                                    std::vector<std::uint32_t>& found) const {
  std::array<double, 3> low{};
  std::array<double, 3> high{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [a, b] = std::minmax({mesh_.positions[triangle.corners[0]][i],
                                     mesh_.positions[triangle.corners[1]][i],
                                     mesh_.positions[triangle.corners[2]][i]});
    low[i] = a - triangle.slack;
    high[i] = b + triangle.slack;
  }
  for (std::uint32_t number = 0; number < mesh_.tetrahedra.size(); ++number) {
    bool meets = true;
    for (std::size_t i = 0; i < 3 && meets; ++i) {
      const Tetrahedron& t = mesh_.tetrahedra[number];
      const auto [a, b] = std::minmax({mesh_.positions[t[0]][i], mesh_.positions[t[1]][i],
                                       mesh_.positions[t[2]][i], mesh_.positions[t[3]][i]});
      meets = a <= high[i] && low[i] <= b;
    }
    if (meets) found.push_back(number);
  }
}

bool ReferenceOverlay::largest_differences(const std::array<std::uint32_t, 3>& corners,
                                           std::span<double> largest, Scratch& scratch) const {
  std::ranges::fill(largest, 0);
  const auto& at = mesh_.positions;
  Triangle triangle{.corners = corners,
                    .origin = at[corners[0]],
                    .edges = {at[corners[1]] - at[corners[0]], at[corners[2]] - at[corners[0]]}};
  const Vec3d normal = cross(triangle.edges[0], triangle.edges[1]);
  const double square = dot(normal, normal);
  const double product = length(triangle.edges[0]) * length(triangle.edges[1]);
  if (!(square > kThin * kThin * product * product)) return false;
  triangle.normal = normal * (1 / std::sqrt(square));
  triangle.gradients = {cross(triangle.edges[1], normal) * (1 / square),
                        cross(normal, triangle.edges[0]) * (1 / square)};
  triangle.plane = kPlane * product / std::sqrt(square);
  if (std::ranges::all_of(corners, [&](std::uint32_t v) { return is_on_boundary_[v] != 0; }))
    triangle.slack = slack_;

  if (scratch.seen.empty()) scratch.seen.assign(mesh_.tetrahedra.size(), 0);
  if (++scratch.n_triangles == 0) {
    std::ranges::fill(scratch.seen, 0);
    scratch.n_triangles = 1;
  }
  scratch.differences.resize(4 * mesh_.fields.size());
  scratch.next.clear();
  const std::uint32_t first = find_first(triangle);
  if (first != kNone)
    scratch.next.push_back(first);
  else
    add_all_near(triangle, scratch.next);
  for (const std::uint32_t i : scratch.next) scratch.seen[i] = scratch.n_triangles;
  while (!scratch.next.empty()) {
    const std::uint32_t tetrahedron = scratch.next.back();
    scratch.next.pop_back();
    visit(triangle, tetrahedron, largest, scratch);
  }
  for (std::size_t f = 0; f < largest.size(); ++f)
    largest[f] = largest[f] * (1 + 0x1p-20) + 0x1p-44 * scales_[f];
  return true;
}

/// What a face of a tetrahedron has in the plane, from one point to another, each between two
/// corners or at one; and what of it is in the triangle.
struct ReferenceOverlay::Segment {
  struct End {
    std::size_t from = 0;
    std::size_t to = 0;
    double share = 0;  ///< Of the second.
    std::array<double, 3> weights{};

    [[nodiscard]] double of(const double* corners) const {
      return corners[from] + share * (corners[to] - corners[from]);
    }
  };
  std::array<End, 2> ends{};
  double begin = 0;  ///< Shares of the second end.
  double end = 1;

  [[nodiscard]] bool is_empty() const { return begin > end; }
  /// Whether more of it than a rim of the triangle is inside.
  [[nodiscard]] bool is_well_inside() const;
  void cut_to_triangle();
};

bool ReferenceOverlay::Segment::is_well_inside() const {
  bool is = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const double a = ends[0].weights[i];
    const double b = ends[1].weights[i];
    is = is && (a + begin * (b - a) > 2 * kEdge || a + end * (b - a) > 2 * kEdge);
  }
  return is;
}

void ReferenceOverlay::Segment::cut_to_triangle() {
  for (std::size_t i = 0; i < 3; ++i) {
    const double a = ends[0].weights[i] + kEdge;
    const double b = ends[1].weights[i] + kEdge;
    if (a < 0 && b < 0) end = -1;
    if (a < 0 && b >= 0) begin = std::max(begin, a / (a - b));
    if (a >= 0 && b < 0) end = std::min(end, a / (a - b));
  }
}

ReferenceOverlay::Meeting ReferenceOverlay::meet(const Triangle& triangle,
                                                 const Tetrahedron& corners,
                                                 std::span<double> differences) const {
  Meeting met{};
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3d to = mesh_.positions[corners[k]] - triangle.origin;
    const double distance = dot(triangle.normal, to);
    const double near =
        triangle.plane * (std::abs(to[0]) + std::abs(to[1]) + std::abs(to[2])) + triangle.slack;
    const double first = dot(triangle.gradients[0], to);
    const double second = dot(triangle.gradients[1], to);
    met.distances[k] = distance;
    met.weights[k] = {1 - first - second, first, second};
    met.sides[k] = std::abs(distance) <= near ? 0 : distance > 0 ? 1 : -1;
    for (std::size_t f = 0; f < mesh_.fields.size(); ++f) {
      const std::vector<double>& values = mesh_.fields[f].values;
      const double origin = values[triangle.corners[0]];
      differences[f * 4 + k] = (values[corners[k]] - origin) -
                               first * (values[triangle.corners[1]] - origin) -
                               second * (values[triangle.corners[2]] - origin);
    }
  }
  return met;
}

/// Of the face across from a corner; empty where it has nothing in the plane, or lies in it: then
/// its edges are of other faces, too.
ReferenceOverlay::Segment ReferenceOverlay::segment_of(const Meeting& met, std::size_t face) {
  Segment segment;
  std::size_t n = 0;
  std::size_t n_in_plane = 0;
  for (const std::uint8_t at : kOtherPlaces[face]) {
    if (met.sides[at] != 0) continue;
    if (n < 2) segment.ends[n++] = {at, at, 0, met.weights[at]};
    ++n_in_plane;
  }
  for (std::size_t i = 0; i < 3 && n < 2; ++i) {
    const std::size_t a = kOtherPlaces[face][i];
    const std::size_t b = kOtherPlaces[face][(i + 1) % 3];
    if (met.sides[a] * met.sides[b] >= 0) continue;
    Segment::End& point = segment.ends[n++];
    point = {a, b, met.distances[a] / (met.distances[a] - met.distances[b]), {}};
    for (std::size_t k = 0; k < 3; ++k)
      point.weights[k] = met.weights[a][k] + point.share * (met.weights[b][k] - met.weights[a][k]);
  }
  if (n == 1) segment.ends[1] = segment.ends[0];
  if (n == 0 || n_in_plane == 3)
    segment.end = -1;
  else
    segment.cut_to_triangle();
  return segment;
}

void ReferenceOverlay::visit(const Triangle& triangle, std::uint32_t tetrahedron,
                             std::span<double> largest, Scratch& scratch) const {
  const Meeting met = meet(triangle, mesh_.tetrahedra[tetrahedron], scratch.differences);
  // A flat one: what is behind it may be anything.
  const bool is_in_plane = std::ranges::all_of(met.sides, [](int side) { return side == 0; });
  for (std::size_t k = 0; k < 4; ++k) {
    const Segment segment = segment_of(met, k);
    for (std::size_t f = 0; f < largest.size() && !segment.is_empty(); ++f) {
      const double a = segment.ends[0].of(&scratch.differences[f * 4]);
      const double b = segment.ends[1].of(&scratch.differences[f * 4]);
      largest[f] = std::max(
          {largest[f], std::abs(a + segment.begin * (b - a)), std::abs(a + segment.end * (b - a))});
    }
    const std::uint32_t across = across_[tetrahedron][k];
    if (across == kNone || scratch.seen[across] == scratch.n_triangles) continue;
    if (!is_in_plane && (segment.is_empty() || !segment.is_well_inside())) continue;
    scratch.seen[across] = scratch.n_triangles;
    scratch.next.push_back(across);
  }
}

}  // namespace lode::tetra_mt

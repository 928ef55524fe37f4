#include "lode/mappers/section.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "lode/mappers/crossed_edge.h"
#include "lode/mappers/march_simplex.h"
#include "lode/mappers/vertex_ids.h"

namespace lode {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// A face of the mesh in the plane, with what the cell on one side of it knows.
struct FlatFace {
  Triangle corners;  ///< Mesh vertices, ascending: what both sides call it.
  Triangle turned;   ///< The same, counter-clockwise from where the normal points to.
  std::size_t cell = 0;

  friend bool operator<(const FlatFace& a, const FlatFace& b) { return a.corners < b.corners; }
};

class SectionCutter {
 public:
  SectionCutter(const SimplexMesh& mesh, const SectionPlane& plane,
                const SectionRounding& rounding);

  Surface run();

 private:
  void add_cell(std::size_t cell);
  void add_flat_face(std::size_t cell, std::size_t opposite);
  void add_flat_faces();
  void add_triangle(const Triangle& triangle, std::size_t cell);
  std::uint32_t vertex_on(std::uint32_t a, std::uint32_t b);

  const SimplexMesh& mesh_;
  std::vector<double> distance_;  ///< Of each mesh vertex; 0 where it counts as in the plane.
  VertexIds ids_;                 ///< By edge; with equal ends, of the vertex itself.
  std::vector<FlatFace> flat_faces_;
  Surface section_;
};

SectionCutter::SectionCutter(const SimplexMesh& mesh, const SectionPlane& plane,
                             const SectionRounding& rounding)
    : mesh_(mesh) {
  section_.origin = rounding.origin;
  for (const Attribute& from : mesh.attributes)
    section_.attributes.push_back({from.name, false, {}, from.error});
  const Vec3d normal = normalized(plane.normal);
  distance_.reserve(mesh.positions.size());
  for (const Vec3d& p : mesh.positions) {
    const double d = dot(normal, p - plane.point);
    distance_.push_back(std::abs(d) <= rounding.snap ? 0.0 : d);
  }
}

/// The vertex where the edge crosses the plane; its ends lie on both sides, or one in it. Found
/// from below, so that it does not depend on the ends' numbers.
std::uint32_t SectionCutter::vertex_on(std::uint32_t a, std::uint32_t b) {
  if (distance_[a] == 0) b = a;
  if (distance_[b] == 0) a = b;
  if (distance_[a] > 0) std::swap(a, b);
  const auto [id, is_new] = ids_.find_or_add(edge_key(a, b));
  if (!is_new) return id;
  const double t = a == b ? 0.0 : distance_[a] / (distance_[a] - distance_[b]);
  const Vec3d p = mesh_.positions[a] + (mesh_.positions[b] - mesh_.positions[a]) * t;
  section_.positions.push_back(narrowed(p - section_.origin));
  section_.values.push_back(mesh_.values[a] + t * (mesh_.values[b] - mesh_.values[a]));
  for (std::size_t i = 0; i < mesh_.attributes.size(); ++i) {
    const std::vector<double>& values = mesh_.attributes[i].values;
    section_.attributes[i].values.push_back(values[a] * (1 - t) + values[b] * t);
  }
  return id;
}

void SectionCutter::add_triangle(const Triangle& t, std::size_t cell) {
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return;
  section_.triangles.push_back(t);
  section_.errors.push_back(mesh_.errors[cell]);
  if (!mesh_.regions.empty()) section_.regions.push_back(mesh_.regions[cell]);
}

void SectionCutter::add_flat_face(std::size_t at, std::size_t opposite) {
  const std::array<std::uint32_t, 4>& cell = mesh_.tetrahedra[at];
  Triangle turned{};
  for (std::size_t i = 0, n = 0; i < 4; ++i)
    if (i != opposite) turned[n++] = cell[i];
  // Without vertex 3, a positive tetrahedron's others turn counter-clockwise seen from it; without
  // vertex 1, too. The normal points to a vertex above.
  const bool is_seen_from_opposite = opposite % 2 == 1;
  const bool is_above = distance_[cell[opposite]] > 0;
  if (is_seen_from_opposite != is_above) std::swap(turned[1], turned[2]);
  Triangle corners = turned;
  std::sort(corners.begin(), corners.end());
  flat_faces_.push_back({corners, turned, at});
}

void SectionCutter::add_cell(std::size_t at) {
  const std::array<std::uint32_t, 4>& cell = mesh_.tetrahedra[at];
  std::size_t above = 0;
  std::size_t below = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (distance_[cell[i]] > 0) above |= std::size_t{1} << i;
    if (distance_[cell[i]] < 0) below |= std::size_t{1} << i;
  }
  if (above == 0 || below == 0) {
    if (std::has_single_bit(above | below))
      add_flat_face(at, static_cast<std::size_t>(std::countr_zero(above | below)));
    return;
  }
  // Vertices in the plane are inside, as those above: then all edges between the sides that are
  // asked for have an end below.
  march_simplex<3>(
      std::size_t{15} - below, true,
      [&](std::size_t i, std::size_t j) { return vertex_on(cell[i], cell[j]); },
      [&](const Triangle& t) { add_triangle(t, at); });
}

/// Each once, though two cells have it, as that of the one with the smaller error.
void SectionCutter::add_flat_faces() {
  std::stable_sort(flat_faces_.begin(), flat_faces_.end());
  for (std::size_t i = 0; i < flat_faces_.size(); ++i) {
    const FlatFace& face = flat_faces_[i];
    std::size_t cell = face.cell;
    if (i + 1 < flat_faces_.size() && flat_faces_[i + 1].corners == face.corners) {
      const std::size_t other = flat_faces_[++i].cell;
      if (mesh_.errors[other] < mesh_.errors[cell]) cell = other;
    }
    add_triangle(
        {vertex_on(face.turned[0], face.turned[0]), vertex_on(face.turned[1], face.turned[1]),
         vertex_on(face.turned[2], face.turned[2])},
        cell);
  }
}

Surface SectionCutter::run() {
  for (std::size_t i = 0; i < mesh_.tetrahedra.size(); ++i) add_cell(i);
  add_flat_faces();
  return std::move(section_);
}

/// Contour lines of one isovalue.
class IsolineMarcher {
 public:
  IsolineMarcher(const Surface& section, double isovalue, double distance, Surface& lines)
      : section_(section),
        isovalue_(isovalue),
        distance_(distance),
        first_(static_cast<std::uint32_t>(lines.positions.size())),
        lines_(lines) {}

  double run();

 private:
  std::uint32_t vertex_on(std::uint32_t a, std::uint32_t b);

  const Surface& section_;
  double isovalue_;
  double distance_;  ///< To be kept from ends of edges, world units.
  std::uint32_t first_;
  VertexIds ids_;
  Surface& lines_;
};

std::uint32_t IsolineMarcher::vertex_on(std::uint32_t a, std::uint32_t b) {
  if (a > b) std::swap(a, b);
  const auto [id, is_new] = ids_.find_or_add(edge_key(a, b));
  if (!is_new) return first_ + id;
  const Vec3d from = section_.world_position(a);
  const Vec3d way = section_.world_position(b) - from;
  const double t = crossing_of(isovalue_, section_.values[a], section_.values[b], way, distance_);
  lines_.positions.push_back(narrowed(from + way * t - section_.origin));
  lines_.isovalues.push_back(isovalue_);
  for (std::size_t i = 0; i < section_.attributes.size(); ++i) {
    const std::vector<double>& values = section_.attributes[i].values;
    lines_.attributes[i].values.push_back(values[a] * (1 - t) + values[b] * t);
  }
  return first_ + id;
}

double IsolineMarcher::run() {
  double largest_error = 0;
  for (std::size_t at = 0; at < section_.triangles.size(); ++at) {
    const Triangle& t = section_.triangles[at];
    std::size_t inside = 0;
    for (std::size_t i = 0; i < 3; ++i)
      if (section_.values[t[i]] >= isovalue_) inside |= std::size_t{1} << i;
    if (inside == 0 || inside == 7) continue;
    march_simplex<2>(
        inside, false, [&](std::size_t i, std::size_t j) { return vertex_on(t[i], t[j]); },
        [&](const auto& line) { lines_.lines.push_back(line); });
    lines_.errors.push_back(section_.errors[at]);
    if (!section_.regions.empty()) lines_.regions.push_back(section_.regions[at]);
    largest_error = std::max(largest_error, static_cast<double>(section_.errors[at]));
  }
  return largest_error;
}

}  // namespace

SectionRounding section_rounding(const LatticeFrame& frame, const Vec3d& normal) {
  const Vec3d unit = normalized(normal);
  SectionRounding rounding{.origin = frame.surface_origin};
  double step = length(frame.to_world.column(0));
  for (std::size_t i = 0; i < 3; ++i) {
    rounding.snap += frame.margin * std::abs(dot(unit, frame.to_world.column(i)));
    step = std::min(step, length(frame.to_world.column(i)));
  }
  rounding.margin = frame.margin * step;
  return rounding;
}

SectionRounding section_rounding(const Vec3d& origin, double margin, const Vec3d& normal) {
  const Vec3d unit = normalized(normal);
  const double sum = std::abs(unit[0]) + std::abs(unit[1]) + std::abs(unit[2]);
  return {.origin = origin, .snap = margin * sum, .margin = margin};
}

Surface cut_section(const SimplexMesh& mesh, const SectionPlane& plane,
                    const SectionRounding& rounding) {
  return SectionCutter(mesh, plane, rounding).run();
}

double add_isolines(const Surface& section, double isovalue, double margin, Surface& lines) {
  lines.origin = section.origin;
  if (lines.attributes.empty())
    for (const Attribute& from : section.attributes)
      lines.attributes.push_back({from.name, false, {}, from.error});
  return IsolineMarcher(section, isovalue, margin, lines).run();
}

}  // namespace lode

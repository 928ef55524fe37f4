#include "lode/mappers/surface_cells.h"

#include <algorithm>
#include <array>
#include <limits>

namespace lode {
namespace {

/// Marks cells in which the height, linear on each, is 0 somewhere.
template <typename HeightOf>
void mark_cells_through(const SimplexMesh& mesh, const HeightOf& height_of,
                        std::vector<std::uint8_t>& is_marked) {
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const std::uint32_t v : mesh.tetrahedra[i]) {
      const double height = height_of(v);
      low = std::min(low, height);
      high = std::max(high, height);
    }
    if (low <= 0 && high >= 0) is_marked[i] = 1;
  }
}

/// Of those that are marked, and keeps these alone.
double keep_marked_errors(std::vector<float>& errors, std::span<const std::uint8_t> is_marked) {
  double largest = 0;
  std::size_t n = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (is_marked[i] == 0) continue;
    largest = std::max(largest, static_cast<double>(errors[i]));
    errors[n++] = errors[i];
  }
  errors.resize(n);
  return largest;
}

}  // namespace

std::vector<std::uint8_t> cells_at_boundary(const SimplexMesh& mesh) {
  struct Face {
    std::array<std::uint32_t, 3> corners;
    std::size_t cell;
  };
  std::vector<Face> faces;
  faces.reserve(4 * mesh.tetrahedra.size());
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i)
    for (std::size_t corner = 0; corner < 4; ++corner) {
      faces.push_back({face_across(mesh.tetrahedra[i], corner), i});
      std::ranges::sort(faces.back().corners);
    }
  std::ranges::sort(faces, {}, &Face::corners);
  std::vector<std::uint8_t> is_outer(mesh.tetrahedra.size());
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t last = i + 1;
    while (last < faces.size() && faces[last].corners == faces[i].corners) ++last;
    if (last == i + 1) is_outer[faces[i].cell] = 1;
    i = last;
  }
  return is_outer;
}

std::vector<std::uint8_t> cells_at_planes(const SimplexMesh& mesh,
                                          std::span<const SectionPlane> planes) {
  std::vector<std::uint8_t> is_met(mesh.tetrahedra.size());
  for (const SectionPlane& plane : planes)
    mark_cells_through(
        mesh, [&](std::uint32_t v) { return dot(plane.normal, mesh.positions[v] - plane.point); },
        is_met);
  return is_met;
}

std::vector<std::uint8_t> cells_with_values(const SimplexMesh& mesh,
                                            std::span<const double> values) {
  std::vector<std::uint8_t> has_one(mesh.tetrahedra.size());
  for (const double value : values)
    mark_cells_through(
        mesh, [&](std::uint32_t v) { return mesh.values[v] - value; }, has_one);
  return has_one;
}

void keep_marked_cells(SimplexMesh& mesh, std::span<const std::uint8_t> is_marked) {
  keep_marked_errors(mesh.errors, is_marked);
  for (Attribute& attribute : mesh.attributes)
    if (attribute.errors.size() == is_marked.size())
      attribute.error = keep_marked_errors(attribute.errors, is_marked);
  std::size_t at = 0;
  std::erase_if(mesh.tetrahedra, [&](const auto&) { return is_marked[at++] == 0; });
}

}  // namespace lode

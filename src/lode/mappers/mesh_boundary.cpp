#include "lode/mappers/mesh_boundary.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "lode/core/parallel_fill.h"
#include "lode/mappers/crossed_edge.h"

namespace lode {
namespace {

using FaceCorners = std::array<std::uint32_t, 3>;

constexpr std::uint32_t kNotKept = 0xFFFFFFFFU;

/// A face, by the least of its corners where it is listed.
struct ListedFace {
  std::uint64_t others;  ///< Its other corners, the larger one in the low half.
  std::uint64_t place;   ///< Four times its cell, and the corner across.
};

std::uint32_t least_of(const FaceCorners& face) { return std::min({face[0], face[1], face[2]}); }

std::uint64_t others_of(FaceCorners face) {
  std::ranges::sort(face);
  return edge_key(face[1], face[2]);
}

/// All faces by their least corner, in the order of cells: where each vertex's begin, and they.
struct FaceLists {
  std::vector<std::uint64_t> begins;
  UninitializedArray<ListedFace> faces;

  explicit FaceLists(const SimplexMesh& mesh) : begins(mesh.positions.size() + 1, 0) {
    faces.resize(4 * mesh.tetrahedra.size());
    for (const auto& cell : mesh.tetrahedra)
      for (std::size_t i = 0; i < 4; ++i) ++begins[least_of(face_across(cell, i))];
    std::uint64_t sum = 0;
    for (std::uint64_t& begin : begins) sum += std::exchange(begin, sum);
    for (std::size_t at = 0; at < mesh.tetrahedra.size(); ++at)
      for (std::size_t i = 0; i < 4; ++i) {
        const FaceCorners face = face_across(mesh.tetrahedra[at], i);
        faces[begins[least_of(face)]++] = {others_of(face), 4 * std::uint64_t{at} + i};
      }
    std::copy_backward(begins.begin(), begins.end() - 1, begins.end());
    begins.front() = 0;
  }
  [[nodiscard]] std::span<ListedFace> of(std::size_t vertex) {
    return std::span(faces).subspan(begins[vertex], begins[vertex + 1] - begins[vertex]);
  }
};

/// Moves those that no other equals to the front, by their corners; returns how many these are.
std::size_t keep_single(std::span<ListedFace> faces) {
  std::ranges::sort(faces, {}, [](const ListedFace& f) { return std::pair{f.others, f.place}; });
  std::size_t n = 0;
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t end = i + 1;
    while (end < faces.size() && faces[end].others == faces[i].others) ++end;
    if (end == i + 1) faces[n++] = faces[i];
    i = end;
  }
  return n;
}

/// Numbers those that are not kNotKept 0, 1, 2, ...: how many they are.
std::uint32_t number_kept(std::vector<std::uint32_t>& numbers) {
  std::uint32_t n = 0;
  for (std::uint32_t& id : numbers)
    if (id != kNotKept) id = n++;
  return n;
}

/// Of a place as ListedFace has it: one more than the patch's place, or 0.
std::uint32_t patch_mark(const SimplexMesh& mesh, std::uint64_t place) {
  const auto place_of = [](const PatchSide& side) {
    return 4 * std::uint64_t{side.cell} + side.corner;
  };
  const auto at = std::ranges::lower_bound(mesh.patch_sides, place, {}, place_of);
  return at == mesh.patch_sides.end() || place_of(*at) != place ? 0 : at->patch + 1;
}

/// Those of cells that stay, by their new places; kNotKept of the others.
void keep_sides(const std::vector<std::uint32_t>& cells, SimplexMesh& mesh) {
  std::erase_if(mesh.patch_sides,
                [&](const PatchSide& side) { return cells[side.cell] == kNotKept; });
  for (PatchSide& side : mesh.patch_sides) side.cell = cells[side.cell];
}

/// `is_kept`: of a cell, by its place.
template <typename IsKept>
std::uint64_t keep_cells(SimplexMesh& mesh, const IsKept& is_kept,
                         std::vector<std::uint32_t>& vertex_ids) {
  std::vector<std::uint32_t> numbers(mesh.positions.size(), kNotKept);
  std::vector<std::uint32_t> cells(mesh.patch_sides.empty() ? 0 : mesh.tetrahedra.size(), kNotKept);
  std::size_t n = 0;
  for (std::size_t at = 0; at < mesh.tetrahedra.size(); ++at) {
    if (!is_kept(at)) continue;
    for (const std::uint32_t v : mesh.tetrahedra[at]) numbers[v] = 0;
    mesh.errors[n] = mesh.errors[at];
    for (Attribute& attribute : mesh.attributes)
      if (!attribute.errors.empty()) attribute.errors[n] = attribute.errors[at];
    if (!mesh.regions.empty()) mesh.regions[n] = mesh.regions[at];
    if (!cells.empty()) cells[at] = static_cast<std::uint32_t>(n);
    mesh.tetrahedra[n++] = mesh.tetrahedra[at];
  }
  keep_sides(cells, mesh);
  const std::uint64_t n_left_out = mesh.tetrahedra.size() - n;
  mesh.tetrahedra.resize(n);
  mesh.errors.resize(n);
  for (Attribute& attribute : mesh.attributes) {
    if (attribute.errors.empty()) continue;
    attribute.errors.resize(n);
    attribute.error = n == 0 ? 0 : static_cast<double>(std::ranges::max(attribute.errors));
  }
  if (!mesh.regions.empty()) mesh.regions.resize(n);
  const std::uint32_t n_vertices = number_kept(numbers);
  for (std::size_t v = 0; v < numbers.size(); ++v) {
    if (numbers[v] == kNotKept) continue;
    mesh.positions[numbers[v]] = mesh.positions[v];
    mesh.values[numbers[v]] = mesh.values[v];
    for (Attribute& attribute : mesh.attributes) attribute.values[numbers[v]] = attribute.values[v];
    if (!vertex_ids.empty()) vertex_ids[numbers[v]] = vertex_ids[v];
  }
  mesh.positions.resize(n_vertices);
  mesh.values.resize(n_vertices);
  for (Attribute& attribute : mesh.attributes) attribute.values.resize(n_vertices);
  if (!vertex_ids.empty()) vertex_ids.resize(n_vertices);
  for (auto& cell : mesh.tetrahedra)
    for (std::uint32_t& v : cell) v = numbers[v];
  return n_left_out;
}

}  // namespace

Surface mesh_boundary(const SimplexMesh& mesh, const Vec3d& origin, Threads threads,
                      std::span<const std::uint32_t> patches) {
  FaceLists lists(mesh);
  const std::size_t n_vertices = mesh.positions.size();
  std::vector<std::uint32_t> n_single(n_vertices);
  for_each_piece(n_vertices, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v)
      n_single[v] = static_cast<std::uint32_t>(keep_single(lists.of(v)));
  });
  Surface surface;
  surface.origin = origin;
  surface.patches = mesh.patches;
  std::vector<std::uint32_t> numbers(n_vertices, kNotKept);
  for (std::size_t v = 0; v < n_vertices; ++v)
    for (const ListedFace& face : lists.of(v).first(n_single[v])) {
      const auto cell = static_cast<std::size_t>(face.place / 4);
      const std::uint32_t mark = patch_mark(mesh, face.place);
      if (!patches.empty() && (mark == 0 || std::ranges::find(patches, mark - 1) == patches.end()))
        continue;
      surface.triangles.push_back(face_across(mesh.tetrahedra[cell], face.place % 4));
      surface.errors.push_back(mesh.errors[cell]);
      if (!mesh.regions.empty()) surface.regions.push_back(mesh.regions[cell]);
      if (!mesh.patches.empty()) surface.patch_marks.push_back(mark);
      for (const std::uint32_t corner : surface.triangles.back()) numbers[corner] = 0;
    }
  number_kept(numbers);
  for (const Attribute& from : mesh.attributes)
    surface.attributes.push_back({from.name, from.is_narrow, {}, from.error});
  for (std::size_t v = 0; v < n_vertices; ++v) {
    if (numbers[v] == kNotKept) continue;
    surface.positions.push_back(narrowed(mesh.positions[v] - origin));
    surface.values.push_back(mesh.values[v]);
    for (std::size_t i = 0; i < mesh.attributes.size(); ++i)
      surface.attributes[i].values.push_back(mesh.attributes[i].values[v]);
  }
  for (FaceCorners& triangle : surface.triangles)
    for (std::uint32_t& v : triangle) v = numbers[v];
  return surface;
}

std::uint64_t keep_cells_within(SimplexMesh& mesh, double low, double high,
                                std::vector<std::uint32_t>& vertex_ids) {
  const auto is_within = [&](std::uint32_t v) {
    return low <= mesh.values[v] && mesh.values[v] <= high;
  };
  return keep_cells(
      mesh, [&](std::size_t at) { return std::ranges::all_of(mesh.tetrahedra[at], is_within); },
      vertex_ids);
}

std::uint64_t keep_regions(SimplexMesh& mesh, std::span<const std::int64_t> regions,
                           std::vector<std::uint32_t>& vertex_ids) {
  return keep_cells(
      mesh,
      [&](std::size_t at) { return std::ranges::find(regions, mesh.regions[at]) != regions.end(); },
      vertex_ids);
}

}  // namespace lode

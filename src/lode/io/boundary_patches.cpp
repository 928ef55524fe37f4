#include "lode/io/boundary_patches.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "lode/io/cell_types.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

constexpr const char* kPatchField = "PatchId";
constexpr std::uint32_t kNoCell = std::numeric_limits<std::uint32_t>::max();

bool is_face(std::uint8_t type) {
  const auto kind = cell_kind(type);
  return kind && kind->dimension == 2;
}

/// By point, the cells of two dimensions that have it and belong to a patch.
struct PatchCells {
  std::vector<std::size_t> begins;  ///< By point, and one more.
  std::vector<std::uint32_t> cells;

  [[nodiscard]] std::span<const std::uint32_t> of(std::uint32_t point) const {
    return std::span(cells).subspan(begins[point], begins[point + 1] - begins[point]);
  }
};

PatchCells group_cells(const CellMesh& mesh, std::span<const std::uint32_t> patch_cells) {
  PatchCells groups;
  groups.begins.resize(mesh.points.size() + 2);
  for (const std::uint32_t cell : patch_cells)
    for (const std::uint32_t point : mesh.corners_of(cell)) ++groups.begins[point + std::size_t{2}];
  std::partial_sum(groups.begins.begin(), groups.begins.end(), groups.begins.begin());
  groups.cells.resize(groups.begins.back());
  // While groups are filled their begins stand one place further.
  for (const std::uint32_t cell : patch_cells)
    for (const std::uint32_t point : mesh.corners_of(cell))
      groups.cells[groups.begins[point + std::size_t{1}]++] = cell;
  groups.begins.pop_back();
  return groups;
}

/// The first of the cells that has all three corners; kNoCell of none.
std::uint32_t cell_of(const CellMesh& mesh, const PatchCells& groups,
                      const std::array<std::uint32_t, 3>& face) {
  for (const std::uint32_t cell : groups.of(face[0])) {
    const auto corners = mesh.corners_of(cell);
    const auto is_there = [&](std::uint32_t point) {
      return std::find(corners.begin(), corners.end(), point) != corners.end();
    };
    if (is_there(face[1]) && is_there(face[2])) return cell;
  }
  return kNoCell;
}

/// Those that faces have, with the names that the file gives them.
std::vector<BoundaryPatch> patches_of(const CellMesh& mesh,
                                      const std::map<std::int64_t, std::uint32_t>& ids) {
  std::vector<BoundaryPatch> patches;
  for (const auto& [id, place] : ids) {
    const auto named =
        std::find_if(mesh.patch_names.begin(), mesh.patch_names.end(),
                     [id = id](const BoundaryPatch& patch) { return patch.id == id; });
    patches.push_back({id, named == mesh.patch_names.end() ? std::string() : named->name});
  }
  return patches;
}

}  // namespace

std::size_t find_patch_ids(const CellMesh& mesh, std::size_t regions) {
  for (std::size_t i = 0; i < mesh.cell_fields.size(); ++i) {
    const MeshField& field = mesh.cell_fields[i];
    if (equals_ignoring_case(field.name, kPatchField) && !is_floating(field.type) &&
        field.n_components == 1)
      return i;
  }
  return regions;
}

void take_patches(const CellMesh& mesh, std::size_t regions, const TetraFaces& faces,
                  TetraMesh& result, TetraReport& report) {
  const std::size_t ids = find_patch_ids(mesh, regions);
  if (ids == mesh.cell_fields.size()) return;
  const std::vector<double>& values = mesh.cell_fields[ids].values;
  std::vector<std::uint32_t> patch_cells;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell)
    if (is_face(mesh.types[cell]) && values[cell] != 0)
      patch_cells.push_back(static_cast<std::uint32_t>(cell));
  if (patch_cells.empty()) return;
  const PatchCells groups = group_cells(mesh, patch_cells);
  std::vector<std::uint8_t> is_taken(mesh.n_cells(), 0);
  std::map<std::int64_t, std::uint32_t> places;
  std::vector<std::int64_t> id_of;  // by face taken
  for (const auto& face : faces.boundary) {
    const std::uint32_t cell = cell_of(mesh, groups, face);
    if (cell == kNoCell) continue;
    is_taken[cell] = 1;
    id_of.push_back(static_cast<std::int64_t>(values[cell]));
    places.emplace(id_of.back(), 0);
    result.patch_faces.push_back({face, 0});
  }
  result.patches = patches_of(mesh, places);
  std::uint32_t place = 0;
  for (auto& [id, at] : places) at = place++;
  for (std::size_t i = 0; i < id_of.size(); ++i) result.patch_faces[i].patch = places.at(id_of[i]);
  report.n_patches = result.patches.size();
  for (const std::uint32_t cell : patch_cells)
    ++(is_taken[cell] != 0 ? report.n_patch_cells : report.n_inner_faces);
  report.n_lower_cells -= patch_cells.size();
}

}  // namespace lode::io

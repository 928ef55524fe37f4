#include "lode/io/boundary_patches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "lode/core/label.h"
#include "lode/io/cell_types.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

constexpr const char* kPatchField = "PatchId";
constexpr double kMostId = 0x1p53;  // doubles, in which fields are, hold all below
constexpr std::uint32_t kNoCell = std::numeric_limits<std::uint32_t>::max();

bool is_face(std::uint8_t type) {
  const auto kind = cell_kind(type);
  return kind && kind->dimension == 2;
}

using Corners = std::array<std::uint32_t, 3>;

/// Cells of two dimensions that belong to a patch: triangles by their corners, others by point.
class PatchCells {
 public:
  PatchCells(const CellMesh& mesh, std::span<const std::uint32_t> cells) : mesh_(mesh) {
    begins_.resize(mesh.points.size() + 2);
    for (const std::uint32_t cell : cells) {
      const auto corners = mesh.corners_of(cell);
      if (corners.size() == 3) {
        triangles_.emplace_back(sorted({corners[0], corners[1], corners[2]}), cell);
        continue;
      }
      for (const std::uint32_t point : corners) ++begins_[point + std::size_t{2}];
    }
    std::sort(triangles_.begin(), triangles_.end());
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    others_.resize(begins_.back());
    // While lists are filled their begins stand one place further.
    for (const std::uint32_t cell : cells)
      if (mesh.corners_of(cell).size() != 3)
        for (const std::uint32_t point : mesh.corners_of(cell))
          others_[begins_[point + std::size_t{1}]++] = cell;
    begins_.pop_back();
  }

  /// The first that has all three corners of a face; kNoCell of none.
  [[nodiscard]] std::uint32_t first_with(const Corners& face) const {
    const auto by_corners = [](const auto& triangle, const Corners& corners) {
      return triangle.first < corners;
    };
    const Corners key = sorted(face);
    const auto at = std::lower_bound(triangles_.begin(), triangles_.end(), key, by_corners);
    const bool is_triangle = at != triangles_.end() && at->first == key;
    return std::min(is_triangle ? at->second : kNoCell, first_of_others(face));
  }

 private:
  static Corners sorted(Corners corners) {
    std::sort(corners.begin(), corners.end());
    return corners;
  }
  [[nodiscard]] std::span<const std::uint32_t> others_at(std::uint32_t point) const {
    return std::span(others_).subspan(begins_[point], begins_[point + 1] - begins_[point]);
  }
  /// Looked for at the corner that has fewest.
  [[nodiscard]] std::uint32_t first_of_others(const Corners& face) const {
    const auto fewest = *std::min_element(face.begin(), face.end(), [&](auto a, auto b) {
      return others_at(a).size() < others_at(b).size();
    });
    for (const std::uint32_t cell : others_at(fewest)) {
      const auto corners = mesh_.corners_of(cell);
      const auto is_there = [&](std::uint32_t point) {
        return std::find(corners.begin(), corners.end(), point) != corners.end();
      };
      if (std::all_of(face.begin(), face.end(), is_there)) return cell;
    }
    return kNoCell;
  }

  const CellMesh& mesh_;
  std::vector<std::pair<Corners, std::uint32_t>> triangles_;
  std::vector<std::size_t> begins_;  ///< By point, and one more.
  std::vector<std::uint32_t> others_;
};

/// Those that faces have, with the names that the file gives them.
std::vector<BoundaryPatch> patches_of(const CellMesh& mesh,
                                      const std::map<std::int64_t, std::uint32_t>& ids) {
  std::map<std::int64_t, const std::string*> names;
  for (const BoundaryPatch& patch : mesh.patch_names) names.emplace(patch.id, &patch.name);
  std::vector<BoundaryPatch> patches;
  for (const auto& [id, place] : ids) {
    const auto named = names.find(id);
    patches.push_back({id, named == names.end() ? std::string() : to_label(*named->second)});
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

Result<void> take_patches(const CellMesh& mesh, std::size_t regions, const TetraFaces& faces,
                          TetraMesh& result, TetraReport& report) {
  const std::size_t ids = find_patch_ids(mesh, regions);
  if (ids == mesh.cell_fields.size()) return {};
  const std::vector<double>& values = mesh.cell_fields[ids].values;
  std::vector<std::uint32_t> patch_cells;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    if (!is_face(mesh.types[cell]) || values[cell] == 0) continue;
    if (!(std::abs(values[cell]) < kMostId))
      return fail("{}: expected numbers of patches below 2^53 in {}, got {}", mesh.path,
                  in_quotes(mesh.cell_fields[ids].name), values[cell]);
    patch_cells.push_back(static_cast<std::uint32_t>(cell));
  }
  if (patch_cells.empty()) return {};
  const PatchCells groups(mesh, patch_cells);
  std::vector<std::uint8_t> is_taken(mesh.n_cells(), 0);
  std::map<std::int64_t, std::uint32_t> places;
  std::vector<std::int64_t> id_of;  // by face taken
  for (const auto& face : faces.boundary) {
    const std::uint32_t cell = groups.first_with(face);
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
  return {};
}

}  // namespace lode::io

#include "lode/io/mesh_ghosts.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "lode/io/keep_cells.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

constexpr std::string_view kGhostType = "vtkGhostType";
constexpr std::string_view kGhostLevels = "vtkGhostLevels";

// vtkDataSetAttributes: bits of vtkGhostType.
constexpr unsigned kDuplicateCell = 1;
constexpr unsigned kRefinedCell = 8;
constexpr unsigned kHiddenCell = 32;
constexpr unsigned kHiddenPoint = 2;

unsigned bits_of(double type) { return type >= 0 && type <= 255 ? static_cast<unsigned>(type) : 0; }

/// What becomes of a cell.
enum class Fate : std::uint8_t { stay, ghost, hidden };

using Fates = std::vector<Fate>;

std::size_t find_field(const std::vector<MeshField>& fields, std::string_view name) {
  const auto found = std::find_if(fields.begin(), fields.end(),
                                  [&](const MeshField& f) { return f.name == name; });
  return static_cast<std::size_t>(found - fields.begin());
}

/// Takes a field of one component out of the list; one without values where it is not there.
Result<MeshField> take_field(const std::string& path, std::string_view name,
                             std::vector<MeshField>& fields) {
  const std::size_t at = find_field(fields, name);
  if (at == fields.size()) return MeshField{};
  MeshField field = std::move(fields[at]);
  fields.erase(fields.begin() + static_cast<std::ptrdiff_t>(at));
  if (field.n_components != 1)
    return fail("{}: expected {} of one component, got {}", path, name, field.n_components);
  return field;
}

Result<void> mark_by_cells(CellMesh& mesh, Fates& fates) {
  LODE_TRY(const MeshField types, take_field(mesh.path, kGhostType, mesh.cell_fields));
  for (std::size_t i = 0; i < types.values.size(); ++i) {
    const unsigned bits = bits_of(types.values[i]);
    if ((bits & kDuplicateCell) != 0)
      fates[i] = Fate::ghost;
    else if ((bits & (kHiddenCell | kRefinedCell)) != 0)
      fates[i] = Fate::hidden;
  }
  LODE_TRY(const MeshField levels, take_field(mesh.path, kGhostLevels, mesh.cell_fields));
  for (std::size_t i = 0; i < levels.values.size(); ++i)
    if (levels.values[i] > 0) fates[i] = Fate::ghost;
  return {};
}

Result<void> mark_by_points(CellMesh& mesh, Fates& fates) {
  LODE_TRY(const MeshField types, take_field(mesh.path, kGhostType, mesh.point_fields));
  LODE_TRY(const MeshField levels, take_field(mesh.path, kGhostLevels, mesh.point_fields));
  if (types.values.empty()) return {};
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell)
    for (const std::uint32_t corner : mesh.corners_of(cell))
      if ((bits_of(types.values[corner]) & kHiddenPoint) != 0 && fates[cell] == Fate::stay)
        fates[cell] = Fate::hidden;
  return {};
}

}  // namespace

std::size_t find_ghost_type(const std::vector<MeshField>& fields) {
  return find_field(fields, kGhostType);
}

bool is_ghost(double type) { return (bits_of(type) & kDuplicateCell) != 0; }

Result<void> leave_out_ghosts(CellMesh& mesh) {
  Fates fates(mesh.n_cells(), Fate::stay);
  LODE_CHECK(mark_by_cells(mesh, fates));
  LODE_CHECK(mark_by_points(mesh, fates));
  const auto n_of = [&](Fate fate) {
    return static_cast<std::uint64_t>(std::count(fates.begin(), fates.end(), fate));
  };
  mesh.n_ghost_cells = n_of(Fate::ghost);
  mesh.n_hidden_cells = n_of(Fate::hidden);
  if (mesh.n_ghost_cells + mesh.n_hidden_cells == 0) return {};
  std::vector<std::uint8_t> is_kept(fates.size());
  std::transform(fates.begin(), fates.end(), is_kept.begin(),
                 [](Fate fate) { return fate == Fate::stay ? std::uint8_t{1} : std::uint8_t{0}; });
  keep_cells(is_kept, mesh);
  return {};
}

}  // namespace lode::io

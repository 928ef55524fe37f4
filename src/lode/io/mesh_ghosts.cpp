#include "lode/io/mesh_ghosts.h"

#include <algorithm>
#include <string_view>
#include <utility>

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

void keep_values(const Fates& fates, MeshField& field) {
  const auto n = static_cast<std::size_t>(field.n_components);
  std::size_t to = 0;
  for (std::size_t cell = 0; cell < fates.size(); ++cell) {
    if (fates[cell] != Fate::stay) continue;
    for (std::size_t k = 0; k < n; ++k) field.values[to++] = field.values[cell * n + k];
  }
  field.values.resize(to);
}

/// Moves what stays of one list of lists to its front.
template <typename T>
void keep_lists(const Fates& fates, std::vector<std::uint64_t>& begins, std::vector<T>& items) {
  std::size_t to = 0;
  std::size_t n_items = 0;
  for (std::size_t cell = 0; cell < fates.size(); ++cell) {
    if (fates[cell] != Fate::stay) continue;
    const auto begin = static_cast<std::size_t>(begins[cell]);
    const auto end = static_cast<std::size_t>(begins[cell + 1]);
    begins[to++] = n_items;
    for (std::size_t i = begin; i < end; ++i) items[n_items++] = items[i];
  }
  begins[to] = n_items;
  begins.resize(to + 1);
  items.resize(n_items);
}

void keep_cells(const Fates& fates, CellMesh& mesh) {
  keep_lists(fates, mesh.begins, mesh.corners);
  if (!mesh.face_begins.empty()) keep_lists(fates, mesh.face_begins, mesh.faces);
  for (MeshField& field : mesh.cell_fields) keep_values(fates, field);
  std::size_t to = 0;
  for (std::size_t cell = 0; cell < fates.size(); ++cell)
    if (fates[cell] == Fate::stay) mesh.types[to++] = mesh.types[cell];
  mesh.types.resize(to);
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
  if (mesh.n_ghost_cells + mesh.n_hidden_cells > 0) keep_cells(fates, mesh);
  return {};
}

}  // namespace lode::io

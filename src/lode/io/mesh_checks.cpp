#include "lode/io/mesh_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "lode/io/cell_types.h"

namespace lode::io {
namespace {

bool is_finite(const Vec3d& p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

/// By point, whether cells have it for a corner.
std::vector<bool> find_used(const CellMesh& mesh) {
  std::vector<bool> is_used(mesh.points.size());
  for (const std::uint32_t corner : mesh.corners) is_used[corner] = true;
  for (std::size_t cell = 0; cell + 1 < mesh.face_begins.size(); ++cell) {
    const std::span<const std::uint32_t> list = mesh.faces_of(cell);
    for (std::size_t at = 1; at < list.size(); at += list[at] + std::size_t{1})
      for (std::size_t i = 1; i <= list[at]; ++i) is_used[list[at + i]] = true;
  }
  return is_used;
}

/// Points that no cell has may be anywhere, as what other programs blank is: such a one is put
/// where another is, and is left out, and counted, with all that are not used.
Result<void> check_positions(CellMesh& mesh) {
  if (std::ranges::all_of(mesh.points, is_finite)) return {};
  const std::vector<bool> is_used = find_used(mesh);
  const auto first = std::ranges::find(is_used, true);
  const Vec3d anywhere = first == is_used.end()
                             ? Vec3d{}
                             : mesh.points[static_cast<std::size_t>(first - is_used.begin())];
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    Vec3d& p = mesh.points[i];
    if (is_finite(p)) continue;
    if (is_used[i])
      return fail("{}: expected finite positions, got {} {} {} for point {}", mesh.path, p[0], p[1],
                  p[2], i);
    p = anywhere;
  }
  return {};
}

/// Whether float32 holds all positions exactly.
bool has_narrow_points(const CellMesh& mesh) {
  // What float32 would overflow to is not equal either.
  const auto is_narrow = [](double x) {
    return std::abs(x) <= std::numeric_limits<float>::max() &&
           static_cast<double>(static_cast<float>(x)) == x;
  };
  return std::ranges::all_of(mesh.points,
                             [&](const Vec3d& p) { return std::ranges::all_of(p.v, is_narrow); });
}

Result<void> check_cell(const CellMesh& mesh, std::size_t cell) {
  const std::optional<CellKind> kind = cell_kind(mesh.types[cell]);
  if (!kind)
    return fail("{}: expected cells of VTK's types, got {} for cell {}", mesh.path,
                mesh.types[cell], cell);
  const std::span<const std::uint32_t> corners = mesh.corners_of(cell);
  if (kind->n_corners != 0 && corners.size() != kind->n_corners)
    return fail("{}: expected {} corners for cell {}, a {}, got {}", mesh.path, kind->n_corners,
                cell, kind->name, corners.size());
  for (const std::uint32_t corner : corners)
    if (corner >= mesh.points.size())
      return fail("{}: expected corners below {}, the number of points, got {} in cell {}",
                  mesh.path, mesh.points.size(), corner, cell);
  const bool is_polyhedron = mesh.types[cell] == static_cast<std::uint8_t>(CellType::polyhedron);
  if (is_polyhedron == mesh.faces_of(cell).empty())
    return fail("{}: expected faces for polyhedra and no other cells, got {} for cell {}, a {}",
                mesh.path, is_polyhedron ? "none" : "some", cell, kind->name);
  return {};
}

}  // namespace

Result<void> check_rising(const std::string& path, std::string_view what,
                          std::span<const std::uint64_t> ends) {
  std::uint64_t previous = 0;
  for (const std::uint64_t end : ends) {
    if (end < previous)
      return fail("{}: expected rising {}, got {} after {}", path, what, end, previous);
    previous = end;
  }
  return {};
}

Result<void> append_faces(std::span<const std::uint64_t> list, std::uint64_t n_points,
                          CellMesh& mesh) {
  constexpr std::uint64_t kLeastFaces = 4;
  constexpr std::uint64_t kLeastCorners = 3;
  const std::size_t cell = mesh.face_begins.empty() ? 0 : mesh.face_begins.size() - 1;
  const std::uint64_t n_faces = list.empty() ? 0 : list[0];
  std::size_t at = 1;
  std::uint64_t n_read = 0;
  for (; n_read < n_faces && at < list.size(); ++n_read) {
    const std::uint64_t n = list[at];
    if (n < kLeastCorners || n >= list.size() - at)
      return fail("{}: expected faces of 3 corners or more within their list of {}, got {} at {}",
                  mesh.path, list.size(), n, at);
    for (const std::uint64_t id : list.subspan(at + 1, static_cast<std::size_t>(n)))
      if (id >= n_points)
        return fail("{}: expected corners of faces below {}, the number of points, got {}",
                    mesh.path, n_points, id);
    for (std::size_t i = 0; i <= n; ++i)
      mesh.faces.push_back(static_cast<std::uint32_t>(list[at + i]));
    at += static_cast<std::size_t>(n) + 1;
  }
  if (n_faces < kLeastFaces || n_read != n_faces || at != list.size())
    return fail("{}: expected 4 faces or more that fill their list for cell {}, got {} of {}",
                mesh.path, cell, n_read, n_faces);
  if (mesh.face_begins.empty()) mesh.face_begins.push_back(0);
  mesh.face_begins.push_back(mesh.faces.size());
  return {};
}

Result<void> check_cell_mesh(CellMesh& mesh) {
  LODE_EXPECTS(mesh.begins.size() == mesh.n_cells() + 1);
  if (mesh.points.size() > kMaxMeshCount || mesh.n_cells() > kMaxMeshCount)
    return fail("{}: expected at most {} points and cells, got {} and {}", mesh.path, kMaxMeshCount,
                mesh.points.size(), mesh.n_cells());
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) LODE_CHECK(check_cell(mesh, cell));
  LODE_CHECK(check_positions(mesh));
  mesh.has_narrow_points = has_narrow_points(mesh);
  return {};
}

}  // namespace lode::io

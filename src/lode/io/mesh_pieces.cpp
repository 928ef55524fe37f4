#include "lode/io/mesh_pieces.h"

#include <algorithm>
#include <utility>

#include "lode/io/mesh_checks.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

Result<void> append_fields(const std::string& path, const std::vector<MeshField>& piece,
                           std::vector<MeshField>& fields) {
  LODE_TRY(const auto sources, matching_fields(path, fields, piece));
  for (std::size_t i = 0; i < fields.size(); ++i)
    fields[i].values.insert(fields[i].values.end(), sources[i]->values.begin(),
                            sources[i]->values.end());
  return {};
}

template <typename T>
void append_lists(const std::vector<std::uint64_t>& more_begins, const std::vector<T>& more,
                  std::vector<std::uint64_t>& begins, std::vector<T>& items) {
  const std::uint64_t n = items.size();
  for (std::size_t i = 1; i < more_begins.size(); ++i) begins.push_back(n + more_begins[i]);
  items.insert(items.end(), more.begin(), more.end());
}

/// Faces count their corners: only these move up.
void shift_faces(std::uint32_t n_points, std::vector<std::uint32_t>& faces) {
  for (std::size_t at = 0; at < faces.size(); at += faces[at] + std::size_t{1})
    for (std::size_t i = 1; i <= faces[at]; ++i) faces[at + i] += n_points;
}

/// As if no cell had faces yet.
void prepare_faces(CellMesh& mesh) {
  if (mesh.face_begins.empty()) mesh.face_begins.assign(mesh.n_cells() + 1, 0);
}

}  // namespace

Result<std::vector<const MeshField*>> matching_fields(const std::string& path,
                                                      std::vector<MeshField>& fields,
                                                      const std::vector<MeshField>& piece) {
  if (piece.size() != fields.size())
    return fail("{}: expected as many fields in every Piece, got {} after {}", path, piece.size(),
                fields.size());
  std::vector<const MeshField*> sources;
  for (MeshField& field : fields) {
    const auto found = std::find_if(piece.begin(), piece.end(), [&](const MeshField& each) {
      return each.name == field.name && each.n_components == field.n_components;
    });
    if (found == piece.end())
      return fail("{}: expected the field {} of {} components in every Piece, got one without it",
                  path, in_quotes(field.name), field.n_components);
    if (found->type != field.type) field.type = ScalarType::float64;
    sources.push_back(&*found);
  }
  return sources;
}

Result<void> append_piece(CellMesh&& piece, CellMesh& mesh) {
  if (piece.points.empty() && piece.types.empty()) return {};
  if (mesh.points.empty() && mesh.types.empty()) {
    mesh = std::move(piece);
    return {};
  }
  if (piece.points.size() > kMaxMeshCount - mesh.points.size() ||
      piece.n_cells() > kMaxMeshCount - mesh.n_cells())
    return fail("{}: expected at most {} points and cells, got more", mesh.path, kMaxMeshCount);
  const auto n_points = static_cast<std::uint32_t>(mesh.points.size());
  for (std::uint32_t& corner : piece.corners) corner += n_points;
  shift_faces(n_points, piece.faces);
  LODE_CHECK(append_fields(mesh.path, piece.point_fields, mesh.point_fields));
  LODE_CHECK(append_fields(mesh.path, piece.cell_fields, mesh.cell_fields));
  if (!mesh.face_begins.empty() || !piece.face_begins.empty()) {
    prepare_faces(mesh);
    prepare_faces(piece);
    append_lists(piece.face_begins, piece.faces, mesh.face_begins, mesh.faces);
  }
  append_lists(piece.begins, piece.corners, mesh.begins, mesh.corners);
  mesh.points.insert(mesh.points.end(), piece.points.begin(), piece.points.end());
  mesh.types.insert(mesh.types.end(), piece.types.begin(), piece.types.end());
  return {};
}

}  // namespace lode::io

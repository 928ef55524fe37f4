#include "lode/io/mesh_vtk_xml.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "lode/io/grid_pieces.h"
#include "lode/io/mesh_checks.h"
#include "lode/io/mesh_ghosts.h"
#include "lode/io/mesh_pieces.h"
#include "lode/io/mesh_vtk_xml_arrays.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

Result<std::uint64_t> piece_count(const std::string& path, const pugi::xml_node& piece,
                                  const char* name) {
  const char* text = piece.attribute(name).as_string();
  const std::optional<std::uint64_t> count = to_uint64(text);
  if (count && *count <= kMaxMeshCount) return *count;
  return fail("{}: expected {} of at most {}, got {}", path, name, kMaxMeshCount, in_quotes(text));
}

Result<MeshNumbers> load_named(VtkXmlMeshFile& file, const pugi::xml_node& cells, const char* name,
                               std::uint64_t n) {
  const pugi::xml_node array = find_array(cells, name);
  if (!array) return fail("{}: expected an array {} in Cells, got none", file.path(), name);
  return load_xml_numbers(file, array, n);
}

/// The ends of the faces of polyhedra in their array; that of the cell before where there is none.
Result<std::vector<std::uint64_t>> load_face_ends(VtkXmlMeshFile& file, const pugi::xml_node& cells,
                                                  const CellMesh& mesh) {
  LODE_TRY(const MeshNumbers numbers, load_named(file, cells, "faceoffsets", mesh.n_cells()));
  LODE_TRY(
      const std::vector<std::int64_t> given,
      as_whole<std::int64_t>(
          numbers, {.path = file.path(), .name = "faceoffsets", .low = -1, .high = kMaxWhole}));
  std::vector<std::uint64_t> ends(given.size());
  std::uint64_t previous = 0;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const bool is_polyhedron = mesh.types[i] == static_cast<std::uint8_t>(CellType::polyhedron);
    if (is_polyhedron && given[i] < 0)
      return fail("{}: expected a place in faceoffsets for cell {}, a polyhedron, got {}",
                  file.path(), i, given[i]);
    if (is_polyhedron) previous = static_cast<std::uint64_t>(given[i]);
    ends[i] = previous;
  }
  LODE_CHECK(check_rising(file.path(), "faceoffsets", ends));
  return ends;
}

Result<void> load_faces(VtkXmlMeshFile& file, const pugi::xml_node& cells, std::uint64_t n_points,
                        CellMesh& mesh) {
  const auto polyhedron = static_cast<std::uint8_t>(CellType::polyhedron);
  if (std::count(mesh.types.begin(), mesh.types.end(), polyhedron) == 0) return {};
  LODE_TRY(const std::vector<std::uint64_t> ends, load_face_ends(file, cells, mesh));
  LODE_TRY(const MeshNumbers numbers, load_named(file, cells, "faces", ends.back()));
  LODE_TRY(
      const std::vector<std::uint64_t> faces,
      as_whole<std::uint64_t>(numbers, {.path = file.path(), .name = "faces", .high = kMaxWhole}));
  mesh.face_begins.push_back(0);
  std::uint64_t begin = 0;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const auto list = std::span(faces).subspan(static_cast<std::size_t>(begin),
                                               static_cast<std::size_t>(ends[i] - begin));
    if (mesh.types[i] == polyhedron)
      LODE_CHECK(append_faces(list, n_points, mesh));
    else
      mesh.face_begins.push_back(mesh.faces.size());
    begin = ends[i];
  }
  return {};
}

Result<void> load_cells(VtkXmlMeshFile& file, const pugi::xml_node& piece, std::uint64_t n_points,
                        CellMesh& mesh) {
  const std::string& path = file.path();
  const pugi::xml_node cells = piece.child("Cells");
  mesh.begins = {0};
  LODE_TRY(const std::uint64_t n, piece_count(path, piece, "NumberOfCells"));
  if (n == 0) return {};
  LODE_TRY(const MeshNumbers offsets, load_named(file, cells, "offsets", n));
  LODE_TRY(const std::vector<std::uint64_t> ends,
           as_whole<std::uint64_t>(offsets, {.path = path, .name = "offsets", .high = kMaxWhole}));
  LODE_CHECK(check_rising(path, "offsets", ends));
  LODE_TRY(const MeshNumbers corners, load_named(file, cells, "connectivity", ends.back()));
  if (ends.back() > 0 && n_points == 0)
    return fail("{}: expected points for {} corners of cells, got none", path, ends.back());
  LODE_TRY(mesh.corners,
           as_whole<std::uint32_t>(corners, {.path = path,
                                             .name = "connectivity",
                                             .high = static_cast<std::int64_t>(n_points) - 1}));
  LODE_TRY(const MeshNumbers types, load_named(file, cells, "types", n));
  LODE_TRY(mesh.types, as_whole<std::uint8_t>(types, {.path = path, .name = "types", .high = 255}));
  mesh.begins.insert(mesh.begins.end(), ends.begin(), ends.end());
  return load_faces(file, cells, n_points, mesh);
}

Result<CellMesh> read_unstructured_piece(VtkXmlMeshFile& file, const pugi::xml_node& piece) {
  CellMesh mesh;
  mesh.path = file.path();
  LODE_TRY(const std::uint64_t n_points, piece_count(file.path(), piece, "NumberOfPoints"));
  LODE_TRY(mesh.points, load_xml_points(file, piece, n_points));
  LODE_CHECK(load_cells(file, piece, n_points, mesh));
  LODE_TRY(mesh.point_fields, load_xml_fields(file, piece.child("PointData"), n_points));
  LODE_TRY(mesh.cell_fields, load_xml_fields(file, piece.child("CellData"), mesh.n_cells()));
  return mesh;
}

Result<CellMesh> read_unstructured(VtkXmlMeshFile& file, const pugi::xml_node& data) {
  CellMesh mesh;
  mesh.path = file.path();
  mesh.begins = {0};
  for (const pugi::xml_node piece : data.children("Piece")) {
    LODE_TRY(CellMesh part, read_unstructured_piece(file, piece));
    LODE_CHECK(append_piece(std::move(part), mesh));
  }
  LODE_CHECK(leave_out_ghosts(mesh));
  LODE_TRY(mesh.patch_names, load_xml_patch_names(file, data));
  LODE_TRY(mesh.region_names, load_xml_region_names(file, data));
  LODE_TRY(mesh.time, load_xml_time(file, data));
  return mesh;
}

Result<GridPiece> read_grid_piece(VtkXmlMeshFile& file, const pugi::xml_node& piece) {
  GridPiece part;
  part.content.path = file.path();
  LODE_TRY(part.extent, parse_vtk_extent(file.path(), piece.attribute("Extent").as_string()));
  LODE_TRY(const std::uint64_t n_points, count_places(file.path(), part.extent.dims));
  LODE_TRY(const std::uint64_t n_cells, count_places(file.path(), cell_dims(part.extent.dims)));
  LODE_TRY(part.content.points, load_xml_points(file, piece, n_points));
  LODE_TRY(part.content.point_fields, load_xml_fields(file, piece.child("PointData"), n_points));
  LODE_TRY(part.content.cell_fields, load_xml_fields(file, piece.child("CellData"), n_cells));
  return part;
}

Result<CellMesh> read_curvilinear(VtkXmlMeshFile& file, const pugi::xml_node& data) {
  LODE_TRY(const VtkExtent extent,
           parse_vtk_extent(file.path(), data.attribute("WholeExtent").as_string()));
  std::vector<GridPiece> pieces;
  for (const pugi::xml_node piece : data.children("Piece")) {
    LODE_TRY(GridPiece part, read_grid_piece(file, piece));
    pieces.push_back(std::move(part));
  }
  LODE_TRY(CellMesh mesh, join_grid(file.path(), extent, std::move(pieces)));
  LODE_CHECK(leave_out_ghosts(mesh));
  LODE_TRY(mesh.region_names, load_xml_region_names(file, data));
  LODE_TRY(mesh.time, load_xml_time(file, data));
  return mesh;
}

}  // namespace

Result<CellMesh> read_vtk_xml_mesh(const std::string& path, const MeshReadOptions& options) {
  VtkXmlMeshFile file;
  LODE_TRY(file.xml,
           open_vtk_xml(path, {.memory_limit = options.memory_limit, .spool_directory = {}}));
  file.budget = MeshBudget::of(file.xml->file->size(), options.memory_limit);
  const std::string kind = file.xml->root().attribute("type").as_string();
  if (kind != "UnstructuredGrid" && kind != "StructuredGrid")
    return fail("{}: expected UnstructuredGrid or StructuredGrid, got {}", path, in_quotes(kind));
  const pugi::xml_node data = file.xml->root().child(kind.c_str());
  if (!data.child("Piece")) return fail("{}: expected an element Piece in {}", path, kind);
  LODE_TRY(CellMesh mesh, kind == "UnstructuredGrid" ? read_unstructured(file, data)
                                                     : read_curvilinear(file, data));
  mesh.skipped_arrays = std::move(file.skipped_arrays);
  return mesh;
}

}  // namespace lode::io

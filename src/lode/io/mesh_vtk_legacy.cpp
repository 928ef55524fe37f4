#include "lode/io/mesh_vtk_legacy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "lode/io/grid_pieces.h"
#include "lode/io/mesh_checks.h"
#include "lode/io/mesh_ghosts.h"
#include "lode/io/mesh_numbers.h"
#include "lode/io/text.h"
#include "lode/io/vtk_legacy_arrays.h"
#include "lode/io/vtk_legacy_skip.h"

namespace lode::io {
namespace {

/// Where a mesh's arrays lie in the file.
struct LegacyMeshArrays {
  bool is_grid = false;
  std::optional<std::array<std::int64_t, 3>> counts;
  std::optional<LegacyArray> points;
  std::optional<LegacyArray> cells;  ///< Each as its number of corners and these; to version 4.
  std::int64_t n_cells = 0;
  std::optional<LegacyArray> offsets;  ///< From version 5 on, with connectivity.
  std::optional<LegacyArray> connectivity;
  std::optional<LegacyArray> types;
  std::optional<LegacyArray> time;  ///< TimeValue of the data set, where it is one number.
  std::vector<LegacyArray> point_arrays;
  std::vector<LegacyArray> cell_arrays;
  std::vector<std::string> skipped_arrays;  ///< Of points and cells, no numbers.
};

/// A legacy file being read.
struct LegacyMeshFile {
  InputFilePtr file;
  LegacyEncoding encoding = LegacyEncoding::ascii;
  MeshBudget budget;

  [[nodiscard]] const std::string& path() const { return file->path(); }
};

Result<std::vector<std::int64_t>> counts_after(const LegacyFile& file,
                                               const std::vector<std::string>& words,
                                               std::size_t n) {
  std::vector<std::int64_t> counts;
  for (std::size_t i = 1; i < words.size() && counts.size() < n; ++i) {
    const auto count = to_int64(words[i]);
    if (!count || *count < 0 || *count > kMaxWhole / 16) break;
    counts.push_back(*count);
  }
  if (counts.size() == n) return counts;
  return fail("{}: expected {} counts after {}, got {}", file.cursor.path(), n, words[0],
              in_quotes(words.size() > 1 ? words[1] : ""));
}

/// An array of which the header says how many numbers it has.
Result<LegacyArray> note_array(LegacyFile& file, LegacyArray array) {
  LODE_CHECK(skip_array(file, array));
  return array;
}

Result<void> parse_points(LegacyFile& file, const std::vector<std::string>& words,
                          LegacyMeshArrays& arrays) {
  LODE_TRY(const auto n, counts_after(file, words, 1));
  LegacyArray points{.name = words[0], .n_components = 3, .n_tuples = n[0]};
  LODE_TRY(points.type, legacy_type(file.cursor.path(), words.size() == 3 ? words[2] : ""));
  LODE_TRY(arrays.points, note_array(file, points));
  return {};
}

/// OFFSETS and CONNECTIVITY, each with its type on a line of its own.
Result<LegacyArray> parse_typed_array(LegacyFile& file, const std::string& name, std::int64_t n) {
  LODE_TRY(const auto words, next_words(file));
  if (words.size() != 2 || !equals_ignoring_case(words[0], name))
    return fail("{}: expected {} and a type before byte {}, got {}", file.cursor.path(), name,
                file.cursor.position(), in_quotes(words.empty() ? "" : words[0]));
  LegacyArray array{.name = name, .n_tuples = n};
  LODE_TRY(array.type, legacy_type(file.cursor.path(), words[1]));
  return note_array(file, array);
}

Result<void> parse_cells(LegacyFile& file, const std::vector<std::string>& words,
                         std::int64_t version, LegacyMeshArrays& arrays) {
  LODE_TRY(const auto n, counts_after(file, words, 2));
  if (version < 5) {
    arrays.n_cells = n[0];
    LODE_TRY(arrays.cells,
             note_array(file, {.name = "CELLS", .type = ScalarType::int32, .n_tuples = n[1]}));
    return {};
  }
  arrays.n_cells = std::max<std::int64_t>(n[0] - 1, 0);
  LODE_TRY(arrays.offsets, parse_typed_array(file, "OFFSETS", n[0]));
  LODE_TRY(arrays.connectivity, parse_typed_array(file, "CONNECTIVITY", n[1]));
  return {};
}

/// POINTS, CELLS and so on; false when `words` is none of them.
Result<bool> parse_mesh_part(LegacyFile& file, const std::vector<std::string>& words,
                             std::int64_t version, LegacyMeshArrays& arrays) {
  const std::string keyword = to_lower(words[0]);
  if (keyword == "points") {
    LODE_CHECK(parse_points(file, words, arrays));
  } else if (keyword == "dimensions" && arrays.is_grid) {
    LODE_TRY(const auto n, counts_after(file, words, 3));
    arrays.counts = {n[0], n[1], n[2]};
  } else if (keyword == "cells" && !arrays.is_grid) {
    LODE_CHECK(parse_cells(file, words, version, arrays));
  } else if (keyword == "cell_types" && !arrays.is_grid) {
    LODE_TRY(const auto n, counts_after(file, words, 1));
    LODE_TRY(arrays.types,
             note_array(file, {.name = "CELL_TYPES", .type = ScalarType::int32, .n_tuples = n[0]}));
  } else {
    return false;
  }
  return true;
}

Result<void> parse_arrays(LegacyFile& file, std::int64_t version, LegacyMeshArrays& arrays) {
  // The dataset's own arrays, which come first, are passed over but for its time.
  std::vector<LegacyArray> others;
  std::vector<LegacyArray>* section = &others;
  std::int64_t n_tuples = 0;
  while (true) {
    LODE_TRY(const auto words, next_words(file));
    if (words.empty()) return {};
    const bool is_points = equals_ignoring_case(words[0], "POINT_DATA");
    if (is_points || equals_ignoring_case(words[0], "CELL_DATA")) {
      LODE_TRY(const auto n, counts_after(file, words, 1));
      section = is_points ? &arrays.point_arrays : &arrays.cell_arrays;
      n_tuples = n[0];
      continue;
    }
    if (section == &others) {
      LODE_TRY(const bool is_part, parse_mesh_part(file, words, version, arrays));
      if (is_part) continue;
    }
    LODE_TRY(auto attribute, parse_legacy_attribute(file, words, n_tuples));
    if (!attribute.is_known)
      return fail("{}: expected a legacy VTK keyword before byte {}, got {}", file.cursor.path(),
                  file.cursor.position(), in_quotes(words[0]));
    for (LegacyArray& array : attribute.arrays) section->push_back(std::move(array));
    if (section == &others) {
      for (const LegacyArray& array : others)
        if (array.name == "TimeValue" && array.n_tuples == 1 && array.n_components == 1)
          arrays.time = array;
      others.clear();
      continue;
    }
    for (std::string& name : attribute.skipped) arrays.skipped_arrays.push_back(std::move(name));
  }
}

Result<MeshNumbers> load_numbers(LegacyMeshFile& file, const LegacyArray& array) {
  if (array.n_bytes == 0) return MeshNumbers{.type = array.type, .bytes = {}};
  LODE_CHECK(file.budget.spend(file.path(), array.n_bytes));
  LODE_TRY(const auto store, load_legacy_array(file.file, file.encoding, array, {}));
  return read_numbers(*store, array.type, legacy_byte_order(file.encoding),
                      array.n_bytes / size_of(array.type));
}

Result<std::vector<std::uint64_t>> load_whole(LegacyMeshFile& file, const LegacyArray& array) {
  LODE_TRY(const MeshNumbers numbers, load_numbers(file, array));
  return as_whole<std::uint64_t>(numbers,
                                 {.path = file.path(), .name = array.name, .high = kMaxWhole});
}

Result<std::optional<double>> load_time(LegacyMeshFile& file, const LegacyMeshArrays& arrays) {
  if (!arrays.time) return std::optional<double>();
  LODE_TRY(const MeshNumbers numbers, load_numbers(file, *arrays.time));
  const double time = as_doubles(numbers)[0];
  if (std::isfinite(time)) return std::optional(time);
  return fail("{}: expected a finite TimeValue, got {}", file.path(), time);
}

Result<std::vector<Vec3d>> load_points(LegacyMeshFile& file, const LegacyMeshArrays& arrays) {
  if (!arrays.points) return fail("{}: expected POINTS, got none", file.path());
  if (static_cast<std::uint64_t>(arrays.points->n_tuples) > kMaxMeshCount)
    return fail("{}: expected at most {} points, got {}", file.path(), kMaxMeshCount,
                arrays.points->n_tuples);
  LODE_TRY(const MeshNumbers numbers, load_numbers(file, *arrays.points));
  const std::vector<double> values = as_doubles(numbers);
  std::vector<Vec3d> points(values.size() / 3);
  for (std::size_t i = 0; i < values.size(); ++i) points[i / 3][i % 3] = values[i];
  return points;
}

Result<std::vector<MeshField>> load_fields(LegacyMeshFile& file, std::size_t n,
                                           const std::vector<LegacyArray>& arrays) {
  std::vector<MeshField> fields;
  for (const LegacyArray& array : arrays) {
    if (std::cmp_not_equal(array.n_tuples, n) || array.n_components < 1 ||
        array.n_components > std::numeric_limits<int>::max())
      return fail("{}: expected {} values in {}, got {} of {} components", file.path(), n,
                  in_quotes(array.name), array.n_tuples, array.n_components);
    LODE_TRY(const MeshNumbers numbers, load_numbers(file, array));
    fields.push_back({.name = array.name,
                      .type = array.type,
                      .n_components = static_cast<int>(array.n_components),
                      .values = as_doubles(numbers)});
  }
  return fields;
}

/// Corners of faces, each once, in the order in which they come.
void append_corners_of_faces(std::size_t begin, CellMesh& mesh) {
  const std::size_t first = mesh.corners.size();
  for (std::size_t at = begin; at < mesh.faces.size(); at += mesh.faces[at] + std::size_t{1})
    for (std::size_t i = 1; i <= mesh.faces[at]; ++i) mesh.corners.push_back(mesh.faces[at + i]);
  const auto from = mesh.corners.begin() + static_cast<std::ptrdiff_t>(first);
  std::sort(from, mesh.corners.end());
  mesh.corners.erase(std::unique(from, mesh.corners.end()), mesh.corners.end());
}

/// The next cell, from its list: corners, or of a polyhedron the number of faces and these.
Result<void> append_cell(std::span<const std::uint64_t> list, CellMesh& mesh) {
  const std::size_t cell = mesh.begins.size() - 1;
  if (mesh.types[cell] == static_cast<std::uint8_t>(CellType::polyhedron)) {
    if (mesh.face_begins.empty()) mesh.face_begins.assign(cell + 1, 0);
    const std::size_t begin = mesh.faces.size();
    LODE_CHECK(append_faces(list, mesh.points.size(), mesh));
    append_corners_of_faces(begin, mesh);
  } else {
    for (const std::uint64_t id : list) {
      if (id >= mesh.points.size())
        return fail("{}: expected corners below {}, the number of points, got {} in cell {}",
                    mesh.path, mesh.points.size(), id, cell);
      mesh.corners.push_back(static_cast<std::uint32_t>(id));
    }
    if (!mesh.face_begins.empty()) mesh.face_begins.push_back(mesh.faces.size());
  }
  mesh.begins.push_back(mesh.corners.size());
  return {};
}

Result<void> append_counted_cells(std::span<const std::uint64_t> lists, CellMesh& mesh) {
  std::size_t at = 0;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    if (at >= lists.size() || lists[at] >= lists.size() - at)
      return fail("{}: expected {} cells in CELLS, got {} that fit into its {} numbers", mesh.path,
                  mesh.n_cells(), cell, lists.size());
    const auto n = static_cast<std::size_t>(lists[at]);
    LODE_CHECK(append_cell(lists.subspan(at + 1, n), mesh));
    at += n + 1;
  }
  if (at == lists.size()) return {};
  return fail("{}: expected {} cells to take the {} numbers of CELLS, got {} used", mesh.path,
              mesh.n_cells(), lists.size(), at);
}

Result<void> append_offset_cells(std::span<const std::uint64_t> offsets,
                                 std::span<const std::uint64_t> corners, CellMesh& mesh) {
  if (offsets.empty() && corners.empty()) return {};
  LODE_CHECK(check_rising(mesh.path, "OFFSETS", offsets));
  if (offsets.empty() || offsets.front() != 0 || offsets.back() != corners.size())
    return fail("{}: expected OFFSETS from 0 to {}, the size of CONNECTIVITY, got {}", mesh.path,
                corners.size(), offsets.empty() ? 0 : offsets.back());
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell)
    LODE_CHECK(
        append_cell(corners.subspan(static_cast<std::size_t>(offsets[cell]),
                                    static_cast<std::size_t>(offsets[cell + 1] - offsets[cell])),
                    mesh));
  return {};
}

Result<void> load_cells(LegacyMeshFile& file, const LegacyMeshArrays& arrays, CellMesh& mesh) {
  const std::int64_t n_types = arrays.types ? arrays.types->n_tuples : 0;
  if (n_types != arrays.n_cells || std::cmp_greater(n_types, kMaxMeshCount))
    return fail("{}: expected a type in CELL_TYPES for each of {} cells, got {}", file.path(),
                arrays.n_cells, n_types);
  mesh.begins = {0};
  if (arrays.n_cells == 0) return {};
  LODE_TRY(const MeshNumbers types, load_numbers(file, *arrays.types));
  LODE_TRY(mesh.types,
           as_whole<std::uint8_t>(types, {.path = file.path(), .name = "CELL_TYPES", .high = 255}));
  if (arrays.cells) {
    LODE_TRY(const auto lists, load_whole(file, *arrays.cells));
    return append_counted_cells(lists, mesh);
  }
  LODE_TRY(const auto offsets, load_whole(file, *arrays.offsets));
  LODE_TRY(const auto corners, load_whole(file, *arrays.connectivity));
  return append_offset_cells(offsets, corners, mesh);
}

Result<void> load_grid(const LegacyMeshArrays& arrays, CellMesh& mesh) {
  if (!arrays.counts) return fail("{}: expected DIMENSIONS, got none", mesh.path);
  LODE_TRY(const Index3 dims, checked_dims(mesh.path, *arrays.counts));
  LODE_CHECK(check_solid(mesh.path, dims));
  LODE_TRY(const std::uint64_t n, count_places(mesh.path, dims));
  if (n != mesh.points.size())
    return fail("{}: expected {} x {} x {} points, got {}", mesh.path, dims[0], dims[1], dims[2],
                mesh.points.size());
  make_hexahedra(dims, mesh);
  return {};
}

Result<CellMesh> load_mesh(LegacyMeshFile& file, const LegacyMeshArrays& arrays) {
  CellMesh mesh;
  mesh.path = file.path();
  mesh.skipped_arrays = arrays.skipped_arrays;
  LODE_TRY(mesh.points, load_points(file, arrays));
  LODE_CHECK(arrays.is_grid ? load_grid(arrays, mesh) : load_cells(file, arrays, mesh));
  LODE_TRY(mesh.point_fields, load_fields(file, mesh.points.size(), arrays.point_arrays));
  LODE_TRY(mesh.cell_fields, load_fields(file, mesh.n_cells(), arrays.cell_arrays));
  LODE_TRY(mesh.time, load_time(file, arrays));
  LODE_CHECK(leave_out_ghosts(mesh));
  return mesh;
}

}  // namespace

Result<CellMesh> read_vtk_legacy_mesh(const std::string& path, const MeshReadOptions& options) {
  LegacyMeshFile file;
  LODE_TRY(file.file, InputFile::open(path));
  file.budget = MeshBudget::of(file.file->size(), options.memory_limit);
  const auto stream = make_file_stream(file.file, 0);
  LegacyFile legacy{.cursor = TextCursor(*stream, path)};
  LODE_TRY(const LegacyPreamble preamble, parse_legacy_preamble(legacy));
  const std::string kind = to_lower(preamble.dataset);
  if (kind != "unstructured_grid" && kind != "structured_grid")
    return fail("{}: expected DATASET UNSTRUCTURED_GRID or STRUCTURED_GRID, got {}", path,
                in_quotes(preamble.dataset));
  LegacyMeshArrays arrays;
  arrays.is_grid = kind == "structured_grid";
  LODE_CHECK(parse_arrays(legacy, preamble.version, arrays));
  file.encoding = legacy.encoding;
  return load_mesh(file, arrays);
}

}  // namespace lode::io

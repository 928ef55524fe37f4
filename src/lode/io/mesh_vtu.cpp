#include "lode/io/mesh_vtu.h"

#include <array>
#include <limits>
#include <new>
#include <optional>

#include "lode/core/out_of_memory.h"
#include "lode/io/mesh_blocks.h"
#include "lode/io/mesh_patches.h"
#include "lode/io/vector_arrays.h"
#include "lode/io/vtk_xml_output.h"

namespace lode::io {
namespace {

constexpr std::uint8_t kVtkTriangle = 5;
constexpr std::uint8_t kVtkTetrahedron = 10;

/// The arrays of a file in the order of their data.
struct VtuLayout {
  std::string value_name;
  VtkXmlArray values;
  std::vector<ArrayOfFields> more;      ///< Attributes, and vectors of them,
  std::vector<VtkXmlArray> attributes;  ///< likewise.
  VtkXmlArray errors;
  std::vector<VtkXmlArray> attribute_errors;  ///< Of no bytes, and then left out, where unknown.
  VtkXmlArray regions;  ///< Of no bytes, and then left out, where there is one.
  VtkXmlArray patches;  ///< Likewise without any.
  VtkXmlArray points;
  VtkXmlArray connectivity;
  VtkXmlArray offsets;
  VtkXmlArray types;
};

std::size_t n_corners_per_cell(const SimplexMesh& mesh) { return mesh.triangles.empty() ? 4 : 3; }

/// With the faces of patches, which come after the others.
std::size_t n_all_cells(const SimplexMesh& mesh) {
  return mesh.n_cells() + mesh.patch_sides.size();
}

std::size_t n_all_corners(const SimplexMesh& mesh) {
  return mesh.n_cells() * n_corners_per_cell(mesh) + 3 * mesh.patch_sides.size();
}

bool needs_wide_indices(const SimplexMesh& mesh) {
  constexpr std::uint64_t kMax = std::numeric_limits<std::int32_t>::max();
  return mesh.positions.size() > kMax || n_all_corners(mesh) > kMax;
}

VtuLayout make_vtu_layout(const SimplexMesh& mesh, const MeshWriteOptions& options) {
  const std::uint64_t n = mesh.positions.size();
  const std::uint64_t n_cells = n_all_cells(mesh);
  const std::uint64_t index_bytes = needs_wide_indices(mesh) ? 8 : 4;
  const char* index = index_bytes == 8 ? "Int64" : "Int32";
  VtuLayout layout;
  layout.value_name = vtk_array_name(options.value_name);
  layout.values = {fmt::format(R"(type="{}" Name="{}")",
                               mesh.has_narrow_values ? "Float32" : "Float64", layout.value_name),
                   n * (mesh.has_narrow_values ? sizeof(float) : sizeof(double))};
  layout.more = arrays_of_fields(options.value_name, mesh.attributes);
  for (const ArrayOfFields& array : layout.more) {
    const bool is_float = is_narrow(array, mesh.has_narrow_values, mesh.attributes);
    layout.attributes.push_back(
        {fmt::format(R"(type="{}" Name="{}"{})", is_float ? "Float32" : "Float64",
                     vtk_array_name(array.name),
                     array.fields.size() > 1 ? R"( NumberOfComponents="3")" : ""),
         n * array.fields.size() * (is_float ? sizeof(float) : sizeof(double))});
  }
  for (const Attribute& attribute : mesh.attributes)
    layout.attribute_errors.push_back(
        {fmt::format(R"(type="Float32" Name="{}")", vtk_array_name(error_name(attribute))),
         attribute.errors.empty() ? 0 : n_cells * sizeof(float)});
  layout.errors = {R"(type="Float32" Name="error")", n_cells * sizeof(float)};
  layout.regions = {R"(type="Int64" Name="RegionId")",
                    mesh.regions.empty() ? 0 : n_cells * sizeof(std::int64_t)};
  layout.patches = {R"(type="Int64" Name="PatchId")",
                    mesh.patches.empty() ? 0 : n_cells * sizeof(std::int64_t)};
  layout.points = {R"(type="Float64" Name="Points" NumberOfComponents="3")", n * sizeof(Vec3d)};
  layout.connectivity = {fmt::format(R"(type="{}" Name="connectivity")", index),
                         n_all_corners(mesh) * index_bytes};
  layout.offsets = {fmt::format(R"(type="{}" Name="offsets")", index), n_cells * index_bytes};
  layout.types = {R"(type="UInt8" Name="types")", n_cells};
  return layout;
}

std::uint64_t vtu_bytes(const VtuLayout& layout) {
  std::uint64_t n = 0;
  for (const VtkXmlArray& array : layout.attributes) n += array.n_bytes;
  for (const VtkXmlArray& array : layout.attribute_errors) n += array.n_bytes;
  return n + layout.values.n_bytes + layout.errors.n_bytes + layout.regions.n_bytes +
         layout.patches.n_bytes + layout.points.n_bytes + layout.connectivity.n_bytes +
         layout.offsets.n_bytes + layout.types.n_bytes;
}

std::string vtu_piece(const SimplexMesh& mesh, const VtuLayout& layout,
                      const std::optional<double>& time) {
  std::uint64_t offset = 0;
  std::string xml;
  const std::string notes =
      vtk_time(time) + vtk_region_names(mesh.region_names) + vtk_patch_names(mesh.patches);
  if (!notes.empty()) xml += "<FieldData>\n" + notes + "</FieldData>\n";
  xml += fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", mesh.positions.size(),
                     n_all_cells(mesh));
  xml += fmt::format("<PointData Scalars=\"{}\">\n", layout.value_name);
  xml += describe_array(layout.values, offset);
  for (const VtkXmlArray& array : layout.attributes) xml += describe_array(array, offset);
  xml += "</PointData>\n<CellData>\n";
  xml += describe_array(layout.errors, offset);
  for (std::size_t i = 0; i < mesh.attributes.size(); ++i)
    if (!mesh.attributes[i].errors.empty())
      xml += describe_array(layout.attribute_errors[i], offset);
  if (!mesh.regions.empty()) xml += describe_array(layout.regions, offset);
  if (!mesh.patches.empty()) xml += describe_array(layout.patches, offset);
  xml += "</CellData>\n<Points>\n";
  xml += describe_array(layout.points, offset) + "</Points>\n<Cells>\n";
  for (const VtkXmlArray* array : {&layout.connectivity, &layout.offsets, &layout.types})
    xml += describe_array(*array, offset);
  return xml + "</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
}

Result<void> write_values(SurfaceOutput& file, const std::vector<double>& values, bool is_narrow) {
  if (!is_narrow) return write_array(file, std::span(values));
  return write_records(file, values.size(), sizeof(float), [&](std::size_t i, std::byte* out) {
    put(out, static_cast<float>(values[i]));
  });
}

/// One field, or the components of a vector in turns.
Result<void> write_fields(SurfaceOutput& file, const ArrayOfFields& array,
                          const SimplexMesh& mesh) {
  const bool is_float = is_narrow(array, mesh.has_narrow_values, mesh.attributes);
  const auto fields = fields_of(array, mesh.values, mesh.attributes);
  const std::size_t n_bytes = fields.size() * (is_float ? sizeof(float) : sizeof(double));
  return write_records(file, mesh.positions.size(), n_bytes, [&](std::size_t i, std::byte* out) {
    for (const std::span<const double> field : fields)
      if (is_float)
        put(out, static_cast<float>(field[i]));
      else
        put(out, double{field[i]});
  });
}

template <typename T, std::size_t N>
Result<void> write_corners(SurfaceOutput& file,
                           const std::vector<std::array<std::uint32_t, N>>& cells) {
  if constexpr (sizeof(T) == sizeof(std::uint32_t)) {
    return write_array(file, std::span(cells));
  } else {
    return write_records(file, cells.size(), N * sizeof(T), [&](std::size_t i, std::byte* out) {
      for (const std::uint32_t vertex : cells[i]) put(out, T{vertex});
    });
  }
}

/// Connectivity, offsets and types.
template <typename T>
Result<void> write_cells(SurfaceOutput& file, const SimplexMesh& mesh, const VtuLayout& layout) {
  const std::size_t n_corners = n_corners_per_cell(mesh);
  LODE_CHECK(write_array_size(file, layout.connectivity));
  LODE_CHECK((write_corners<T, 4>(file, mesh.tetrahedra)));
  LODE_CHECK((write_corners<T, 3>(file, mesh.triangles)));
  const std::size_t n_sides = mesh.patch_sides.size();
  LODE_CHECK(write_records(file, n_sides, 3 * sizeof(T), [&](std::size_t i, std::byte* out) {
    for (const std::uint32_t v : mesh.corners_of(mesh.patch_sides[i])) put(out, static_cast<T>(v));
  }));
  LODE_CHECK(write_array_size(file, layout.offsets));
  const std::size_t n = mesh.n_cells();
  LODE_CHECK(write_records(file, n_all_cells(mesh), sizeof(T), [&](std::size_t i, std::byte* out) {
    put(out, static_cast<T>(i < n ? (i + 1) * n_corners : n * n_corners + (i + 1 - n) * 3));
  }));
  LODE_CHECK(write_array_size(file, layout.types));
  return write_records(file, n_all_cells(mesh), 1, [&](std::size_t i, std::byte* out) {
    put(out, n_corners == 4 && i < n ? kVtkTetrahedron : kVtkTriangle);
  });
}

/// Errors, regions and patches.
Result<void> write_cell_data(SurfaceOutput& file, const SimplexMesh& mesh,
                             const VtuLayout& layout) {
  LODE_CHECK(write_array_size(file, layout.errors));
  LODE_CHECK(write_with_sides(file, mesh, mesh.errors));
  for (std::size_t i = 0; i < mesh.attributes.size(); ++i) {
    if (mesh.attributes[i].errors.empty()) continue;
    LODE_CHECK(write_array_size(file, layout.attribute_errors[i]));
    LODE_CHECK(write_with_sides(file, mesh, mesh.attributes[i].errors));
  }
  if (!mesh.regions.empty()) {
    LODE_CHECK(write_array_size(file, layout.regions));
    LODE_CHECK(write_with_sides(file, mesh, mesh.regions));
  }
  if (mesh.patches.empty()) return {};
  LODE_CHECK(write_array_size(file, layout.patches));
  const std::size_t n = mesh.n_cells();
  const auto id_of = [&](std::size_t i) {
    return i < n ? std::int64_t{0} : mesh.patches[mesh.patch_sides[i - n].patch].id;
  };
  return write_records(file, n_all_cells(mesh), sizeof(std::int64_t),
                       [&](std::size_t i, std::byte* out) { put(out, id_of(i)); });
}

}  // namespace

Result<void> write_vtu(const std::string& path, const SimplexMesh& mesh,
                       const MeshWriteOptions& options, Progress& progress) try {
  LODE_EXPECTS(mesh.triangles.empty() || mesh.tetrahedra.empty());
  LODE_EXPECTS(mesh.values.size() == mesh.positions.size());
  LODE_EXPECTS(mesh.errors.size() == mesh.n_cells());
  LODE_EXPECTS(mesh.regions.empty() || mesh.regions.size() == mesh.n_cells());
  LODE_EXPECTS(has_whole_attributes(mesh));
  const VtuLayout layout = make_vtu_layout(mesh, options);
  LODE_TRY(SurfaceOutput file,
           SurfaceOutput::create(path, vtu_bytes(layout), progress, options.threads));
  LODE_CHECK(file.write(vtk_xml_head("UnstructuredGrid", options.comment, options.frame)));
  LODE_CHECK(file.write(vtu_piece(mesh, layout, options.time)));
  LODE_CHECK(write_array_size(file, layout.values));
  LODE_CHECK(write_values(file, mesh.values, mesh.has_narrow_values));
  for (std::size_t i = 0; i < layout.more.size(); ++i) {
    LODE_CHECK(write_array_size(file, layout.attributes[i]));
    LODE_CHECK(write_fields(file, layout.more[i], mesh));
  }
  LODE_CHECK(write_cell_data(file, mesh, layout));
  LODE_CHECK(write_array_size(file, layout.points));
  LODE_CHECK(write_array(file, std::span(mesh.positions)));
  LODE_CHECK(needs_wide_indices(mesh) ? write_cells<std::int64_t>(file, mesh, layout)
                                      : write_cells<std::int32_t>(file, mesh, layout));
  LODE_CHECK(file.write(std::string_view("\n</AppendedData>\n</VTKFile>\n")));
  return file.commit();
} catch (const std::bad_alloc&) {
  return out_of_memory("write the mesh", path);
}

}  // namespace lode::io

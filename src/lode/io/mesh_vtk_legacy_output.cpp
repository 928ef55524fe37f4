#include "lode/io/mesh_vtk_legacy_output.h"

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "lode/io/mesh_blocks.h"
#include "lode/io/surface_output.h"
#include "lode/io/vector_arrays.h"
#include "lode/io/vtk_xml_output.h"

namespace lode::io {
namespace {

constexpr std::int32_t kLegacyTriangle = 5;
constexpr std::int32_t kLegacyTetrahedron = 10;

/// A word: what is no visible character is written as %20 and the like.
std::string legacy_name(std::string_view name) {
  std::string word;
  for (const char c : vtk_array_name(name)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte <= 0x20 || byte >= 0x7f || c == '%' || c == '"')
      word += fmt::format("%{:02X}", byte);
    else
      word += c;
  }
  return word;
}

std::string legacy_head(const MeshWriteOptions& options) {
  constexpr std::size_t kMaxTitle = 255;  // with the end of its line 256
  std::string title = to_one_line(options.comment);
  const std::string frame = fmt::format("; frame {}", name_of(options.frame));
  if (title.size() + frame.size() > kMaxTitle) title.resize(kMaxTitle - frame.size());
  return fmt::format("# vtk DataFile Version 3.0\n{}{}\nBINARY\nDATASET UNSTRUCTURED_GRID\n", title,
                     frame);
}

/// The data set's field data, where there is a time.
Result<void> write_legacy_time(SurfaceOutput& file, const std::optional<double>& time) {
  if (!time) return {};
  LODE_CHECK(file.write(std::string_view("FIELD FieldData 1\nTimeValue 1 1 double\n")));
  LODE_CHECK(write_records(file, 1, sizeof(double),
                           [&](std::size_t, std::byte* out) { put_big(out, *time); }));
  return file.write(std::string_view("\n"));
}

Result<void> write_legacy_cells(SurfaceOutput& file, const SimplexMesh& mesh) {
  const std::size_t n_corners = n_simplex_corners(mesh);
  const std::size_t n = mesh.n_cells();
  const std::size_t n_sides = mesh.patch_sides.size();
  LODE_CHECK(
      file.write(fmt::format("\nCELLS {} {}\n", n + n_sides, n * (n_corners + 1) + n_sides * 4)));
  LODE_CHECK(write_records(file, n, (n_corners + 1) * sizeof(std::int32_t),
                           [&](std::size_t cell, std::byte* out) {
                             put_big(out, static_cast<std::int32_t>(n_corners));
                             for (const std::uint32_t v : simplex_corners(mesh, cell))
                               put_big(out, v);
                           }));
  LODE_CHECK(
      write_records(file, n_sides, 4 * sizeof(std::int32_t), [&](std::size_t i, std::byte* out) {
        put_big(out, std::int32_t{3});
        for (const std::uint32_t v : mesh.corners_of(mesh.patch_sides[i])) put_big(out, v);
      }));
  LODE_CHECK(file.write(fmt::format("\nCELL_TYPES {}\n", n + n_sides)));
  return write_records(file, n + n_sides, sizeof(std::int32_t), [&](std::size_t i, std::byte* out) {
    put_big(out, n_corners == 4 && i < n ? kLegacyTetrahedron : kLegacyTriangle);
  });
}

Result<void> write_legacy_cell_data(SurfaceOutput& file, const SimplexMesh& mesh) {
  const std::size_t n = mesh.n_cells() + mesh.patch_sides.size();
  // Faces of patches have what their cells have.
  const auto cell_of = [&](std::size_t i) {
    return i < mesh.n_cells() ? i : mesh.patch_sides[i - mesh.n_cells()].cell;
  };
  std::size_t n_arrays =
      std::size_t{1} + (mesh.regions.empty() ? 0 : 1) + (mesh.patches.empty() ? 0 : 1);
  for (const Attribute& attribute : mesh.attributes) n_arrays += attribute.errors.empty() ? 0 : 1;
  LODE_CHECK(file.write(fmt::format("\nCELL_DATA {}\nFIELD FieldData {}", n, n_arrays)));
  const auto write_errors = [&](const std::string& name,
                                const std::vector<float>& errors) -> Result<void> {
    LODE_CHECK(file.write(fmt::format("\n{} 1 {} float\n", name, n)));
    return write_records(file, n, sizeof(float),
                         [&](std::size_t i, std::byte* out) { put_big(out, errors[cell_of(i)]); });
  };
  LODE_CHECK(write_errors("error", mesh.errors));
  for (const Attribute& attribute : mesh.attributes)
    if (!attribute.errors.empty())
      LODE_CHECK(write_errors(legacy_name(error_name(attribute)), attribute.errors));
  const auto write_ids = [&](const char* name, const auto& id_of) -> Result<void> {
    LODE_CHECK(file.write(fmt::format("\n{} 1 {} vtktypeint64\n", name, n)));
    return write_records(file, n, sizeof(std::int64_t), [&](std::size_t i, std::byte* out) {
      put_big(out, std::int64_t{id_of(i)});
    });
  };
  if (!mesh.regions.empty())
    LODE_CHECK(write_ids("RegionId", [&](std::size_t i) { return mesh.regions[cell_of(i)]; }));
  if (mesh.patches.empty()) return {};
  return write_ids("PatchId", [&](std::size_t i) {
    return i < mesh.n_cells() ? 0 : mesh.patches[mesh.patch_sides[i - mesh.n_cells()].patch].id;
  });
}

/// Big-endian, as floats where these hold them; of several fields their values in turns.
Result<void> write_legacy_values(SurfaceOutput& file,
                                 std::span<const std::span<const double>> fields, bool is_float) {
  const std::size_t n_bytes = fields.size() * (is_float ? sizeof(float) : sizeof(double));
  return write_records(file, fields.front().size(), n_bytes, [&](std::size_t i, std::byte* out) {
    for (const std::span<const double> field : fields)
      if (is_float)
        put_big(out, static_cast<float>(field[i]));
      else
        put_big(out, double{field[i]});
  });
}

Result<void> write_legacy_point_data(SurfaceOutput& file, const SimplexMesh& mesh,
                                     const MeshWriteOptions& options) {
  const auto type_of = [](bool is_narrow) { return is_narrow ? "float" : "double"; };
  const std::size_t n = mesh.values.size();
  LODE_CHECK(
      file.write(fmt::format("\nPOINT_DATA {}\nSCALARS {} {} 1\nLOOKUP_TABLE default\n", n,
                             legacy_name(options.value_name), type_of(mesh.has_narrow_values))));
  const std::array values{std::span<const double>(mesh.values)};
  LODE_CHECK(write_legacy_values(file, values, mesh.has_narrow_values));
  if (mesh.attributes.empty()) return {};
  const std::vector<ArrayOfFields> arrays = arrays_of_fields(options.value_name, mesh.attributes);
  LODE_CHECK(file.write(fmt::format("\nFIELD FieldData {}", arrays.size())));
  for (const ArrayOfFields& array : arrays) {
    const bool is_float = is_narrow(array, mesh.has_narrow_values, mesh.attributes);
    LODE_CHECK(file.write(fmt::format("\n{} {} {} {}\n", legacy_name(array.name),
                                      array.fields.size(), n, type_of(is_float))));
    LODE_CHECK(write_legacy_values(file, fields_of(array, mesh.values, mesh.attributes), is_float));
  }
  return {};
}

}  // namespace

Result<void> write_vtk_legacy_mesh(const std::string& path, const SimplexMesh& mesh,
                                   const MeshWriteOptions& options, Progress& progress) {
  constexpr std::size_t kMax = std::numeric_limits<std::int32_t>::max();
  if (mesh.positions.size() > kMax ||
      mesh.n_cells() + mesh.patch_sides.size() > kMax / (n_simplex_corners(mesh) + 1))
    return fail("{}: expected a mesh that legacy VTK can count in 32 bits, got {} cells; .vtu can",
                path, mesh.n_cells());
  const std::size_t n_bytes =
      mesh.positions.size() * (sizeof(Vec3d) + (mesh.attributes.size() + 1) * sizeof(double)) +
      mesh.n_cells() * (n_simplex_corners(mesh) + 3 + mesh.attributes.size()) *
          sizeof(std::int32_t);
  LODE_TRY(SurfaceOutput file, SurfaceOutput::create(path, n_bytes, progress, options.threads));
  LODE_CHECK(file.write(legacy_head(options)));
  LODE_CHECK(write_legacy_time(file, options.time));
  LODE_CHECK(file.write(fmt::format("POINTS {} double\n", mesh.positions.size())));
  LODE_CHECK(
      write_records(file, mesh.positions.size(), sizeof(Vec3d), [&](std::size_t i, std::byte* out) {
        for (const double x : mesh.positions[i].v) put_big(out, x);
      }));
  LODE_CHECK(write_legacy_cells(file, mesh));
  LODE_CHECK(write_legacy_cell_data(file, mesh));
  LODE_CHECK(write_legacy_point_data(file, mesh, options));
  LODE_CHECK(file.write(std::string_view("\n")));
  return file.commit();
}

}  // namespace lode::io

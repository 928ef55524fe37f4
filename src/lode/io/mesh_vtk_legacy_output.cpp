#include "lode/io/mesh_vtk_legacy_output.h"

#include <limits>

#include "lode/io/mesh_blocks.h"
#include "lode/io/surface_output.h"
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

std::string legacy_head(const MeshWriteOptions& options, std::size_t n_points) {
  constexpr std::size_t kMaxTitle = 255;  // with the end of its line 256
  std::string title = to_one_line(options.comment);
  const std::string frame = fmt::format("; frame {}", name_of(options.frame));
  if (title.size() + frame.size() > kMaxTitle) title.resize(kMaxTitle - frame.size());
  return fmt::format(
      "# vtk DataFile Version 3.0\n{}{}\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS {} double\n",
      title, frame, n_points);
}

Result<void> write_legacy_cells(SurfaceOutput& file, const SimplexMesh& mesh) {
  const std::size_t n_corners = n_simplex_corners(mesh);
  const std::size_t n = mesh.n_cells();
  LODE_CHECK(file.write(fmt::format("\nCELLS {} {}\n", n, n * (n_corners + 1))));
  LODE_CHECK(write_records(file, n, (n_corners + 1) * sizeof(std::int32_t),
                           [&](std::size_t cell, std::byte* out) {
                             put_big(out, static_cast<std::int32_t>(n_corners));
                             for (const std::uint32_t v : simplex_corners(mesh, cell))
                               put_big(out, v);
                           }));
  LODE_CHECK(file.write(fmt::format("\nCELL_TYPES {}\n", n)));
  return write_records(file, n, sizeof(std::int32_t), [&](std::size_t, std::byte* out) {
    put_big(out, n_corners == 4 ? kLegacyTetrahedron : kLegacyTriangle);
  });
}

Result<void> write_legacy_cell_data(SurfaceOutput& file, const SimplexMesh& mesh) {
  const std::size_t n = mesh.n_cells();
  LODE_CHECK(file.write(fmt::format("\nCELL_DATA {}\nFIELD FieldData {}\nerror 1 {} float\n", n,
                                    mesh.regions.empty() ? 1 : 2, n)));
  LODE_CHECK(write_records(file, n, sizeof(float), [&](std::size_t cell, std::byte* out) {
    put_big(out, mesh.errors[cell]);
  }));
  if (mesh.regions.empty()) return {};
  LODE_CHECK(file.write(fmt::format("\nRegionId 1 {} vtktypeint64\n", n)));
  return write_records(file, n, sizeof(std::int64_t),
                       [&](std::size_t cell, std::byte* out) { put_big(out, mesh.regions[cell]); });
}

Result<void> write_legacy_scalars(SurfaceOutput& file, const std::string& name, bool is_narrow,
                                  std::span<const double> values) {
  LODE_CHECK(file.write(fmt::format("\nSCALARS {} {} 1\nLOOKUP_TABLE default\n", legacy_name(name),
                                    is_narrow ? "float" : "double")));
  const std::size_t n_bytes = is_narrow ? sizeof(float) : sizeof(double);
  return write_records(file, values.size(), n_bytes, [&](std::size_t i, std::byte* out) {
    if (is_narrow)
      put_big(out, static_cast<float>(values[i]));
    else
      put_big(out, values[i]);
  });
}

Result<void> write_legacy_point_data(SurfaceOutput& file, const SimplexMesh& mesh,
                                     const MeshWriteOptions& options) {
  LODE_CHECK(file.write(fmt::format("\nPOINT_DATA {}", mesh.values.size())));
  LODE_CHECK(write_legacy_scalars(file, options.value_name, mesh.has_narrow_values, mesh.values));
  for (const Attribute& attribute : mesh.attributes)
    LODE_CHECK(write_legacy_scalars(file, attribute.name, attribute.is_narrow, attribute.values));
  return {};
}

}  // namespace

Result<void> write_vtk_legacy_mesh(const std::string& path, const SimplexMesh& mesh,
                                   const MeshWriteOptions& options, Progress& progress) {
  constexpr std::size_t kMax = std::numeric_limits<std::int32_t>::max();
  if (mesh.positions.size() > kMax || mesh.n_cells() > kMax / (n_simplex_corners(mesh) + 1))
    return fail("{}: expected a mesh that legacy VTK can count in 32 bits, got {} cells; .vtu can",
                path, mesh.n_cells());
  const std::size_t n_bytes = mesh.positions.size() * (sizeof(Vec3d) + sizeof(double)) +
                              mesh.n_cells() * (n_simplex_corners(mesh) + 3) * sizeof(std::int32_t);
  LODE_TRY(SurfaceOutput file, SurfaceOutput::create(path, n_bytes, progress));
  LODE_CHECK(file.write(legacy_head(options, mesh.positions.size())));
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

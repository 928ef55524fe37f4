#include "lode/io/surface_vtp.h"

#include <limits>
#include <optional>

#include "lode/io/vtk_xml_output.h"

namespace lode::io {
namespace {

/// The arrays of a file in the order of their data. Unused ones are left out.
struct VtpLayout {
  std::optional<VtkXmlArray> values;
  std::optional<VtkXmlArray> isovalues;
  std::optional<VtkXmlArray> normals;
  std::optional<VtkXmlArray> origins;
  std::optional<VtkXmlArray> errors;
  VtkXmlArray points;
  VtkXmlArray connectivity;
  VtkXmlArray offsets;
};

std::size_t n_cells(const Surface& surface) {
  return surface.triangles.size() + surface.lines.size();
}

std::size_t corners_per_cell(const Surface& surface) { return surface.lines.empty() ? 3 : 2; }

bool needs_wide_indices(const Surface& surface) {
  constexpr std::uint64_t kMax = std::numeric_limits<std::int32_t>::max();
  return surface.positions.size() > kMax || n_cells(surface) * corners_per_cell(surface) > kMax;
}

VtpLayout make_vtp_layout(const Surface& surface, const SurfaceWriteOptions& options) {
  const bool is_double = has_origin(surface);
  const char* coordinate = is_double ? "Float64" : "Float32";
  const std::uint64_t n = surface.positions.size();
  const std::uint64_t point_bytes = n * (is_double ? sizeof(Vec3d) : sizeof(Vec3f));
  const std::uint64_t index_bytes = needs_wide_indices(surface) ? 8 : 4;
  const char* index = index_bytes == 8 ? "Int64" : "Int32";
  VtpLayout layout;
  if (!surface.values.empty())
    layout.values = {fmt::format(R"(type="Float64" Name="{}")", vtk_array_name(options.value_name)),
                     n * sizeof(double)};
  if (!surface.isovalues.empty())
    layout.isovalues = {R"(type="Float32" Name="isovalue")", n * sizeof(float)};
  if (!surface.normals.empty())
    layout.normals = {R"(type="Float32" Name="Normals" NumberOfComponents="3")", n * sizeof(Vec3f)};
  if (!surface.origins.empty())
    layout.origins = {fmt::format(R"(type="{}" Name="origin" NumberOfComponents="3")", coordinate),
                      point_bytes};
  if (!surface.errors.empty())
    layout.errors = {R"(type="Float32" Name="error")", n_cells(surface) * sizeof(float)};
  layout.points = {fmt::format(R"(type="{}" Name="Points" NumberOfComponents="3")", coordinate),
                   point_bytes};
  layout.connectivity = {fmt::format(R"(type="{}" Name="connectivity")", index),
                         n_cells(surface) * corners_per_cell(surface) * index_bytes};
  layout.offsets = {fmt::format(R"(type="{}" Name="offsets")", index),
                    n_cells(surface) * index_bytes};
  return layout;
}

std::uint64_t bytes_of(const std::optional<VtkXmlArray>& array) {
  return array ? array->n_bytes : 0;
}

/// Of the arrays, without the XML.
std::uint64_t vtp_bytes(const VtpLayout& layout) {
  return bytes_of(layout.values) + bytes_of(layout.isovalues) + bytes_of(layout.normals) +
         bytes_of(layout.origins) + bytes_of(layout.errors) + layout.points.n_bytes +
         layout.connectivity.n_bytes + layout.offsets.n_bytes;
}

std::string vtp_head(const Surface& surface, const SurfaceWriteOptions& options) {
  std::string xml = vtk_xml_head("PolyData", options.comment, options.frame);
  if (has_origin(surface))
    xml += fmt::format(
        "<FieldData>\n<DataArray type=\"Float64\" Name=\"{}\" NumberOfComponents=\"3\" "
        "NumberOfTuples=\"1\" format=\"ascii\">{} {} {}</DataArray>\n</FieldData>\n",
        kOriginNote, surface.origin[0], surface.origin[1], surface.origin[2]);
  xml += fmt::format(
      "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"{}\" "
      "NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n",
      surface.positions.size(), surface.lines.size(), surface.triangles.size());
  return xml;
}

std::string vtp_piece(const Surface& surface, const SurfaceWriteOptions& options,
                      const VtpLayout& layout) {
  const char* cells = surface.lines.empty() ? "Polys" : "Lines";
  std::uint64_t offset = 0;
  std::string xml = "<PointData";
  if (layout.values)
    xml += fmt::format(" Scalars=\"{}\"", vtk_array_name(options.value_name));
  else if (layout.isovalues)
    xml += " Scalars=\"isovalue\"";
  if (layout.normals) xml += " Normals=\"Normals\"";
  xml += ">\n";
  for (const auto* array : {&layout.values, &layout.isovalues, &layout.normals, &layout.origins})
    if (*array) xml += describe_array(**array, offset);
  xml += "</PointData>\n";
  if (layout.errors)
    xml += "<CellData>\n" + describe_array(*layout.errors, offset) + "</CellData>\n";
  xml += "<Points>\n" + describe_array(layout.points, offset) + "</Points>\n";
  xml += fmt::format("<{}>\n", cells) + describe_array(layout.connectivity, offset);
  xml += describe_array(layout.offsets, offset) + fmt::format("</{}>\n", cells);
  xml += "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
  return xml;
}

/// A size and an array, where there is one.
template <typename T>
Result<void> write_optional(SurfaceOutput& file, const std::optional<VtkXmlArray>& array,
                            const std::vector<T>& data) {
  if (!array) return {};
  LODE_CHECK(write_array_size(file, *array));
  return write_array(file, std::span(data));
}

/// As positions are: in world units where the surface has an origin.
Result<void> write_places(SurfaceOutput& file, const Surface& surface,
                          const std::vector<Vec3f>& places) {
  if (!has_origin(surface)) return write_array(file, std::span(places));
  const auto fill = [&](std::size_t i, std::byte* out) {
    put(out, world_place(surface, places[i]));
  };
  return write_records(file, places.size(), sizeof(Vec3d), fill);
}

/// Attributes and points.
Result<void> write_point_arrays(SurfaceOutput& file, const Surface& surface,
                                const VtpLayout& layout) {
  LODE_CHECK(write_optional(file, layout.values, surface.values));
  LODE_CHECK(write_optional(file, layout.isovalues, surface.isovalues));
  LODE_CHECK(write_optional(file, layout.normals, surface.normals));
  if (layout.origins) {
    LODE_CHECK(write_array_size(file, *layout.origins));
    LODE_CHECK(write_places(file, surface, surface.origins));
  }
  LODE_CHECK(write_optional(file, layout.errors, surface.errors));
  LODE_CHECK(write_array_size(file, layout.points));
  return write_places(file, surface, surface.positions);
}

/// Connectivity and offsets, as T where the indices are not already so in memory.
template <typename T>
Result<void> write_cell_arrays(SurfaceOutput& file, const Surface& surface,
                               const VtpLayout& layout) {
  const std::size_t n_corners = corners_per_cell(surface);
  LODE_CHECK(write_array_size(file, layout.connectivity));
  const auto write_corners = [&](const auto& cells) -> Result<void> {
    if constexpr (sizeof(T) == sizeof(std::uint32_t)) {
      return write_array(file, std::span(cells));
    } else {
      const auto fill = [&](std::size_t i, std::byte* out) {
        for (const std::uint32_t vertex : cells[i]) put(out, T{vertex});
      };
      return write_records(file, cells.size(), n_corners * sizeof(T), fill);
    }
  };
  LODE_CHECK(write_corners(surface.triangles));
  LODE_CHECK(write_corners(surface.lines));
  LODE_CHECK(write_array_size(file, layout.offsets));
  return write_records(file, n_cells(surface), sizeof(T), [&](std::size_t i, std::byte* out) {
    put(out, static_cast<T>((i + 1) * n_corners));
  });
}

}  // namespace

Result<void> write_vtp(const std::string& path, const Surface& surface,
                       const SurfaceWriteOptions& options, Progress& progress) {
  const VtpLayout layout = make_vtp_layout(surface, options);
  LODE_TRY(SurfaceOutput file, SurfaceOutput::create(path, vtp_bytes(layout), progress));
  LODE_CHECK(file.write(vtp_head(surface, options)));
  LODE_CHECK(file.write(vtp_piece(surface, options, layout)));
  LODE_CHECK(write_point_arrays(file, surface, layout));
  LODE_CHECK(needs_wide_indices(surface) ? write_cell_arrays<std::int64_t>(file, surface, layout)
                                         : write_cell_arrays<std::int32_t>(file, surface, layout));
  LODE_CHECK(file.write(std::string_view("\n</AppendedData>\n</VTKFile>\n")));
  return file.commit();
}

}  // namespace lode::io

#include "lode/io/network_vtp.h"

#include <fmt/format.h>

#include <span>

#include "lode/core/expects.h"
#include "lode/io/vtk_xml_output.h"

namespace lode::io {
namespace {

/// The arrays of a file in the order of their data.
struct NetworkLayout {
  VtkXmlArray heights;
  std::vector<VtkXmlArray> columns;
  VtkXmlArray places;
  VtkXmlArray vertices;
  VtkXmlArray vertex_ends;
  VtkXmlArray corners;
  VtkXmlArray line_ends;
};

VtkXmlArray index_array(const char* name, std::uint64_t n) {
  return {fmt::format(R"(type="Int64" Name="{}")", name), n * sizeof(std::int64_t)};
}

NetworkLayout make_network_layout(const Network& network) {
  const std::uint64_t n_cells = network.n_points + network.line_ends.size();
  NetworkLayout layout;
  layout.heights = {R"(type="Float64" Name="height")", network.places.size() * sizeof(double)};
  for (const Network::Column& column : network.columns) {
    LODE_EXPECTS(column.values.size() == n_cells);
    layout.columns.push_back(
        {fmt::format(R"(type="{}" Name="{}")", column.is_integer ? "Int32" : "Float64",
                     vtk_array_name(column.name)),
         n_cells * (column.is_integer ? sizeof(std::int32_t) : sizeof(double))});
  }
  layout.places = {R"(type="Float64" Name="Points" NumberOfComponents="3")",
                   network.places.size() * sizeof(Vec3d)};
  layout.vertices = index_array("connectivity", network.n_points);
  layout.vertex_ends = index_array("offsets", network.n_points);
  layout.corners = index_array("connectivity", network.places.size() - network.n_points);
  layout.line_ends = index_array("offsets", network.line_ends.size());
  return layout;
}

std::string network_head(const Network& network, const NetworkLayout& layout,
                         const std::string& comment) {
  std::string xml = vtk_xml_head("PolyData", comment, Frame::unknown);
  xml += fmt::format(
      "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"{}\" "
      "NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n",
      network.places.size(), network.n_points, network.line_ends.size());
  std::uint64_t offset = 0;
  xml += "<PointData Scalars=\"height\">\n" + describe_array(layout.heights, offset);
  xml += "</PointData>\n<CellData>\n";
  for (const VtkXmlArray& array : layout.columns) xml += describe_array(array, offset);
  xml += "</CellData>\n<Points>\n" + describe_array(layout.places, offset) + "</Points>\n";
  xml += "<Verts>\n" + describe_array(layout.vertices, offset);
  xml += describe_array(layout.vertex_ends, offset) + "</Verts>\n";
  xml += "<Lines>\n" + describe_array(layout.corners, offset);
  xml += describe_array(layout.line_ends, offset) + "</Lines>\n";
  return xml + "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
}

/// number(i) of an array's n numbers.
template <typename T, typename Number>
Result<void> write_numbers(SurfaceOutput& file, const VtkXmlArray& array, const Number& number) {
  LODE_CHECK(write_array_size(file, array));
  return write_records(file, static_cast<std::size_t>(array.n_bytes / sizeof(T)), sizeof(T),
                       [&](std::size_t i, std::byte* out) { put(out, static_cast<T>(number(i))); });
}

Result<void> write_column(SurfaceOutput& file, const VtkXmlArray& array,
                          const Network::Column& column) {
  const auto value = [&](std::size_t i) { return column.values[i]; };
  return column.is_integer ? write_numbers<std::int32_t>(file, array, value)
                           : write_numbers<double>(file, array, value);
}

Result<void> write_network_cells(SurfaceOutput& file, const Network& network,
                                 const NetworkLayout& layout) {
  const auto same = [](std::size_t i) { return i; };
  const auto after = [](std::size_t i) { return i + 1; };
  const auto corner = [&](std::size_t i) { return network.n_points + i; };
  const auto end = [&](std::size_t i) { return network.line_ends[i] - network.n_points; };
  LODE_CHECK(write_numbers<std::int64_t>(file, layout.vertices, same));
  LODE_CHECK(write_numbers<std::int64_t>(file, layout.vertex_ends, after));
  LODE_CHECK(write_numbers<std::int64_t>(file, layout.corners, corner));
  return write_numbers<std::int64_t>(file, layout.line_ends, end);
}

}  // namespace

Result<void> write_network_vtp(const std::string& path, const Network& network,
                               const std::string& comment, Progress& progress) {
  LODE_EXPECTS((network.line_ends.empty() ? network.n_points : network.line_ends.back()) ==
               network.places.size());
  const NetworkLayout layout = make_network_layout(network);
  std::uint64_t n_bytes = layout.heights.n_bytes + layout.places.n_bytes +
                          2 * layout.vertices.n_bytes + layout.corners.n_bytes +
                          layout.line_ends.n_bytes;
  for (const VtkXmlArray& array : layout.columns) n_bytes += array.n_bytes;
  LODE_TRY(SurfaceOutput file, SurfaceOutput::create(path, n_bytes, progress, {1}));
  LODE_CHECK(file.write(network_head(network, layout, comment)));
  LODE_CHECK(write_numbers<double>(file, layout.heights,
                                   [&](std::size_t i) { return network.places[i][2]; }));
  for (std::size_t i = 0; i < layout.columns.size(); ++i)
    LODE_CHECK(write_column(file, layout.columns[i], network.columns[i]));
  LODE_CHECK(write_array_size(file, layout.places));
  LODE_CHECK(write_array(file, std::span<const Vec3d>(network.places)));
  LODE_CHECK(write_network_cells(file, network, layout));
  LODE_CHECK(file.write("\n</AppendedData>\n</VTKFile>\n"));
  return file.commit();
}

}  // namespace lode::io

#include "lode/io/surface_vtp_reader.h"

#include <limits>
#include <memory>
#include <optional>
#include <pugixml.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "lode/io/image.h"
#include "lode/io/surface_input.h"
#include "lode/io/surface_output.h"
#include "lode/io/text.h"
#include "lode/io/vtk_xml_array.h"

namespace lode::io {
namespace {

/// No file has more cells or vertices than 32 bits number.
constexpr std::uint64_t kMaxCount = std::numeric_limits<std::uint32_t>::max();

/// Reads an array of exactly `n` numbers.
Result<std::vector<double>> read_array(const VtkXmlFile& xml, pugi::xml_node array,
                                       std::uint64_t n) {
  const std::string& path = xml.file->path();
  const std::string_view type_name = array.attribute("type").value();
  const std::optional<ScalarType> type = scalar_type_from_name(type_name);
  if (!type) return fail("{}: expected a DataArray of numbers, got {}", path, quoted(type_name));
  if (n == 0) return std::vector<double>{};
  LODE_TRY(const std::unique_ptr<SampleStore> store,
           load_vtk_xml_array(xml, {.node = array, .type = *type, .n_bytes = n * size_of(*type)}));
  return read_doubles(*store, *type, byte_order_of(xml, array), static_cast<std::size_t>(n));
}

Result<std::uint64_t> count_of(const VtkXmlFile& xml, pugi::xml_node piece, const char* name) {
  const std::string_view text = piece.attribute(name).as_string("0");
  const std::optional<std::uint64_t> count = to_uint64(text);
  if (count && *count <= kMaxCount) return *count;
  return fail("{}: expected {} of at most {}, got {}", xml.file->path(), name, kMaxCount,
              quoted(text));
}

pugi::xml_node array_named(pugi::xml_node parent, const char* name) {
  return parent.find_child_by_attribute("DataArray", "Name", name);
}

/// Returns the places that positions do not have exactly.
Result<std::vector<Vec3d>> read_points(const VtkXmlFile& xml, pugi::xml_node data,
                                       Surface& surface) {
  const pugi::xml_node piece = data.child("Piece");
  LODE_TRY(const std::uint64_t n, count_of(xml, piece, "NumberOfPoints"));
  std::vector<Vec3d> world;
  if (n > 0) {
    LODE_TRY(const std::vector<double> values,
             read_array(xml, piece.child("Points").child("DataArray"), 3 * n));
    world.resize(static_cast<std::size_t>(n));
    for (std::size_t i = 0; i < values.size(); ++i) world[i / 3][i % 3] = values[i];
  }
  std::optional<Vec3d> note;
  if (const pugi::xml_node array = array_named(data.child("FieldData"), kOriginNote.data())) {
    LODE_TRY(const std::vector<double> origin, read_array(xml, array, 3));
    note = Vec3d{{origin[0], origin[1], origin[2]}};
  }
  return place_positions(xml.file->path(), std::move(world), note, surface);
}

Result<void> read_point_data(const VtkXmlFile& xml, pugi::xml_node point_data, Surface& surface) {
  const std::size_t n = surface.positions.size();
  const char* normals_name = point_data.attribute("Normals").as_string("Normals");
  if (const pugi::xml_node normals = array_named(point_data, normals_name)) {
    LODE_TRY(const std::vector<double> values, read_array(xml, normals, 3 * n));
    surface.normals.resize(n);
    for (std::size_t i = 0; i < values.size(); ++i)
      surface.normals[i / 3][i % 3] = to_attribute(values[i]);
  }
  if (const pugi::xml_node isovalues = array_named(point_data, "isovalue")) {
    LODE_TRY(const std::vector<double> values, read_array(xml, isovalues, n));
    surface.isovalues = values;
  }
  if (const pugi::xml_node origins = array_named(point_data, "origin")) {
    LODE_TRY(const std::vector<double> values, read_array(xml, origins, 3 * n));
    for (std::size_t i = 0; i < values.size(); i += 3)
      surface.origins.push_back(to_origin({{values[i], values[i + 1], values[i + 2]}}, surface));
  }
  return {};
}

/// The corners of all cells of one kind, one after the other, and where each cell's end.
struct VtpCells {
  std::vector<std::uint32_t> corners;
  std::vector<std::uint32_t> ends;
};

Result<std::vector<std::uint32_t>> read_indices(const VtkXmlFile& xml, pugi::xml_node array,
                                                std::uint64_t n) {
  LODE_TRY(const std::vector<double> values, read_array(xml, array, n));
  std::vector<std::uint32_t> indices;
  indices.reserve(values.size());
  for (const double value : values) {
    const std::optional<std::uint32_t> index = to_index(value);
    if (!index) return fail("{}: expected an index from 0, got {}", xml.file->path(), value);
    indices.push_back(*index);
  }
  return indices;
}

Result<VtpCells> read_cells(const VtkXmlFile& xml, pugi::xml_node node, std::uint64_t count) {
  if (count == 0) return VtpCells{};
  VtpCells cells;
  LODE_TRY(cells.ends, read_indices(xml, array_named(node, "offsets"), count));
  std::uint32_t previous = 0;
  for (const std::uint32_t end : cells.ends) {
    if (end < previous)
      return fail("{}: expected rising offsets in {}, got {} after {}", xml.file->path(),
                  node.name(), end, previous);
    previous = end;
  }
  LODE_TRY(cells.corners, read_indices(xml, array_named(node, "connectivity"), previous));
  return cells;
}

Result<void> read_all_cells(const VtkXmlFile& xml, pugi::xml_node piece, Surface& surface) {
  const std::string& path = xml.file->path();
  LODE_TRY(const std::uint64_t n_strips, count_of(xml, piece, "NumberOfStrips"));
  if (n_strips != 0)
    return fail("{}: expected polygons, got triangle strips, which are not supported", path);
  LODE_TRY(const std::uint64_t n_polygons, count_of(xml, piece, "NumberOfPolys"));
  LODE_TRY(const std::uint64_t n_lines, count_of(xml, piece, "NumberOfLines"));
  LODE_TRY(const VtpCells polygons, read_cells(xml, piece.child("Polys"), n_polygons));
  LODE_TRY(const VtpCells lines, read_cells(xml, piece.child("Lines"), n_lines));
  std::size_t first = 0;
  for (const std::uint32_t end : polygons.ends) {
    LODE_CHECK(
        append_polygon(path, std::span(polygons.corners).subspan(first, end - first), surface));
    first = end;
  }
  first = 0;
  for (const std::uint32_t end : lines.ends) {
    for (std::size_t i = first + 1; i < end; ++i)
      surface.lines.push_back({lines.corners[i - 1], lines.corners[i]});
    first = end;
  }
  return {};
}

}  // namespace

Result<PlacedSurface> read_vtp(const std::string& path) {
  LODE_TRY(const VtkXmlFilePtr xml, open_vtk_xml(path));
  const std::string_view type = xml->root().attribute("type").value();
  if (type != "PolyData")
    return fail("{}: expected VTK XML of type PolyData, got {}", path, quoted(type));
  const pugi::xml_node data = xml->root().child("PolyData");
  const pugi::xml_node piece = data.child("Piece");
  if (!piece || piece.next_sibling("Piece"))
    return fail("{}: expected PolyData of one piece, got {}", path, piece ? "several" : "none");
  Surface surface;
  LODE_TRY(std::vector<Vec3d> places, read_points(*xml, data, surface));
  LODE_CHECK(read_point_data(*xml, piece.child("PointData"), surface));
  LODE_CHECK(read_all_cells(*xml, piece, surface));
  LODE_CHECK(check_surface(path, surface));
  return PlacedSurface{std::move(surface), std::move(places)};
}

}  // namespace lode::io

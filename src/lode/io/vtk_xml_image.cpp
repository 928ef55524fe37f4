#include "lode/io/vtk_xml_image.h"

#include "lode/io/image_grid.h"
#include "lode/io/text.h"
#include "lode/io/vtk_xml_array.h"
#include "lode/io/vtk_xml_extent.h"

namespace lode::io {
namespace {

/// `fallback` where the attribute is missing.
Result<std::vector<double>> xml_numbers(const std::string& path, const pugi::xml_node& node,
                                        const char* name, std::vector<double> fallback) {
  const pugi::xml_attribute attribute = node.attribute(name);
  if (!attribute) return fallback;
  const auto numbers = to_doubles(attribute.as_string());
  if (!numbers || numbers->size() != fallback.size())
    return fail("{}: expected {} numbers for {}, got {}", path, fallback.size(), name,
                in_quotes(attribute.as_string()));
  return *numbers;
}

Result<RegularGrid> image_grid(const std::string& path, const pugi::xml_node& node,
                               const VtkExtent& extent) {
  LODE_TRY(const auto spacing, xml_numbers(path, node, "Spacing", {1, 1, 1}));
  LODE_TRY(const auto origin, xml_numbers(path, node, "Origin", {0, 0, 0}));
  LODE_TRY(const auto direction, xml_numbers(path, node, "Direction", {1, 0, 0, 0, 1, 0, 0, 0, 1}));
  GridFrame frame{.dims = extent.dims};
  Vec3d start;
  for (std::size_t i = 0; i < 3; ++i) {
    frame.spacing[i] = spacing[i];
    frame.direction.rows[i] = {{direction[3 * i], direction[3 * i + 1], direction[3 * i + 2]}};
    start[i] = spacing[i] * static_cast<double>(extent.first[i]);
  }
  // Origin belongs to index (0, 0, 0), which the extent need not contain.
  frame.origin = Vec3d{{origin[0], origin[1], origin[2]}} + frame.direction * start;
  return make_grid(path, frame);
}

Result<ScalarType> type_of(const std::string& path, const pugi::xml_node& array) {
  const char* name = array.attribute("type").as_string();
  const auto type = scalar_type_from_name(name);
  if (!type) return fail("{}: expected an array of a numeric type, got {}", path, in_quotes(name));
  return *type;
}

Result<RegularGrid> rectilinear_grid(const VtkXmlFile& xml, const pugi::xml_node& piece,
                                     const VtkExtent& extent) {
  const std::string& path = xml.file->path();
  RectilinearAxes axes;
  pugi::xml_node array = piece.child("Coordinates").child("DataArray");
  for (std::size_t i = 0; i < 3; ++i, array = array.next_sibling("DataArray")) {
    if (!array) return fail("{}: expected three coordinate arrays, got {}", path, i);
    LODE_TRY(const ScalarType type, type_of(path, array));
    const auto n = static_cast<std::size_t>(extent.dims[i]);
    LODE_TRY(const auto store,
             load_vtk_xml_array(xml, {.node = array, .type = type, .n_bytes = n * size_of(type)}));
    LODE_TRY(axes.positions[i], read_doubles(*store, type, byte_order_of(xml, array), n));
    axes.precisions[i] =
        type == ScalarType::float32 ? AxisPrecision::float32 : AxisPrecision::float64;
  }
  return make_grid(path, axes);
}

Result<ImageField> make_field(const VtkXmlFilePtr& xml, const pugi::xml_node& array,
                              const Index3& dims, const SampleStorage& storage) {
  const std::string& path = xml->file->path();
  ImageField field;
  field.name = array.attribute("Name").as_string();
  LODE_TRY(const ScalarType type, type_of(path, array));
  const auto n_components = to_int64(array.attribute("NumberOfComponents").as_string("1"));
  if (!n_components)
    return fail("{}: expected a number of components, got {}", path,
                in_quotes(array.attribute("NumberOfComponents").as_string()));
  LODE_TRY(field.layout, interleaved_layout(path, dims, type, *n_components, 1));
  field.layout.byte_order = byte_order_of(*xml, array);
  const std::uint64_t n_bytes = field.layout.n_bytes;
  field.load = [xml, array, type, n_bytes, storage] {
    return load_vtk_xml_array(
        *xml, {.node = array, .type = type, .n_bytes = n_bytes, .storage = storage});
  };
  return field;
}

Result<std::vector<ImageField>> make_xml_fields(const VtkXmlFilePtr& xml,
                                                const pugi::xml_node& piece, const Index3& dims,
                                                const SampleStorage& storage) {
  const std::string& path = xml->file->path();
  std::vector<ImageField> fields;
  for (const pugi::xml_node array : piece.child("PointData").children("DataArray")) {
    // Strings and bits ride along in some files; they are no scalars.
    if (!scalar_type_from_name(array.attribute("type").as_string())) continue;
    LODE_TRY(ImageField field, make_field(xml, array, dims, storage));
    fields.push_back(std::move(field));
  }
  if (!fields.empty()) return fields;
  if (piece.child("CellData").child("DataArray"))
    return fail("{}: expected values at points, got only cell data; convert them first", path);
  return fail("{}: expected a numeric array in PointData, got none", path);
}

std::string describe_format(const VtkXmlFile& xml, bool is_image) {
  return fmt::format("VTK XML {}{}", is_image ? "ImageData" : "RectilinearGrid",
                     xml.is_compressed ? ", zlib" : "");
}

}  // namespace

Result<Image> read_vtk_xml_image(const std::string& path, const SampleStorage& storage) {
  LODE_TRY(const VtkXmlFilePtr xml, open_vtk_xml(path, storage));
  const std::string kind = xml->root().attribute("type").as_string();
  if (kind != "ImageData" && kind != "RectilinearGrid")
    return fail("{}: expected ImageData or RectilinearGrid, got {}", path, in_quotes(kind));
  const bool is_image = kind == "ImageData";
  const pugi::xml_node data = xml->root().child(kind.c_str());
  const pugi::xml_node piece = data.child("Piece");
  if (!piece) return fail("{}: expected an element Piece in {}", path, kind);
  if (piece.next_sibling("Piece")) return fail("{}: expected one Piece, got several", path);
  LODE_TRY(const VtkExtent extent,
           parse_vtk_extent(path, data.attribute("WholeExtent").as_string()));
  LODE_TRY(const VtkExtent own, parse_vtk_extent(path, piece.attribute("Extent").as_string()));
  if (own.first != extent.first || own.dims != extent.dims)
    return fail("{}: expected a Piece with the whole extent {}, got {}", path,
                in_quotes(data.attribute("WholeExtent").as_string()),
                in_quotes(piece.attribute("Extent").as_string()));
  Image image{.path = path,
              .format = describe_format(*xml, is_image),
              .frame_note = "VTK files name no frame",
              .grid = {},
              .fields = {},
              .tally = xml->file->tally()};
  LODE_TRY(image.grid,
           is_image ? image_grid(path, data, extent) : rectilinear_grid(*xml, piece, extent));
  LODE_TRY(image.fields, make_xml_fields(xml, piece, extent.dims, storage));
  return image;
}

}  // namespace lode::io

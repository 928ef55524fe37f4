#include "lode/io/mesh_vtk_xml_arrays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "lode/io/text.h"

namespace lode::io {
namespace {

Result<int> n_components_of(const std::string& path, const pugi::xml_node& array) {
  const char* text = array.attribute("NumberOfComponents").as_string("1");
  const std::optional<std::int64_t> n = to_int64(text);
  if (n && *n >= 1 && *n <= std::numeric_limits<int>::max()) return static_cast<int>(*n);
  return fail("{}: expected a number of components from 1 for the array {}, got {}", path,
              in_quotes(array.attribute("Name").as_string()), in_quotes(text));
}

Result<MeshField> load_xml_field(VtkXmlMeshFile& file, const pugi::xml_node& array,
                                 std::uint64_t n_tuples) {
  MeshField field{.name = array.attribute("Name").as_string(), .values = {}};
  LODE_TRY(field.n_components, n_components_of(file.path(), array));
  field.type = *scalar_type_from_name(array.attribute("type").as_string());
  if (n_tuples == 0) return field;
  const std::array<std::int64_t, 2> counts = {static_cast<std::int64_t>(n_tuples),
                                              field.n_components};
  LODE_TRY(const std::uint64_t n, checked_n_bytes(file.path(), counts, 1));
  LODE_TRY(const MeshNumbers numbers, load_xml_numbers(file, array, n));
  field.values = as_doubles(numbers);
  return field;
}

/// Pieces have the same ones.
void note_skipped(VtkXmlMeshFile& file, const pugi::xml_node& array) {
  const std::string name = array.attribute("Name").as_string();
  std::vector<std::string>& names = file.skipped_arrays;
  if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end())
    names.push_back(name);
}

/// Characters' codes, which VTK writes as numbers with a sign.
std::string characters_in(std::string_view text) {
  std::string characters;
  for (const std::string_view word : split_words(text)) {
    const auto code = to_int64(word);
    if (!code || *code < -128 || *code > 255) break;
    characters += static_cast<char>(*code);
  }
  return characters;
}

/// The strings in an Array, each up to a 0.
Result<std::vector<std::string>> load_xml_strings(VtkXmlMeshFile& file,
                                                  const pugi::xml_node& array) {
  std::string characters = characters_in(array.child_value());
  if (std::string_view(array.attribute("format").as_string("ascii")) != "ascii") {
    LODE_TRY(const std::uint64_t n, encoded_size(*file.xml, array));
    LODE_CHECK(file.budget.spend(file.path(), n));
    characters.assign(static_cast<std::size_t>(n), '\0');
    if (n > 0) {
      LODE_TRY(const auto store, load_vtk_xml_array(*file.xml, {.node = array, .n_bytes = n}));
      LODE_CHECK(store->read(0, std::as_writable_bytes(std::span(characters))));
    }
  }
  std::vector<std::string> strings;
  for (std::size_t at = 0, end = 0; (end = characters.find('\0', at)) != std::string::npos;
       at = end + 1)
    strings.push_back(characters.substr(at, end - at));
  return strings;
}

/// What a data set's KINDIds and KINDNames tell.
template <typename Named>
Result<std::vector<Named>> load_xml_names(VtkXmlMeshFile& file, const pugi::xml_node& data,
                                          const std::string& kind) {
  const pugi::xml_node fields = data.child("FieldData");
  const std::string ids_name = kind + "Ids";
  const pugi::xml_node ids = find_array(fields, ids_name.c_str());
  const pugi::xml_node names =
      fields.find_child_by_attribute("Array", "Name", (kind + "Names").c_str());
  std::vector<Named> found;
  if (!ids || !names) return found;
  LODE_TRY(const std::vector<std::string> strings, load_xml_strings(file, names));
  const auto n = to_uint64(ids.attribute("NumberOfTuples").as_string());
  if (!n || *n != strings.size()) {
    file.skipped_arrays.push_back(fmt::format("{}Names ({} for {} numbers)", kind, strings.size(),
                                              n ? std::to_string(*n) : "an unknown count of"));
    return found;
  }
  LODE_TRY(const MeshNumbers numbers, load_xml_numbers(file, ids, *n));
  LODE_TRY(const std::vector<std::int64_t> whole,
           as_whole<std::int64_t>(numbers, {.path = file.path(),
                                            .name = ids_name,
                                            .low = std::numeric_limits<std::int64_t>::min(),
                                            .high = std::numeric_limits<std::int64_t>::max()}));
  for (std::size_t i = 0; i < strings.size(); ++i) found.push_back({whole[i], strings[i]});
  return found;
}

}  // namespace

pugi::xml_node find_array(const pugi::xml_node& parent, const char* name) {
  return parent.find_child_by_attribute("DataArray", "Name", name);
}

Result<MeshNumbers> load_xml_numbers(VtkXmlMeshFile& file, const pugi::xml_node& array,
                                     std::uint64_t n) {
  const char* type_name = array.attribute("type").as_string();
  const std::optional<ScalarType> type = scalar_type_from_name(type_name);
  if (!type)
    return fail("{}: expected a DataArray of numbers, got {}", file.path(), in_quotes(type_name));
  if (n == 0) return MeshNumbers{.type = *type, .bytes = {}};
  const std::array<std::int64_t, 1> counts = {static_cast<std::int64_t>(n)};
  LODE_TRY(const std::uint64_t n_bytes, checked_n_bytes(file.path(), counts, size_of(*type)));
  LODE_CHECK(file.budget.spend(file.path(), n_bytes));
  LODE_TRY(const auto store,
           load_vtk_xml_array(*file.xml, {.node = array, .type = *type, .n_bytes = n_bytes}));
  return read_numbers(*store, *type, byte_order_of(*file.xml, array), n);
}

Result<std::vector<Vec3d>> load_xml_points(VtkXmlMeshFile& file, const pugi::xml_node& piece,
                                           std::uint64_t n) {
  std::vector<Vec3d> points;
  if (n == 0) return points;
  const pugi::xml_node array = piece.child("Points").child("DataArray");
  if (!array) return fail("{}: expected a DataArray in Points, got none", file.path());
  LODE_TRY(const int n_components, n_components_of(file.path(), array));
  if (n_components != 3)
    return fail("{}: expected points of 3 components, got {}", file.path(), n_components);
  LODE_TRY(const MeshNumbers numbers, load_xml_numbers(file, array, 3 * n));
  const std::vector<double> values = as_doubles(numbers);
  points.resize(static_cast<std::size_t>(n));
  for (std::size_t i = 0; i < values.size(); ++i) points[i / 3][i % 3] = values[i];
  return points;
}

Result<std::vector<MeshField>> load_xml_fields(VtkXmlMeshFile& file, const pugi::xml_node& data,
                                               std::uint64_t n_tuples) {
  std::vector<MeshField> fields;
  for (const pugi::xml_node array : data.children()) {
    if (std::string_view(array.name()) == "Array" ||
        !scalar_type_from_name(array.attribute("type").as_string())) {
      note_skipped(file, array);
      continue;
    }
    if (std::string_view(array.name()) != "DataArray") continue;
    LODE_TRY(MeshField field, load_xml_field(file, array, n_tuples));
    fields.push_back(std::move(field));
  }
  return fields;
}

Result<std::vector<BoundaryPatch>> load_xml_patch_names(VtkXmlMeshFile& file,
                                                        const pugi::xml_node& data) {
  return load_xml_names<BoundaryPatch>(file, data, "Patch");
}

Result<std::vector<MeshRegion>> load_xml_region_names(VtkXmlMeshFile& file,
                                                      const pugi::xml_node& data) {
  return load_xml_names<MeshRegion>(file, data, "Region");
}

Result<std::optional<double>> load_xml_time(VtkXmlMeshFile& file, const pugi::xml_node& data) {
  const pugi::xml_node array = find_array(data.child("FieldData"), "TimeValue");
  const auto n_tuples = to_uint64(array.attribute("NumberOfTuples").as_string("1"));
  LODE_TRY(const int n_components, n_components_of(file.path(), array));
  if (!array || n_tuples != 1 || n_components != 1) return std::optional<double>();
  LODE_TRY(const MeshNumbers numbers, load_xml_numbers(file, array, 1));
  const double time = as_doubles(numbers)[0];
  if (std::isfinite(time)) return std::optional(time);
  return fail("{}: expected a finite TimeValue, got {}", file.path(), time);
}

}  // namespace lode::io

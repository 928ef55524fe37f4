#include "lode/io/surface_ply_reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "lode/core/scalar_type.h"
#include "lode/io/surface_input.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

enum class PlyEncoding : std::uint8_t { ascii, little_endian, big_endian };

struct PlyProperty {
  std::string name;
  ScalarType type = ScalarType::uint8;
  std::optional<ScalarType> count_type;  ///< Set for lists.
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::ascii;
  std::vector<PlyElement> elements;
  std::optional<Vec3d> origin_note;
};

Result<PlyProperty> parse_property(const std::string& path, std::string_view line) {
  const std::string_view whole = line;
  PlyProperty property;
  std::string_view type = next_word(line);
  if (type == "list") {
    property.count_type = scalar_type_from_name(next_word(line));
    if (!property.count_type || is_floating(*property.count_type))
      return fail("{}: expected an integer type for a list's count, got {}", path, quoted(whole));
    type = next_word(line);
  }
  const std::optional<ScalarType> known = scalar_type_from_name(type);
  property.name = next_word(line);
  if (!known || property.name.empty())
    return fail("{}: expected a PLY property's type and name, got {}", path, quoted(whole));
  property.type = *known;
  return property;
}

Result<PlyEncoding> parse_ply_encoding(const std::string& path, std::string_view line) {
  const std::string_view name = next_word(line);
  if (name == "ascii") return PlyEncoding::ascii;
  if (name == "binary_little_endian") return PlyEncoding::little_endian;
  if (name == "binary_big_endian") return PlyEncoding::big_endian;
  return fail("{}: expected PLY format ascii, binary_little_endian or binary_big_endian, got {}",
              path, quoted(name));
}

Result<PlyElement> parse_element(const std::string& path, std::string_view line) {
  const std::string_view whole = line;
  PlyElement element;
  element.name = next_word(line);
  const std::optional<std::uint64_t> count = to_uint64(next_word(line));
  if (!count)
    return fail("{}: expected a PLY element's name and count, got {}", path, quoted(whole));
  element.count = *count;
  return element;
}

/// Takes the header off `rest`.
Result<PlyHeader> parse_ply_header(const std::string& path, std::string_view& rest) {
  if (next_line(rest) != "ply") return fail("{}: expected \"ply\" as the first line", path);
  PlyHeader header;
  bool has_format = false;
  while (!rest.empty()) {
    std::string_view line = next_line(rest);
    const std::string_view keyword = next_word(line);
    if (keyword == "end_header") {
      if (!has_format) return fail("{}: expected a \"format\" line in the PLY header", path);
      return header;
    }
    if (keyword == "format") {
      LODE_TRY(header.encoding, parse_ply_encoding(path, line));
      has_format = true;
    } else if (keyword == "element") {
      LODE_TRY(PlyElement element, parse_element(path, line));
      header.elements.push_back(std::move(element));
    } else if (keyword == "property" && !header.elements.empty()) {
      LODE_TRY(PlyProperty property, parse_property(path, line));
      header.elements.back().properties.push_back(std::move(property));
    } else if (keyword == "comment") {
      if (const auto note = parse_origin_note(line)) header.origin_note = note;
    } else if (keyword != "obj_info" && !keyword.empty()) {
      return fail("{}: expected a line of a PLY header, got {}", path, quoted(keyword));
    }
  }
  return fail("{}: the PLY header has no \"end_header\"; the file is cut off", path);
}

/// Takes values off the data, in whichever encoding.
class PlyValues {
 public:
  PlyValues(PlyEncoding encoding, std::string_view rest) : encoding_(encoding), rest_(rest) {}

  /// Sets `value` and returns true, or returns false at the end of the data or at a bad word.
  /// Every PLY type but 64-bit integers is exact as a double.
  bool next(ScalarType type, double& value) {
    if (encoding_ == PlyEncoding::ascii) return next_text(type, value);
    return visit_scalar_type(type, [&]<typename T>() { return next_binary<T>(value); });
  }

  /// The fewest bytes that `count` values of a type take.
  [[nodiscard]] std::size_t min_bytes(ScalarType type) const {
    return encoding_ == PlyEncoding::ascii ? 2 : size_of(type);
  }
  /// Bytes left; a last word needs no separator after it, hence the one more.
  [[nodiscard]] std::size_t n_left() const { return rest_.size() + 1; }

 private:
  template <typename T>
  bool next_binary(double& value) {
    std::array<char, sizeof(T)> bytes;
    if (rest_.size() < sizeof(T)) return false;
    std::memcpy(bytes.data(), rest_.data(), sizeof(T));
    rest_.remove_prefix(sizeof(T));
    const bool is_little = encoding_ == PlyEncoding::little_endian;
    if (is_little != (std::endian::native == std::endian::little))
      std::reverse(bytes.begin(), bytes.end());
    value = static_cast<double>(std::bit_cast<T>(bytes));
    return true;
  }

  bool next_text(ScalarType type, double& value) {
    const std::string_view word = next_word(rest_);
    if (type == ScalarType::float32) {
      const std::optional<float> number = to_float(word);
      value = static_cast<double>(number.value_or(0));
      return number.has_value();
    }
    const std::optional<double> number = to_double(word);
    value = number.value_or(0);
    return number.has_value();
  }

  PlyEncoding encoding_;
  std::string_view rest_;
};

/// Reads the elements of one PLY file into a surface.
class PlyParser {
 public:
  PlyParser(const std::string& path, const PlyHeader& header, std::string_view data)
      : path_(path), header_(header), values_(header.encoding, data) {}

  Result<PlacedSurface> parse() {
    for (const PlyElement& element : header_.elements) {
      // No properties, no data, whatever the count.
      if (element.properties.empty()) continue;
      LODE_CHECK(check_count(element));
      if (element.name == "vertex")
        LODE_CHECK(parse_vertices(element));
      else if (element.name == "tristrips")
        return fail("{}: expected faces, got triangle strips, which are not supported", path_);
      else
        LODE_CHECK(parse_cells(element));
    }
    LODE_TRY(std::vector<Vec3d> places,
             place_positions(path_, std::move(world_), header_.origin_note, surface_));
    for (const Vec3d& origin : origins_) surface_.origins.push_back(to_origin(origin, surface_));
    LODE_CHECK(check_surface(path_, surface_));
    return PlacedSurface{std::move(surface_), std::move(places)};
  }

 private:
  /// What a vertex property is for; the numbers index the values of one vertex.
  enum Role : std::size_t { x, y, z, nx, ny, nz, isovalue, ox, oy, oz, ignored, n_roles };

  static Role role_of(std::string_view name) {
    constexpr std::array<std::string_view, ignored> kNames = {
        "x", "y", "z", "nx", "ny", "nz", "isovalue", "origin_x", "origin_y", "origin_z"};
    const auto found = std::find(kNames.begin(), kNames.end(), name);
    return static_cast<Role>(found - kNames.begin());
  }

  Error cut_off(const PlyElement& element, std::uint64_t i) const {
    return fail("{}: expected {} PLY elements \"{}\", but number {} is cut off or no number", path_,
                element.count, element.name, i);
  }

  Result<void> check_count(const PlyElement& element) const {
    std::uint64_t record_bytes = 0;
    for (const PlyProperty& property : element.properties)
      record_bytes += values_.min_bytes(property.count_type.value_or(property.type));
    if (element.count <= values_.n_left() / record_bytes) return {};
    return fail(
        "{}: the header announces {} PLY elements \"{}\" of at least {} bytes, but {} bytes "
        "are left",
        path_, element.count, element.name, record_bytes, values_.n_left() - 1);
  }

  Result<void> parse_vertices(const PlyElement& element) {
    std::vector<Role> roles;
    std::array<bool, n_roles> has{};
    for (const PlyProperty& property : element.properties) {
      roles.push_back(property.count_type ? ignored : role_of(property.name));
      has[roles.back()] = true;
    }
    if (!has[x] || !has[y] || !has[z])
      return fail("{}: expected properties x, y and z of the PLY element \"vertex\"", path_);
    if (!world_.empty()) return fail("{}: expected one PLY element \"vertex\", got more", path_);
    const bool has_normals = has[nx] && has[ny] && has[nz];
    const bool has_origins = has[ox] && has[oy] && has[oz];
    reserve_vertices(element.count, has_normals, has[isovalue]);
    std::array<double, n_roles> values{};
    for (std::uint64_t i = 0; i < element.count; ++i) {
      for (std::size_t k = 0; k < roles.size(); ++k) {
        const PlyProperty& property = element.properties[k];
        const bool is_read = property.count_type ? read_list(property)
                                                 : values_.next(property.type, values[roles[k]]);
        if (!is_read) return cut_off(element, i);
      }
      world_.push_back({{values[x], values[y], values[z]}});
      if (has_normals)
        surface_.normals.push_back(
            {{to_attribute(values[nx]), to_attribute(values[ny]), to_attribute(values[nz])}});
      if (has[isovalue]) surface_.isovalues.push_back(values[isovalue]);
      if (has_origins) origins_.push_back({{values[ox], values[oy], values[oz]}});
    }
    return {};
  }

  void reserve_vertices(std::size_t n, bool has_normals, bool has_isovalues) {
    world_.reserve(n);
    if (has_normals) surface_.normals.reserve(n);
    if (has_isovalues) surface_.isovalues.reserve(n);
  }

  /// Reads a list into list_; false when the data end or it is too long for them.
  bool read_list(const PlyProperty& property) {
    double value = 0;
    if (!values_.next(*property.count_type, value)) return false;
    const std::optional<std::uint32_t> n = to_index(value);
    if (!n || *n > values_.n_left() / values_.min_bytes(property.type)) return false;
    list_.resize(*n);
    for (double& entry : list_)
      if (!values_.next(property.type, entry)) return false;
    return true;
  }

  /// Faces, edges, and anything else, whose values are only stepped over.
  Result<void> parse_cells(const PlyElement& element) {
    const bool is_face = element.name == "face";
    const bool is_edge = element.name == "edge";
    if (is_face) surface_.triangles.reserve(element.count);
    for (std::uint64_t i = 0; i < element.count; ++i) {
      std::array<double, 2> ends{-1, -1};
      for (const PlyProperty& property : element.properties) {
        double value = 0;
        const bool is_read =
            property.count_type ? read_list(property) : values_.next(property.type, value);
        if (!is_read) return cut_off(element, i);
        const std::string& name = property.name;
        if (is_edge && name == "vertex1") ends[0] = value;
        if (is_edge && name == "vertex2") ends[1] = value;
        if (is_face && (name == "vertex_indices" || name == "vertex_index") && property.count_type)
          LODE_CHECK(append_face(i));
      }
      if (is_edge) LODE_CHECK(append_edge(ends, i));
    }
    return {};
  }

  Result<void> append_face(std::uint64_t i) {
    corners_.clear();
    for (const double entry : list_) {
      const std::optional<std::uint32_t> corner = to_index(entry);
      if (!corner)
        return fail("{}: face {} names vertex {}, expected a number from 0", path_, i, entry);
      corners_.push_back(*corner);
    }
    return append_polygon(path_, corners_, surface_);
  }

  Result<void> append_edge(const std::array<double, 2>& ends, std::uint64_t i) {
    const std::optional<std::uint32_t> first = to_index(ends[0]);
    const std::optional<std::uint32_t> second = to_index(ends[1]);
    if (!first || !second)
      return fail("{}: edge {} runs from vertex {} to {}, expected numbers from 0", path_, i,
                  ends[0], ends[1]);
    surface_.lines.push_back({*first, *second});
    return {};
  }

  const std::string& path_;
  const PlyHeader& header_;
  PlyValues values_;
  Surface surface_;
  std::vector<Vec3d> world_;
  std::vector<Vec3d> origins_;  ///< Likewise in world units.
  std::vector<double> list_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

Result<PlacedSurface> read_ply(const std::string& path) {
  LODE_TRY(const SurfaceBytes file, SurfaceBytes::load(path));
  std::string_view rest = file.text();
  LODE_TRY(const PlyHeader header, parse_ply_header(path, rest));
  return PlyParser(path, header, rest).parse();
}

}  // namespace lode::io

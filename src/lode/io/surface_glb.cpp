#include "lode/io/surface_glb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "lode/io/surface_input.h"
#include "lode/io/surface_output.h"

namespace lode::io {
namespace {

using nlohmann::json;

// The numbers that glTF 2.0 and its container define.
constexpr std::uint32_t kGlbMagic = 0x46546c67;
constexpr std::uint32_t kGlbVersion = 2;
constexpr std::uint32_t kJsonChunk = 0x4e4f534a;
constexpr std::uint32_t kBinChunk = 0x004e4942;
constexpr int kGlFloat = 5126;
constexpr int kGlUint32 = 5125;
constexpr int kGlVertexBuffer = 34962;
constexpr int kGlIndexBuffer = 34963;
constexpr int kGlPoints = 0;
constexpr int kGlLines = 1;
constexpr int kGlTriangles = 4;
constexpr std::size_t kChunkHeadBytes = 8;
constexpr std::size_t kFileHeadBytes = 12;
/// Of the outer node, column by column: glTF's up is y, which our z becomes.
constexpr std::array<double, 16> kTurn{1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1};

/// Extras of the inner node.
constexpr const char* kOriginKey = "lode_origin";
constexpr const char* kFirstKey = "lode_first";

/// Where kTurn has what becomes of x, y and z.
constexpr std::array<std::size_t, 3> kAxes{0, 6, 9};

/// Collects the JSON of the arrays, in the order of their data.
struct GlbArrays {
  json accessors = json::array();
  json views = json::array();
  std::uint64_t n_bytes = 0;

  /// Returns the accessor's number.
  std::size_t add(const char* type, int component, std::size_t count, std::size_t bytes,
                  int target) {
    views.push_back(
        {{"buffer", 0}, {"byteOffset", n_bytes}, {"byteLength", bytes}, {"target", target}});
    accessors.push_back({{"bufferView", views.size() - 1},
                         {"componentType", component},
                         {"count", count},
                         {"type", type}});
    n_bytes += bytes;
    return accessors.size() - 1;
  }
};

/// What positions are counted from.
struct NearPositions {
  std::vector<Vec3f> moved{};  ///< Empty: the surface's own.
  Vec3d origin;
  Vec3f first;  ///< The one that moved ones are counted from.

  /// Renderers compute with floats: where a surface lies far from its origin, its vertices are
  /// counted from one of them, if that loses nothing.
  explicit NearPositions(const Surface& surface) : origin(surface.origin) {
    if (surface.positions.empty() || !is_far(surface.positions)) return;
    first = surface.positions.front();
    moved.reserve(surface.positions.size());
    for (const Vec3f& p : surface.positions) {
      Vec3f near;
      for (std::size_t k = 0; k < 3; ++k) {
        const double exact = static_cast<double>(p[k]) - static_cast<double>(first[k]);
        near[k] = static_cast<float>(exact);
        if (static_cast<double>(near[k]) != exact) {
          moved.clear();
          return;
        }
      }
      moved.push_back(near);
    }
    for (std::size_t k = 0; k < 3; ++k) origin[k] += static_cast<double>(first[k]);
  }

  [[nodiscard]] const std::vector<Vec3f>& of(const Surface& surface) const {
    return moved.empty() ? surface.positions : moved;
  }

 private:
  static bool is_far(const std::vector<Vec3f>& positions) {
    constexpr double kFar = 8;
    double extent = 0;
    double largest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] =
          std::ranges::minmax(positions, {}, [&](const Vec3f& p) { return p[k]; });
      extent = std::max(extent, static_cast<double>(high[k]) - static_cast<double>(low[k]));
      largest = std::max(
          {largest, std::abs(static_cast<double>(low[k])), std::abs(static_cast<double>(high[k]))});
    }
    return std::isfinite(largest) && largest > kFar * extent;
  }
};

json describe_point(const Vec3f& p) { return json::array({p[0], p[1], p[2]}); }

void add_bounds(const std::vector<Vec3f>& positions, json& accessor) {
  Vec3f lower = positions.front();
  Vec3f upper = positions.front();
  for (const Vec3f& p : positions)
    for (std::size_t k = 0; k < 3; ++k) {
      lower[k] = std::min(lower[k], p[k]);
      upper[k] = std::max(upper[k], p[k]);
    }
  accessor["min"] = describe_point(lower);
  accessor["max"] = describe_point(upper);
}

json describe_primitive(const Surface& surface, const NearPositions& near, GlbArrays& arrays) {
  const std::size_t n = surface.positions.size();
  json attributes = json::object();  // of a null that cannot become one, destruction would crash
  attributes["POSITION"] = arrays.add("VEC3", kGlFloat, n, n * sizeof(Vec3f), kGlVertexBuffer);
  add_bounds(near.of(surface), arrays.accessors[0]);
  if (!surface.normals.empty())
    attributes["NORMAL"] = arrays.add("VEC3", kGlFloat, n, n * sizeof(Vec3f), kGlVertexBuffer);
  if (!surface.isovalues.empty())
    attributes["_ISOVALUE"] = arrays.add("SCALAR", kGlFloat, n, n * sizeof(float), kGlVertexBuffer);
  json primitive = {{"attributes", attributes}, {"mode", kGlPoints}};
  const std::size_t n_indices = 3 * surface.triangles.size() + 2 * surface.lines.size();
  if (n_indices > 0) {
    primitive["indices"] = arrays.add("SCALAR", kGlUint32, n_indices,
                                      n_indices * sizeof(std::uint32_t), kGlIndexBuffer);
    primitive["mode"] = surface.lines.empty() ? kGlTriangles : kGlLines;
  }
  return primitive;
}

/// The JSON chunk, padded to whole words as the container demands; sets the size of the data.
std::string describe(const Surface& surface, const NearPositions& near,
                     const SurfaceWriteOptions& options, std::uint64_t& n_bytes) {
  std::array<double, 16> matrix = kTurn;
  for (std::size_t i = 0; i < 3; ++i) matrix[kAxes[i]] *= options.metres[i];
  const json outer = {{"name", options.node_name.empty() ? "isosurface" : options.node_name},
                      {"matrix", matrix},
                      {"children", json::array({1})}};
  json node = json::object();
  if (near.origin != Vec3d{{0, 0, 0}})
    node["translation"] = {near.origin[0], near.origin[1], near.origin[2]};
  // What reading puts back, as rounding is that of the surface's own positions.
  if (!near.moved.empty())
    node["extras"] = {{kOriginKey, {surface.origin[0], surface.origin[1], surface.origin[2]}},
                      {kFirstKey, {near.first[0], near.first[1], near.first[2]}}};
  json document = {
      {"asset",
       {{"version", "2.0"},
        {"generator", "lode"},
        {"extras", {{"comment", options.comment}, {"frame", name_of(options.frame)}}}}},
      {"scene", 0},
      {"scenes", json::array({{{"nodes", json::array({0})}}})}};
  if (!surface.positions.empty()) {
    GlbArrays arrays;
    const json primitives = json::array({describe_primitive(surface, near, arrays)});
    document["meshes"] = json::array({{{"primitives", primitives}}});
    document["accessors"] = arrays.accessors;
    document["bufferViews"] = arrays.views;
    document["buffers"] = json::array({{{"byteLength", arrays.n_bytes}}});
    node["mesh"] = 0;
    n_bytes = arrays.n_bytes;
  }
  document["nodes"] = json::array({outer, node});
  // Comments may hold any bytes; those that are no UTF-8 are replaced, not thrown at.
  std::string text = document.dump(-1, ' ', false, json::error_handler_t::replace);
  text.resize((text.size() + 3) / 4 * 4, ' ');
  return text;
}

Result<void> write_words(SurfaceOutput& file, std::initializer_list<std::uint64_t> words) {
  for (const std::uint64_t word : words) {
    const auto narrow = static_cast<std::uint32_t>(word);
    LODE_CHECK(file.write(std::as_bytes(std::span(&narrow, 1))));
  }
  return {};
}

Error not_ours(const std::string& path, std::string_view expected) {
  return fail("{}: expected glTF as Lode writes it: {}", path, expected);
}

/// The JSON and the data of a .glb file.
struct GlbChunks {
  std::string_view json_text;
  std::span<const std::byte> data;
};

Result<GlbChunks> split_chunks(const std::string& path, const SurfaceBytes& file) {
  const std::span<const std::byte> bytes = file.bytes();
  const auto word = [&](std::size_t offset) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + offset, sizeof(value));
    return value;
  };
  constexpr std::size_t kJsonStart = kFileHeadBytes + kChunkHeadBytes;
  if (bytes.size() < kJsonStart || word(0) != kGlbMagic || word(4) != kGlbVersion)
    return fail("{}: expected a binary glTF 2 file (starting with \"glTF\")", path);
  if (word(8) != bytes.size())
    return fail("{}: the header announces {} bytes, but the file has {}", path, word(8),
                bytes.size());
  const std::size_t json_bytes = word(kFileHeadBytes);
  if (word(kFileHeadBytes + 4) != kJsonChunk || json_bytes > bytes.size() - kJsonStart)
    return fail("{}: expected a JSON chunk inside the file, got one of {} bytes", path, json_bytes);
  GlbChunks chunks{file.text().substr(kJsonStart, json_bytes), {}};
  const std::size_t bin = kJsonStart + json_bytes;
  if (bytes.size() - bin < kChunkHeadBytes) return chunks;
  const std::size_t data_bytes = word(bin);
  if (word(bin + 4) != kBinChunk || data_bytes > bytes.size() - bin - kChunkHeadBytes)
    return fail("{}: expected a BIN chunk inside the file, got one of {} bytes", path, data_bytes);
  chunks.data = bytes.subspan(bin + kChunkHeadBytes, data_bytes);
  return chunks;
}

const json* member(const json& object, const char* key) {
  const auto found = object.find(key);
  return object.is_object() && found != object.end() ? &*found : nullptr;
}

/// The only entry of an array of one.
const json* only_entry(const json* array) {
  return array != nullptr && array->is_array() && array->size() == 1 ? &array->front() : nullptr;
}

/// An unsigned member, or `fallback`; nothing when it is something else.
std::optional<std::uint64_t> number(const json& object, const char* key,
                                    std::optional<std::uint64_t> fallback = std::nullopt) {
  const json* value = member(object, key);
  if (value == nullptr) return fallback;
  if (!value->is_number_unsigned()) return std::nullopt;
  return value->get<std::uint64_t>();
}

/// The entry of document[list] that object[key] numbers.
const json* referred(const json& document, const char* list, const json& object, const char* key) {
  const json* entries = member(document, list);
  const std::optional<std::uint64_t> index = number(object, key);
  if (entries == nullptr || !entries->is_array() || !index || *index >= entries->size())
    return nullptr;
  return &(*entries)[static_cast<std::size_t>(*index)];
}

/// Copies the array that object[key] numbers: `component` values, `type` of them an entry, each
/// entry a T.
template <typename T>
Result<std::vector<T>> copy_array(const std::string& path, const json& document,
                                  std::span<const std::byte> data, const json& object,
                                  const char* key) {
  constexpr bool is_index = std::is_same_v<T, std::uint32_t>;
  const Error error = not_ours(path, fmt::format("a plain array {} inside the file", key));
  const json* accessor = referred(document, "accessors", object, key);
  if (accessor == nullptr || member(*accessor, "sparse") != nullptr) return error;
  const json* view = referred(document, "bufferViews", *accessor, "bufferView");
  if (view == nullptr || number(*view, "buffer") != 0U) return error;
  const json* type = member(*accessor, "type");
  // Comparing JSON itself with a text would end the program where there is no memory for it.
  const auto* const name = type == nullptr ? nullptr : type->get_ptr<const json::string_t*>();
  if (name == nullptr || *name != (sizeof(T) == sizeof(Vec3f) ? "VEC3" : "SCALAR")) return error;
  if (number(*accessor, "componentType") != std::uint64_t{is_index ? kGlUint32 : kGlFloat})
    return error;
  if (number(*view, "byteStride", sizeof(T)) != sizeof(T)) return error;
  const auto view_offset = number(*view, "byteOffset", 0);
  const auto view_bytes = number(*view, "byteLength");
  const auto offset = number(*accessor, "byteOffset", 0);
  const auto count = number(*accessor, "count");
  if (!view_offset || !view_bytes || !offset || !count) return error;
  if (*view_offset > data.size() || *view_bytes > data.size() - *view_offset) return error;
  if (*offset > *view_bytes || *count > (*view_bytes - *offset) / sizeof(T)) return error;
  std::vector<T> values(static_cast<std::size_t>(*count));
  const std::size_t start = static_cast<std::size_t>(*view_offset + *offset);
  if (!values.empty()) std::memcpy(values.data(), data.data() + start, values.size() * sizeof(T));
  return values;
}

template <std::size_t N>
Result<void> fill_cells(const std::string& path, const std::vector<std::uint32_t>& indices,
                        std::vector<std::array<std::uint32_t, N>>& cells) {
  if (indices.size() % N != 0)
    return fail("{}: expected {} indices per cell, got {} indices", path, N, indices.size());
  cells.resize(indices.size() / N);
  for (std::size_t i = 0; i < indices.size(); ++i) cells[i / N][i % N] = indices[i];
  return {};
}

Result<void> read_primitive(const std::string& path, const json& document,
                            std::span<const std::byte> data, const json& primitive,
                            Surface& surface) {
  const json* attributes = member(primitive, "attributes");
  if (attributes == nullptr) return not_ours(path, "a primitive with attributes");
  LODE_TRY(surface.positions, copy_array<Vec3f>(path, document, data, *attributes, "POSITION"));
  if (member(*attributes, "NORMAL") != nullptr) {
    LODE_TRY(surface.normals, copy_array<Vec3f>(path, document, data, *attributes, "NORMAL"));
  }
  if (member(*attributes, "_ISOVALUE") != nullptr) {
    LODE_TRY(const std::vector<float> narrow,
             copy_array<float>(path, document, data, *attributes, "_ISOVALUE"));
    surface.isovalues.assign(narrow.begin(), narrow.end());
  }
  const std::optional<std::uint64_t> mode = number(primitive, "mode", kGlTriangles);
  if (mode == std::uint64_t{kGlPoints} && member(primitive, "indices") == nullptr) return {};
  if (mode != std::uint64_t{kGlTriangles} && mode != std::uint64_t{kGlLines})
    return not_ours(path, "a primitive of mode 0, 1 or 4");
  LODE_TRY(const std::vector<std::uint32_t> indices,
           copy_array<std::uint32_t>(path, document, data, primitive, "indices"));
  if (mode == std::uint64_t{kGlTriangles}) return fill_cells(path, indices, surface.triangles);
  return fill_cells(path, indices, surface.lines);
}

/// The node with the mesh, in the one that turns it and may enlarge it.
Result<const json*> inner_node(const std::string& path, const json& document) {
  const json* nodes = member(document, "nodes");
  if (nodes == nullptr || !nodes->is_array() || nodes->size() != 2 || !nodes->back().is_object())
    return not_ours(path, "two nodes");
  const json* matrix = member(nodes->front(), "matrix");
  if (matrix == nullptr || !matrix->is_array() || matrix->size() != kTurn.size())
    return not_ours(path, "a node with a matrix");
  for (std::size_t i = 0; i < kTurn.size(); ++i) {
    const bool is_axis = std::ranges::find(kAxes, i) != kAxes.end();
    const double value = (*matrix)[i].is_number() ? (*matrix)[i].get<double>() : std::nan("");
    if (is_axis ? !(value * kTurn[i] > 0) : value != kTurn[i])
      return not_ours(path, "a node that turns z into y");
  }
  return &nodes->back();
}

Result<Vec3d> read_vector(const std::string& path, const json& array, const std::string& name) {
  Vec3d vector;
  if (!array.is_array() || array.size() != 3) return not_ours(path, name + " of three numbers");
  for (std::size_t k = 0; k < 3; ++k) {
    if (!array[k].is_number()) return not_ours(path, name + " of three numbers");
    vector[k] = array[k].get<double>();
  }
  return vector;
}

/// Positions that were counted from one of them are as they were before, unless what they are
/// relative to was changed since.
Result<void> put_back(const std::string& path, const json& node, Surface& surface) {
  const json* extras = member(node, "extras");
  const json* origin = extras != nullptr ? member(*extras, kOriginKey) : nullptr;
  const json* first = extras != nullptr ? member(*extras, kFirstKey) : nullptr;
  if (origin == nullptr || first == nullptr) return {};
  LODE_TRY(const Vec3d before, read_vector(path, *origin, kOriginKey));
  LODE_TRY(const Vec3d from, read_vector(path, *first, kFirstKey));
  if (surface.origin != before + from) return {};
  surface.origin = before;
  for (Vec3f& p : surface.positions)
    for (std::size_t k = 0; k < 3; ++k)
      p[k] = static_cast<float>(static_cast<double>(p[k]) + from[k]);
  return {};
}

Result<void> read_translation(const std::string& path, const json& node, Surface& surface) {
  for (const char* key : {"matrix", "rotation", "scale", "children"})
    if (member(node, key) != nullptr)
      return not_ours(path, fmt::format("a node without \"{}\"", key));
  const json* translation = member(node, "translation");
  if (translation == nullptr) return {};
  LODE_TRY(surface.origin, read_vector(path, *translation, "a translation"));
  return {};
}

Result<Surface> read_document(const std::string& path, const json& document,
                              std::span<const std::byte> data) {
  LODE_TRY(const json* node, inner_node(path, document));
  Surface surface;
  LODE_CHECK(read_translation(path, *node, surface));
  if (member(*node, "mesh") == nullptr) return surface;
  const json* mesh = referred(document, "meshes", *node, "mesh");
  const json* primitive = mesh == nullptr ? nullptr : only_entry(member(*mesh, "primitives"));
  if (primitive == nullptr) return not_ours(path, "one mesh of one primitive");
  LODE_CHECK(read_primitive(path, document, data, *primitive, surface));
  LODE_CHECK(put_back(path, *node, surface));
  LODE_CHECK(check_surface(path, surface));
  return surface;
}

}  // namespace

Result<void> write_glb(const std::string& path, const Surface& surface,
                       const SurfaceWriteOptions& options, Progress& progress) {
  std::uint64_t n_data_bytes = 0;
  const NearPositions near(surface);
  const std::string text = describe(surface, near, options, n_data_bytes);
  std::uint64_t n_bytes = kFileHeadBytes + kChunkHeadBytes + text.size();
  if (n_data_bytes > 0) n_bytes += kChunkHeadBytes + n_data_bytes;
  if (n_bytes > std::numeric_limits<std::uint32_t>::max())
    return fail(
        "{}: glTF files hold fewer than 2^32 bytes, and this surface takes {}; expected "
        ".ply, .obj or .vtp",
        path, n_bytes);
  LODE_TRY(SurfaceOutput file, SurfaceOutput::create(path, n_bytes, progress, options.threads));
  LODE_CHECK(write_words(file, {kGlbMagic, kGlbVersion, n_bytes, text.size(), kJsonChunk}));
  LODE_CHECK(file.write(text));
  if (n_data_bytes > 0) {
    LODE_CHECK(write_words(file, {n_data_bytes, kBinChunk}));
    LODE_CHECK(write_array(file, std::span(near.of(surface))));
    LODE_CHECK(write_array(file, std::span(surface.normals)));
    std::vector<float> isovalues;  // glTF has no doubles
    isovalues.reserve(surface.isovalues.size());
    for (const double value : surface.isovalues) isovalues.push_back(static_cast<float>(value));
    LODE_CHECK(write_array(file, std::span<const float>(isovalues)));
    LODE_CHECK(write_array(file, std::span(surface.triangles)));
    LODE_CHECK(write_array(file, std::span(surface.lines)));
  }
  return file.commit();
}

Result<Surface> read_glb(const std::string& path) {
  LODE_TRY(const SurfaceBytes file, SurfaceBytes::load(path));
  LODE_TRY(const GlbChunks chunks, split_chunks(path, file));
  const json document = json::parse(chunks.json_text, nullptr, false);
  if (document.is_discarded()) return fail("{}: expected JSON in the first glTF chunk", path);
  try {
    return read_document(path, document, chunks.data);
  } catch (const json::exception& exception) {
    return fail("{}: unexpected glTF content: {}", path, exception.what());
  }
}

}  // namespace lode::io

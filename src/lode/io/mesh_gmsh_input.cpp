#include "lode/io/mesh_gmsh_input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lode/io/mesh_checks.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

Result<void> add_tag(const std::string& path, std::string_view what, std::int64_t tag,
                     std::size_t number, FlatIndex& index) {
  if (number > kMaxMeshCount)
    return fail("{}: expected at most {} {}s, got more", path, kMaxMeshCount, what);
  const auto key = static_cast<std::uint64_t>(tag);
  if (index.find(key) != FlatIndex::kNone)
    return fail("{}: expected each {} once, got the tag {} twice", path, what, tag);
  index.insert(key, static_cast<std::uint32_t>(number));
  return {};
}

Result<void> read_point(GmshInput& input) {
  Vec3d point;
  for (double& x : point.v) {
    LODE_TRY(x, input.real("a coordinate"));
  }
  input.mesh.points.push_back(point);
  return {};
}

/// Nodes as tag and position each.
Result<void> read_listed_nodes(GmshInput& input) {
  LODE_TRY(const std::int64_t n, input.text.whole("a number of nodes"));
  for (std::int64_t i = 0; i < n; ++i) {
    LODE_TRY(const std::int64_t tag, input.whole("a node's tag"));
    LODE_CHECK(add_tag(input.text.path(), "node", tag, input.mesh.points.size(), input.nodes));
    LODE_CHECK(read_point(input));
  }
  return {};
}

/// A block's tags, then its positions, each with the parameters of its entity where it says so.
Result<void> read_node_block(GmshInput& input) {
  LODE_TRY(const std::int64_t dimension, input.whole("an entity's dimension"));
  LODE_TRY([[maybe_unused]] const std::int64_t entity, input.whole("an entity's tag"));
  LODE_TRY(const std::int64_t is_parametric, input.whole("0 or 1"));
  LODE_TRY(const std::int64_t n, input.count("a number of nodes"));
  if (dimension < 0 || dimension > 3 || is_parametric < 0 || is_parametric > 1)
    return fail("{}: expected a block of nodes of a dimension from 0 to 3, got {} and {}",
                input.text.path(), dimension, is_parametric);
  const std::size_t first = input.mesh.points.size();
  for (std::int64_t i = 0; i < n; ++i) {
    LODE_TRY(const std::int64_t tag, input.large("a node's tag"));
    LODE_CHECK(
        add_tag(input.text.path(), "node", tag, first + static_cast<std::size_t>(i), input.nodes));
  }
  for (std::int64_t i = 0; i < n; ++i) {
    LODE_CHECK(read_point(input));
    for (std::int64_t k = 0; k < is_parametric * dimension; ++k) {
      LODE_TRY([[maybe_unused]] const double parameter, input.real("a parameter"));
    }
  }
  return {};
}

/// The physical groups of an entity, and what bounds it.
Result<void> read_entity(std::int64_t dimension, GmshInput& input) {
  LODE_TRY(const std::int64_t tag, input.whole("an entity's tag"));
  for (int i = 0; i < (dimension == 0 ? 3 : 6); ++i) {
    LODE_TRY([[maybe_unused]] const double bound, input.real("an entity's bounds"));
  }
  LODE_TRY(const std::int64_t n_groups, input.count("a number of physical groups"));
  for (std::int64_t i = 0; i < n_groups; ++i) {
    LODE_TRY(const std::int64_t group, input.whole("a physical group"));
    input.groups.try_emplace({dimension, tag}, group);
  }
  if (dimension == 0) return {};
  LODE_TRY(const std::int64_t n_bounding, input.count("a number of bounding entities"));
  for (std::int64_t i = 0; i < n_bounding; ++i) {
    LODE_TRY([[maybe_unused]] const std::int64_t bounding, input.whole("an entity's tag"));
  }
  return {};
}

/// The name, time step and shape that a section of data begins with, as text in all files.
struct GmshDataHead {
  std::string name;
  GmshTime when;
  std::int64_t n_components = 1;
  std::int64_t n = 0;
};

std::string without_quotes(std::string_view line) {
  const bool is_quoted = line.size() >= 2 && line.front() == '"' && line.back() == '"';
  return std::string(is_quoted ? line.substr(1, line.size() - 2) : line);
}

Result<GmshDataHead> read_data_head(MeshText& text) {
  GmshDataHead head;
  LODE_TRY(const std::int64_t n_strings, text.whole("a number of names"));
  for (std::int64_t i = 0; i < n_strings && text.n_left() > 0; ++i) {
    const std::string line = without_quotes(text.line());
    if (i == 0) head.name = line;
  }
  LODE_TRY(const std::int64_t n_reals, text.whole("a number of real tags"));
  for (std::int64_t i = 0; i < n_reals; ++i) {
    LODE_TRY(const double tag, text.real("a real tag"));
    if (i == 0) head.when.time = tag;
  }
  if (!std::isfinite(head.when.time))
    return fail("{}: expected a finite time of {}, got {}", text.path(), in_quotes(head.name),
                head.when.time);
  LODE_TRY(const std::int64_t n_wholes, text.whole("a number of integer tags"));
  std::array<std::int64_t, 3> tags{0, 1, 0};
  for (std::int64_t i = 0; i < n_wholes; ++i) {
    LODE_TRY(const std::int64_t tag, text.whole("an integer tag"));
    if (i < 3) tags[static_cast<std::size_t>(i)] = tag;
  }
  constexpr std::int64_t kMaxComponents = 1 << 16;
  if (n_wholes < 3 || tags[1] < 1 || tags[1] > kMaxComponents || tags[2] < 0)
    return fail("{}: expected a time step, components and a count for {}, got {} and {}",
                text.path(), in_quotes(head.name), tags[1], tags[2]);
  head.when.step = tags[0];
  head.n_components = tags[1];
  head.n = tags[2];
  return head;
}

}  // namespace

Result<std::int64_t> GmshInput::whole(std::string_view what) {
  return is_binary ? text.binary_whole(ScalarType::int32, order) : text.whole(what);
}

Result<std::int64_t> GmshInput::large(std::string_view what) {
  if (is_binary && has_blocks) return text.binary_whole(ScalarType::int64, order);
  return whole(what);
}

Result<std::int64_t> GmshInput::count(std::string_view what) {
  LODE_TRY(const std::int64_t n, large(what));
  if (n >= 0 && std::cmp_less_equal(n, text.n_left())) return n;
  return fail("{}: expected {} that {} bytes can hold, got {}", text.path(), what, text.n_left(),
              n);
}

Result<double> GmshInput::real(std::string_view what) {
  return is_binary ? text.binary_real(order) : text.real(what);
}

Result<void> read_gmsh_format(GmshInput& input) {
  const std::string& path = input.text.path();
  const std::string version(input.text.word());
  LODE_TRY(const std::int64_t form, input.text.whole("0 for text or 1 for binary"));
  LODE_TRY(const std::int64_t n_bytes, input.text.whole("the size of numbers"));
  input.has_blocks = version == "4.1";
  if (!input.has_blocks && version != "2" && !version.starts_with("2."))
    return fail("{}: expected a .msh file of version 2.2 or 4.1, got {}", path, in_quotes(version));
  if (form < 0 || form > 1 || n_bytes != 8)
    return fail("{}: expected text or binary (0 or 1) with numbers of 8 bytes, got {} and {}", path,
                form, n_bytes);
  if (form == 0) return {};
  LODE_TRY(const std::int64_t one, input.text.binary_whole(ScalarType::int32, ByteOrder::little));
  if (one != 1 && one != 1 << 24)
    return fail("{}: expected 1 in the file's byte order, got {}", path, one);
  input.is_binary = true;
  input.order = one == 1 ? ByteOrder::little : ByteOrder::big;
  return {};
}

Result<void> read_gmsh_names(GmshInput& input) {
  MeshText& text = input.text;
  LODE_TRY(const std::int64_t n, text.whole("a number of names"));
  if (n < 0) return fail("{}: expected a number of names >= 0, got {}", text.path(), n);
  for (std::int64_t i = 0; i < n && text.n_left() > 0; ++i) {
    LODE_TRY(const std::int64_t dimension, text.whole("a group's dimension"));
    LODE_TRY(const std::int64_t group, text.whole("a group's number"));
    const std::string name = without_quotes(text.line());
    if (dimension == 2) input.mesh.patch_names.push_back({group, name});
    if (dimension == 3) input.mesh.region_names.push_back({group, name});
  }
  return {};
}

Result<void> read_gmsh_entities(GmshInput& input) {
  std::array<std::int64_t, 4> counts{};
  for (std::int64_t& n : counts) {
    LODE_TRY(n, input.count("a number of entities"));
  }
  for (std::size_t dimension = 0; dimension < 4; ++dimension)
    for (std::int64_t i = 0; i < counts[dimension]; ++i)
      LODE_CHECK(read_entity(static_cast<std::int64_t>(dimension), input));
  return {};
}

Result<void> read_gmsh_nodes(GmshInput& input) {
  if (!input.has_blocks) return read_listed_nodes(input);
  LODE_TRY(const std::int64_t n_blocks, input.count("a number of blocks"));
  for (int i = 0; i < 3; ++i) {
    LODE_TRY([[maybe_unused]] const std::int64_t total, input.large("a number of nodes"));
  }
  for (std::int64_t i = 0; i < n_blocks; ++i) LODE_CHECK(read_node_block(input));
  return {};
}

Result<void> read_gmsh_data(GmshPlace place, GmshInput& input) {
  const bool is_at_nodes = place == GmshPlace::nodes;
  CellMesh& mesh = input.mesh;
  LODE_TRY(const GmshDataHead head, read_data_head(input.text));
  std::vector<MeshField>& fields = is_at_nodes ? mesh.point_fields : mesh.cell_fields;
  const std::size_t n = is_at_nodes ? mesh.points.size() : mesh.n_cells();
  const auto n_components = static_cast<std::size_t>(head.n_components);
  if (static_cast<std::uint64_t>(head.n) > input.text.n_left() / n_components)
    return fail("{}: expected {} values for {} within {} bytes, got fewer", input.text.path(),
                head.n, in_quotes(head.name), input.text.n_left());
  LODE_CHECK(input.budget.spend(input.text.path(), n * n_components * sizeof(double)));
  MeshField field{.name = head.name,
                  .type = ScalarType::float64,
                  .n_components = static_cast<int>(head.n_components),
                  .values = {}};
  field.values.assign(n * n_components, std::numeric_limits<double>::quiet_NaN());
  for (std::int64_t i = 0; i < head.n; ++i) {
    LODE_TRY(const std::int64_t tag, input.whole("a tag"));
    const std::uint32_t at =
        (is_at_nodes ? input.nodes : input.elements).find(static_cast<std::uint64_t>(tag));
    if (at == FlatIndex::kNone)
      return fail("{}: expected values of {} for what the mesh has, got one for the tag {}",
                  input.text.path(), in_quotes(head.name), tag);
    for (std::size_t k = 0; k < n_components; ++k) {
      LODE_TRY(field.values[at * n_components + k], input.real("a value"));
    }
  }
  fields.push_back(std::move(field));
  (is_at_nodes ? input.point_times : input.cell_times).push_back(head.when);
  return {};
}

Result<void> skip_gmsh_data(const std::string& section, GmshInput& input) {
  LODE_TRY(const GmshDataHead head, read_data_head(input.text));
  std::vector<std::string>& skipped = input.mesh.skipped_arrays;
  std::string name = fmt::format("{} ({})", head.name, section);
  if (std::find(skipped.begin(), skipped.end(), name) == skipped.end())
    skipped.push_back(std::move(name));
  return {};
}

}  // namespace lode::io

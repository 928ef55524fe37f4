// Names of dimensions, variables and attributes follow the appendix of EXODUS II: A Finite Element
// Data Model (Schoof and Yarberry, SAND92-2137), and what later versions of its library write.
#include "lode/io/mesh_exodus_output.h"

#include <algorithm>
#include <array>
#include <limits>

#include "lode/io/mesh_blocks.h"
#include "lode/io/mesh_patches.h"
#include "lode/io/netcdf_output.h"
#include "lode/io/vector_arrays.h"
#include "lode/io/vtk_xml_output.h"

namespace lode::io {
namespace {

constexpr std::size_t kNameBytes = 256;  // with the zero that ends it
constexpr std::size_t kLineBytes = 81;

/// An Exodus file's content being put together. What it fills rows from must outlive it.
class ExodusContent {
 public:
  ExodusContent(const SimplexMesh& mesh, const MeshBlocks& blocks, const PatchBlocks& patches)
      : mesh_(mesh), blocks_(blocks), patches_(patches) {}

  void add_head(const MeshWriteOptions& options);
  void add_points();
  void add_blocks();
  void add_side_sets();
  void add_fields(const MeshWriteOptions& options);
  [[nodiscard]] const NetcdfContent& content() const { return content_; }

 private:
  std::uint32_t dimension(std::string name, std::size_t length) {
    content_.dimensions.push_back({std::move(name), static_cast<std::uint32_t>(length)});
    return static_cast<std::uint32_t>(content_.dimensions.size() - 1);
  }
  NetcdfVariable& variable(NetcdfVariable made) {
    content_.variables.push_back(std::move(made));
    return content_.variables.back();
  }
  void add_nodal_values(const MeshWriteOptions& options);
  /// Texts of at most the length of the dimension `length`, with zeros behind them.
  void add_texts(const char* name, std::uint32_t count, std::uint32_t length,
                 std::vector<std::string> texts);
  /// An element variable of each block; `value_of(cell)`.
  template <typename ValueOf>
  void add_element_values(std::size_t number, const ValueOf& value_of);

  const SimplexMesh& mesh_;
  const MeshBlocks& blocks_;
  const PatchBlocks& patches_;
  NetcdfContent content_;
  std::uint32_t name_ = 0;
  std::uint32_t line_ = 0;
  std::uint32_t step_ = 0;
  std::uint32_t axes_ = 0;
  std::uint32_t nodes_ = 0;
  std::uint32_t n_blocks_ = 0;
  std::vector<std::uint32_t> elements_;  ///< By block.
};

void ExodusContent::add_texts(const char* name, std::uint32_t count, std::uint32_t length,
                              std::vector<std::string> texts) {
  const std::size_t n = texts.size();
  const std::size_t n_bytes = content_.dimensions[length].length;
  variable({.name = name,
            .type = NetcdfType::text,
            .dimensions = {count, length},
            .n_rows = n,
            .fill = [texts = std::move(texts), n_bytes](std::size_t i, std::byte* out) {
              std::fill_n(out, n_bytes, std::byte{0});
              std::memcpy(out, texts[i].data(), std::min(texts[i].size(), n_bytes - 1));
            }});
}

/// A text in lines that Exodus can hold.
std::vector<std::string> in_lines(std::string_view text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size(); at += kLineBytes - 1)
    lines.emplace_back(text.substr(at, kLineBytes - 1));
  return lines;
}

void ExodusContent::add_head(const MeshWriteOptions& options) {
  const std::string comment =
      fmt::format("{}; frame {}", to_one_line(options.comment), name_of(options.frame));
  content_.attributes = {{"api_version", 5.1F},
                         {"version", 5.1F},
                         {"floating_point_word_size", 8},
                         {"file_size", 1},
                         {"maximum_name_length", static_cast<std::int32_t>(kNameBytes - 1)},
                         {"title", comment.substr(0, kLineBytes - 1)}};
  dimension("len_string", 33);
  name_ = dimension("len_name", kNameBytes);
  line_ = dimension("len_line", kLineBytes);
  dimension("four", 4);
  step_ = dimension("time_step", 0);
  axes_ = dimension("num_dim", 3);
  std::vector<std::string> lines = in_lines(comment);
  lines.emplace_back("error, of each element: in the unit of the nodal variable");
  add_texts("info_records", dimension("num_info", lines.size()), line_, lines);
  variable({.name = "time_whole",
            .dimensions = {step_},
            .n_rows = 1,
            .fill = [time = options.time.value_or(0)](std::size_t, std::byte* out) {
              put_big(out, time);
            }});
}

void ExodusContent::add_points() {
  add_texts("coor_names", axes_, name_, {"x", "y", "z"});
  if (mesh_.positions.empty()) return;
  nodes_ = dimension("num_nodes", mesh_.positions.size());
  for (std::size_t axis = 0; axis < 3; ++axis)
    variable({.name = std::string("coord") + "xyz"[axis],
              .dimensions = {nodes_},
              .n_rows = mesh_.positions.size(),
              .fill = [this, axis](std::size_t i, std::byte* out) {
                put_big(out, mesh_.positions[i][axis]);
              }});
}

void ExodusContent::add_blocks() {
  const std::span<const MeshBlock> blocks = blocks_.blocks();
  if (blocks.empty()) return;
  const std::size_t n_corners = n_simplex_corners(mesh_);
  dimension("num_elem", mesh_.n_cells());
  n_blocks_ = dimension("num_el_blk", blocks.size());
  const auto add_numbers = [&](const char* name, const auto& number_of) {
    return &variable({.name = name,
                      .type = NetcdfType::int32,
                      .dimensions = {n_blocks_},
                      .n_rows = blocks.size(),
                      .fill = [number_of](std::size_t i, std::byte* out) {
                        put_big(out, std::int32_t{number_of(i)});
                      }});
  };
  add_numbers("eb_status", [](std::size_t) { return 1; });
  add_numbers("eb_prop1", [blocks](std::size_t i) { return blocks[i].tag; })->attributes = {
      {"name", "ID"}};
  std::vector<std::string> names;
  for (const MeshBlock& block : blocks)
    names.push_back(block.name.empty() ? std::string("mesh") : block.name);
  add_texts("eb_names", n_blocks_, name_, names);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    elements_.push_back(dimension(fmt::format("num_el_in_blk{}", b + 1), blocks[b].cells.size()));
    const std::uint32_t corners = dimension(fmt::format("num_nod_per_el{}", b + 1), n_corners);
    variable({.name = fmt::format("connect{}", b + 1),
              .type = NetcdfType::int32,
              .dimensions = {elements_.back(), corners},
              .attributes = {{"elem_type", n_corners == 4 ? "TETRA" : "TRI3"}},
              .n_rows = blocks[b].cells.size(),
              .fill = [this, cells = blocks[b].cells](std::size_t i, std::byte* out) {
                for (const std::uint32_t v : simplex_corners(mesh_, cells[i])) put_big(out, v + 1);
              }});
  }
}

/// A patch is one: elements by their numbers, and which of their sides.
void ExodusContent::add_side_sets() {
  const std::span<const PatchBlock> sets = patches_.blocks();
  if (sets.empty()) return;
  std::vector<std::int32_t> numbers(mesh_.n_cells());
  for (std::size_t i = 0; i < blocks_.cells().size(); ++i)
    numbers[blocks_.cells()[i]] = static_cast<std::int32_t>(i + 1);
  const std::uint32_t n_sets = dimension("num_side_sets", sets.size());
  std::vector<std::string> names;
  for (const PatchBlock& set : sets) names.push_back(set.name);
  const auto add = [&](const std::string& name, std::uint32_t length, std::size_t n,
                       auto number_of) {
    return &variable({.name = name,
                      .type = NetcdfType::int32,
                      .dimensions = {length},
                      .n_rows = n,
                      .fill = [number_of](std::size_t i, std::byte* out) {
                        put_big(out, std::int32_t{number_of(i)});
                      }});
  };
  add("ss_status", n_sets, sets.size(), [](std::size_t) { return 1; });
  add("ss_prop1", n_sets, sets.size(), [sets](std::size_t i) {
    return sets[i].tag;
  })->attributes = {{"name", "ID"}};
  add_texts("ss_names", n_sets, name_, std::move(names));
  for (std::size_t s = 0; s < sets.size(); ++s) {
    const std::span<const std::uint32_t> sides = sets[s].sides;
    const std::uint32_t length = dimension(fmt::format("num_side_ss{}", s + 1), sides.size());
    std::vector<std::int32_t> elements;
    for (const std::uint32_t side : sides)
      elements.push_back(numbers[mesh_.patch_sides[side].cell]);
    add(fmt::format("elem_ss{}", s + 1), length, sides.size(),
        [elements = std::move(elements)](std::size_t i) { return elements[i]; });
    add(fmt::format("side_ss{}", s + 1), length, sides.size(), [this, sides](std::size_t i) {
      // Sides of TETRA have the nodes 1 2 4, 2 3 4, 1 4 3 and 1 3 2.
      constexpr std::array<std::int32_t, 4> kSideAcross{2, 3, 1, 4};
      return kSideAcross[mesh_.patch_sides[sides[i]].corner];
    });
  }
}

template <typename ValueOf>
void ExodusContent::add_element_values(std::size_t number, const ValueOf& value_of) {
  for (std::size_t b = 0; b < elements_.size(); ++b) {
    const std::span<const std::uint32_t> cells = blocks_.blocks()[b].cells;
    variable({.name = fmt::format("vals_elem_var{}eb{}", number, b + 1),
              .dimensions = {step_, elements_[b]},
              .n_rows = cells.size(),
              .fill = [cells, value_of](std::size_t i, std::byte* out) {
                put_big(out, static_cast<double>(value_of(cells[i])));
              }});
  }
}

/// By field, the first one first. Exodus II has scalars alone; readers make a vector of three that
/// are called NAME_x, NAME_y and NAME_z.
std::vector<std::string> names_of_scalars(const std::string& first_field,
                                          std::span<const Attribute> attributes) {
  std::vector<std::string> names{vtk_array_name(first_field)};
  for (const Attribute& attribute : attributes) names.push_back(vtk_array_name(attribute.name));
  for (const ArrayOfFields& array : arrays_of_fields(first_field, attributes)) {
    const auto is_taken = [&](char axis) {
      const std::string name = fmt::format("{}_{}", vtk_array_name(array.name), axis);
      return std::ranges::find(names, name) != names.end();
    };
    if (array.fields.size() != 3 || is_taken('x') || is_taken('y') || is_taken('z')) continue;
    for (std::size_t i = 0; i < 3; ++i)
      names[static_cast<std::size_t>(array.fields[i]) + 1] =
          fmt::format("{}_{}", vtk_array_name(array.name), "xyz"[i]);
  }
  return names;
}

void ExodusContent::add_nodal_values(const MeshWriteOptions& options) {
  std::vector<std::string> names = names_of_scalars(options.value_name, mesh_.attributes);
  std::vector<const std::vector<double>*> fields{&mesh_.values};
  for (const Attribute& attribute : mesh_.attributes) fields.push_back(&attribute.values);
  const std::uint32_t n_names = dimension("num_nod_var", names.size());
  add_texts("name_nod_var", n_names, name_, std::move(names));
  for (std::size_t i = 0; i < fields.size(); ++i)
    variable({.name = fmt::format("vals_nod_var{}", i + 1),
              .dimensions = {step_, nodes_},
              .n_rows = mesh_.values.size(),
              .fill = [values = fields[i]](std::size_t v, std::byte* out) {
                put_big(out, (*values)[v]);
              }});
}

void ExodusContent::add_fields(const MeshWriteOptions& options) {
  if (mesh_.positions.empty()) return;
  add_nodal_values(options);
  if (elements_.empty()) return;
  std::vector<std::string> names{"error"};
  if (!mesh_.regions.empty()) names.emplace_back("RegionId");
  std::vector<const std::vector<float>*> errors;
  for (const Attribute& attribute : mesh_.attributes) {
    if (attribute.errors.empty()) continue;
    names.push_back(vtk_array_name(error_name(attribute)));
    errors.push_back(&attribute.errors);
  }
  const std::uint32_t n_names = dimension("num_elem_var", names.size());
  const std::size_t n_pairs = names.size() * elements_.size();
  add_texts("name_elem_var", n_names, name_, std::move(names));
  variable({.name = "elem_var_tab",
            .type = NetcdfType::int32,
            .dimensions = {n_blocks_, n_names},
            .n_rows = n_pairs,
            .fill = [](std::size_t, std::byte* out) { put_big(out, std::int32_t{1}); }});
  std::size_t number = 0;
  add_element_values(++number, [this](std::uint32_t cell) { return mesh_.errors[cell]; });
  if (!mesh_.regions.empty())
    add_element_values(++number, [this](std::uint32_t cell) { return mesh_.regions[cell]; });
  for (const std::vector<float>* const of_attribute : errors)
    add_element_values(++number,
                       [of_attribute](std::uint32_t cell) { return (*of_attribute)[cell]; });
}

}  // namespace

Result<void> write_exodus_mesh(const std::string& path, const SimplexMesh& mesh,
                               const MeshWriteOptions& options, Progress& progress) {
  constexpr std::size_t kMax = std::numeric_limits<std::int32_t>::max();
  if (mesh.positions.size() >= kMax || mesh.n_cells() >= kMax)
    return fail("{}: expected a mesh that Exodus can number in 32 bits, got {} cells; .vtu can",
                path, mesh.n_cells());
  const MeshBlocks blocks(mesh);
  const PatchBlocks patches(mesh);
  ExodusContent content(mesh, blocks, patches);
  content.add_head(options);
  content.add_points();
  content.add_blocks();
  content.add_side_sets();
  content.add_fields(options);
  LODE_TRY(SurfaceOutput file, SurfaceOutput::create(path, netcdf_data_bytes(content.content()),
                                                     progress, options.threads));
  LODE_CHECK(write_netcdf(path, content.content(), file));
  return file.commit();
}

}  // namespace lode::io

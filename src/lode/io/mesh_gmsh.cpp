#include "lode/io/mesh_gmsh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "lode/io/cell_types.h"
#include "lode/io/mesh_gmsh_input.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

constexpr const char* kRegionField = "RegionId";
constexpr double kMostRegion = 0x1p53;

Result<void> read_section(const std::string& name, GmshInput& input) {
  if (name == "$MeshFormat") return read_gmsh_format(input);
  if (name == "$PhysicalNames") return read_gmsh_names(input);
  if (name == "$Entities" && input.has_blocks) return read_gmsh_entities(input);
  if (name == "$Nodes") return read_gmsh_nodes(input);
  if (name == "$Elements") return read_gmsh_elements(input);
  if (name == "$NodeData") return read_gmsh_data(GmshPlace::nodes, input);
  if (name == "$ElementData") return read_gmsh_data(GmshPlace::elements, input);
  if (name == "$ElementNodeData") return skip_gmsh_data(name, input);
  return {};
}

/// Sections whose counts say all that is in them: what is behind would be lost without a word.
bool is_counted(std::string_view section) {
  return section == "$Nodes" || section == "$Elements" || section == "$NodeData" ||
         section == "$ElementData";
}

/// Goes behind a section's end.
Result<void> end_section(const std::string& name, GmshInput& input) {
  MeshText& text = input.text;
  const std::string end = "$End" + name.substr(1);
  if (is_counted(name)) {
    const std::string_view found = text.word();
    if (found == end) return {};
    return fail("{}: expected {} behind as many as {} says, before byte {}, got {}", text.path(),
                end, name, text.position(), in_quotes(found));
  }
  if (text.skip_past(end)) return {};
  return fail("{}: expected {} behind byte {}, got none", text.path(), end, text.position());
}

/// Names of groups become those of what RegionId numbers them, where all elements of a group have
/// one number there; else they are left out, which is said.
void renumber_names(const std::vector<double>& groups, const std::vector<double>& ids,
                    CellMesh& mesh) {
  std::map<double, std::optional<double>> id_of;  // none: several
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    const auto kind = cell_kind(mesh.types[cell]);
    if (!kind || kind->dimension != 3) continue;
    const auto [at, is_new] = id_of.try_emplace(groups[cell], ids[cell]);
    if (!is_new && at->second != ids[cell]) at->second.reset();
  }
  std::vector<MeshRegion> renamed;
  for (MeshRegion& region : mesh.region_names) {
    const auto at = id_of.find(static_cast<double>(region.id));
    if (at == id_of.end()) continue;
    if (at->second)
      renamed.push_back({static_cast<std::int64_t>(*at->second), std::move(region.name)});
    else
      mesh.skipped_arrays.push_back(
          fmt::format("the name {} of several regions", in_quotes(region.name)));
  }
  mesh.region_names = std::move(renamed);
}

/// Physical groups become the first field, unless values of elements say what RegionId is, in one
/// whole number each: groups cannot have all of these.
void finish_groups(GmshInput& input) {
  std::vector<MeshField>& fields = input.mesh.cell_fields;
  const auto named = std::find_if(fields.begin(), fields.end(), [](const MeshField& field) {
    return field.name == kRegionField && field.n_components == 1 &&
           std::all_of(field.values.begin(), field.values.end(),
                       [](double x) { return x == std::trunc(x) && std::abs(x) <= kMostRegion; });
  });
  const std::vector<double>& groups = input.element_groups;
  if (named != fields.end()) {
    named->type = ScalarType::int64;
    renumber_names(groups, named->values, input.mesh);
  } else if (std::any_of(groups.begin(), groups.end(), [](double group) { return group != 0; })) {
    fields.insert(fields.begin(),
                  {kRegionField, ScalarType::int32, 1, std::move(input.element_groups)});
  }
}

/// Values of elements are as many as these were when their section came.
Result<void> check_field_sizes(const CellMesh& mesh) {
  const auto check = [&](const std::vector<MeshField>& fields, std::size_t n) {
    return std::all_of(fields.begin(), fields.end(), [&](const MeshField& field) {
      return field.values.size() == n * static_cast<std::size_t>(field.n_components);
    });
  };
  if (check(mesh.point_fields, mesh.points.size()) && check(mesh.cell_fields, mesh.n_cells()))
    return {};
  return fail("{}: expected all nodes and elements before their values, got some behind",
              mesh.path);
}

}  // namespace

Result<CellMesh> read_gmsh_mesh(const std::string& path, const MeshReadOptions& options) {
  LODE_TRY(MeshText text, MeshText::open(path, options));
  GmshInput input{.text = std::move(text)};
  input.budget = MeshBudget::of(input.text.n_left(), options.memory_limit);
  input.mesh.path = path;
  input.mesh.begins = {0};
  for (std::string name(input.text.word()); !name.empty(); name = input.text.word()) {
    if (!name.starts_with('$'))
      return fail("{}: expected a section before byte {}, got {}", path, input.text.position(),
                  in_quotes(name));
    LODE_CHECK(read_section(name, input));
    LODE_CHECK(end_section(name, input));
  }
  LODE_CHECK(check_field_sizes(input.mesh));
  LODE_CHECK(choose_gmsh_step(options, input));
  finish_groups(input);
  return std::move(input.mesh);
}

}  // namespace lode::io

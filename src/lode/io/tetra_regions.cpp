#include "lode/io/tetra_regions.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>

#include "lode/core/label.h"
#include "lode/io/cell_types.h"
#include "lode/io/keep_cells.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

/// As plain_name() has them.
constexpr std::array<std::string_view, 9> kRegionNames = {
    "material", "materialid", "regionid",      "objectid", "elementblockid",
    "blockid",  "zoneid",     "gmsh:physical", "medit:ref"};

/// In lower case, without blanks and - _ #, and without an s at the end.
std::string plain_name(std::string_view name) {
  std::string plain = to_lower(name);
  std::erase_if(plain, [](char c) { return c == ' ' || c == '-' || c == '_' || c == '#'; });
  if (plain.ends_with('s')) plain.pop_back();
  return plain;
}

bool is_region_name(std::string_view name) {
  return std::find(kRegionNames.begin(), kRegionNames.end(), plain_name(name)) !=
         kRegionNames.end();
}

/// What is wrong with a field as one of regions; nothing where it can be.
std::optional<std::string> region_fault(const MeshField& field) {
  constexpr double kLimit = 0x1p53;
  if (field.n_components != 1) return fmt::format("{} components", field.n_components);
  for (const double value : field.values)
    if (std::trunc(value) != value || std::abs(value) > kLimit)
      return fmt::format("{}, which is no whole number", value);
  return std::nullopt;
}

/// Those that a message can name.
std::string names_of(const std::vector<MeshField>& fields) {
  constexpr std::size_t kMost = 20;
  std::string names;
  for (std::size_t i = 0; i < std::min(fields.size(), kMost); ++i)
    names += (i > 0 ? ", " : " (") + fields[i].name;
  if (fields.size() > kMost) names += ", ...";
  return names.empty() ? ", of which there is none" : names + ')';
}

}  // namespace

Result<std::size_t> find_regions(const CellMesh& mesh, const TetraOptions& options) {
  const std::vector<MeshField>& fields = mesh.cell_fields;
  const auto place_of = [&](auto&& is_it) {
    return static_cast<std::size_t>(std::find_if(fields.begin(), fields.end(), is_it) -
                                    fields.begin());
  };
  if (!options.region_field) {
    for (const std::string_view name : kRegionNames) {
      const std::size_t at = place_of([&](const MeshField& field) {
        return plain_name(field.name) == name && !region_fault(field);
      });
      if (at < fields.size()) return at;
    }
    return fields.size();
  }
  const std::string& name = *options.region_field;
  const std::size_t at = place_of([&](const MeshField& field) { return field.name == name; });
  if (at == fields.size())
    return fail("{}: expected a field of the cells for regions{}, got {}", mesh.path,
                names_of(fields), in_quotes(name));
  if (const auto fault = region_fault(fields[at]))
    return fail("{}: expected whole numbers of one component for regions in {}, got {}", mesh.path,
                in_quotes(name), *fault);
  return at;
}

std::vector<std::string> find_regions_not_taken(const CellMesh& mesh, std::size_t regions) {
  std::vector<std::string> found;
  for (std::size_t i = 0; i < mesh.cell_fields.size(); ++i) {
    const MeshField& field = mesh.cell_fields[i];
    if (i == regions || !is_region_name(field.name)) continue;
    const auto fault = region_fault(field);
    found.push_back(
        fmt::format("{} ({})", field.name,
                    fault ? *fault : fmt::format("{} is taken", mesh.cell_fields[regions].name)));
  }
  for (const MeshField& field : mesh.point_fields)
    if (is_region_name(field.name)) found.push_back(fmt::format("{} (of points)", field.name));
  return found;
}

std::vector<std::string> names_of_regions(const CellMesh& mesh, std::size_t regions,
                                          std::span<const std::int64_t> ids) {
  if (plain_name(mesh.cell_fields[regions].name) != "regionid") return {};
  std::vector<std::string> found(ids.size());
  bool has_any = false;
  for (const MeshRegion& region : mesh.region_names) {
    const auto at = std::lower_bound(ids.begin(), ids.end(), region.id);
    if (at == ids.end() || *at != region.id || region.name == name_of(MeshRegion{region.id, {}}))
      continue;
    std::string& name = found[static_cast<std::size_t>(at - ids.begin())];
    if (name.empty()) name = to_label(region.name);
    has_any = has_any || !name.empty();
  }
  if (!has_any) found.clear();
  return found;
}

namespace {

/// Of solid cells, ascending.
std::vector<std::int64_t> ids_of_solid(const CellMesh& mesh, std::size_t regions) {
  std::set<std::int64_t> ids;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell)
    if (is_solid(mesh.types[cell]))
      ids.insert(static_cast<std::int64_t>(mesh.cell_fields[regions].values[cell]));
  return {ids.begin(), ids.end()};
}

std::string list_regions(const std::vector<std::int64_t>& ids,
                         const std::vector<std::string>& names) {
  constexpr std::size_t kMostListed = 20;
  std::string list;
  for (std::size_t i = 0; i < ids.size() && i < kMostListed; ++i)
    list += fmt::format("{}{}{}", i > 0 ? ", " : "", ids[i],
                        names.empty() || names[i].empty() ? "" : " (" + names[i] + ')');
  return ids.size() > kMostListed ? list + ", ..." : list;
}

}  // namespace

Result<std::uint64_t> keep_regions(const TetraOptions& options, std::size_t regions,
                                   CellMesh& mesh) {
  if (options.only_regions.empty()) return 0;
  if (regions == mesh.cell_fields.size())
    return fail("{}: expected cells with regions, of which to keep {}, got none", mesh.path,
                in_quotes(options.only_regions.front()));
  const std::vector<std::int64_t> ids = ids_of_solid(mesh, regions);
  const std::vector<std::string> names = names_of_regions(mesh, regions, ids);
  std::set<std::int64_t> wanted;
  for (const std::string& text : options.only_regions) {
    // What is a region's number is no other one's name.
    const auto number = to_int64(text);
    const bool is_number = number && std::binary_search(ids.begin(), ids.end(), *number);
    bool is_found = is_number;
    if (is_number) wanted.insert(*number);
    for (std::size_t i = 0; i < names.size() && !is_number; ++i)
      if (names[i] == text) {
        wanted.insert(ids[i]);
        is_found = true;
      }
    if (!is_found)
      return fail("{}: expected one of its regions ({}), got {}", mesh.path,
                  list_regions(ids, names), in_quotes(text));
  }
  std::vector<std::uint8_t> is_kept(mesh.n_cells(), 1);
  std::uint64_t n_other = 0;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    if (!is_solid(mesh.types[cell])) continue;
    if (wanted.contains(static_cast<std::int64_t>(mesh.cell_fields[regions].values[cell])))
      continue;
    is_kept[cell] = 0;
    ++n_other;
  }
  if (n_other > 0) keep_cells(is_kept, mesh);
  return n_other;
}

}  // namespace lode::io

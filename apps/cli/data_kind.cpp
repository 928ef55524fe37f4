#include "data_kind.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "lode/api/opened_terrain.h"
#include "lode/api/tile_verification.h"
#include "vtk_import.h"

namespace lode::cli {
namespace {

/// The bits 1 << DataKind.
using Kinds = unsigned;
constexpr Kinds kVolume = 1;
constexpr Kinds kMesh = 2;
constexpr Kinds kCells = kVolume | kMesh;
constexpr Kinds kTerrain = 4;
constexpr Kinds kUnlessMesh = kVolume | kTerrain;
constexpr Kinds kUnlessVolume = kMesh | kTerrain;
constexpr Kinds kAll = 7;

/// In sentences, as kDataKinds.
constexpr std::array<const char*, kDataKinds.size()> kDataKindWords{"a volume", "a mesh of cells",
                                                                    "terrain"};

/// What most options of a group are for; of others all kinds have most.
const std::map<std::string, Kinds>& kinds_of_groups() {
  static const std::map<std::string, Kinds> kKinds{
      {"Surface", kVolume},
      {"Simplification", kVolume},
      {"Steps", kVolume},
      {"Moving camera", kCells},
      {"Meshes and sections", kMesh},
      {"Meshes of cells", kMesh},
      {"Reading other formats", kMesh},
      {"Rasters of heights", kTerrain},
      {"Rasters to write (.tif)", kTerrain},
      {"Scattered points", kTerrain},
      {"Heights", kTerrain},
      {"Lines of terrain", kTerrain},
      {"Terrain", kTerrain},
  };
  return kKinds;
}

/// Those that are for others than most of their group.
const std::map<std::string, Kinds>& kinds_of_options() {
  static const std::map<std::string, Kinds> kKinds{
      // Surface
      {"isovalue", kCells},
      {"max-error", kAll},
      {"clip", kAll},
      {"min-component", kCells},
      {"flip", kCells},
      {"normals", kCells},
      // Meshes and sections
      {"mesh", kCells},
      {"section", kCells},
      {"field-range", kCells},
      // Focus and budget
      {"ball", kCells},
      {"half-space", kCells},
      {"max-space-error", kMesh},
      {"max-error-px", kAll},
      {"deadline-ms", kCells},
      {"focus-point", kTerrain},
      {"growth", kTerrain},
      {"exaggeration", kTerrain},
      // Reading other formats
      {"field", kCells},
      {"component", kCells},
      {"time", kCells},
      {"nodata", kUnlessMesh},
      {"dims", kVolume},
      {"type", kVolume},
      {"spacing", kVolume},
      {"origin", kVolume},
      {"byte-order", kVolume},
      {"length-unit", kVolume},
      {"value-unit", kVolume},
      // build
      {"resume", kVolume},
      {"no-resume", kVolume},
      {"base-cells", kMesh},
      {"boundary-tolerance", kMesh},
      {"everywhere", kMesh},
      {"keep-extrema", kMesh},
      {"space-errors", kMesh},
      {"lean", kMesh},
      {"at", kMesh},
      {"levels", kTerrain},
      // extract and verify
      {"salvage", kVolume},
      {"exact", kMesh},
      {"surface", kUnlessMesh},
      {"simplify", kVolume},
      {"max-distance", kVolume},
      {"error-bound", kVolume},
  };
  return kKinds;
}

/// Those that are for others in one command than elsewhere.
std::optional<Kinds> kinds_in_command(const std::string& command, const std::string& name) {
  if (command != "build" && name == "memory-limit") return kVolume;
  if (command != "extract")
    for (const char* const of_volumes : {"clip", "normals", "min-component", "flip"})
      if (name == of_volumes) return kVolume;
  if (command == "verify" && (name == "isovalue" || name == "box")) return kVolume;
  if (command == "verify" && name == "max-error") return kUnlessMesh;
  if (command == "probe" && name == "region") return kMesh;
  if (command != "render") return {};
  if (name == "max-cells") return kUnlessVolume;
  // Pictures of volumes and terrain have no foci.
  for (const char* const of_meshes : {"section", "field-range", "box", "ball", "half-space", "view",
                                      "view-size", "max-error-outside", "deadline-ms"})
    if (name == of_meshes) return kMesh;
  return {};
}

Kinds kinds_of(const CLI::App& app, const CLI::Option& option) {
  const std::string& name = option.get_lnames().front();
  const auto find = [](const std::map<std::string, Kinds>& kinds, const std::string& key) {
    const auto found = kinds.find(key);
    return found == kinds.end() ? std::optional<Kinds>{} : found->second;
  };
  std::optional<Kinds> kinds = kinds_in_command(app.get_name(), name);
  if (!kinds) kinds = find(kinds_of_options(), name);
  if (!kinds) kinds = find(kinds_of_groups(), option.get_group());
  return kinds.value_or(kAll);
}

bool has(Kinds kinds, std::size_t kind) { return (kinds >> kind & 1U) != 0; }

bool is_of(DataKind kind, const CLI::App& app, const CLI::Option& option) {
  return has(kinds_of(app, option), static_cast<std::size_t>(kind));
}

/// What the first positional argument names; empty where it is missing.
std::string first_input(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options())
    if (option->get_positional())
      return option->results().empty() ? std::string() : option->results().front();
  return {};
}

DataKind kind_of(const std::string& path) {
  if (holds_tiles(path) || holds_terrain(path)) return DataKind::terrain;
  return holds_cells(path) ? DataKind::mesh : DataKind::volume;
}

/// "a volume or terrain"
std::string describe(Kinds kinds) {
  std::string text;
  for (std::size_t i = 0; i < kDataKindWords.size(); ++i)
    if (has(kinds, i)) text += (text.empty() ? "" : " or ") + std::string(kDataKindWords.at(i));
  return text;
}

}  // namespace

std::string HelpFooter::text(std::string_view command, std::optional<DataKind> kind) const {
  std::string all;
  std::string examples = "Examples:\n";
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (kind && static_cast<std::size_t>(*kind) != i) continue;
    const std::string_view paragraphs = parts.at(i).text;
    if (!paragraphs.empty()) all += std::string(paragraphs) + '\n';
    examples += parts.at(i).examples;
  }
  all += examples;
  return kind ? fmt::format("{}\nFor all kinds of data: lode {} --help", all, command)
              : fmt::format(
                    "{}\nFor one kind of data alone: lode help {} volume (or mesh, terrain), "
                    "or --help after a FILE",
                    all, command);
}

std::optional<DataKind> find_data_kind(std::string_view name) {
  const auto found = std::ranges::find(kDataKinds, name);
  if (found == kDataKinds.end()) return {};
  return static_cast<DataKind>(found - kDataKinds.begin());
}

std::optional<DataKind> kind_of_input(const CLI::App& app) {
  const std::string path = first_input(app);
  std::error_code error;
  if (path.empty() || !std::filesystem::exists(path, error)) return {};
  return kind_of(path);
}

void show_only(DataKind kind, CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    // Options without a group are hidden.
    if (!option->get_lnames().empty() && !is_of(kind, app, *option)) option->group("");
  }
}

Result<void> check_options(const CLI::App& app) {
  const std::string path = first_input(app);
  if (path.empty()) return {};
  std::optional<DataKind> found;  // The file is looked at if an option asks for it.
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0 || option->get_positional() || kinds_of(app, *option) == kAll)
      continue;
    if (!found) found = kind_of(path);
    const DataKind kind = *found;
    if (is_of(kind, app, *option)) continue;
    // A file that is not there is of no kind.
    if (is_lode_path(path)) LODE_CHECK(check_lode_opens(path));
    return fail("--{}: expected {}, got {}: {} (see lode help {} {})", option->get_lnames().front(),
                describe(kinds_of(app, *option)), kDataKindWords.at(static_cast<std::size_t>(kind)),
                path, app.get_name(), kDataKinds.at(static_cast<std::size_t>(kind)));
  }
  return {};
}

}  // namespace lode::cli

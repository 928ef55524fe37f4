#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>

#include "extract_terrain.h"
#include "terrain_input.h"

namespace lode::cli {

/// What every question to the TIN of a terrain takes, as typed.
struct TerrainQueryArguments {
  std::string input;
  std::string max_error;
  std::string nodata;
  bool is_everywhere = false;      ///< Bounds are to hold between samples, too,
  bool may_be_everywhere = false;  ///< or where all heights are at hand.
  bool is_closed = false;          ///< Of TerrainReadOptions, and the next.
  std::optional<std::array<Place, 2>> way{};
  std::string way_crs{};
  TerrainArguments terrain;
};

/// The terrain, --nodata, and what that use of it has.
void add_terrain_source(CLI::App& app, TerrainQueryArguments& arguments, TerrainUse use);
/// For extraction, with --max-error.
void add_terrain_query(CLI::App& app, TerrainQueryArguments& arguments);
/// --to-crs, for commands that measure distances.
void add_distance_crs(CLI::App& app, TerrainQueryArguments& arguments);
/// --everywhere.
void add_everywhere(CLI::App& app, TerrainQueryArguments& arguments);

/// Looks at the arguments alone. `instead`: what there is for volumes and meshes, or empty.
[[nodiscard]] Result<void> check_terrain_query(const TerrainQueryArguments& arguments,
                                               const std::string& instead);

/// A terrain, and what is wanted of it.
struct TerrainInput {
  OpenedTerrain opened;
  HorizontalMetric metric;  ///< Distances are those of the target, where there is one.
  TerrainOptions options;
  double read_seconds = 0;
  std::optional<TargetCrs> target{};  ///< Of --to-crs.
};

/// A terrain and its TIN.
struct TerrainAnswerer {
  OpenedTerrain opened;
  HorizontalMetric metric;
  TerrainTin tin;
  double read_seconds = 0;
  std::optional<TargetCrs> target{};
};

/// Looks at a terrain before the work starts, and may refuse it.
using AcceptTerrain = std::function<Result<void>(const TerrainFacts&)>;

[[nodiscard]] Result<TerrainInput> read_terrain(const TerrainQueryArguments& arguments,
                                                Session& session);
[[nodiscard]] Result<TerrainAnswerer> answer_terrain(const TerrainQueryArguments& arguments,
                                                     Session& session,
                                                     const AcceptTerrain& accept = {},
                                                     TinUse use = TinUse::all);

/// "everywhere" or "at samples": where the bounds of a TIN hold.
[[nodiscard]] const char* bound_kind_of(const TerrainReport& report);

/// Warns of what heights are taken for, where their unit is not known.
void warn_of_unit(bool is_known, const HeightFrame& frame, const HorizontalMetric& metric,
                  const std::string& path, Session& session);

/// Warns of a way that is straight in the coordinates and goes the long way round the earth, on a
/// raster that has all of it.
void warn_of_long_way(const HorizontalMetric& metric, const HeightFrame& frame, const Place& from,
                      const Place& to, Session& session);

/// The keys and rows that all answers begin with.
void add_terrain_head(const TerrainAnswerer& answerer, const TerrainQueryArguments& arguments,
                      Json& json, Table& table);

/// "metre, on the ellipsoid WGS 84", or what coordinates are in.
/// Where distances are those of --to-crs, that.
[[nodiscard]] std::string describe_metric(const HorizontalMetric& metric,
                                          const std::optional<TargetCrs>& target = {});
void add_metric(const HorizontalMetric& metric, Json& json,
                const std::optional<TargetCrs>& target = {});

/// Exactly two finite numbers separated by a comma.
[[nodiscard]] Result<Place> parse_place(const std::string& option, const std::string& text);

/// --from and --to, both required.
void add_segment(CLI::App& app, std::string& from, std::string& to);
/// Two different places.
[[nodiscard]] Result<void> check_segment(const std::string& from, const std::string& to);

/// Names the file, unless the reason is that the user stopped.
template <typename T>
Result<T> naming(const std::string& path, Result<T> result, Session& session) {
  if (result || session.progress().is_cancelled()) return result;
  return fail("{}: {}", path, result.error().message);
}

}  // namespace lode::cli

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/mappers/tin_gaps.h"
#include "lode/mappers/tin_quality.h"

namespace lode {

struct PointTerrain;

struct ComparisonOptions {
  std::vector<double> tolerances;   ///< Units of the heights, finite, >= 0; at least one.
  int n_runs = 3;                   ///< What takes time is done so often; the median counts.
  std::uint32_t n_places = 200000;  ///< Random ones for which heights are asked.
  int n_contours = 20;              ///< Levels, evenly between lowest and highest.
  std::uint64_t n_steps = 1000000;  ///< Of a walk from triangle to triangle.
  std::uint64_t seed = 1;
  /// Of links between levels, which may be quadratic: a model that takes more is not run. 0: a
  /// quarter of the machine's.
  std::uint64_t memory_limit = 0;
  Threads threads{};
};

/// A model's answer to one tolerance. What it cannot do has no value.
struct ComparedMesh {
  double tolerance = 0;
  std::uint64_t triangles = 0;
  std::uint64_t vertices = 0;
  std::uint64_t memory_bytes = 0;        ///< With twins, errors and heights.
  TinQuality quality{};                  ///< As measured on the mesh, whatever the model says.
  TinGaps gaps{};                        ///< Likewise, in units of the heights.
  std::optional<double> stated_error{};  ///< What the model says of it.
  double extract_seconds = 0;            ///< From the model, or, without one, from the raster.
  /// In the middle quarter of columns and of rows, a sixteenth of the area; outside ten times.
  std::optional<double> variable_seconds{};
  std::uint64_t variable_triangles = 0;
  std::optional<double> contour_seconds{};  ///< Of meshes without gaps.
  std::uint64_t contour_points = 0;
  double places_per_second = 0;  ///< One thread; the locator's making apart.
  double locator_seconds = 0;
  /// The triangles that meet the same part, from the model, without a mesh.
  std::optional<double> zoom_seconds{};
  std::uint64_t zoom_triangles = 0;
  /// Of samples, one thread, from the model, without a mesh.
  std::optional<double> located_per_second{};
  /// Edges crossed in a random walk over the triangles, one thread, by ComparedModel::neighbours.
  std::optional<double> crossed_per_second{};
  std::optional<double> twins_seconds{};  ///< To find twins by sorting, where meshes lack them.
  /// Along the raster's diagonal; over gaps on the model's own surface.
  std::optional<double> profile_seconds{};
  std::uint64_t profile_points = 0;

  double rounding = 0;  ///< Of measured errors, and of heights of vertices between samples.

  /// Of the samples in triangles: what is left out, quality says.
  [[nodiscard]] bool is_met() const { return quality.worst_error <= tolerance + rounding; }
};

struct ComparedModel {
  /// What has no value, and why not.
  struct Missing {
    std::string what;
    std::string why;
  };

  std::string name;
  std::string what;       ///< In one sentence.
  std::string refusal{};  ///< Why there are no meshes; else empty.
  /// Once, for all tolerances. Of what is made anew for each that takes all meshes.
  std::optional<double> build_seconds{};
  bool is_made_anew = false;
  std::string neighbours{};  ///< How it goes to what is behind an edge, or why it does not.
  int n_levels = 0;          ///< 0: it has none.
  std::string levels_are{};  ///< What they are, or why there are none.
  std::optional<std::uint64_t> memory_bytes{};  ///< Of the model itself.
  std::optional<std::uint64_t> n_links{};       ///< Between levels.
  /// That building took beside the raster, at most, as the system counts it, where it does; of what
  /// is made anew that its mesh within the finest tolerance did.
  std::optional<std::uint64_t> peak_bytes{};
  std::optional<std::uint64_t> file_bytes{};  ///< Of a .lode file with these tolerances.
  std::vector<ComparedMesh> meshes{};         ///< By tolerance, as given.
  std::vector<Missing> missing{};             ///< Of a model with meshes; each has a reason.
};

struct TerrainComparison {
  std::uint64_t n_samples = 0;  ///< With a height.
  HeightRange range;
  std::uint64_t memory_limit = 0;  ///< That held.
  std::vector<ComparedModel> models;
  double seconds = 0;
};

/// Runs all models of terrain that there are on a grid, and the regular subsampled grid as the
/// baseline, and measures their meshes by the same means. Fails on options that are none, on
/// rasters without a cell, and when cancelled.
[[nodiscard]] Result<TerrainComparison> compare_terrain(const HeightGrid& grid,
                                                        const ComparisonOptions& options,
                                                        Progress& progress);
/// The same of scattered points, whose errors are measured at the points of the domain: of models
/// that can be built of them. The others are there, too, with a refusal.
[[nodiscard]] Result<TerrainComparison> compare_terrain(const PointTerrain& terrain,
                                                        const ComparisonOptions& options,
                                                        Progress& progress);

}  // namespace lode

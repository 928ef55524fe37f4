#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "lode/api/built_terrain.h"
#include "lode/api/mapped_errors.h"
#include "lode/api/point_terrain.h"
#include "lode/api/terrain_lines.h"
#include "lode/api/terrain_source.h"
#include "lode/core/height_frame.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/io/height_reader.h"
#include "lode/io/point_reader.h"

namespace lode {

/// What a file of scattered points has, and what became of it.
struct PointFacts {
  io::PointCounts counts;
  bool has_classes = false;
  std::string crs_note;          ///< See PointFile.
  std::uint64_t n_nodes = 0;     ///< Different positions.
  std::uint64_t n_outside = 0;   ///< Points outside of the outline.
  std::uint64_t n_left_out = 0;  ///< Positions that are not in the domain.
  std::uint64_t n_outline = 0;   ///< Edges of the domain's outline.
  std::uint64_t n_repeated = 0;  ///< See HeightPoints, and so the next two.
  double largest_spread = 0;
  double largest_move = 0;
  double step = 0;             ///< Of the lattice.
  std::uint64_t n_turned = 0;  ///< To whose longitudes a turn was added; see turn_from().
};

/// What a file says of its terrain.
struct TerrainFacts {
  HeightFrame frame;
  std::string format;      ///< GDAL's name of a raster's, HGT, LODE, or that of points.
  std::string type;        ///< Of the raster's samples; see HeightRaster.
  bool has_place = false;  ///< See HeightRaster.
  std::uint64_t n_missing = 0;
  bool goes_round = false;             ///< A raster that goes round the earth (columns_of_turn()).
  bool is_of_points = false;           ///< A model, of points or of a raster with lines.
  std::optional<PointFacts> points{};  ///< Where their file was read.
  io::RasterForm form{};               ///< Of a raster's file.
  io::VerticalOutcome vertical{};
};

[[nodiscard]] TerrainFacts facts_of(const io::HeightRaster& raster);

/// How rasters and points are to be read; each has its own.
struct TerrainReadOptions {
  io::HeightReadOptions raster{};
  io::PointReadOptions points{};
  PointTerrainOptions domain{};
  /// A file of polygons (io/polygon_file.h), in place of domain.outline; empty: none.
  std::string outline{};
  /// Critical points of at least this relief, ridges and channels become edges: see
  /// terrain_lines.h.
  std::optional<double> least_relief{};
  bool keeps_features = false;  ///< Without a least relief: of 1 % of the range of heights.
  std::string breaklines{};  ///< A file of lines (io/line_file.h) that become edges; empty: none.
  bool is_draped = false;    ///< Whatever heights breaklines have.
  /// Draped lines stay that near to the surface; without it and drape_share: a quarter percent of
  /// the range of heights.
  std::optional<double> drape_error{};
  std::optional<double> drape_share{};  ///< The same as a share of the range of heights.
  /// Of a raster that a model is built of: its heights stay at hand (OpenedTerrain::samples).
  bool keeps_samples = false;
  /// A raster without lines that goes round the earth ends with its first column (cut_open_at()),
  bool is_closed = false;
  /// the same where it is asked for: rasters that do not go round, and lines, are refused;
  bool is_wrapped = false;
  /// and begins at the western end of this way, which is the shorter one round the earth.
  std::optional<std::array<Vec<double, 2>, 2>> way{};
  std::string way_crs{};  ///< EPSG:N or WKT, of the way's ends; empty: that of the raster.

  [[nodiscard]] bool has_lines() const {
    return least_relief || keeps_features || !breaklines.empty();
  }
};

/// A terrain from a file, ready to be asked.
struct OpenedTerrain {
  Terrain terrain;
  TerrainModel model = TerrainModel::delaunay_selector;
  TerrainFacts facts;
  std::optional<BuiltTerrain> built{};  ///< Of all but the delaunay_selector.
  /// Scattered points, or a terrain with lines; null: it is of a raster without, or of a file of a
  /// model.
  std::shared_ptr<const PointTerrain> points{};
  std::shared_ptr<const HeightGrid> grid{};  ///< The raster; null where only a model is at hand.
  /// All heights of the raster that it is of, where they are at hand.
  std::shared_ptr<const HeightGrid> samples{};
  bool is_closed = false;                    ///< It goes round the earth without a gap.
  std::optional<TerrainLineReport> lines{};  ///< Where there are some.
};

/// All samples or points of its domain, to be measured in another CRS (mapped_errors.h); nothing:
/// they are not at hand.
[[nodiscard]] std::optional<MeasuredSamples> measured_samples(const OpenedTerrain& opened);

/// Whether a path is read as terrain: it is a raster of heights or of scattered points by its name,
/// or a .lode file of a model of terrain.
[[nodiscard]] bool holds_terrain(const std::string& path);
/// Whether it is such a .lode file.
[[nodiscard]] bool holds_terrain_model(const std::string& path);
/// That there is a .lode file whose header and directory are whole, of whatever model.
[[nodiscard]] Result<void> check_lode_opens(const std::string& path);

/// With `building` the model is built first: of points, and with lines, one that
/// is_of_any_points(); models on squares keep samples of features. Of a .lode file the options of
/// reading and building mean nothing. Fails as reading,
/// make_point_terrain() and building do, naming the file.
[[nodiscard]] Result<OpenedTerrain> open_terrain(const std::string& path,
                                                 const TerrainReadOptions& reading,
                                                 const std::optional<TerrainBuildOptions>& building,
                                                 Progress& progress);

}  // namespace lode

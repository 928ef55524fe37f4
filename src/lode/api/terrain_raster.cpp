#include "lode/api/terrain_raster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <string_view>
#include <utility>
#include <vector>

#include "lode/api/terrain_selection.h"
#include "lode/api/terrain_tin.h"
#include "lode/api/tin_samples.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/io/crs_metric.h"

namespace lode {
namespace {

using io::RasterLayer;
using io::RasterType;
using io::RasterWriter;

static_assert(RasterWriter::kTileRows == TinRaster::kStripRows);

/// Of pixels' corners, where `frame` has their middles.
std::array<double, 6> corner_transform(const HeightFrame& frame) {
  const auto& g = frame.to_world;
  return {g[0] - (g[1] + g[2]) / 2, g[1], g[2], g[3] - (g[4] + g[5]) / 2, g[4], g[5]};
}

/// Files of GDAL say such a value in decimals, so that it is the nearest float that is meant.
std::optional<double> nodata_of(const io::RasterForm& form, RasterType type) {
  if (!form.nodata) return std::nullopt;
  if (type == RasterType::float64 || std::isnan(*form.nodata)) return form.nodata;
  const auto value = static_cast<double>(static_cast<float>(*form.nodata));
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

bool are_whole(std::string_view sample_type) {
  return sample_type == "byte" || sample_type.starts_with("int") || sample_type.starts_with("uint");
}

void replace_missing(std::span<double> heights, double nodata) {
  for (double& z : heights)
    if (std::isnan(z)) z = nodata;
}

/// Threads whose strips take a GiB at most.
Threads threads_for(std::size_t n_strip_samples, Threads threads) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 30;
  const std::size_t most =
      std::max<std::size_t>(1, kMostBytes / (sizeof(double) * n_strip_samples));
  return {
      static_cast<int>(std::min<std::size_t>(most, static_cast<std::size_t>(n_workers(threads))))};
}

/// The heights that a TIN is of, where they are at hand, or given; else null.
const HeightGrid* samples_of(const OpenedTerrain& opened, const TerrainRasterOptions& wanted) {
  if (opened.grid) return opened.grid.get();
  return opened.samples ? opened.samples.get() : wanted.samples.get();
}

/// Whether samples are at the same places, but for rounding.
bool is_same_grid(const HeightFrame& a, const HeightFrame& b) {
  if (a.n_columns != b.n_columns || a.n_rows != b.n_rows) return false;
  constexpr double kMostOff = 1e-6;  // of a step
  const double step =
      std::min(std::hypot(a.to_world[1], a.to_world[4]), std::hypot(a.to_world[2], a.to_world[5]));
  const double x = a.n_columns - 1;
  const double y = a.n_rows - 1;
  for (const auto& [column, row] : {std::pair{0.0, 0.0}, {x, 0.0}, {0.0, y}, {x, y}}) {
    const Place off = a.world(column, row) - b.world(column, row);
    if (!(std::hypot(off[0], off[1]) <= kMostOff * step)) return false;
  }
  return true;
}

/// The raster of a TIN on the grid whose samples it is of.
class OwnGrid {
 public:
  OwnGrid(const OpenedTerrain& opened, const SelectedTerrain& selected,
          const TerrainRasterOptions& wanted)
      : opened_(opened),
        wanted_(wanted),
        raster_(selected.tin, opened.facts.frame.n_columns, opened.facts.frame.n_rows),
        samples_(samples_of(opened, wanted)),
        stored_(raster_, samples_, selected.report.achieved_error),
        threads_(threads_for(raster_.n_nodes(0), wanted.threads)) {
    report_.terrain = selected.report;
    report_.frame = opened.facts.frame;
  }

  Result<TerrainRasterReport> write(const std::string& path, Progress& progress) {
    const Stopwatch measuring;
    LODE_CHECK(choose_type(progress));
    LODE_CHECK(check_is_of_samples());
    report_.sample_seconds = measuring.seconds();
    const Stopwatch writing;
    LODE_CHECK(write_files(path, progress));
    report_.write_seconds = writing.seconds();
    return report_;
  }

 private:
  /// float32, unless it would break what the TIN keeps.
  Result<void> choose_type(Progress& progress) {
    LODE_CHECK(measure(RasterType::float32, progress));
    const TerrainReport& terrain = report_.terrain;
    const bool has_tolerance = terrain.is_within_error && terrain.is_uniform;
    const double kept = samples_ != nullptr ? terrain.achieved_error
                        : has_tolerance     ? terrain.max_error
                                            : std::numeric_limits<double>::infinity();
    if (report_.error <= kept) return {};
    return measure(RasterType::float64, progress);
  }

  /// No sample of the raster that it is of is farther from the TIN than its error; where that
  /// varies nothing is known of all.
  [[nodiscard]] Result<void> check_is_of_samples() const {
    const bool is_given = samples_ != nullptr && samples_ == wanted_.samples.get();
    if (!is_given || !report_.terrain.is_uniform) return {};
    const double most = report_.terrain.achieved_error + report_.rounding;
    if (report_.error <= most) return {};
    return fail(
        "expected the raster that the model is of, whose heights are within {} of its TIN, got {}, "
        "with heights up to {} from it",
        most, wanted_.samples_name, report_.error);
  }

  Result<void> measure(RasterType type, Progress& progress) {
    const std::optional<double> nodata = nodata_of(opened_.facts.form, type);
    LODE_TRY(const TinSampleFacts facts,
             stored_.measure(type, nodata.value_or(kLowestFloat), threads_, progress));
    report_.type = type;
    report_.nodata = facts.meets_value ? kLowestFloat : nodata.value_or(kLowestFloat);
    report_.n_heights = facts.n_heights;
    report_.rounding = facts.rounding + raster_.rounding();
    const bool is_measured = samples_ != nullptr;
    report_.error_kind = is_measured ? RasterErrorKind::measured : RasterErrorKind::bound;
    report_.error = is_measured ? facts.error : bound_without_samples(type);
    return {};
  }

  /// Whole samples are on no other side of a whole tolerance than the planes are.
  [[nodiscard]] double bound_without_samples(RasterType type) const {
    const TerrainReport& terrain = report_.terrain;
    const double bound = terrain.achieved_error + report_.rounding;
    const double limit = terrain.is_within_error && terrain.is_uniform
                             ? terrain.max_error
                             : std::ceil(terrain.achieved_error);
    const bool is_kept = raster_.keeps_whole_numbers() && are_whole(opened_.facts.type) &&
                         limit == std::floor(limit) && terrain.achieved_error <= limit;
    return is_kept && (type == RasterType::float64 || are_small()) ? std::min(bound, limit) : bound;
  }
  /// float32 holds whole numbers so large.
  [[nodiscard]] bool are_small() const {
    const HeightRange range = opened_.terrain.range();
    return std::max(std::abs(range.lower), std::abs(range.upper)) < 0x1p23;
  }

  [[nodiscard]] RasterLayer layer(const char* name, double nodata) const {
    const TerrainFacts& facts = opened_.facts;
    RasterLayer layer{.n_columns = report_.frame.n_columns,
                      .n_rows = report_.frame.n_rows,
                      .type = report_.type,
                      .nodata = nodata,
                      .geotransform = facts.form.geotransform,
                      .is_point = facts.form.is_point,
                      .crs = report_.frame.crs,
                      .unit = report_.frame.vertical_unit,
                      .name = name};
    if (!layer.geotransform && facts.has_place)
      layer.geotransform = corner_transform(report_.frame);
    if (wanted_.comment) layer.comment = wanted_.comment(report_.terrain);
    return layer;
  }

  Result<void> write_files(const std::string& path, Progress& progress) {
    LODE_TRY(RasterWriter heights, RasterWriter::create(path, layer("height", report_.nodata)));
    std::optional<RasterWriter> differences;
    if (!wanted_.difference.empty()) {
      LODE_TRY(RasterWriter made,
               RasterWriter::create(wanted_.difference, layer("TIN - raster", kLowestFloat)));
      differences.emplace(std::move(made));
    }
    LODE_CHECK(write_strips(heights, differences ? &*differences : nullptr, progress));
    if (differences) LODE_CHECK(differences->commit(progress));
    return heights.commit(progress);
  }

  /// Strips are made by as many threads at once, and written in their order.
  Result<void> write_strips(RasterWriter& heights, RasterWriter* differences, Progress& progress) {
    const std::int32_t n = raster_.n_strips();
    std::vector<std::vector<double>> strips(static_cast<std::size_t>(n_workers(threads_)));
    std::vector<double> less;
    for (std::int32_t first = 0; first < n;) {
      const auto n_now = std::min<std::size_t>(strips.size(), static_cast<std::size_t>(n - first));
      parallel_for(n_now, threads_, 1, [&](std::size_t i, int) {
        const std::int32_t strip = first + static_cast<std::int32_t>(i);
        strips[i].resize(raster_.n_nodes(strip));
        stored_.fill(strip, report_.type, strips[i]);
      });
      for (std::size_t i = 0; i < n_now; ++i, ++first) {
        if (progress.is_cancelled()) return cancelled_error();
        progress.report("writing", static_cast<double>(first) / n);
        if (differences != nullptr) {
          less.resize(strips[i].size());
          stored_.subtract_samples(first, report_.type, strips[i], less);
          replace_missing(less, kLowestFloat);
          LODE_CHECK(differences->add_rows(less));
        }
        replace_missing(strips[i], report_.nodata);
        LODE_CHECK(heights.add_rows(strips[i]));
      }
    }
    return {};
  }

  const OpenedTerrain& opened_;
  const TerrainRasterOptions& wanted_;
  TinRaster raster_;
  const HeightGrid* samples_;  ///< Null: not at hand.
  StoredHeights stored_;
  Threads threads_;
  TerrainRasterReport report_;
};

/// Rows from north to south, pixels' corners at multiples of the cell, around a lattice's nodes.
Result<HeightFrame> frame_around(const HeightFrame& source, double cell) {
  const double x = source.n_columns - 1;
  const double y = source.n_rows - 1;
  Place lower = source.world(0, 0);
  Place upper = lower;
  for (const Place& at : {source.world(x, 0), source.world(0, y), source.world(x, y)})
    for (std::size_t i = 0; i < 2; ++i) {
      lower[i] = std::min(lower[i], at[i]);
      upper[i] = std::max(upper[i], at[i]);
    }
  const double left = std::floor(lower[0] / cell);
  const double top = std::ceil(upper[1] / cell);
  const double n_columns = std::max(1.0, std::ceil(upper[0] / cell) - left);
  const double n_rows = std::max(1.0, top - std::floor(lower[1] / cell));
  constexpr double kMostSamples = 0x1p32;
  constexpr double kMostSide = 0x1p30;
  if (!(n_columns * n_rows <= kMostSamples && std::max(n_columns, n_rows) <= kMostSide))
    return fail("expected a cell that gives at most 2^32 samples, got {}, which gives {} x {}",
                cell, n_columns, n_rows);
  HeightFrame frame = source;
  frame.n_columns = static_cast<std::int32_t>(n_columns);
  frame.n_rows = static_cast<std::int32_t>(n_rows);
  frame.to_world = {(left + 0.5) * cell, cell, 0, (top - 0.5) * cell, 0, -cell};
  return frame;
}

/// The heights of a TIN on another grid.
class OtherGrid {
 public:
  OtherGrid(const TerrainTin& tin, HeightFrame frame, const TerrainRasterOptions& wanted)
      : tin_(tin), frame_(std::move(frame)), wanted_(wanted) {}

  Result<TerrainRasterReport> write(const std::string& path, Progress& progress) {
    const TerrainReport& terrain = tin_.report();
    const HeightRange range = tin_.height_range();
    const double largest = std::max(std::abs(range.lower), std::abs(range.upper));
    // What is lost of the tolerance should not be seen in it.
    constexpr double kShare = 1e-3;
    const double rounding = 0x1p-24 * largest;
    report_.terrain = terrain;
    report_.frame = frame_;
    report_.type =
        rounding <= kShare * terrain.max_error ? RasterType::float32 : RasterType::float64;
    report_.nodata = kLowestFloat;
    report_.error_kind = RasterErrorKind::of_tin;
    report_.error = terrain.achieved_error;
    RasterLayer layer{.n_columns = frame_.n_columns,
                      .n_rows = frame_.n_rows,
                      .type = report_.type,
                      .nodata = report_.nodata,
                      .geotransform = corner_transform(frame_),
                      .crs = frame_.crs,
                      .unit = frame_.vertical_unit,
                      .name = "height"};
    if (wanted_.comment) layer.comment = wanted_.comment(terrain);
    LODE_TRY(RasterWriter writer, RasterWriter::create(path, layer));
    for (std::int32_t row = 0; row < frame_.n_rows; row += RasterWriter::kTileRows) {
      LODE_CHECK(write_strip(row, writer, progress));
    }
    LODE_CHECK(writer.commit(progress));
    return report_;
  }

 private:
  Result<void> write_strip(std::int32_t first, RasterWriter& writer, Progress& progress) {
    const std::int32_t n = std::min(RasterWriter::kTileRows, frame_.n_rows - first);
    progress.report("sampling", static_cast<double>(first) / frame_.n_rows);
    const Stopwatch sampling;
    strip_.clear();
    for (std::int32_t y = first; y < first + n; ++y) LODE_CHECK(add_row(y, progress));
    LODE_CHECK(find_heights(progress));
    report_.sample_seconds += sampling.seconds();
    const Stopwatch writing;
    LODE_CHECK(writer.add_rows(strip_));
    report_.write_seconds += writing.seconds();
    return {};
  }
  /// Its places wait until they are worth a search.
  Result<void> add_row(std::int32_t y, Progress& progress) {
    constexpr std::size_t kPlacesAtOnce = std::size_t{1} << 20;
    for (std::int32_t x = 0; x < frame_.n_columns; ++x) places_.push_back(frame_.world(x, y));
    return places_.size() < kPlacesAtOnce ? Result<void>() : find_heights(progress);
  }
  Result<void> find_heights(Progress& progress) {
    Progress silent;  // Reports of a part would tell of the whole.
    if (progress.is_cancelled()) return cancelled_error();
    LODE_TRY(const HeightsReport found, tin_.heights(places_, heights_, wanted_.threads, silent));
    report_.n_heights += places_.size() - found.n_outside - found.n_in_gaps;
    for (const TerrainHeight& one : heights_) {
      if (one.where != TerrainHeight::Where::inside) {
        strip_.push_back(report_.nodata);
        continue;
      }
      const bool is_float = report_.type == RasterType::float32;
      const double z = is_float ? static_cast<double>(static_cast<float>(one.height)) : one.height;
      report_.rounding = std::max(report_.rounding, std::abs(z - one.height));
      strip_.push_back(z);
    }
    places_.clear();
    return {};
  }

  const TerrainTin& tin_;
  HeightFrame frame_;
  const TerrainRasterOptions& wanted_;
  TerrainRasterReport report_;
  std::vector<Place> places_;
  std::vector<TerrainHeight> heights_;
  std::vector<double> strip_;
};

Result<void> check_difference(const OpenedTerrain& opened, const TerrainRasterOptions& wanted) {
  if (wanted.samples && !is_same_grid(*wanted.samples, opened.facts.frame))
    return fail(
        "expected the raster of {} x {} samples that the model is of, got {}, of {} x {}, or "
        "elsewhere",
        opened.facts.frame.n_columns, opened.facts.frame.n_rows, wanted.samples_name,
        wanted.samples->n_columns, wanted.samples->n_rows);
  if (wanted.difference.empty()) return {};
  if (wanted.cell) return fail("expected a raster on its own grid to subtract, got a cell");
  if (samples_of(opened, wanted) != nullptr) return {};
  return fail(
      "expected the raster that the model is of, to subtract it, got none: its samples are not at "
      "hand in a model of {}",
      name_of(opened.model));
}

Result<void> check_raster_options(const OpenedTerrain& opened, const TerrainRasterOptions& wanted) {
  if (opened.facts.is_of_points && !wanted.cell)
    return fail(
        "expected a cell, the size of pixels, for a raster of a model of points, or of a raster "
        "with lines, got none");
  if (opened.points && !opened.grid && !wanted.cell)
    return fail("expected a cell, the size of pixels, for a raster of scattered points, got none");
  if (!wanted.cell && opened.terrain.frame().n_columns != opened.facts.frame.n_columns &&
      opened.lines)
    return fail(
        "expected a cell, the size of pixels, for a raster of a terrain with breaklines, whose "
        "vertices lie between samples, got none");
  if (!wanted.cell && is_hierarchy(opened.model))
    return fail(
        "expected a cell, the size of pixels, for a raster of {}, whose vertices lie between "
        "samples, got none",
        name_of(opened.model));
  if (wanted.cell && !(*wanted.cell > 0 && std::isfinite(*wanted.cell)))
    return fail("expected a cell > 0, got {}", *wanted.cell);
  return check_difference(opened, wanted);
}

}  // namespace

Result<TerrainRasterReport> write_terrain_raster(const OpenedTerrain& opened,
                                                 const TerrainOptions& options,
                                                 const TerrainRasterOptions& wanted,
                                                 const std::string& path, Progress& progress) try {
  LODE_CHECK(check_raster_options(opened, wanted));
  if (!wanted.cell) {
    LODE_TRY(const SelectedTerrain selected,
             opened.terrain.origin().select(options, delaunay::TinLinks::left_out, progress));
    return OwnGrid(opened, selected, wanted).write(path, progress);
  }
  LODE_TRY(const HorizontalMetric metric, io::read_metric(opened.facts.frame.crs));
  LODE_TRY(HeightFrame frame, frame_around(opened.facts.frame, *wanted.cell));
  LODE_TRY(const TerrainTin tin, TerrainTin::select(opened.terrain, options, metric, progress));
  return OtherGrid(tin, std::move(frame), wanted).write(path, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("write the raster", path);
}

}  // namespace lode

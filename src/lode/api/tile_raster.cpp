#include "lode/api/tile_raster.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "lode/core/vertical_unit.h"
#include "lode/io/crs_metric.h"
#include "lode/io/height_stream.h"
#include "lode/io/height_transform.h"

namespace lode {
namespace {

class GridRows final : public TileRows {
 public:
  GridRows(const std::string& path, HeightGrid grid, double metres)
      : TileRows(path, metres), grid_(std::move(grid)) {}
  const HeightFrame& frame() const override { return grid_; }

 private:
  Result<void> read_own(std::int32_t first, std::int32_t n_rows, std::span<double> out) override {
    io::copy_rows(grid_, first, n_rows, out);
    return {};
  }

  HeightGrid grid_;
};

class FileRows final : public TileRows {
 public:
  FileRows(const std::string& path, io::HeightStream stream, double metres)
      : TileRows(path, metres), stream_(std::move(stream)) {}
  const HeightFrame& frame() const override { return stream_.raster().grid; }

 private:
  Result<void> read_own(std::int32_t first, std::int32_t n_rows, std::span<double> out) override {
    return stream_.read(first, n_rows, out);
  }

  io::HeightStream stream_;
};

Result<double> metres_of(const std::string& path, const HeightFrame& frame,
                         std::vector<std::string>& notes) {
  if (frame.vertical_unit.empty()) {
    notes.emplace_back("heights are taken for metres: the file does not say");
    return 1.0;
  }
  const auto metres = metres_of_unit(frame.vertical_unit);
  if (!metres)
    return fail("{}: expected heights in a unit of length that is known, got {}", path,
                frame.vertical_unit);
  return *metres;
}

double semi_minor_of(const Ellipsoid& ellipsoid) {
  const double inverse = ellipsoid.inverse_flattening;
  return inverse == 0 ? ellipsoid.semi_major : ellipsoid.semi_major * (1 - 1 / inverse);
}

/// Clients put places on WGS 84, from Greenwich on. Datums of the Earth, whose axes are within
/// 0.02 % of its, are told apart by less than most rasters err; other worlds and spheres are not.
Result<void> check_globe(const std::string& path, const HorizontalMetric& metric) {
  if (metric.prime_meridian != 0)
    return fail(
        "{}: expected longitudes from Greenwich, got the prime meridian {} at {} degrees: "
        "--resample cubic puts it in degrees of WGS 84",
        path, metric.prime_meridian_name, metric.prime_meridian);
  constexpr double kMostApart = 1e-3;
  const auto is_near = [](double a, double b) { return std::abs(a / b - 1) <= kMostApart; };
  if (!is_near(metric.ellipsoid->semi_major, kWgs84Ellipsoid.semi_major) ||
      !is_near(semi_minor_of(*metric.ellipsoid), semi_minor_of(kWgs84Ellipsoid)))
    return fail(
        "{}: expected an ellipsoid whose axes are within 0.1 % of those of WGS 84, got {} of {} "
        "and {} m: where it is the Earth gdal_translate -a_srs EPSG:4326 says so",
        path, metric.ellipsoid_name, metric.ellipsoid->semi_major,
        semi_minor_of(*metric.ellipsoid));
  return {};
}

/// Says how far clients put a raster from where it is, as they take its degrees for those of
/// WGS 84.
void note_datum(const HeightFrame& frame, std::vector<std::string>& notes) {
  const Vec<double, 2> own = frame.world((frame.n_columns - 1) / 2.0, (frame.n_rows - 1) / 2.0);
  const auto there = io::to_wgs84(frame.crs, own);
  if (!there) {
    notes.push_back("its degrees are taken for those of WGS 84: " + there.error().message);
    return;
  }
  constexpr double kTurn = 360;
  constexpr double kDegree = std::numbers::pi / 180;
  const Vec<double, 2> near{{own[0] + std::remainder((*there)[0] - own[0], kTurn), (*there)[1]}};
  const double metres = length_on(kWgs84Ellipsoid, own * kDegree, near * kDegree);
  constexpr double kLittle = 1;
  if (metres >= kLittle)
    notes.push_back(fmt::format(
        "its degrees are taken for those of WGS 84, which its datum is not: its middle is put "
        "{:.3g} m from where it is; --resample cubic puts it in degrees of WGS 84",
        metres));
}

/// Degrees on an ellipsoid.
Result<void> check_place(const std::string& path, const io::HeightRaster& raster,
                         std::vector<std::string>& notes) {
  if (!raster.has_place)
    return fail("{}: expected a raster with a position on the globe, got one without", path);
  LODE_TRY(const HorizontalMetric metric, io::read_metric(raster.grid.crs));
  if (!metric.is_known) {
    notes.emplace_back("places are taken for degrees of WGS 84: the file does not say");
    return {};
  }
  if (!metric.ellipsoid)
    return fail(
        "{}: expected longitudes and latitudes, got a projected raster: --resample cubic puts it "
        "in degrees",
        path);
  constexpr double kDegree = std::numbers::pi / 180;
  constexpr double kRounding = 1e-9;
  if (std::abs(metric.angle_unit / kDegree - 1) > kRounding)
    return fail(
        "{}: expected longitudes and latitudes in degrees, got another unit: --resample cubic puts "
        "it in degrees",
        path);
  LODE_CHECK(check_globe(path, metric));
  note_datum(raster.grid, notes);
  return {};
}

bool is_above_ellipsoid(const io::HeightRaster& raster) {
  return io::vertical_name(raster.grid.crs) == "ellipsoid";
}
bool is_above_something(const io::HeightRaster& raster) {
  return !io::vertical_name(raster.grid.crs).empty();
}

Result<TileRaster> describe(const std::string& path, const io::HeightRaster& raster,
                            const io::HeightReadOptions& reading) {
  TileRaster out;
  if (reading.to_degrees)
    out.notes.emplace_back(
        fmt::format("put in degrees of WGS 84: errors are of the {} x {} samples that come out",
                    raster.grid.n_columns, raster.grid.n_rows));
  LODE_CHECK(check_place(path, raster, out.notes));
  if (!is_above_something(raster))
    out.notes.emplace_back(
        "heights are taken as above the ellipsoid, as tiles want them: the file does not say; "
        "--vertical-crs declares what they are above");
  out.type = raster.type;
  out.vertical = raster.vertical;
  return out;
}

/// With heights above the ellipsoid, where it is known what they are above.
Result<io::HeightStream> open_above_ellipsoid(const std::string& path,
                                              const io::HeightReadOptions& reading,
                                              Progress& progress) {
  LODE_TRY(io::HeightStream opened, io::HeightStream::open(path, reading, progress));
  const io::HeightRaster& raster = opened.raster();
  if (!is_above_something(raster) || is_above_ellipsoid(raster)) return opened;
  io::VerticalOptions above = reading.vertical;
  above.target = "ellipsoid";
  return std::move(opened).with_vertical(above, progress);
}

/// A raster too large for memory; nothing for others.
Result<std::optional<TileRaster>> stream(const std::string& path,
                                         const io::HeightReadOptions& reading,
                                         std::uint64_t most_bytes, Progress& progress) {
  auto opened = open_above_ellipsoid(path, reading, progress);
  // Whoever reads all of it says what is wrong.
  if (!opened || opened->n_bytes() <= most_bytes) return std::optional<TileRaster>();
  const io::HeightRaster& raster = opened->raster();
  LODE_TRY(TileRaster out, describe(path, raster, reading));
  LODE_TRY(const double metres, metres_of(path, raster.grid, out.notes));
  out.is_in_memory = false;
  out.rows = std::make_unique<FileRows>(path, std::move(opened).value(), metres);
  return std::optional(std::move(out));
}

}  // namespace

Result<void> TileRows::read(std::int32_t first, std::int32_t n_rows, std::span<double> out) {
  LODE_CHECK(read_own(first, n_rows, out));
  const auto n_columns = static_cast<std::size_t>(frame().n_columns);
  for (std::int32_t row = first; row < first + n_rows; ++row) {
    const auto heights = out.subspan(static_cast<std::size_t>(row - first) * n_columns, n_columns);
    if (row == n_counted_) {
      ++n_counted_;
      for (const double z : heights) n_missing_ += std::isnan(z) ? 1 : 0;
    }
    if (metres_ != 1)
      for (double& z : heights) z *= metres_;
  }
  return {};
}

Result<TileRaster> open_tile_raster(const std::string& path, const io::HeightReadOptions& reading,
                                    std::uint64_t most_bytes, Progress& progress) {
  LODE_TRY(auto streamed, stream(path, reading, most_bytes, progress));
  if (streamed) return *std::move(streamed);
  LODE_TRY(io::HeightRaster raster, io::read_heights(path, reading, progress));
  if (is_above_something(raster) && !is_above_ellipsoid(raster)) {
    auto outcome = io::set_vertical(raster, {.declared = {}, .target = "ellipsoid"}, progress);
    if (!outcome && progress.is_cancelled()) return outcome.error();
    if (!outcome) return fail("{}: {}", path, outcome.error().message);
    outcome->notes.insert(outcome->notes.begin(), raster.vertical.notes.begin(),
                          raster.vertical.notes.end());
    raster.vertical = *std::move(outcome);
  }
  LODE_TRY(TileRaster out, describe(path, raster, reading));
  LODE_TRY(const double metres, metres_of(path, raster.grid, out.notes));
  out.rows = std::make_unique<GridRows>(path, std::move(raster.grid), metres);
  return out;
}

}  // namespace lode

// Rasters put in degrees while they are read, through GDAL's warped virtual rasters.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/io/gdal_crs.h"
#include "lode/io/gdal_raster.h"
#include "lode/io/vector_input.h"
#include "lode/io/vertical_crs.h"

namespace lode::io {
namespace {

constexpr const char* kDegrees = "EPSG:4326";
/// In pixels, how far a sample's place may be from where the projection has it.
constexpr const char* kMostOff = "0.015625";

const char* name_of(Resampling resampling) {
  switch (resampling) {
    case Resampling::nearest: return "near";
    case Resampling::bilinear: return "bilinear";
    case Resampling::cubic: return "cubic";
  }
  return "near";
}

/// Where a raster lies on the globe, as nine of its places tell.
struct GlobePlace {
  double middle = 0;  ///< Longitude.
  bool crosses_180 = false;
  /// The least steps of longitude and latitude between samples; of one whose rows run slantwise as
  /// far as those of a step along both.
  std::array<double, 2> spacing{360, 180};
};

/// Nothing where nothing can be told.
std::optional<GlobePlace> find_place(const PlaceTransform& to_degrees, const HeightFrame& pixels) {
  GlobePlace place;
  bool is_known = false;
  for (const int i : {4, 0, 1, 2, 3, 5, 6, 7, 8}) {  // the middle first
    const int across = i % 3;
    const int up = i / 3;
    const double column = 0.5 * across * pixels.n_columns;
    const double row = 0.5 * up * pixels.n_rows;
    // A place, and a step along columns and rows from it.
    std::array<Vec<double, 2>, 3> at{pixels.world(column, row), pixels.world(column + 1, row),
                                     pixels.world(column, row + 1)};
    if (!to_degrees.apply<2>(at)) continue;
    if (!is_known) place.middle = at[0][0];
    is_known = true;
    const auto east_of = [](double from, double longitude) {
      return std::remainder(longitude - from, 360.0);
    };
    place.crosses_180 =
        place.crosses_180 || std::abs(place.middle + east_of(place.middle, at[0][0])) > 180;
    place.spacing[0] = std::min(
        place.spacing[0], std::hypot(east_of(at[0][0], at[1][0]), east_of(at[0][0], at[2][0])));
    place.spacing[1] =
        std::min(place.spacing[1], std::hypot(at[1][1] - at[0][1], at[2][1] - at[0][1]));
  }
  const bool is_fit = place.spacing[0] > 1e-9 && place.spacing[1] > 1e-9;
  return is_known && is_fit ? std::optional(place) : std::nullopt;
}

/// Whether a pole lies among a raster's pixels, and not on their border.
bool holds_pole(const PlaceTransform& from_degrees, const HeightFrame& pixels) {
  for (const double latitude : {90.0, -90.0}) {
    std::array<Vec<double, 2>, 1> pole{{{{0, latitude}}}};
    if (!from_degrees.apply<2>(pole)) continue;
    const auto at = pixels.lattice(pole[0][0], pole[0][1]);
    if (at[0] > 1 && at[1] > 1 && at[0] < pixels.n_columns - 1 && at[1] < pixels.n_rows - 1)
      return true;
  }
  return false;
}

/// What GDAL is to put a raster in.
struct Degrees {
  std::string crs = kDegrees;
  std::optional<std::array<double, 2>> spacing{};
};

Result<Degrees> choose_degrees(const std::string& path, const GdalLibrary& gdal, const char* crs,
                               const HeightFrame& pixels) {
  constexpr const char* kWhat = "raster in degrees";
  LODE_TRY(const GdalCrs source, GdalCrs::of(crs));
  LODE_TRY(const auto from_degrees, PlaceTransform::make(path, kDegrees, crs, kWhat));
  LODE_TRY(const auto to_degrees, PlaceTransform::make(path, crs, kDegrees, kWhat));
  if (gdal.is_geographic(source.handle()) == 0 && holds_pole(from_degrees, pixels))
    return fail(
        "{}: expected a raster without a pole in it, to be put in degrees, got one: cut it in "
        "parts that leave the pole out",
        path);
  Degrees chosen;
  const auto place = find_place(to_degrees, pixels);
  if (!place) return chosen;  // then GDAL chooses, or says what is wrong
  chosen.spacing = place->spacing;
  if (place->crosses_180)
    chosen.crs =
        fmt::format("+proj=longlat +datum=WGS84 +lon_wrap={} +no_defs", std::lround(place->middle));
  return chosen;
}

std::vector<std::string> warp_words(GDALDataType type, const Degrees& degrees,
                                    Resampling resampling, const HeightReadOptions& options) {
  const bool is_short = type == GDT_Byte || type == GDT_Int16 || type == GDT_UInt16;
  // What is missing is NaN, in each band by itself.
  std::vector<std::string> words{"-of", "VRT", "-t_srs", degrees.crs, "-r", name_of(resampling)};
  words.insert(words.end(), {"-et", kMostOff, "-novshift", "-dstnodata", "nan"});
  words.insert(words.end(), {"-ot", is_short || type == GDT_Float32 ? "Float32" : "Float64"});
  if (degrees.spacing)
    words.insert(words.end(),
                 {"-tr", fmt::format("{}", (*degrees.spacing)[0] / options.oversampling),
                  fmt::format("{}", (*degrees.spacing)[1] / options.oversampling)});
  // In between samples heights are found from those round them, also where they come closer.
  for (const char* option : {"XSCALE=1", "YSCALE=1", "UNIFIED_SRC_NODATA=NO"})
    words.insert(words.end(), {"-wo", option});
  if (options.nodata) words.insert(words.end(), {"-srcnodata", fmt::format("{}", *options.nodata)});
  return words;
}

using Lacks = std::array<std::array<std::int32_t, 2>, 2>;

/// With the columns and rows that a raster lacks.
std::vector<std::string> with_extent(std::vector<std::string> words, const HeightFrame& frame,
                                     const Lacks& lacks) {
  const auto& g = frame.to_world;
  const auto at = [&](double column, double row) {
    return std::array{g[0] + column * g[1], g[3] + row * g[5]};
  };
  const auto [west, north] = at(-0.5 - lacks[0][0], -0.5 - lacks[1][0]);
  const auto [east, south] =
      at(frame.n_columns - 0.5 + lacks[0][1], frame.n_rows - 0.5 + lacks[1][1]);
  words.emplace_back("-te");
  for (const double side : {west, south, east, north}) words.push_back(fmt::format("{}", side));
  return words;
}

}  // namespace

Result<void> GdalRaster::put_in_degrees(Resampling resampling, const HeightReadOptions& options) {
  if (options.encoding != HeightEncoding::none)
    return fail("{}: expected no encoding of a raster that is resampled, got one", path_);
  LODE_TRY(GDALRasterBandH band, this->band(options.band_or_first()));
  LODE_CHECK(check_size(band, 1));  // before GDAL takes memory for its blocks
  const std::string crs = this->crs();
  if (crs.empty())
    return fail(
        "{}: expected a raster whose CRS is known, to be put in degrees, got one without: --crs "
        "says it",
        path_);
  HeightFrame pixels;
  pixels.n_columns = n_columns();
  pixels.n_rows = n_rows();
  if (gdal_->geotransform(dataset_, pixels.to_world.data()) != CE_None)
    return fail("{}: expected a raster with a position, to be put in degrees, got one without",
                path_);
  LODE_TRY(const Degrees degrees, choose_degrees(path_, *gdal_, crs.c_str(), pixels));
  std::vector<std::string> words = warp_words(gdal_->type(band), degrees, resampling, options);
  if (!stated_crs_.empty()) words.insert(words.end(), {"-s_srs", stated_crs_});
  LODE_TRY(std::vector<BorderHeight> border, read_border(*this, options));
  source_ = std::exchange(dataset_, nullptr);
  LODE_CHECK(warp_source(words));
  LODE_CHECK(check_size_in_degrees(options));
  LODE_TRY(const HeightFrame frame, frame_in_degrees());
  LODE_TRY(auto there, border_in_degrees(path_, crs, frame, border));
  const Lacks lacks = lacking(frame, there);
  if (degrees.spacing && lacks != Lacks{}) {
    LODE_CHECK(warp_source(with_extent(words, frame, lacks)));
    LODE_TRY(const HeightFrame wider, frame_in_degrees());
    LODE_TRY(there, border_in_degrees(path_, crs, wider, std::move(border)));
    rim_ = find_rim(wider, there);
    return {};
  }
  rim_ = find_rim(frame, there);
  return {};
}

Result<void> GdalRaster::warp_source(std::vector<std::string> words) {
  if (dataset_ != nullptr) gdal_->close(std::exchange(dataset_, nullptr));
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  gdal_->reset_errors();
  GDALWarpAppOptions* warping = gdal_->new_warp_options(arguments.data(), nullptr);
  if (warping == nullptr) return fail("{}: expected GDAL to resample, got: {}", path_, reason());
  dataset_ = gdal_->warp("", nullptr, 1, &source_, warping, nullptr);
  gdal_->free_warp_options(warping);
  if (dataset_ != nullptr) return {};
  return fail("{}: expected a raster that can be put in degrees, got: {}", path_, reason());
}

Result<void> GdalRaster::check_size_in_degrees(const HeightReadOptions& options) const {
  const auto n_samples = [&](GDALDatasetH dataset) {
    return static_cast<std::uint64_t>(gdal_->n_columns(dataset)) *
           static_cast<std::uint64_t>(gdal_->n_rows(dataset));
  };
  // Near poles, and of places that are far apart.
  constexpr std::uint64_t kMostTimes = 64;
  const auto n_along = static_cast<std::uint64_t>(options.oversampling);
  if (n_samples(dataset_) / kMostTimes / (n_along * n_along) <= n_samples(source_) + 4096)
    return {};
  return fail("{}: expected a raster that has some more samples in degrees, got {} x {} of {} x {}",
              path_, gdal_->n_columns(dataset_), gdal_->n_rows(dataset_), gdal_->n_columns(source_),
              gdal_->n_rows(source_));
}

Result<HeightFrame> GdalRaster::frame_in_degrees() const {
  HeightFrame frame;
  frame.n_columns = n_columns();
  frame.n_rows = n_rows();
  frame.crs = kDegrees;
  std::array<double, 6> g{};
  if (gdal_->geotransform(dataset_, g.data()) != CE_None)
    return fail("{}: expected a position of what is in degrees, got: {}", path_, reason());
  frame.to_world = {g[0] + (g[1] + g[2]) / 2, g[1], g[2], g[3] + (g[4] + g[5]) / 2, g[4], g[5]};
  return frame;
}

Result<std::string> GdalRaster::crs_of_degrees() const {
  LODE_TRY(std::string degrees, to_wkt(kDegrees));
  const std::string crs = this->crs();
  if (!says_heights(crs)) return degrees;
  LODE_TRY(const Proj proj, Proj::make());
  LODE_TRY(const SplitCrs of_source, split_crs(proj, crs));
  if (!of_source.vertical) return degrees;
  LODE_TRY(const SplitCrs horizontal, split_crs(proj, degrees));
  LODE_TRY(const Proj::Object both, joined(proj, horizontal.horizontal.get(), *of_source.vertical));
  return wkt_of(proj, both.get());
}

}  // namespace lode::io

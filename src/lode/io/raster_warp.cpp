// Rasters put in degrees while they are read, through GDAL's warped virtual rasters.
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "lode/core/lattice_point.h"
#include "lode/io/gdal_crs.h"
#include "lode/io/gdal_raster.h"
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

/// How far samples are apart in the middle of a raster, in degrees of longitude and of latitude; of
/// one whose rows run slantwise as far as those of a step along both. Nothing where that cannot be
/// told.
std::optional<std::array<double, 2>> spacing_in_degrees(const GdalLibrary& gdal, const char* crs,
                                                        const std::array<double, 6>& g,
                                                        LatticePoint middle) {
  const auto from = GdalCrs::of(crs);
  const auto to = GdalCrs::of(kDegrees);
  if (!from || !to) return {};
  from->strip_heights();
  OGRCoordinateTransformationH transformation =
      gdal.new_transformation(from->handle(), to->handle());
  if (transformation == nullptr) return {};
  // The middle, and a step along columns and rows from it.
  std::array<double, 3> x{};
  std::array<double, 3> y{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double column = middle.x + (i == 1 ? 1 : 0);
    const double row = middle.y + (i == 2 ? 1 : 0);
    x[i] = g[0] + g[1] * column + g[2] * row;
    y[i] = g[3] + g[4] * column + g[5] * row;
  }
  const bool is_done = gdal.transform(transformation, 3, x.data(), y.data(), nullptr) != 0;
  gdal.destroy_transformation(transformation);
  const std::array spacing{std::hypot(x[1] - x[0], x[2] - x[0]),
                           std::hypot(y[1] - y[0], y[2] - y[0])};
  // Across the meridian of 180 degrees, and where there is no such place, GDAL chooses.
  const auto is_fit = [](double degrees) { return degrees > 1e-9 && degrees < 90; };
  if (!is_done || !is_fit(spacing[0]) || !is_fit(spacing[1])) return {};
  return spacing;
}

}  // namespace

Result<void> GdalRaster::put_in_degrees(Resampling resampling, const HeightReadOptions& options) {
  if (options.encoding != HeightEncoding::none)
    return fail("{}: expected no encoding of a raster that is resampled, got one", path_);
  LODE_TRY(GDALRasterBandH band, this->band(options.band));
  LODE_CHECK(check_size(band, 1));  // before GDAL takes memory for its blocks
  if (const char* crs = gdal_->projection(dataset_); crs == nullptr || *crs == '\0')
    return fail("{}: expected a raster whose CRS is known, to be put in degrees, got one without",
                path_);
  const GDALDataType type = gdal_->type(band);
  const bool is_short = type == GDT_Byte || type == GDT_Int16 || type == GDT_UInt16;
  // What is missing is NaN.
  std::vector<std::string> words{"-of", "VRT", "-t_srs", kDegrees, "-r", name_of(resampling)};
  words.insert(words.end(), {"-et", kMostOff, "-novshift", "-dstnodata", "nan"});
  words.insert(words.end(), {"-ot", is_short || type == GDT_Float32 ? "Float32" : "Float64"});
  std::array<double, 6> g{};
  if (gdal_->geotransform(dataset_, g.data()) == CE_None)
    if (const auto spacing = spacing_in_degrees(*gdal_, gdal_->projection(dataset_), g,
                                                {n_columns() / 2, n_rows() / 2}))
      words.insert(words.end(), {"-tr", fmt::format("{}", (*spacing)[0] / options.oversampling),
                                 fmt::format("{}", (*spacing)[1] / options.oversampling)});
  // In between samples heights are found from those round them, also where they come closer.
  for (const char* scale : {"XSCALE=1", "YSCALE=1"}) words.insert(words.end(), {"-wo", scale});
  if (options.nodata) words.insert(words.end(), {"-srcnodata", fmt::format("{}", *options.nodata)});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  gdal_->reset_errors();
  GDALWarpAppOptions* warping = gdal_->new_warp_options(arguments.data(), nullptr);
  if (warping == nullptr) return fail("{}: expected GDAL to resample, got: {}", path_, reason());
  GDALDatasetH warped = gdal_->warp("", nullptr, 1, &dataset_, warping, nullptr);
  gdal_->free_warp_options(warping);
  if (warped == nullptr)
    return fail("{}: expected a raster that can be put in degrees, got: {}", path_, reason());
  source_ = std::exchange(dataset_, warped);
  return {};
}

Result<std::string> GdalRaster::crs_of_degrees() const {
  LODE_TRY(std::string degrees, to_wkt(kDegrees));
  const char* crs = gdal_->projection(source_);
  if (crs == nullptr || !says_heights(crs)) return degrees;
  LODE_TRY(const Proj proj, Proj::make());
  LODE_TRY(const SplitCrs of_source, split_crs(proj, crs));
  if (!of_source.vertical) return degrees;
  LODE_TRY(const SplitCrs horizontal, split_crs(proj, degrees));
  LODE_TRY(const Proj::Object both, joined(proj, horizontal.horizontal.get(), *of_source.vertical));
  return wkt_of(proj, both.get());
}

}  // namespace lode::io

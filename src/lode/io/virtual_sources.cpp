#include "lode/io/virtual_sources.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <set>
#include <system_error>
#include <vector>

#include "lode/io/gdal_raster.h"
#include "lode/io/height_formats.h"
#include "lode/io/text.h"
#include "lode/io/virtual_raster.h"

namespace lode::io {
namespace {

bool is_same_number(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

/// What a band of a source says of samples that are none.
struct SourceFacts {
  std::optional<double> nodata{};
  bool has_mask = false;
};

class SourceCheck {
 public:
  explicit SourceCheck(const GdalLibrary& gdal) : gdal_(gdal) {}

  /// Also of one that is part of another.
  Result<void> check(const std::string& path);
  [[nodiscard]] std::uint64_t n_bytes() const { return n_bytes_; }

 private:
  Result<void> check_band(const std::string& path, const VirtualRaster& raster,
                          const VirtualBand& band);
  Result<void> check_source(const std::string& path, const VirtualRaster& raster,
                            const VirtualBand& band, const VirtualSource& source);
  Result<SourceFacts> look_at(const std::string& path, const VirtualSource& source) const;
  [[nodiscard]] bool is_new(const std::string& path) { return seen_.insert(path).second; }

  const GdalLibrary& gdal_;
  std::vector<std::string> open_;  ///< VRTs that are being looked at, each a part of the former.
  std::set<std::string> seen_;
  std::uint64_t n_bytes_ = 0;
};

Result<void> SourceCheck::check(const std::string& path) {
  constexpr std::size_t kMaxDepth = 8;
  std::error_code ignored;
  const std::string place = std::filesystem::weakly_canonical(path, ignored).string();
  if (std::ranges::find(open_, place) != open_.end())
    return fail("{}: expected a VRT that is no part of itself", path);
  if (open_.size() >= kMaxDepth)
    return fail("{}: expected up to {} VRTs inside one another", path, kMaxDepth);
  if (!is_new(place)) return {};
  open_.push_back(place);
  LODE_TRY(const VirtualRaster raster, read_virtual_raster(path));
  for (const VirtualBand& band : raster.bands) LODE_CHECK(check_band(path, raster, band));
  open_.pop_back();
  return {};
}

Result<void> SourceCheck::check_band(const std::string& path, const VirtualRaster& raster,
                                     const VirtualBand& band) {
  for (const VirtualSource& source : band.sources)
    LODE_CHECK(check_source(path, raster, band, source));
  if (band.nodata || raster.has_mask || band.is_opacity) return {};
  constexpr const char* kAdvice =
      "a NoDataValue for samples without heights, which would be 0: gdalbuildvrt -vrtnodata "
      "writes one";
  if (const double n = uncovered_samples(raster, band); n > 0)
    return fail("{}: expected {}; {:.0f} of {} x {} samples are in none of its {} files", path,
                kAdvice, n, raster.n_columns, raster.n_rows, band.sources.size());
  for (const VirtualSource& source : band.sources)
    if (!source.is_copied)
      return fail("{}: expected {}; of {} some are left out", path, kAdvice, quoted(source.path));
  return {};
}

Result<void> SourceCheck::check_source(const std::string& path, const VirtualRaster& raster,
                                       const VirtualBand& band, const VirtualSource& source) {
  std::error_code status;
  if (!std::filesystem::is_regular_file(source.path, status))
    return fail("{}: expected its part {}, got no such file", path, quoted(source.path));
  const bool is_nested = is_virtual_raster(source.path);
  if (const auto done = is_nested ? check(source.path) : check_raster_kind(source.path); !done)
    return fail("{}: part {}", path, done.error().message);
  const std::uintmax_t n_bytes = std::filesystem::file_size(source.path, status);
  if (!status && is_new(source.path)) n_bytes_ += n_bytes;
  LODE_TRY(const SourceFacts facts, look_at(path, source));
  if (!source.is_copied || band.is_opacity || raster.has_mask) return {};
  const bool agrees = !facts.nodata || (band.nodata && is_same_number(*facts.nodata, *band.nodata));
  if (!agrees)
    return fail(
        "{}: expected the NoDataValue {} of its part {}, which would become a height, got "
        "{}",
        path, *facts.nodata, quoted(source.path),
        band.nodata ? fmt::format("{}", *band.nodata) : "none");
  if (facts.has_mask)
    return fail("{}: expected a mask, as its part {} has one, got none", path, quoted(source.path));
  return {};
}

Result<SourceFacts> SourceCheck::look_at(const std::string& path,
                                         const VirtualSource& source) const {
  constexpr std::array<const char*, 2> kVirtual{"VRT", nullptr};
  const bool is_nested = is_virtual_raster(source.path);
  gdal_.reset_errors();
  GDALDatasetH dataset =
      gdal_.open(source.path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY,
                 is_nested ? kVirtual.data() : raster_drivers().data(), nullptr, nullptr);
  if (dataset == nullptr)
    return fail("{}: expected its part {} to be {}, got: {}", path, quoted(source.path),
                kRasterFormats, without_controls(gdal_.last_error()));
  const int n_bands = gdal_.n_bands(dataset);
  const double n_columns = gdal_.n_columns(dataset);
  const double n_rows = gdal_.n_rows(dataset);
  SourceFacts facts;
  if (source.band >= 1 && source.band <= n_bands) {
    GDALRasterBandH band = gdal_.band(dataset, source.band);
    int has_nodata = 0;
    const double nodata = gdal_.nodata(band, &has_nodata);
    if (has_nodata != 0) facts.nodata = nodata;
    facts.has_mask = (gdal_.mask_flags(band) & (GMF_PER_DATASET | GMF_ALPHA)) != 0;
  }
  gdal_.close(dataset);
  if (source.band < 0 || source.band > n_bands)
    return fail("{}: expected its part {} to have a band {}, got {} of them", path,
                quoted(source.path), source.band, n_bands);
  constexpr double kRounding = 1e-3;
  if (const auto& from = source.from;
      from && (from->left < -kRounding || from->top < -kRounding ||
               from->right > n_columns + kRounding || from->bottom > n_rows + kRounding))
    return fail(
        "{}: expected a SrcRect inside of the {} x {} samples of {}, got {} x {} from {}, {}", path,
        n_columns, n_rows, quoted(source.path), from->right - from->left, from->bottom - from->top,
        from->left, from->top);
  return facts;
}

}  // namespace

Result<std::uint64_t> check_virtual_sources(const std::string& path, const GdalLibrary& gdal) {
  SourceCheck check(gdal);
  LODE_CHECK(check.check(path));
  return check.n_bytes();
}

}  // namespace lode::io

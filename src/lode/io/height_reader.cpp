#include "lode/io/height_reader.h"

#include <cmath>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "lode/core/out_of_memory.h"
#include "lode/io/gdal_raster.h"
#include "lode/io/height_band.h"
#include "lode/io/height_hgt.h"
#include "lode/io/height_transform.h"

namespace lode::io {
namespace {

Result<HeightRaster> read_hgt_alone(const std::string& path, const HeightReadOptions& options) {
  if (options.band_or_first() != 1 || options.encoding != HeightEncoding::none)
    return fail(
        "{}: expected no band or encoding of a .hgt file, which has one of heights, got one", path);
  if (!options.variable.empty())
    return fail("{}: expected no variable of a .hgt file, got '{}'", path, options.variable);
  if (options.to_degrees)
    return fail("{}: expected no resampling of a .hgt file, which is in degrees, got some", path);
  return read_hgt(path, options);
}

Result<HeightRaster> read_with_gdal(const std::string& path, const HeightReadOptions& options,
                                    Progress& progress) {
  LODE_TRY(GdalRaster raster, GdalRaster::open(path, options, progress));
  LODE_CHECK(raster.state_crs(options.crs));
  if (options.to_degrees) LODE_CHECK(raster.put_in_degrees(*options.to_degrees, options));
  LODE_TRY(HeightRaster result, describe_raster(raster, options));
  LODE_TRY(HeightGrid samples, read_rows(raster, options, {0, raster.n_rows()}, &progress));
  static_cast<HeightFrame&>(samples) = result.grid;
  result.grid = std::move(samples);
  return result;
}

}  // namespace

Result<HeightRaster> read_heights(const std::string& path, const HeightReadOptions& options,
                                  Progress& progress) try {
  if (auto status = check_vertical(options.vertical); !status)
    return fail("{}: {}", path, status.error().message);
  LODE_TRY(HeightRaster raster, is_hgt_path(path) ? read_hgt_alone(path, options)
                                                  : read_with_gdal(path, options, progress));
  auto outcome = set_vertical(raster, options.vertical, progress);
  if (!outcome && progress.is_cancelled()) return outcome.error();
  if (!outcome) return fail("{}: {}", path, outcome.error().message);
  std::vector<std::string> notes = std::exchange(raster.vertical.notes, {});
  raster.vertical = std::move(outcome).value();
  raster.vertical.notes.insert(raster.vertical.notes.begin(), notes.begin(), notes.end());
  return raster;
} catch (const std::bad_alloc&) {
  return out_of_memory("read the raster", path);
}

}  // namespace lode::io

#include "lode/io/height_stream.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "lode/io/gdal_raster.h"
#include "lode/io/height_band.h"
#include "lode/io/height_hgt.h"
#include "lode/io/height_transform.h"

namespace lode::io {
namespace {

/// GDAL would keep a twentieth of the machine's memory in blocks; rows need those of two of theirs.
void limit_cache(const GdalRaster& file, GDALRasterBandH band) {
  constexpr std::int64_t kLeast = std::int64_t{64} << 20;
  constexpr std::int64_t kSample = 8;
  int block_columns = 0;
  int block_rows = 0;
  file.gdal().block_size(band, &block_columns, &block_rows);
  const std::int64_t n_rows = std::max(block_rows, file.n_part_block_rows());
  const std::int64_t row_of_blocks = kSample * file.n_columns() * n_rows;
  file.gdal().set_cache(std::max(kLeast, 2 * row_of_blocks));
}

}  // namespace

struct HeightStream::Impl {
  GdalRaster file;
  HeightReadOptions options;
  HeightRaster raster{};
  std::optional<RowTransformer> transformer{};
};

HeightStream::HeightStream(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
HeightStream::HeightStream(HeightStream&&) noexcept = default;
HeightStream::~HeightStream() = default;

Result<HeightStream> HeightStream::open(const std::string& path, const HeightReadOptions& options,
                                        Progress& progress) {
  if (is_hgt_path(path)) return fail("{}: expected a raster that GDAL reads", path);
  LODE_TRY(GdalRaster file, GdalRaster::open(path, options, progress));
  LODE_CHECK(file.state_crs(options.crs));
  if (options.to_degrees) LODE_CHECK(file.put_in_degrees(*options.to_degrees, options));
  return of(std::make_unique<Impl>(Impl{std::move(file), options}), progress);
}

Result<HeightStream> HeightStream::of(std::unique_ptr<Impl> impl, Progress& progress) {
  const std::string& path = impl->file.path();
  LODE_TRY(HeightRaster raster, describe_raster(impl->file, impl->options));
  auto plan = plan_vertical(raster.grid, impl->options.vertical, progress);
  if (!plan && progress.is_cancelled()) return plan.error();
  if (!plan) return fail("{}: {}", path, plan.error().message);
  std::vector<std::string> notes = std::exchange(raster.vertical.notes, {});
  raster.vertical = std::move(plan->outcome);
  raster.vertical.notes.insert(raster.vertical.notes.begin(), notes.begin(), notes.end());
  if (plan->rows) raster.type = "float64";
  impl->raster = std::move(raster);
  impl->transformer = std::move(plan->rows);
  return HeightStream(std::move(impl));
}

Result<HeightStream> HeightStream::with_vertical(const VerticalOptions& vertical,
                                                 Progress& progress) && {
  impl_->options.vertical = vertical;
  return of(std::move(impl_), progress);
}

const HeightRaster& HeightStream::raster() const { return impl_->raster; }

std::uint64_t HeightStream::n_bytes() const {
  const std::string& type = impl_->raster.type;
  const std::uint64_t n_sample =
      type == "byte" || type == "int8" || type == "int16" || type == "uint16" ? 2
      : type == "float32" || type == "terrarium"                              ? 4
                                                                              : 8;
  return n_sample * static_cast<std::uint64_t>(impl_->raster.grid.n_samples());
}

Result<void> HeightStream::read(std::int32_t first, std::int32_t n_rows,
                                std::span<double> out) const {
  LODE_TRY(GDALRasterBandH band, impl_->file.band(impl_->options.band_or_first()));
  limit_cache(impl_->file, band);
  LODE_TRY(const HeightGrid grid, read_rows(impl_->file, impl_->options, {first, n_rows}, nullptr));
  copy_rows(grid, 0, n_rows, out);
  if (!impl_->transformer) return {};
  Progress progress;
  auto transformed =
      impl_->transformer->transform(impl_->raster.grid, first, n_rows, out, progress);
  if (!transformed) return fail("{}: {}", impl_->file.path(), transformed.error().message);
  return {};
}

void copy_rows(const HeightGrid& grid, std::int32_t first, std::int32_t n_rows,
               std::span<double> out) {
  const auto n = static_cast<std::size_t>(grid.n_columns);
  std::visit(
      [&](const auto& heights) {
        for (std::int32_t y = 0; y < n_rows; ++y) {
          const auto* from = heights.data() + std::int64_t{first + y} * grid.stride;
          const std::span<double> to = out.subspan(static_cast<std::size_t>(y) * n, n);
          for (std::size_t x = 0; x < n; ++x)
            to[x] = grid.has_height(static_cast<std::int32_t>(x), first + y)
                        ? static_cast<double>(from[x])
                        : std::numeric_limits<double>::quiet_NaN();
        }
      },
      grid.heights);
}

}  // namespace lode::io

#include "copy.h"

#include <cpl_error.h>
#include <cpl_string.h>
#include <gdal.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "free_space.h"
#include "missing.h"

namespace lode::raster_import {
namespace {

/// GDAL's type of samples and whether they are int8 as GDAL before 3.7 has it.
struct SampleType {
  GDALDataType type = GDT_Unknown;
  std::size_t n_bytes = 0;
  bool is_signed_byte = false;
};

nc_type type_of(const Variable& variable) {
  if (!is_marked_unsigned(variable)) return variable.type;
  switch (variable.type) {
    case NC_BYTE: return NC_UBYTE;
    case NC_SHORT: return NC_USHORT;
    case NC_INT: return NC_UINT;
    case NC_INT64: return NC_UINT64;
    default: return variable.type;
  }
}

SampleType sample_type(nc_type type) {
  switch (type) {
#if GDAL_VERSION_NUM >= GDAL_COMPUTE_VERSION(3, 7, 0)
    case NC_BYTE: return {GDT_Int8, 1, false};
#else
    case NC_BYTE: return {GDT_Byte, 1, true};
#endif
    case NC_UBYTE: return {GDT_Byte, 1};
    case NC_SHORT: return {GDT_Int16, 2};
    case NC_USHORT: return {GDT_UInt16, 2};
    case NC_INT: return {GDT_Int32, 4};
    case NC_UINT: return {GDT_UInt32, 4};
    case NC_INT64: return {GDT_Int64, 8};
    case NC_UINT64: return {GDT_UInt64, 8};
    case NC_FLOAT: return {GDT_Float32, 4};
    default: return {GDT_Float64, 8};
  }
}

/// A raster that is being written.
class Output {
 public:
  Output(const std::string& path, const Grid& grid, SampleType type) : type_(type) {
    char** options = CSLAddString(nullptr, "BIGTIFF=IF_SAFER");
    if (type.is_signed_byte) options = CSLAddString(options, "PIXELTYPE=SIGNEDBYTE");
    dataset_ =
        GDALCreate(GDALGetDriverByName("GTiff"), path.c_str(), static_cast<int>(grid.columns.n),
                   static_cast<int>(grid.rows.n), 1, type.type, options);
    CSLDestroy(options);
    if (dataset_ == nullptr) fail();
    band_ = GDALGetRasterBand(dataset_, 1);
  }
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;
  ~Output() {
    if (dataset_ != nullptr) GDALClose(dataset_);
  }

  void place(const Grid& grid) {
    if (!grid.columns.has_places) return;
    const auto west_and_step = [](const Axis& axis, bool falls) {
      const double last = axis.first + static_cast<double>(axis.n - 1) * axis.step;
      const bool is_turned = (axis.step < 0) != falls;
      const double step = is_turned ? -axis.step : axis.step;
      return std::array{(is_turned ? last : axis.first) - step / 2, step};
    };
    const auto [x, x_step] = west_and_step(grid.columns, false);
    const auto [y, y_step] = west_and_step(grid.rows, true);
    std::array<double, 6> geotransform{x, x_step, 0, y, 0, y_step};
    if (GDALSetGeoTransform(dataset_, geotransform.data()) != CE_None) fail();
  }
  template <typename T>
  void describe(const Variable& variable, const std::optional<T>& nodata) {
    const Packing packing = read_packing(variable);
    if (packing.scale != 1) GDALSetRasterScale(band_, packing.scale);
    if (packing.offset != 0) GDALSetRasterOffset(band_, packing.offset);
    const std::string unit = text_attribute(variable.group, variable.id, "units");
    if (!unit.empty()) GDALSetRasterUnitType(band_, unit.c_str());
    if (!nodata) return;
    if constexpr (std::is_same_v<T, std::int64_t>) {
      GDALSetRasterNoDataValueAsInt64(band_, *nodata);
    } else if constexpr (std::is_same_v<T, std::uint64_t>) {
      GDALSetRasterNoDataValueAsUInt64(band_, *nodata);
    } else {
      GDALSetRasterNoDataValue(band_, static_cast<double>(*nodata));
    }
  }
  void write(std::size_t first, std::size_t n_rows, std::size_t n_columns, void* samples) {
    if (GDALRasterIO(band_, GF_Write, 0, static_cast<int>(first), static_cast<int>(n_columns),
                     static_cast<int>(n_rows), samples, static_cast<int>(n_columns),
                     static_cast<int>(n_rows), type_.type, 0, 0) != CE_None)
      fail();
  }
  void close() {
    CPLErrorReset();
    GDALClose(dataset_);
    dataset_ = nullptr;
    if (CPLGetLastErrorType() >= CE_Failure) fail();
  }

 private:
  [[noreturn]] static void fail() {
    throw std::runtime_error(std::string("expected to write a temporary copy, got: ") +
                             CPLGetLastErrorMsg());
  }

  SampleType type_;
  GDALDatasetH dataset_ = nullptr;
  GDALRasterBandH band_ = nullptr;
};

std::uint64_t check_size(const Grid& grid, SampleType type, std::uint64_t n_input) {
  // As deflate has it at most; what is small may be emptier.
  constexpr std::uint64_t kRatio = 1032;
  constexpr std::uint64_t kSmall = std::uint64_t{512} << 20;
  const std::string size = std::to_string(grid.columns.n) + " x " + std::to_string(grid.rows.n);
  constexpr auto kMost = static_cast<std::size_t>(std::numeric_limits<int>::max());
  if (grid.columns.n > kMost || grid.rows.n > kMost)
    throw std::runtime_error("expected up to 2^31 - 1 columns and rows, got " + size);
  const std::uint64_t n_bytes = std::uint64_t{grid.columns.n} * grid.rows.n * type.n_bytes;
  if (n_bytes > kSmall && n_bytes / kRatio > n_input)
    throw std::runtime_error("expected a file that can hold " + size + " samples, got " +
                             std::to_string(n_input) + " bytes");
  return n_bytes;
}

/// How rows are read: whole rows of chunks, where these are not too large.
std::size_t rows_at_once(const Grid& grid, std::size_t n_sample) {
  constexpr std::size_t kFew = std::size_t{8} << 20;
  constexpr std::size_t kMany = std::size_t{256} << 20;
  constexpr std::size_t kCache = std::size_t{1} << 30;
  const Variable& variable = grid.variable;
  const std::size_t n_row = grid.columns.n * n_sample;
  std::vector<std::size_t> chunk(variable.rank(), 1);
  int storage = NC_CONTIGUOUS;
  check(nc_inq_var_chunking(variable.group, variable.id, &storage, chunk.data()), "chunks");
  const std::size_t n_chunk_rows =
      storage == NC_CHUNKED ? std::max<std::size_t>(1, chunk[variable.rank() - 2]) : 1;
  // Chunks of several layers are unpacked for one.
  std::size_t n_layers = 1;
  for (std::size_t i = 0; storage == NC_CHUNKED && i + 2 < variable.rank(); ++i)
    n_layers *= std::clamp<std::size_t>(chunk[i], 1, kFew);
  const std::size_t n_at_once = std::max<std::size_t>(1, kFew / n_row / std::min(n_layers, kFew));
  if (storage != NC_CHUNKED) return n_at_once;
  if (n_chunk_rows <= kMany / n_row)
    return std::max(n_at_once / n_chunk_rows, std::size_t{1}) * n_chunk_rows;
  // Chunks stay until all of their rows were read.
  constexpr std::size_t kSlots = 100003;
  check(nc_set_var_chunk_cache(variable.group, variable.id, kCache, kSlots, 1), "chunks");
  return n_at_once;
}

template <typename T>
void turn(bool columns, bool rows, std::size_t n_columns, std::vector<T>& samples) {
  const auto n = static_cast<std::ptrdiff_t>(n_columns);
  if (columns)
    for (auto row = samples.begin(); row != samples.end(); row += n) std::reverse(row, row + n);
  if (!rows) return;
  for (auto low = samples.begin(), high = samples.end(); high - low > n; low += n)
    std::swap_ranges(low, low + n, high -= n);
}

template <typename T>
void copy_samples(const Grid& grid, const Missing<T>& missing, Output& output,
                  const std::function<void(double, std::uint64_t)>& progress) {
  const Variable& variable = grid.variable;
  const std::size_t n_columns = grid.columns.n;
  const std::size_t n_rows = grid.rows.n;
  const std::size_t n_at_once = rows_at_once(grid, sizeof(T));
  const bool turns_rows = grid.rows.has_places && grid.rows.step > 0;
  const bool turns_columns = grid.columns.has_places && grid.columns.step < 0;
  const std::size_t n_blocks = (n_rows + n_at_once - 1) / n_at_once;
  std::vector<std::size_t> start = grid.start;
  std::vector<std::size_t> count(variable.rank(), 1);
  count.back() = n_columns;
  std::vector<T> samples;
  for (std::size_t i = 0; i < n_blocks; ++i) {
    progress(static_cast<double>(i) / static_cast<double>(n_blocks),
             std::uint64_t{n_columns} * n_rows * sizeof(T));
    // From the north, so that the copy grows at its end.
    const std::size_t first = (turns_rows ? n_blocks - 1 - i : i) * n_at_once;
    const std::size_t n = std::min(n_at_once, n_rows - first);
    samples.resize(n * n_columns);
    start[variable.rank() - 2] = first;
    count[variable.rank() - 2] = n;
    check(nc_get_vara(variable.group, variable.id, start.data(), count.data(), samples.data()),
          "samples from row " + std::to_string(first));
    if (!missing.is_plain() && missing.nodata)
      for (T& sample : samples)
        if (missing.is_other(sample)) sample = *missing.nodata;
    turn(turns_columns, turns_rows, n_columns, samples);
    output.write(turns_rows ? n_rows - first - n : first, n, n_columns, samples.data());
  }
}

template <typename T>
void copy_typed(const Grid& grid, const Choice& choice, Output& output,
                const std::function<void(double, std::uint64_t)>& progress) {
  const Missing<T> missing =
      choice.nodata_is_stated ? Missing<T>{} : read_missing<T>(grid.variable);
  output.place(grid);
  output.describe(grid.variable, missing.nodata);
  copy_samples(grid, missing, output, progress);
  output.close();
}

}  // namespace

void copy_grid(const Grid& grid, const Choice& choice, std::uint64_t n_input,
               const std::string& output,
               const std::function<void(double, std::uint64_t)>& progress) {
  const nc_type type = type_of(grid.variable);
  const SampleType sample = sample_type(type);
  check_space(output, check_size(grid, sample, n_input));
  Output file(output, grid, sample);
  switch (type) {
    case NC_BYTE: return copy_typed<std::int8_t>(grid, choice, file, progress);
    case NC_UBYTE: return copy_typed<std::uint8_t>(grid, choice, file, progress);
    case NC_SHORT: return copy_typed<std::int16_t>(grid, choice, file, progress);
    case NC_USHORT: return copy_typed<std::uint16_t>(grid, choice, file, progress);
    case NC_INT: return copy_typed<std::int32_t>(grid, choice, file, progress);
    case NC_UINT: return copy_typed<std::uint32_t>(grid, choice, file, progress);
    case NC_INT64: return copy_typed<std::int64_t>(grid, choice, file, progress);
    case NC_UINT64: return copy_typed<std::uint64_t>(grid, choice, file, progress);
    case NC_FLOAT: return copy_typed<float>(grid, choice, file, progress);
    default: return copy_typed<double>(grid, choice, file, progress);
  }
}

}  // namespace lode::raster_import

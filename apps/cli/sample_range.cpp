#include "sample_range.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace lode::cli {
namespace {

constexpr std::size_t kSlabBytes = std::size_t{8} << 20;

struct Running {
  double lower = std::numeric_limits<double>::infinity();
  double upper = -std::numeric_limits<double>::infinity();
  std::uint64_t n_holes = 0;
};

template <typename T>
void add_samples(std::span<const std::byte> bytes, const std::optional<double>& nodata,
                 Running& running) {
  const std::span samples(reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T));
  for (const T sample : samples) {
    const auto value = static_cast<double>(sample);
    if (!std::isfinite(value) || (nodata && value == *nodata)) {
      ++running.n_holes;
    } else {
      running.lower = std::min(running.lower, value);
      running.upper = std::max(running.upper, value);
    }
  }
}

/// The next box from row `row` of slice `slice`: several slices, or some rows of one.
IndexBox next_box(const RegularGrid& grid, std::int32_t slice, std::int32_t row,
                  std::size_t row_bytes) {
  const auto rows = static_cast<std::int64_t>(
      std::max<std::size_t>(1, kSlabBytes / std::max<std::size_t>(1, row_bytes)));
  const std::int64_t slices = rows / grid.dims[1];
  if (row == 0 && slices >= 1) {
    const auto end =
        static_cast<std::int32_t>(std::min<std::int64_t>(grid.dims[2], slice + slices));
    return {{{0, 0, slice}}, {{grid.dims[0], grid.dims[1], end}}};
  }
  const auto end = static_cast<std::int32_t>(std::min<std::int64_t>(grid.dims[1], row + rows));
  return {{{0, row, slice}}, {{grid.dims[0], end, slice + 1}}};
}

}  // namespace

Result<SampleRange> find_sample_range(VolumeSource& source, Progress& progress) {
  const VolumeInfo& info = source.info();
  const RegularGrid& grid = info.grid;
  const std::size_t row_bytes = static_cast<std::size_t>(grid.dims[0]) * size_of(info.type);
  Running running;
  std::vector<std::byte> slab;
  std::int32_t slice = 0;
  std::int32_t row = 0;
  while (slice < grid.dims[2]) {
    if (progress.is_cancelled()) return cancelled_error();
    const IndexBox box = next_box(grid, slice, row, row_bytes);
    slab.resize(static_cast<std::size_t>(box.n_samples()) * size_of(info.type));
    LODE_CHECK(source.read(box, slab));
    visit_scalar_type(info.type, [&]<typename T>() { add_samples<T>(slab, info.nodata, running); });
    row = box.upper[1] == grid.dims[1] ? 0 : box.upper[1];
    slice = row == 0 ? box.upper[2] : slice;
    progress.report("reading", static_cast<double>(slice) / grid.dims[2]);
  }
  if (running.lower > running.upper) return SampleRange{0, 0, running.n_holes};
  return SampleRange{running.lower, running.upper, running.n_holes};
}

}  // namespace lode::cli

#include "lode/core/height_grid.h"

#include <algorithm>

namespace lode {

double HeightGrid::height(std::int32_t x, std::int32_t y) const {
  const auto at = static_cast<std::size_t>(y * stride + x);
  return std::visit([at](const auto& samples) { return static_cast<double>(samples[at]); },
                    heights);
}

std::uint64_t HeightGrid::n_missing() const {
  return static_cast<std::uint64_t>(std::count(is_valid.begin(), is_valid.end(), 0));
}

std::int64_t padded_stride(std::int32_t n_columns) {
  constexpr std::int64_t kLanes = 32;
  const std::int64_t stride = (std::int64_t{n_columns} + kLanes - 1) / kLanes * kLanes;
  return stride % 512 == 0 ? stride + kLanes : stride;
}

HeightRange height_range(const HeightGrid& grid) {
  HeightRange range;
  bool is_first = true;
  for (std::int32_t y = 0; y < grid.n_rows; ++y)
    std::visit(
        [&](const auto& samples) {
          const auto* row = samples.data() + y * grid.stride;
          for (std::int32_t x = 0; x < grid.n_columns; ++x) {
            if (!grid.has_height(x, y)) continue;
            const auto z = static_cast<double>(row[x]);
            if (is_first) range = {z, z};
            is_first = false;
            range.lower = std::min(range.lower, z);
            range.upper = std::max(range.upper, z);
          }
        },
        grid.heights);
  return range;
}

}  // namespace lode

// The outermost samples of a raster that is put in degrees. GDAL gives heights to what lies on the
// file's pixels, half a step beyond these samples: about half of them would be in cells without
// four heights.
#include "lode/io/degrees_rim.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>

#include "lode/core/height_grid.h"
#include "lode/io/gdal_raster.h"
#include "lode/io/height_band.h"
#include "lode/io/vector_input.h"

namespace lode::io {
namespace {

/// On a column or row where only rounding may have moved it off.
double snapped_place(double at) {
  constexpr double kOff = 1e-6;  // of steps, as places in degrees are told to
  const double nearest = std::round(at);
  return std::abs(at - nearest) <= kOff ? nearest : at;
}

void keep_border(const HeightFrame& file, const HeightGrid& strip, std::int32_t first,
                 std::vector<BorderHeight>& border) {
  for (std::int32_t y = 0; y < strip.n_rows; ++y) {
    const std::int32_t row = first + y;
    const bool is_outermost = row == 0 || row == file.n_rows - 1;
    const std::int32_t step = is_outermost ? 1 : std::max(1, file.n_columns - 1);
    for (std::int32_t x = 0; x < file.n_columns; x += step)
      if (strip.has_height(x, y)) border.push_back({file.world(x, row), strip.height(x, y)});
  }
}

/// All at once, or, where some cannot be, one by one.
std::vector<BorderHeight> border_through(const PlaceTransform& way,
                                         const std::vector<BorderHeight>& border) {
  std::vector<Vec<double, 2>> places;
  places.reserve(border.size());
  for (const BorderHeight& one : border) places.push_back(one.place);
  std::vector<BorderHeight> there;
  there.reserve(border.size());
  if (way.apply<2>(places)) {
    for (std::size_t i = 0; i < border.size(); ++i) there.push_back({places[i], border[i].height});
    return there;
  }
  for (BorderHeight one : border)
    if (way.apply<2>(std::span(&one.place, 1))) there.push_back(one);
  return there;
}

}  // namespace

Result<std::vector<BorderHeight>> read_border(const GdalRaster& raster,
                                              const HeightReadOptions& options) {
  constexpr std::int32_t kRows = 64;
  HeightReadOptions plain = options;
  plain.to_degrees.reset();
  LODE_TRY(const HeightRaster file, describe_raster(raster, plain));
  std::vector<BorderHeight> border;
  for (std::int32_t first = 0; first < file.grid.n_rows; first += kRows) {
    const std::int32_t n = std::min(kRows, file.grid.n_rows - first);
    LODE_TRY(const HeightGrid strip, read_rows(raster, plain, {first, n}, nullptr));
    keep_border(file.grid, strip, first, border);
  }
  return border;
}

Result<std::vector<BorderHeight>> border_in_degrees(const std::string& path,
                                                    const std::string& file_crs,
                                                    const HeightFrame& degrees,
                                                    std::vector<BorderHeight> border) {
  LODE_TRY(const auto way, PlaceTransform::make(path, file_crs, degrees.crs, "raster in degrees"));
  border = border_through(way, border);
  // Longitudes go on beyond 180 degrees where the raster does.
  const double middle = degrees.world(0.5 * degrees.n_columns, 0.5 * degrees.n_rows)[0];
  for (BorderHeight& one : border) {
    const double longitude = middle + std::remainder(one.place[0] - middle, 360.0);
    const auto at = degrees.lattice(longitude, one.place[1]);
    one.place = {{snapped_place(at[0]), snapped_place(at[1])}};
  }
  return border;
}

std::array<std::array<std::int32_t, 2>, 2> lacking(const HeightFrame& degrees,
                                                   const std::vector<BorderHeight>& border) {
  // GDAL's raster holds the file's, but for parts of a step.
  constexpr double kMost = 2;
  std::array<std::array<std::int32_t, 2>, 2> lacks{};
  const std::array<double, 2> last{degrees.n_columns - 1.0, degrees.n_rows - 1.0};
  for (const BorderHeight& one : border)
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double before = std::clamp(std::ceil(-one.place[axis]), 0.0, kMost);
      const double behind = std::clamp(std::ceil(one.place[axis] - last[axis]), 0.0, kMost);
      lacks[axis][0] = std::max(lacks[axis][0], static_cast<std::int32_t>(before));
      lacks[axis][1] = std::max(lacks[axis][1], static_cast<std::int32_t>(behind));
    }
  return lacks;
}

std::vector<RimHeight> find_rim(const HeightFrame& degrees,
                                const std::vector<BorderHeight>& border) {
  struct Wish {
    RimHeight rim;
    double distance;
  };
  std::vector<Wish> wishes;
  for (const BorderHeight& one : border)
    for (const double row : {std::floor(one.place[1]), std::ceil(one.place[1])})
      for (const double column : {std::floor(one.place[0]), std::ceil(one.place[0])}) {
        if (!(row >= 0 && column >= 0 && row < degrees.n_rows && column < degrees.n_columns))
          continue;
        wishes.push_back(
            {{static_cast<std::int32_t>(row), static_cast<std::int32_t>(column), one.height},
             std::hypot(one.place[0] - column, one.place[1] - row)});
      }
  const auto key = [](const Wish& wish) {
    return std::tuple(wish.rim.row, wish.rim.column, wish.distance, wish.rim.height);
  };
  std::ranges::sort(wishes, {}, key);
  std::vector<RimHeight> rim;
  for (const Wish& wish : wishes)
    if (rim.empty() || rim.back().row != wish.rim.row || rim.back().column != wish.rim.column)
      rim.push_back(wish.rim);
  return rim;
}

}  // namespace lode::io

#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lode/core/height_points.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"
#include "lode/io/vertical_options.h"

namespace lode::io {

struct PointReadOptions {
  std::vector<std::uint8_t> classes{};  ///< Of LAS, to be kept; none: all.
  std::optional<double> nodata{};       ///< Points of this height are missing.
  std::string crs{};                    ///< EPSG:N or WKT, instead of what the file says.
  VerticalOptions vertical{};           ///< See set_vertical().
};

/// What a file has, and what of it was kept.
struct PointCounts {
  std::uint64_t n_in_file = 0;
  std::uint64_t n_missing = 0;      ///< Without a finite height, or with the nodata value.
  std::uint64_t n_withheld = 0;     ///< Left out, as LAS wants it; of any class.
  std::uint64_t n_other_class = 0;  ///< Left out for their class.
  std::uint64_t n_synthetic = 0;    ///< Kept, though not measured.
  std::array<std::uint64_t, 256> of_class{};  ///< Of LAS: all points of the file.
};

/// Scattered points, finite, and what their file says of them.
struct PointFile {
  std::vector<Vec3d> points;  ///< x, y and height.
  PointLattice lattice;       ///< That the file's numbers lie on.
  std::string format;         ///< "LAS 1.2, format 3", or "text".
  std::string crs;            ///< As WKT; empty: not known.
  std::string crs_note;       ///< Why it is not, where the file has one; else empty.
  bool has_degrees = false;   ///< A heading of text says longitude and latitude, of x and y.
  std::string vertical_unit;  ///< Empty: not known.
  PointCounts counts;
  VerticalOutcome vertical{};

  [[nodiscard]] bool has_classes() const { return format.starts_with("LAS"); }
};

}  // namespace lode::io

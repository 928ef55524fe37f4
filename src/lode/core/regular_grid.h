#pragma once

#include <cstdint>
#include <string_view>

#include "lode/core/box.h"
#include "lode/core/vec.h"

namespace lode {

/// Which way the world axes of a file point. Lode never converts; it carries the name along.
enum class Frame : std::uint8_t { unknown = 0, ras = 1, lps = 2 };

/// "RAS", "LPS" or "unknown".
[[nodiscard]] std::string_view name_of(Frame frame);

/// Samples at origin + direction · (spacing ⊙ index), 0 <= index < dims; x varies fastest.
struct RegularGrid {
  Index3 dims{{0, 0, 0}};             ///< Samples per axis, each >= 1.
  Vec3d spacing{{1, 1, 1}};           ///< World units between samples, each > 0.
  Vec3d origin{{0, 0, 0}};            ///< World position of sample (0, 0, 0).
  Mat3 direction = Mat3::identity();  ///< Columns are the axes' unit directions; det may be < 0.
  Frame frame = Frame::unknown;

  friend bool operator==(const RegularGrid&, const RegularGrid&) = default;

  [[nodiscard]] std::int64_t n_samples() const { return std::int64_t{dims[0]} * dims[1] * dims[2]; }
  [[nodiscard]] IndexBox index_box() const { return {{{0, 0, 0}}, dims}; }
  /// direction · diag(spacing): the linear part of index_to_world.
  [[nodiscard]] Mat3 index_to_world_matrix() const;
  [[nodiscard]] Vec3d to_world(const Vec3d& index) const;
  /// The inverse of to_world.
  [[nodiscard]] Vec3d to_index(const Vec3d& world) const;
  /// Whether each axis runs along one of the world's.
  [[nodiscard]] bool has_world_axes() const;
  /// The smallest axis-aligned world box round all samples.
  [[nodiscard]] Box3d world_bounds() const;
};

}  // namespace lode

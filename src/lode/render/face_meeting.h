#pragma once

#include <array>
#include <cstdint>

#include "lode/render/volume_view.h"

namespace lode {

/// Bits of a vertex's place relative to a line of sight that are cut off, so that products of two
/// are exact.
inline constexpr std::uint64_t kCutBits = 0x7ffffff;

/// A vertex relative to a line of sight: u right and v up of it at the vertex's own depth.
struct LineOffset {
  double u;
  double v;
};

/// Whether u v' - u' v of two vertices counts as negative where it is zero: the line counts as
/// moved by (e, e^2) for a tiny e > 0, and of two vertices at one place the smaller number comes
/// first.
[[nodiscard]] bool is_tie_negative(const LineOffset& a, const LineOffset& b, std::uint64_t vertex_a,
                                   std::uint64_t vertex_b);

/// A face that a line of sight goes through.
struct MetFace {
  std::array<LineOffset, 3> offsets;
  std::array<double, 3> depths;
  std::array<double, 3> levels;
  std::array<double, 3> edges;  ///< u v' - u' v of the other two corners, >= 0.
  std::array<std::uint32_t, 3> corners;
  double depth = 0;  ///< Where it is met.
  double level = 0;
};

/// Whether a line meets an outer face, and where.
[[nodiscard]] bool meet_face(const VolumeView& view, const SightLine& line,
                             std::uint32_t outer_face, MetFace& face);

}  // namespace lode

#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/surface.h"
#include "lode/core/vec.h"
#include "lode/render/color.h"

namespace lode {

/// What a surface is painted with, linear light.
struct SurfaceColors {
  Vec3f uniform{{1, 1, 1}};
  std::vector<Vec3f> per_vertex;  ///< Empty when the whole surface is `uniform`.
  /// Where triangles are coloured by a field, its share of the ramp at their vertices, 0..1, which
  /// is linear between them as the field is; negative elsewhere. Empty: nowhere.
  std::vector<float> levels{};
  std::vector<Vec3f> ramp{};  ///< Colours of evenly spaced levels from 0 to 1.

  /// At a point of a triangle, whose corners make it up by `weights`.
  [[nodiscard]] Vec3f at(const std::array<std::uint32_t, 3>& triangle,
                         const std::array<float, 3>& weights) const;
  [[nodiscard]] const Vec3f& at(std::uint32_t vertex) const {
    return per_vertex.empty() ? uniform : per_vertex[vertex];
  }
};

/// One colour per isovalue of the surface: distinct_colors in ascending order for surfaces,
/// sequential_color by value for lines and for more isovalues than a reader can count. `color`,
/// when set, paints everything. Non-finite isovalues count as the lowest.
[[nodiscard]] SurfaceColors color_surface(const Surface& surface, const std::optional<Color>& color,
                                          Threads threads);

}  // namespace lode

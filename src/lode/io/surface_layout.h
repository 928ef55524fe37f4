#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lode/core/surface.h"

namespace lode::io {

/// What a surface file's head has to say of its content.
struct SurfaceLayout {
  Vec3d origin{{0, 0, 0}};
  std::uint64_t n_vertices = 0;
  std::uint64_t n_triangles = 0;
  std::uint64_t n_lines = 0;
  bool has_normals = false;
  bool has_isovalues = false;
  bool has_values = false;
  bool has_origins = false;
  bool has_errors = false;
  bool has_regions = false;
  bool has_places = false;                ///< In float64, in place of positions from the origin.
  std::vector<std::string> attributes{};  ///< Their names.
  std::vector<MeshRegion> region_names{};
  std::vector<BoundaryPatch> patches{};

  [[nodiscard]] static SurfaceLayout of(const Surface& surface,
                                        std::span<const Vec3d> places = {}) {
    std::vector<std::string> names;
    for (const Attribute& attribute : surface.attributes) names.push_back(attribute.name);
    return {.origin = surface.origin,
            .n_vertices = surface.positions.size(),
            .n_triangles = surface.triangles.size(),
            .n_lines = surface.lines.size(),
            .has_normals = !surface.normals.empty(),
            .has_isovalues = !surface.isovalues.empty(),
            .has_values = !surface.values.empty(),
            .has_origins = !surface.origins.empty(),
            .has_errors = !surface.errors.empty(),
            .has_regions = !surface.regions.empty(),
            .has_places = !places.empty(),
            .attributes = std::move(names),
            .region_names = surface.region_names,
            .patches = surface.patches};
  }
  [[nodiscard]] bool has_origin() const { return origin != Vec3d{{0, 0, 0}}; }
  /// Whether coordinates are doubles.
  [[nodiscard]] bool is_double() const { return has_places || has_origin(); }
  [[nodiscard]] std::uint64_t n_cells() const { return n_triangles + n_lines; }
  [[nodiscard]] std::uint64_t n_corners() const { return 3 * n_triangles + 2 * n_lines; }
};

}  // namespace lode::io

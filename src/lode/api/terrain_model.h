#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace lode {

/// What terrain is asked of: a TIN made anew for each question, or what was built once for all.
enum class TerrainModel : std::uint8_t {
  delaunay_selector,
  delaunay_pyramid,
  complete_pyramid,
  triangle_lists,
  linked_triangle_lists,
  ternary_triangulation,
  implicit_delaunay_pyramid,
  surface_quadtree,
  quaternary_triangulation,
  restricted_quadtree,
  right_triangle_bisection,
  adaptive_triangulation,
  hierarchical_delaunay
};

/// Those that are built, and have files.
inline constexpr std::array kBuiltTerrainModels{
    TerrainModel::delaunay_pyramid,       TerrainModel::complete_pyramid,
    TerrainModel::triangle_lists,         TerrainModel::linked_triangle_lists,
    TerrainModel::ternary_triangulation,  TerrainModel::implicit_delaunay_pyramid,
    TerrainModel::surface_quadtree,       TerrainModel::quaternary_triangulation,
    TerrainModel::restricted_quadtree,    TerrainModel::right_triangle_bisection,
    TerrainModel::adaptive_triangulation, TerrainModel::hierarchical_delaunay};

[[nodiscard]] constexpr bool is_quadtree(TerrainModel model) {
  return model == TerrainModel::surface_quadtree ||
         model == TerrainModel::quaternary_triangulation ||
         model == TerrainModel::restricted_quadtree;
}

/// Whether its triangles are halves and quarters of squares of samples. Files of these have all
/// heights, and samples can be kept as vertices of all meshes.
[[nodiscard]] constexpr bool is_on_squares(TerrainModel model) {
  return is_quadtree(model) || model == TerrainModel::right_triangle_bisection;
}

/// Whether it is of triangles refined into triangulations, one level for each tolerance. Vertices
/// of these lie between samples, too.
[[nodiscard]] constexpr bool is_hierarchy(TerrainModel model) {
  return model == TerrainModel::adaptive_triangulation ||
         model == TerrainModel::hierarchical_delaunay;
}

/// Whether it is a Delaunay pyramid kept by levels, a mesh for each tolerance: see
/// delaunay_pyramid/encodings.h.
[[nodiscard]] constexpr bool is_pyramid_of_levels(TerrainModel model) {
  return model == TerrainModel::complete_pyramid || model == TerrainModel::triangle_lists ||
         model == TerrainModel::linked_triangle_lists;
}

/// Whether it has interference links.
[[nodiscard]] constexpr bool has_links(TerrainModel model) {
  return model == TerrainModel::complete_pyramid || model == TerrainModel::linked_triangle_lists;
}

/// Whether it can be built of scattered points, and keep lines as edges.
[[nodiscard]] constexpr bool is_of_any_points(TerrainModel model) {
  return model == TerrainModel::delaunay_pyramid || model == TerrainModel::ternary_triangulation ||
         model == TerrainModel::implicit_delaunay_pyramid || is_pyramid_of_levels(model) ||
         is_hierarchy(model);
}

/// Whether its tolerances may vary.
[[nodiscard]] constexpr bool may_vary(TerrainModel model) {
  return model != TerrainModel::delaunay_selector && model != TerrainModel::restricted_quadtree &&
         !is_pyramid_of_levels(model);
}

/// Whether its triangles leave gaps where their sizes differ.
[[nodiscard]] constexpr bool has_gaps(TerrainModel model) {
  return model == TerrainModel::surface_quadtree || model == TerrainModel::quaternary_triangulation;
}

/// As --model, files and outputs name it.
[[nodiscard]] constexpr const char* name_of(TerrainModel model) {
  switch (model) {
    case TerrainModel::delaunay_selector: return "delaunay_selector";
    case TerrainModel::delaunay_pyramid: return "delaunay_pyramid";
    case TerrainModel::complete_pyramid: return "complete_pyramid";
    case TerrainModel::triangle_lists: return "triangle_lists";
    case TerrainModel::linked_triangle_lists: return "linked_triangle_lists";
    case TerrainModel::ternary_triangulation: return "ternary_triangulation";
    case TerrainModel::implicit_delaunay_pyramid: return "implicit_delaunay_pyramid";
    case TerrainModel::surface_quadtree: return "surface_quadtree";
    case TerrainModel::quaternary_triangulation: return "quaternary_triangulation";
    case TerrainModel::restricted_quadtree: return "restricted_quadtree";
    case TerrainModel::right_triangle_bisection: return "right_triangle_bisection";
    case TerrainModel::adaptive_triangulation: return "adaptive_triangulation";
    case TerrainModel::hierarchical_delaunay: return "hierarchical_delaunay";
  }
  return "";
}

/// The model of that name that is built, or nothing.
[[nodiscard]] constexpr std::optional<TerrainModel> built_model_of(std::string_view name) {
  for (const TerrainModel model : kBuiltTerrainModels)
    if (name == name_of(model)) return model;
  return {};
}

}  // namespace lode

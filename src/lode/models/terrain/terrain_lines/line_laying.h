#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/place_line.h"
#include "lode/core/progress.h"
#include "lode/locate/tin_locator.h"
#include "lode/models/terrain/terrain_lines/noding.h"

namespace lode::terrain_lines {

struct LayingOptions {
  bool is_draped = false;  ///< All heights are the surface's, also of lines with their own.
  double max_error = 0;    ///< Draped lines are no farther from the surface where it is looked at.
  double step = 1;         ///< At least one look in so many columns and rows, > 0.
  double pull = 0;         ///< Ends at the outline are moved in by so many columns and rows.
};

struct LaidLines {
  std::vector<LineToNode> parts;  ///< Of two places or more; all with heights.
  std::uint64_t n_own = 0;        ///< Lines with their own heights.
  std::uint64_t n_outside = 0;    ///< Lines no part of which is in the domain, or of one place.
  std::uint64_t n_cut = 0;        ///< Lines of which some is outside.
};

/// Lays lines, columns and rows, onto a TIN with heights: what is outside of its triangles, looked
/// at in steps, is left out. Lines keep their heights, which are linear between those of their
/// points that have one; those without any, and draped ones, get the TIN's at their points and, so
/// that they follow it, at more between. Fails when cancelled.
[[nodiscard]] Result<LaidLines> lay_lines(std::span<const PlaceLine> lines,
                                          const TinLocator& surface, const LayingOptions& options,
                                          Progress& progress);

}  // namespace lode::terrain_lines

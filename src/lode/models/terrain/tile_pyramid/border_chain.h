#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/models/terrain/tile_pyramid/border_lines.h"
#include "lode/models/terrain/tile_pyramid/tile_scheme.h"

namespace lode::tile_pyramid {

/// What a level is made to.
struct LevelForm {
  double max_error = 0;               ///< Vertical, of the samples.
  double height_step = 0;             ///< A power of 2: heights of vertices are multiples of it.
  std::int32_t most_gap = kLastNode;  ///< Nodes between neighbours on a side, at most.
};

/// The multiple that is nearest.
[[nodiscard]] double rounded(double height, double step);

/// Nodes of a side such that the line through them, at rounded heights, is nowhere farther than
/// max_error from the profile, as far as nodes allow it: those in `kept`, which rise, both ends,
/// and where that is too far off the node next to the worst place, again and again (U. Ramer 1972;
/// D. Douglas, T. Peucker 1973). Gaps beyond the largest are cut into equal ones.
[[nodiscard]] std::vector<std::uint16_t> refine_chain(const Profile& profile,
                                                      std::span<const std::uint16_t> kept,
                                                      const LevelForm& form);

/// The nodes of all sides of tiles, level by level. Tiles of one level share those of the side
/// between them; nodes of a coarser level are nodes of the finer ones, too.
class BorderChains {
 public:
  /// `ranges` and `forms`: by level.
  BorderChains(const BorderLines& lines, std::span<const TileRange> ranges,
               std::span<const LevelForm> forms, Threads threads);

  [[nodiscard]] std::span<const std::uint16_t> nodes(const TileSide& side) const;

 private:
  struct Level {
    TileRange range;
    std::vector<std::vector<std::uint16_t>> west_sides;   ///< Columns one more than of tiles.
    std::vector<std::vector<std::uint16_t>> south_sides;  ///< Rows one more.
  };
  [[nodiscard]] std::vector<std::uint16_t> inherited(const TileSide& side) const;
  /// Nothing where the level has no such side.
  [[nodiscard]] static const std::vector<std::uint16_t>* find(const Level& level,
                                                              const TileSide& side);

  std::vector<Level> levels_;
};

}  // namespace lode::tile_pyramid

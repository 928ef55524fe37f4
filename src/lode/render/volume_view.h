#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/render/lens.h"
#include "lode/render/light_integral.h"
#include "lode/render/mesh_volume.h"

namespace lode {

/// A vertex as a camera sees it: along its axes, normalised, and the field as a level.
struct alignas(32) ViewVertex {
  double right;
  double up;
  double depth;
  double level;
};

/// A line of sight: where it is right and up at depth z is right + right_slope · z and so on.
struct SightLine {
  double right;
  double up;
  double right_slope;
  double up_slope;
};

/// A volume seen through a lens: its vertices in the camera's axes, and by tile of the picture the
/// outer faces that lines of sight through the tile may meet, in front of the eye or behind it.
class VolumeView {
 public:
  static constexpr int kTile = 8;           ///< Pixels a side.
  static constexpr double kTileMargin = 1;  ///< Pixels round a tile from which it may be asked.

  /// `volume` and `lens` must outlive the view. `width` and `height` in pixels.
  VolumeView(const MeshVolume& volume, const LightRamps& ramps, const Lens& lens,
             const Normalization& normalization, std::array<int, 2> size, Threads threads);

  [[nodiscard]] const CellLinks& links() const { return volume_.links(); }
  [[nodiscard]] std::span<const ViewVertex> vertices() const { return vertices_; }
  [[nodiscard]] int n_tiles_x() const { return n_tiles_x_; }
  [[nodiscard]] int n_tiles_y() const { return n_tiles_y_; }
  [[nodiscard]] double eye_depth() const { return eye_[2]; }

  struct TileFace {
    std::uint32_t face;
    std::array<float, 4> box;  ///< Left, right, top and bottom in pixels.
  };
  [[nodiscard]] std::span<const TileFace> faces_in(int tile_x, int tile_y) const;
  [[nodiscard]] SightLine line_through(double x, double y) const;
  /// Of a line, for each unit of depth.
  [[nodiscard]] double world_length(const SightLine& line) const;

 private:
  struct TileRange {
    int x0, x1, y0, y1;  ///< x0 <= x < x1.
  };
  void place_vertices(const LightRamps& ramps, const Normalization& normalization, Threads threads);
  [[nodiscard]] TileFace box_of(std::uint32_t face) const;
  [[nodiscard]] TileRange tiles_of(const TileFace& face) const;
  [[nodiscard]] bool may_meet_column(std::uint32_t face, int column) const;
  [[nodiscard]] bool may_meet_row(std::uint32_t face, int row) const;
  void fill_tiles();

  const MeshVolume& volume_;
  const Lens& lens_;
  Vec3d eye_;  ///< In the camera's axes: right, up, depth.
  double world_per_unit_;
  int n_tiles_x_;
  int n_tiles_y_;
  std::vector<ViewVertex> vertices_;
  std::vector<std::size_t> first_;  ///< Of each tile, by rows; one more at the end.
  std::vector<TileFace> faces_;
};

}  // namespace lode

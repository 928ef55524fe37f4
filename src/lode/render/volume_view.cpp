#include "lode/render/volume_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lode {

VolumeView::VolumeView(const MeshVolume& volume, const LightRamps& ramps, const Lens& lens,
                       const Normalization& normalization, std::array<int, 2> size, Threads threads)
    : volume_(volume),
      lens_(lens),
      eye_{{dot(lens.axes().right, lens.eye()), dot(lens.axes().up, lens.eye()),
            dot(lens.axes().forward, lens.eye())}},
      world_per_unit_(1 / normalization.scale),
      n_tiles_x_((size[0] + kTile - 1) / kTile),
      n_tiles_y_((size[1] + kTile - 1) / kTile) {
  place_vertices(ramps, normalization, threads);
  fill_tiles();
}

void VolumeView::place_vertices(const LightRamps& ramps, const Normalization& normalization,
                                Threads threads) {
  const SimplexMesh& mesh = volume_.mesh();
  vertices_.resize(mesh.positions.size());
  parallel_for(vertices_.size(), threads, 1 << 14, [&](std::size_t v, int) {
    const Vec3d p = normalization.apply(mesh.positions[v]);
    vertices_[v] = {dot(lens_.axes().right, p), dot(lens_.axes().up, p),
                    dot(lens_.axes().forward, p), ramps.level(mesh.values[v])};
  });
}

SightLine VolumeView::line_through(double x, double y) const {
  const Lens::Slopes slopes = lens_.slopes_at(x, y);
  return {eye_[0] - slopes.right * eye_[2], eye_[1] - slopes.up * eye_[2], slopes.right, slopes.up};
}

double VolumeView::world_length(const SightLine& line) const {
  return std::sqrt(1 + line.right_slope * line.right_slope + line.up_slope * line.up_slope) *
         world_per_unit_;
}

std::span<const VolumeView::TileFace> VolumeView::faces_in(int tile_x, int tile_y) const {
  const auto tile = static_cast<std::size_t>(tile_y) * static_cast<std::size_t>(n_tiles_x_) +
                    static_cast<std::size_t>(tile_x);
  return {faces_.data() + first_[tile], faces_.data() + first_[tile + 1]};
}

// The face's picture where all of it is before the eye, else no limits.
VolumeView::TileFace VolumeView::box_of(std::uint32_t face, bool& is_in_front) const {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  constexpr double kNearest = 1e-9;
  constexpr double kFarthest = 1e9;  // Pixels: float and int hold it.
  TileFace result{face, {kInfinity, -kInfinity, kInfinity, -kInfinity}};
  for (const std::uint32_t corner : links().outer_faces[face].corners) {
    const ViewVertex& v = vertices_[corner];
    const double distance = v.depth - eye_[2];
    is_in_front = distance > kNearest;
    if (is_in_front) {
      const Lens::Point p =
          lens_.point_at({(v.right - eye_[0]) / distance, (v.up - eye_[1]) / distance});
      is_in_front = std::abs(p.x) < kFarthest && std::abs(p.y) < kFarthest;
      if (!is_in_front) break;
      const auto x = static_cast<float>(p.x);
      const auto y = static_cast<float>(p.y);
      const float slack = 0.01f + 1e-6f * std::max(std::abs(x), std::abs(y));
      result.box = {std::min(result.box[0], x - slack), std::max(result.box[1], x + slack),
                    std::min(result.box[2], y - slack), std::max(result.box[3], y + slack)};
    }
    if (!is_in_front) break;
  }
  if (!is_in_front) result.box = {-kInfinity, kInfinity, -kInfinity, kInfinity};
  return result;
}

VolumeView::TileRange VolumeView::tiles_of(const TileFace& face) const {
  constexpr auto kMargin = static_cast<float>(kTileMargin);
  const auto tile = [&](float pixel, int n) {
    return static_cast<int>(std::clamp(std::floor(pixel / kTile), 0.0f, static_cast<float>(n)));
  };
  const auto& [left, right, top, bottom] = face.box;
  return {tile(left - kMargin, n_tiles_x_), tile(right + kMargin + kTile, n_tiles_x_),
          tile(top - kMargin, n_tiles_y_), tile(bottom + kMargin + kTile, n_tiles_y_)};
}

// Lines through a tile make a double pyramid. Outside it are four convex parts, one beyond each
// side (before the eye and behind it they change places): what is all in one of them is not met.
bool VolumeView::may_meet(std::uint32_t face, int tile_x, int tile_y) const {
  constexpr double kMargin = kTileMargin + 0.01;
  const SightLine low = line_through(tile_x * kTile - kMargin, tile_y * kTile - kMargin);
  const SightLine high =
      line_through((tile_x + 1) * kTile + kMargin, (tile_y + 1) * kTile + kMargin);
  std::array<bool, 4> is_beyond{true, true, true, true};
  for (const std::uint32_t corner : links().outer_faces[face].corners) {
    const ViewVertex& v = vertices_[corner];
    const double right_of_low = v.right - low.right - low.right_slope * v.depth;
    const double right_of_high = v.right - high.right - high.right_slope * v.depth;
    const double above_low = v.up - low.up - low.up_slope * v.depth;
    const double above_high = v.up - high.up - high.up_slope * v.depth;
    is_beyond[0] &= right_of_low < 0 && right_of_high < 0;
    is_beyond[1] &= right_of_low > 0 && right_of_high > 0;
    is_beyond[2] &= above_low < 0 && above_high < 0;
    is_beyond[3] &= above_low > 0 && above_high > 0;
  }
  return std::ranges::none_of(is_beyond, [](bool is) { return is; });
}

void VolumeView::fill_tiles() {
  const auto n_faces = static_cast<std::uint32_t>(links().outer_faces.size());
  const auto for_each_tile = [&](const auto& visit) {
    for (std::uint32_t f = 0; f < n_faces; ++f) {
      bool is_in_front = false;
      const TileFace face = box_of(f, is_in_front);
      const TileRange range = tiles_of(face);
      for (int y = range.y0; y < range.y1; ++y) {
        for (int x = range.x0; x < range.x1; ++x) {
          if (is_in_front || may_meet(f, x, y))
            visit(face, static_cast<std::size_t>(y) * static_cast<std::size_t>(n_tiles_x_) +
                            static_cast<std::size_t>(x));
        }
      }
    }
  };
  const std::size_t n_tiles =
      static_cast<std::size_t>(n_tiles_x_) * static_cast<std::size_t>(n_tiles_y_);
  first_.assign(n_tiles + 2, 0);
  for_each_tile([&](const TileFace&, std::size_t tile) { ++first_[tile + 2]; });
  for (std::size_t i = 2; i < first_.size(); ++i) first_[i] += first_[i - 1];
  faces_.resize(first_.back());
  for_each_tile([&](const TileFace& face, std::size_t tile) { faces_[first_[tile + 1]++] = face; });
}

}  // namespace lode

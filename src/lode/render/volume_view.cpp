#include "lode/render/volume_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lode {
namespace {

constexpr double kMeetMargin = VolumeView::kTileMargin + 0.01;  // Pixels; rounding included.

}  // namespace

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

// The face's picture where all of it is before the eye or all of it behind, else no limits.
VolumeView::TileFace VolumeView::box_of(std::uint32_t face) const {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  constexpr double kNearest = 1e-9;
  constexpr double kFarthest = 1e9;  // Pixels: float and int hold it.
  const TileFace unlimited{face, {-kInfinity, kInfinity, -kInfinity, kInfinity}};
  TileFace result{face, {kInfinity, -kInfinity, kInfinity, -kInfinity}};
  double side = 0;
  for (const std::uint32_t corner : links().outer_faces[face].corners) {
    const ViewVertex& v = vertices_[corner];
    const double distance = v.depth - eye_[2];
    if (!(std::abs(distance) > kNearest) || distance * side < 0) return unlimited;
    side = distance;
    const Lens::Point p =
        lens_.point_at({(v.right - eye_[0]) / distance, (v.up - eye_[1]) / distance});
    if (!(std::abs(p.x) < kFarthest && std::abs(p.y) < kFarthest)) return unlimited;
    const auto x = static_cast<float>(p.x);
    const auto y = static_cast<float>(p.y);
    const float slack = 0.01f + 1e-6f * std::max(std::abs(x), std::abs(y));
    result.box = {std::min(result.box[0], x - slack), std::max(result.box[1], x + slack),
                  std::min(result.box[2], y - slack), std::max(result.box[3], y + slack)};
  }
  return result;
}

VolumeView::TileRange VolumeView::tiles_of(const TileFace& face) const {
  constexpr auto kReach = static_cast<float>(kTileMargin);
  const auto tile = [&](float pixel, int n) {
    return static_cast<int>(std::clamp(std::floor(pixel / kTile), 0.0f, static_cast<float>(n)));
  };
  const auto& [left, right, top, bottom] = face.box;
  return {tile(left - kReach, n_tiles_x_), tile(right + kReach + kTile, n_tiles_x_),
          tile(top - kReach, n_tiles_y_), tile(bottom + kReach + kTile, n_tiles_y_)};
}

// Lines through a column of tiles make a double wedge. Beside it are two convex parts (before the
// eye and behind it they change places): what is all in one of them is not met.
bool VolumeView::may_meet_column(std::uint32_t face, int column) const {
  const SightLine low = line_through(column * kTile - kMeetMargin, 0);
  const SightLine high = line_through((column + 1) * kTile + kMeetMargin, 0);
  bool is_left = true;
  bool is_right = true;
  for (const std::uint32_t corner : links().outer_faces[face].corners) {
    const ViewVertex& v = vertices_[corner];
    const double of_low = v.right - low.right - low.right_slope * v.depth;
    const double of_high = v.right - high.right - high.right_slope * v.depth;
    is_left &= of_low < 0 && of_high < 0;
    is_right &= of_low > 0 && of_high > 0;
  }
  return !is_left && !is_right;
}

bool VolumeView::may_meet_row(std::uint32_t face, int row) const {
  const SightLine low = line_through(0, row * kTile - kMeetMargin);
  const SightLine high = line_through(0, (row + 1) * kTile + kMeetMargin);
  bool is_above = true;
  bool is_below = true;
  for (const std::uint32_t corner : links().outer_faces[face].corners) {
    const ViewVertex& v = vertices_[corner];
    const double of_low = v.up - low.up - low.up_slope * v.depth;
    const double of_high = v.up - high.up - high.up_slope * v.depth;
    is_above &= of_low > 0 && of_high > 0;
    is_below &= of_low < 0 && of_high < 0;
  }
  return !is_above && !is_below;
}

void VolumeView::fill_tiles() {
  const auto n_faces = static_cast<std::uint32_t>(links().outer_faces.size());
  std::vector<int> columns;
  std::vector<int> rows;
  const auto for_each_tile = [&](const auto& visit) {
    for (std::uint32_t f = 0; f < n_faces; ++f) {
      const TileFace face = box_of(f);
      const TileRange range = tiles_of(face);
      const bool is_limited = std::isfinite(face.box[0]);
      columns.clear();
      rows.clear();
      for (int x = range.x0; x < range.x1; ++x)
        if (is_limited || may_meet_column(f, x)) columns.push_back(x);
      for (int y = range.y0; y < range.y1; ++y)
        if (is_limited || may_meet_row(f, y)) rows.push_back(y);
      for (const int y : rows)
        for (const int x : columns)
          visit(face, static_cast<std::size_t>(y) * static_cast<std::size_t>(n_tiles_x_) +
                          static_cast<std::size_t>(x));
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

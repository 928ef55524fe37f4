#include "lode/render/volume_tracer.h"

#include <algorithm>

namespace lode {
namespace {

constexpr std::uint32_t kUsed = 0xffffffffU;

/// Whether a line comes near the ball of radius 1 that holds the volume; not where it is too far
/// for numbers.
bool comes_near(const SightLine& line) {
  const double along = line.right * line.right_slope + line.up * line.up_slope;
  const double slope2 = line.right_slope * line.right_slope + line.up_slope * line.up_slope;
  const double distance2 =
      line.right * line.right + line.up * line.up - along * along / (1 + slope2);
  return distance2 < 1.01;
}

}  // namespace

// Leaves the hits of the ray at the end of hits_, nearest first.
void VolumeTracer::find_hits(int tile_x, int tile_y, const VolumeRay& ray, Walker& walker) {
  const auto x = static_cast<float>(ray.x);
  const auto y = static_cast<float>(ray.y);
  walker.next_hit = hits_.size();
  if (comes_near(walker.line)) {
    for (const VolumeView::TileFace& face : view_.faces_in(tile_x, tile_y)) {
      const auto& [left, right, top, bottom] = face.box;
      if (x < left || x > right || y < top || y > bottom) continue;
      if (walker.walk.enter(view_, walker.line, face.face))
        hits_.push_back({walker.walk.depth(), face.face});
    }
  }
  walker.end_hit = hits_.size();
  std::sort(hits_.begin() + static_cast<std::ptrdiff_t>(walker.next_hit), hits_.end(),
            [](const Hit& a, const Hit& b) {
              return a.depth != b.depth ? a.depth < b.depth : a.face < b.face;
            });
}

/// Goes to the nearest outer face that no walk has ended at; false where there is none.
bool VolumeTracer::start_walk(Walker& walker) {
  while (walker.next_hit < walker.end_hit) {
    const Hit& hit = hits_[walker.next_hit++];
    if (hit.face == kUsed) continue;
    if (hit.depth >= walker.end) return false;
    walker.walk.enter(view_, walker.line, hit.face);
    walker.depth = walker.walk.depth();
    walker.level = walker.walk.level();
    walker.integral.start(ramps_, walker.level);
    return true;
  }
  return false;
}

void VolumeTracer::leave(Walker& walker) {
  for (std::size_t i = walker.next_hit; i < walker.end_hit; ++i) {
    if (hits_[i].face != walker.walk.outer_face()) continue;
    hits_[i].face = kUsed;
    return;
  }
}

void VolumeTracer::add_clipped(Walker& walker, double from, double level, double to,
                               double to_level) {
  const double per_depth = (to_level - level) / (to - from);
  if (from < walker.begin) {
    const double cut = std::min(walker.begin, to);
    const double cut_level = level + per_depth * (cut - from);
    walker.integral.add(level, cut_level, 0);
    from = cut;
    level = cut_level;
  }
  if (to > walker.end) {
    to = std::max(walker.end, from);
    to_level = level + per_depth * (to - from);
  }
  walker.integral.add(level, to_level, (to - from) * walker.world_per_depth);
}

// Rounding may turn the two faces of a flat cell round: depths that do not grow add nothing.
void VolumeTracer::add_segment(Walker& walker) {
  const double from = walker.depth;
  const double to = std::max(from, walker.walk.depth());
  const double level = walker.level;
  walker.depth = to;
  walker.level = walker.walk.level();
  if ((from < walker.begin || to > walker.end) && to > from) [[unlikely]] {
    add_clipped(walker, from, level, to, walker.level);
  } else {
    walker.integral.add(level, walker.level, (to - from) * walker.world_per_depth);
  }
}

/// One cell on; false where the ray is done.
bool VolumeTracer::advance(Walker& walker) {
  const bool is_inside = walker.walk.step(view_, walker.line);
  add_segment(walker);
  if (walker.integral.is_opaque() || walker.depth >= walker.end) return false;
  if (is_inside) return true;
  leave(walker);
  return start_walk(walker);
}

// All of a cell's work in one piece of code: every call in it would cost a tenth.
[[gnu::flatten]] void VolumeTracer::advance_all(std::span<RayLight> light) {
  for (std::size_t i = 0; i < walkers_.size();) {
    Walker& walker = walkers_[i];
    if (advance(walker)) {
      ++i;
      continue;
    }
    light[walker.ray] = {walker.integral.light(), walker.integral.transmittance()};
    walker = walkers_.back();
    walkers_.pop_back();
  }
}

void VolumeTracer::trace(int tile_x, int tile_y, std::span<const VolumeRay> rays,
                         std::span<RayLight> light) {
  hits_.clear();
  walkers_.clear();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    light[i] = {};
    Walker walker{};
    walker.line = view_.line_through(rays[i].x, rays[i].y);
    walker.world_per_depth = view_.world_length(walker.line);
    walker.begin = view_.eye_depth();
    walker.end = rays[i].end_depth;
    walker.ray = i;
    find_hits(tile_x, tile_y, rays[i], walker);
    if (start_walk(walker)) walkers_.push_back(walker);
  }
  // No ray meets a cell twice, so there are no more rounds than cells.
  const std::size_t n_cells = view_.links().cells.size();
  for (std::size_t round = 0; !walkers_.empty() && round < n_cells; ++round) advance_all(light);
}

}  // namespace lode

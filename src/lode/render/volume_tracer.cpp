#include "lode/render/volume_tracer.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "lode/core/expects.h"

namespace lode {
namespace {

constexpr std::uint32_t kUsed = 0xffffffffU;
constexpr double kLeastCosine = 0.1;

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
void VolumeTracer::find_hits(int tile_x, int tile_y, const VolumeRay& ray, const SightLine& line) {
  const auto x = static_cast<float>(ray.x);
  const auto y = static_cast<float>(ray.y);
  const auto n_before = static_cast<std::ptrdiff_t>(hits_.size());
  for (const VolumeView::TileFace& face : view_.faces_in(tile_x, tile_y)) {
    const auto& [left, right, top, bottom] = face.box;
    if (x < left || x > right || y < top || y > bottom) continue;
    MetFace met;
    if (meet_face(view_, line, face.face, met)) hits_.push_back({met.depth, face.face});
  }
  std::sort(hits_.begin() + n_before, hits_.end(), [](const Hit& a, const Hit& b) {
    return a.depth != b.depth ? a.depth < b.depth : a.face < b.face;
  });
}

void VolumeTracer::start_ray(std::size_t lane, const VolumeRay& ray, const SightLine& line) {
  lanes_.right[lane] = line.right;
  lanes_.up[lane] = line.up;
  lanes_.right_slope[lane] = line.right_slope;
  lanes_.up_slope[lane] = line.up_slope;
  lanes_.world_per_depth[lane] = view_.world_length(line);
  lanes_.begin[lane] = view_.eye_depth();
  lanes_.end[lane] = ray.end_depth;
  set_integral(lane, LightIntegral());
}

LightIntegral VolumeTracer::integral_of(std::size_t lane) const {
  return LightIntegral({lanes_.transmittance[lane], lanes_.weight[lane], lanes_.level_weight[lane],
                        travellers_[lane].light, travellers_[lane].ramp});
}

void VolumeTracer::set_integral(std::size_t lane, const LightIntegral& integral) {
  const LightIntegral::State& state = integral.state();
  lanes_.transmittance[lane] = state.transmittance;
  lanes_.weight[lane] = state.weight;
  lanes_.level_weight[lane] = state.level_weight;
  travellers_[lane].light = state.light;
  travellers_[lane].ramp = state.ramp;
  if (state.ramp == nullptr) return;
  lanes_.lower[lane] = state.ramp->lower;
  lanes_.upper[lane] = state.ramp->upper;
  lanes_.origin[lane] = state.ramp->origin;
  lanes_.extinction[lane] = state.ramp->extinction;
  lanes_.extinction_slope[lane] = state.ramp->extinction_slope;
}

/// Puts a ray at the nearest outer face that no walk has ended at; false where there is none.
bool VolumeTracer::start_walk(std::size_t lane) {
  Traveller& traveller = travellers_[lane];
  while (traveller.next_hit < traveller.end_hit) {
    const Hit& hit = hits_[traveller.next_hit++];
    if (hit.face == kUsed) continue;
    if (hit.depth >= lanes_.end[lane]) return false;
    const SightLine line{lanes_.right[lane], lanes_.up[lane], lanes_.right_slope[lane],
                         lanes_.up_slope[lane]};
    MetFace met;
    if (!meet_face(view_, line, hit.face, met)) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      lanes_.u[i][lane] = met.offsets[i].u;
      lanes_.v[i][lane] = met.offsets[i].v;
      lanes_.depths[i][lane] = met.depths[i];
      lanes_.levels[i][lane] = met.levels[i];
      lanes_.edges[i][lane] = met.edges[i];
      lanes_.corners[i][lane] = met.corners[i];
    }
    lanes_.next[lane] = view_.links().outer_faces[hit.face].cell;
    lanes_.depth[lane] = met.depth;
    lanes_.level[lane] = met.level;
    LightIntegral integral = integral_of(lane);
    integral.start(ramps_, met.level);
    set_integral(lane, integral);
    add_film(lane, hit.face, met.depth);
    return true;
  }
  return false;
}

/// No other walk of the ray starts at the outer face where this one ends.
void VolumeTracer::mark_left(std::size_t lane, std::uint32_t face) {
  const Traveller& traveller = travellers_[lane];
  for (std::size_t i = traveller.next_hit; i < traveller.end_hit; ++i)
    if (hits_[i].face == face) hits_[i].face = kUsed;
}

void VolumeTracer::add_film(std::size_t lane, std::uint32_t face, double depth) {
  if (!(film_.opacity > 0) || depth < lanes_.begin[lane] || depth > lanes_.end[lane]) return;
  std::array<Vec3d, 3> corners;
  for (std::size_t i = 0; i < 3; ++i) {
    const ViewVertex& v = view_.vertices()[view_.links().outer_faces[face].corners[i]];
    corners[i] = {{v.right, v.up, v.depth}};
  }
  const Vec3d normal = normalized(cross(corners[1] - corners[0], corners[2] - corners[0]));
  const Vec3d sight = normalized(Vec3d{{lanes_.right_slope[lane], lanes_.up_slope[lane], 1}});
  const double cosine = std::max(kLeastCosine, std::abs(dot(normal, sight)));
  const double passes = std::pow(1 - std::min(film_.opacity, 1.0), 1 / cosine);
  Vec3d& light = travellers_[lane].light;
  light = light + film_.color * (lanes_.transmittance[lane] * (1 - passes));
  lanes_.transmittance[lane] *= passes;
}

/// The segment that step_lanes() has left open, cut at the ray's ends.
void VolumeTracer::add_segment(std::size_t lane) {
  double from = lanes_.depth[lane];
  double level = lanes_.level[lane];
  double to = lanes_.to_depth[lane];
  double to_level = lanes_.to_level[lane];
  LightIntegral integral = integral_of(lane);
  lanes_.depth[lane] = to;
  lanes_.level[lane] = to_level;
  if (to > from) {
    const double per_depth = (to_level - level) / (to - from);
    if (from < lanes_.begin[lane]) {
      const double cut = std::min(lanes_.begin[lane], to);
      const double cut_level = level + per_depth * (cut - from);
      integral.add(level, cut_level, 0);
      from = cut;
      level = cut_level;
    }
    if (to > lanes_.end[lane]) {
      to = std::max(lanes_.end[lane], from);
      to_level = level + per_depth * (to - from);
    }
  }
  integral.add(level, to_level, (to - from) * lanes_.world_per_depth[lane]);
  set_integral(lane, integral);
}

/// After a step that may have ended the walk; false where the ray is done.
bool VolumeTracer::continue_ray(std::size_t lane) {
  if (lanes_.transmittance[lane] < LightIntegral::kOpaque) return false;
  if (lanes_.depth[lane] >= lanes_.end[lane]) return false;
  if (lanes_.next[lane] < CellLinks::kOuter) return true;
  const auto face = static_cast<std::uint32_t>(lanes_.next[lane] - CellLinks::kOuter);
  mark_left(lane, face);
  add_film(lane, face, lanes_.depth[lane]);
  return start_walk(lane);
}

void VolumeTracer::move_lane(std::size_t from, std::size_t to) {
  const auto move = [=](auto&... rows) { ((rows[to] = rows[from]), ...); };
  RayLanes& l = lanes_;
  move(l.right, l.up, l.right_slope, l.up_slope, l.world_per_depth, l.begin, l.end, l.next);
  for (std::size_t i = 0; i < 3; ++i)
    move(l.u[i], l.v[i], l.depths[i], l.levels[i], l.edges[i], l.corners[i]);
  move(l.depth, l.level, l.transmittance, l.weight, l.level_weight);
  move(l.lower, l.upper, l.origin, l.extinction, l.extinction_slope, travellers_);
}

void VolumeTracer::trace(int tile_x, int tile_y, std::span<const VolumeRay> rays,
                         std::span<RayLight> light) {
  LODE_EXPECTS(rays.size() <= RayLanes::kCapacity && light.size() >= rays.size());
  hits_.clear();
  std::size_t n = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    light[i] = {};
    const SightLine line = view_.line_through(rays[i].x, rays[i].y);
    if (!comes_near(line)) continue;
    const std::size_t first_hit = hits_.size();
    find_hits(tile_x, tile_y, rays[i], line);
    if (hits_.size() == first_hit) continue;
    travellers_[n] = {i, first_hit, hits_.size(), {}, nullptr};
    start_ray(n, rays[i], line);
    if (start_walk(n)) ++n;
  }
  // No ray meets a cell twice, so there are no more steps than cells.
  const std::size_t n_cells = view_.links().cells.size();
  for (std::size_t step = 0; n > 0 && step < n_cells; ++step) {
    LaneEvents events = step_lanes(view_.links(), view_.vertices(), n, lanes_);
    for (std::uint64_t left = events.is_segment_open; left != 0; left &= left - 1)
      add_segment(static_cast<std::size_t>(std::countr_zero(left)));
    // From the last on, so that the one that is moved into a gap has been looked at.
    for (std::uint64_t left = events.is_segment_open | events.has_ended; left != 0;) {
      const auto lane = static_cast<std::size_t>(std::bit_width(left)) - 1;
      left ^= std::uint64_t{1} << lane;
      if (continue_ray(lane)) continue;
      const LightIntegral integral = integral_of(lane);
      light[travellers_[lane].ray] = {integral.light(), integral.transmittance()};
      if (lane != --n) move_lane(n, lane);
    }
  }
}

}  // namespace lode

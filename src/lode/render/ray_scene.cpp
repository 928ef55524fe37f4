#include "lode/render/ray_scene.h"

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace lode {
namespace {

struct ReleaseDevice {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct ReleaseScene {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using Device = std::unique_ptr<RTCDeviceTy, ReleaseDevice>;
using Scene = std::unique_ptr<RTCSceneTy, ReleaseScene>;

// Normalised units: far above float rounding at coordinates of 1, far below a sample's spacing.
constexpr float kLift = 1e-4f;
constexpr unsigned kEverything = 0xffffffffU;

bool is_finite(const Vec3f& a) {
  return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}

Result<void> check_attributes(const Surface& surface) {
  const std::size_t n = surface.positions.size();
  for (const double coordinate : surface.origin.v) {
    // The square of a coordinate must still be a double.
    if (!(std::abs(coordinate) <= 1e150)) {
      return fail("surface: expected an origin of numbers up to 1e150, got {}", coordinate);
    }
  }
  if (n > std::numeric_limits<std::uint32_t>::max()) {
    return fail("surface: expected fewer than 2^32 vertices, got {}", n);
  }
  if (!surface.normals.empty() && surface.normals.size() != n) {
    return fail("surface: expected {} normals, one per vertex, got {}", n, surface.normals.size());
  }
  if (!surface.isovalues.empty() && surface.isovalues.size() != n) {
    return fail("surface: expected {} isovalues, one per vertex, got {}", n,
                surface.isovalues.size());
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!is_finite(surface.positions[i])) {
      return fail("surface: expected finite positions, vertex {} is not", i);
    }
  }
  return {};
}

template <std::size_t N>
Result<void> check_indices(const std::vector<std::array<std::uint32_t, N>>& elements,
                           std::size_t n_vertices, const char* name) {
  for (std::size_t i = 0; i < elements.size(); ++i) {
    for (const std::uint32_t vertex : elements[i]) {
      if (vertex >= n_vertices) {
        return fail("surface: {} {} names vertex {}, expected one of {}", name, i, vertex,
                    n_vertices);
      }
    }
  }
  return {};
}

Result<void> check_surface(const Surface& surface) {
  LODE_CHECK(check_attributes(surface));
  LODE_CHECK(check_indices(surface.triangles, surface.positions.size(), "triangle"));
  return check_indices(surface.lines, surface.positions.size(), "line");
}

// Each triangle's cross product is twice its area times its normal, which is the weight wanted.
std::vector<Vec3f> area_weighted_normals(const Surface& surface, std::span<const Vec3f> positions) {
  std::vector<Vec3f> normals(positions.size());
  for (const auto& [a, b, c] : surface.triangles) {
    const Vec3f normal = cross(positions[b] - positions[a], positions[c] - positions[a]);
    for (const std::uint32_t vertex : {a, b, c}) normals[vertex] = normals[vertex] + normal;
  }
  for (Vec3f& normal : normals) normal = normalized(normal);
  return normals;
}

Error embree_error(RTCDevice device, const char* action) {
  switch (rtcGetDeviceError(device)) {
    case RTC_ERROR_CANCELLED: return cancelled_error();
    case RTC_ERROR_OUT_OF_MEMORY: return fail("render: not enough memory for {}", action);
    case RTC_ERROR_UNSUPPORTED_CPU: return fail("render: Embree needs a CPU with SSE2");
    // Where there is no memory it does not always say so.
    default: return fail("render: Embree failed at {}, perhaps for want of memory", action);
  }
}

bool continue_building(void* progress, double fraction) {
  auto& p = *static_cast<Progress*>(progress);
  p.report("preparing rays", fraction);
  return !p.is_cancelled();
}

RTCRay make_ray(const Vec3f& origin, const Vec3f& direction, float distance) {
  RTCRay ray{};
  ray.org_x = origin[0];
  ray.org_y = origin[1];
  ray.org_z = origin[2];
  ray.dir_x = direction[0];
  ray.dir_y = direction[1];
  ray.dir_z = direction[2];
  ray.tnear = 0;
  ray.tfar = distance;
  ray.mask = kEverything;
  return ray;
}

}  // namespace

Normalization normalization_of(const Box3d& box) {
  const double radius = length((box.upper - box.lower) * 0.5);
  return {.center = box.lower * 0.5 + box.upper * 0.5, .scale = radius > 0 ? 1 / radius : 1};
}

class RayScene::Impl {
 public:
  Impl(const Surface& surface, const SurfaceColors& colors, const SceneOptions& options)
      : surface_(surface), colors_(colors), options_(options) {}

  Result<void> prepare(Progress& progress);
  std::optional<SceneHit> intersect(const Vec3f& origin, const Vec3f& direction) const;
  bool is_occluded(const Vec3f& origin, const Vec3f& direction, float distance) const;

 private:
  void normalize_positions();
  Result<void> attach_triangles();
  Result<void> attach_lines();
  Result<void> attach_segments(std::vector<std::uint32_t>& lines);
  Result<void> attach_dots();
  SceneHit triangle_hit(const RTCRayHit& found, const Vec3f& direction) const;
  SceneHit line_hit(const RTCRayHit& found, const Vec3f& position) const;

  const Surface& surface_;
  const SurfaceColors& colors_;
  SceneOptions options_;
  std::vector<Vec3f> positions_;  // Normalised; one more than the vertices, see attach_triangles.
  std::vector<Vec3f> own_normals_;
  std::span<const Vec3f> normals_;
  Device device_;
  Scene scene_;
  std::vector<std::uint32_t> segments_;  ///< Lines by their number in their geometry,
  std::vector<std::uint32_t> dots_;      ///< and those that are points, likewise.
  unsigned triangles_id_ = RTC_INVALID_GEOMETRY_ID;
  unsigned dots_id_ = RTC_INVALID_GEOMETRY_ID;
};

void RayScene::Impl::normalize_positions() {
  const std::size_t n = surface_.positions.size();
  positions_.resize(n + 1);
  parallel_for(n, options_.threads, 1 << 16, [&](std::size_t i, int) {
    const Vec3d world = surface_.world_position(static_cast<std::uint32_t>(i));
    positions_[i] = to_vec3f(options_.normalization.apply(world));
  });
}

Result<void> RayScene::Impl::attach_triangles() {
  if (surface_.triangles.empty()) return {};
  const std::size_t n = surface_.positions.size();
  RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  // Embree loads 16 bytes from each 12-byte vertex: positions_ has one spare vertex at its end.
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                             positions_.data(), 0, sizeof(Vec3f), n);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             surface_.triangles.data(), 0, 3 * sizeof(std::uint32_t),
                             surface_.triangles.size());
  rtcCommitGeometry(geometry);
  triangles_id_ = rtcAttachGeometry(scene_.get(), geometry);
  rtcReleaseGeometry(geometry);
  if (triangles_id_ == RTC_INVALID_GEOMETRY_ID) {
    return embree_error(device_.get(), "adding triangles");
  }
  return {};
}

Result<void> RayScene::Impl::attach_lines() {
  std::vector<std::uint32_t> lines;
  for (std::uint32_t i = 0; i < surface_.lines.size(); ++i) {
    const auto& [a, b] = surface_.lines[i];
    (a == b ? dots_ : lines).push_back(i);
  }
  LODE_CHECK(attach_segments(lines));
  return attach_dots();
}

// A round segment takes two consecutive vertices, so each line gets its own two.
Result<void> RayScene::Impl::attach_segments(std::vector<std::uint32_t>& lines) {
  const std::size_t n = lines.size();
  if (n == 0) return {};
  RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE);
  auto* const ends = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float), 2 * n));
  auto* const firsts = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, sizeof(std::uint32_t), n));
  if (ends == nullptr || firsts == nullptr) {
    rtcReleaseGeometry(geometry);
    return embree_error(device_.get(), "lines");
  }
  for (std::size_t i = 0; i < 2 * n; ++i) {
    const Vec3f& p = positions_[surface_.lines[lines[i / 2]][i % 2]];
    std::copy(p.v.begin(), p.v.end(), ends + 4 * i);
    ends[4 * i + 3] = static_cast<float>(options_.line_radius);
    firsts[i / 2] = static_cast<std::uint32_t>(i / 2 * 2);
  }
  rtcCommitGeometry(geometry);
  const unsigned id = rtcAttachGeometry(scene_.get(), geometry);
  rtcReleaseGeometry(geometry);
  if (id == RTC_INVALID_GEOMETRY_ID) return embree_error(device_.get(), "adding lines");
  segments_ = std::move(lines);
  return {};
}

// Segments that are far shorter than wide are drawn wrong.
Result<void> RayScene::Impl::attach_dots() {
  const std::size_t n = dots_.size();
  if (n == 0) return {};
  RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_SPHERE_POINT);
  auto* const balls = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float), n));
  if (balls == nullptr) {
    rtcReleaseGeometry(geometry);
    return embree_error(device_.get(), "points");
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3f& p = positions_[surface_.lines[dots_[i]][0]];
    std::copy(p.v.begin(), p.v.end(), balls + 4 * i);
    balls[4 * i + 3] = static_cast<float>(kDotRadius * options_.line_radius);
  }
  rtcCommitGeometry(geometry);
  dots_id_ = rtcAttachGeometry(scene_.get(), geometry);
  rtcReleaseGeometry(geometry);
  if (dots_id_ == RTC_INVALID_GEOMETRY_ID) return embree_error(device_.get(), "adding points");
  return {};
}

Result<void> RayScene::Impl::prepare(Progress& progress) {
  LODE_CHECK(check_surface(surface_));
  normalize_positions();
  const std::size_t n = surface_.positions.size();
  if (surface_.normals.empty()) {
    own_normals_ = area_weighted_normals(surface_, {positions_.data(), n});
    normals_ = own_normals_;
  } else {
    normals_ = surface_.normals;
  }
  device_.reset(rtcNewDevice(nullptr));
  if (!device_) return embree_error(nullptr, "starting");
  scene_.reset(rtcNewScene(device_.get()));
  if (!scene_) return embree_error(device_.get(), "making a scene");
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneProgressMonitorFunction(scene_.get(), continue_building, &progress);
  LODE_CHECK(attach_triangles());
  LODE_CHECK(attach_lines());
  // One thread: a parallel build may order the triangles of a leaf differently from run to run,
  // which decides who is hit on a shared edge. Embree's own thread limit would hold for every
  // user of oneTBB in the process, hence an arena.
  tbb::task_arena(1).execute([&] { rtcCommitScene(scene_.get()); });
  const RTCError error = rtcGetDeviceError(device_.get());
  if (progress.is_cancelled()) return cancelled_error();
  if (error == RTC_ERROR_OUT_OF_MEMORY) return fail("render: not enough memory for the surface");
  if (error != RTC_ERROR_NONE)
    return fail("render: Embree could not prepare the surface, perhaps for want of memory");
  return {};
}

// Rays that leave a coarse triangle at the flat hit point meet its neighbours too early and draw
// the triangles' edges into the shade. Starting from the smooth surface that the vertex normals
// suggest avoids it (Hanika, Hacking the shadow terminator, Ray Tracing Gems II, 2021).
SceneHit RayScene::Impl::triangle_hit(const RTCRayHit& found, const Vec3f& direction) const {
  const auto& triangle = surface_.triangles[found.hit.primID];
  const std::array<float, 3> weights{1 - found.hit.u - found.hit.v, found.hit.u, found.hit.v};
  Vec3f geometric = normalized(Vec3f{{found.hit.Ng_x, found.hit.Ng_y, found.hit.Ng_z}});
  if (dot(geometric, direction) > 0) geometric = geometric * -1.0f;

  SceneHit hit;
  for (std::size_t i = 0; i < 3; ++i) {
    hit.position = hit.position + positions_[triangle[i]] * weights[i];
    hit.normal = hit.normal + normals_[triangle[i]] * weights[i];
  }
  hit.color = colors_.at(triangle, weights);
  hit.normal = normalized(hit.normal);
  if (!(dot(hit.normal, hit.normal) > 0.5f)) hit.normal = geometric;  // Zero or NaN normals.
  const float side = dot(hit.normal, geometric) < 0 ? -1.0f : 1.0f;
  hit.normal = hit.normal * side;
  hit.geometric_normal = geometric;
  Vec3f lift{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3f normal = normals_[triangle[i]] * side;
    const float below = std::min(0.0f, dot(hit.position - positions_[triangle[i]], normal));
    lift = lift - normal * (below * weights[i]);
  }
  if (!is_finite(lift)) lift = {};
  hit.lifted = hit.position + lift + geometric * kLift;
  return hit;
}

SceneHit RayScene::Impl::line_hit(const RTCRayHit& found, const Vec3f& position) const {
  const bool is_dot = found.hit.geomID == dots_id_;
  const auto& line = surface_.lines[(is_dot ? dots_ : segments_)[found.hit.primID]];
  SceneHit hit;
  hit.position = position;
  const float along = is_dot ? 0 : found.hit.u;
  hit.color = colors_.at(line[0]) * (1 - along) + colors_.at(line[1]) * along;
  hit.is_line = true;
  return hit;
}

std::optional<SceneHit> RayScene::Impl::intersect(const Vec3f& origin,
                                                  const Vec3f& direction) const {
  RTCRayHit found{};
  found.ray = make_ray(origin, direction, std::numeric_limits<float>::infinity());
  found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene_.get(), &context, &found);
  if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  if (found.hit.geomID == triangles_id_) return triangle_hit(found, direction);
  return line_hit(found, origin + direction * found.ray.tfar);
}

bool RayScene::Impl::is_occluded(const Vec3f& origin, const Vec3f& direction,
                                 float distance) const {
  RTCRay ray = make_ray(origin, direction, distance);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene_.get(), &context, &ray);
  return ray.tfar < 0;
}

RayScene::RayScene(std::unique_ptr<const Impl> impl) : impl_(std::move(impl)) {}
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;
RayScene::~RayScene() = default;

Result<RayScene> RayScene::build(const Surface& surface, const SurfaceColors& colors,
                                 const SceneOptions& options, Progress& progress) {
  auto impl = std::make_unique<Impl>(surface, colors, options);
  LODE_CHECK(impl->prepare(progress));
  return RayScene(std::move(impl));
}

std::optional<SceneHit> RayScene::intersect(const Vec3f& origin, const Vec3f& direction) const {
  return impl_->intersect(origin, direction);
}

bool RayScene::is_occluded(const Vec3f& origin, const Vec3f& direction, float distance) const {
  return impl_->is_occluded(origin, direction, distance);
}

}  // namespace lode

#include "lode/render/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace lode {
namespace {

constexpr double kThreeQuarterFovDeg = 26;
constexpr double kTopFovDeg = 1;
constexpr double kMargin = 1.06;
constexpr double kRadPerDeg = std::numbers::pi / 180;

bool has_finite_parts(const Vec3d& a) {
  return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}

std::array<Vec3d, 8> corners_of(const Box3d& box) {
  std::array<Vec3d, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      corners[i][axis] = ((i >> axis) & 1) != 0 ? box.upper[axis] : box.lower[axis];
    }
  }
  return corners;
}

// The slopes of the tightest frame, along one picture axis, round all corners.
struct Extent {
  double lower = 1e300;
  double upper = -1e300;

  void include(double slope) {
    lower = std::min(lower, slope);
    upper = std::max(upper, slope);
  }
};

// Moves the camera along its axes until the corners fill the frame: a few rounds of centring
// and backing off, each solved for the perspective of the round before.
Camera fit(Camera camera, const Box3d& box, double aspect) {
  const CameraAxes axes = axes_of(camera);
  const double tan_v = std::tan(camera.field_of_view_deg / 2 * kRadPerDeg) / kMargin;
  const double tan_h = tan_v * aspect;
  const double radius = std::max(length(box.upper - box.lower) / 2, 1e-300);
  for (int round = 0; round < 20; ++round) {
    const double distance = length(camera.target - camera.eye);
    Extent horizontal;
    Extent vertical;
    double closer = 1e300;
    for (const Vec3d& corner : corners_of(box)) {
      const Vec3d p = corner - camera.eye;
      const double depth = std::max(dot(p, axes.forward), radius * 1e-3);
      horizontal.include(dot(p, axes.right) / depth);
      vertical.include(dot(p, axes.up) / depth);
    }
    const Vec3d shift = axes.right * ((horizontal.lower + horizontal.upper) / 2 * distance) +
                        axes.up * ((vertical.lower + vertical.upper) / 2 * distance);
    camera.eye = camera.eye + shift;
    camera.target = camera.target + shift;
    for (const Vec3d& corner : corners_of(box)) {
      const Vec3d p = corner - camera.eye;
      const double needed =
          std::max(std::abs(dot(p, axes.right)) / tan_h, std::abs(dot(p, axes.up)) / tan_v);
      closer = std::min(closer, dot(p, axes.forward) - needed);
    }
    camera.eye = camera.eye + axes.forward * closer;
  }
  return camera;
}

Camera looking_along(const Box3d& bounds, const Vec3d& forward, const Vec3d& up, double fov_deg,
                     double aspect) {
  const Vec3d center = bounds.lower * 0.5 + bounds.upper * 0.5;
  const double diagonal = length(bounds.upper - bounds.lower);
  const double distance =
      (diagonal > 0 ? diagonal : 1.0) / (2 * std::tan(fov_deg / 2 * kRadPerDeg));
  const Camera camera{
      .eye = center - forward * distance, .target = center, .up = up, .field_of_view_deg = fov_deg};
  return diagonal > 0 ? fit(camera, bounds, aspect) : camera;
}

}  // namespace

Result<void> check_camera(const Camera& camera) {
  if (!has_finite_parts(camera.eye) || !has_finite_parts(camera.target) ||
      !has_finite_parts(camera.up)) {
    return fail("camera: expected finite coordinates in eye, target and up");
  }
  if (!(camera.field_of_view_deg > 0 && camera.field_of_view_deg <= 170)) {
    return fail("camera: expected 0 < field_of_view_deg <= 170, got {}", camera.field_of_view_deg);
  }
  const Vec3d forward = normalized(camera.target - camera.eye);
  if (length(forward) == 0) return fail("camera: eye and target are the same point");
  if (!(length(cross(forward, normalized(camera.up))) > 1e-6)) {
    return fail("camera: up must not be zero or parallel to the view from eye to target");
  }
  return {};
}

CameraAxes axes_of(const Camera& camera) {
  const Vec3d forward = normalized(camera.target - camera.eye);
  const Vec3d right = normalized(cross(forward, normalized(camera.up)));
  return {.right = right, .up = cross(right, forward), .forward = forward};
}

Mat3 viewing_axes(Frame frame) {
  if (frame == Frame::ras) return {{Vec3d{{-1, 0, 0}}, Vec3d{{0, -1, 0}}, Vec3d{{0, 0, 1}}}};
  return Mat3::identity();
}

Camera default_camera(const Box3d& bounds, const Mat3& axes, double aspect) {
  constexpr double kAzimuth = 32 * kRadPerDeg;
  constexpr double kElevation = 24 * kRadPerDeg;
  const Vec3d forward =
      axes * Vec3d{{-std::sin(kAzimuth) * std::cos(kElevation),
                    std::cos(kAzimuth) * std::cos(kElevation), -std::sin(kElevation)}};
  return looking_along(bounds, forward, axes.column(2), kThreeQuarterFovDeg, aspect);
}

Camera top_camera(const Box3d& bounds, double aspect) {
  const Vec3d size = bounds.upper - bounds.lower;
  // Ties go to z, then y: the picture of a cube is its xy side.
  std::size_t thin = 2;
  if (size[1] < size[thin]) thin = 1;
  if (size[0] < size[thin]) thin = 0;
  Vec3d forward;
  Vec3d up;
  forward[thin] = thin == 1 ? 1 : -1;
  up[thin == 2 ? 1 : 2] = 1;
  return looking_along(bounds, forward, up, kTopFovDeg, aspect);
}

}  // namespace lode

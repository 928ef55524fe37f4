#pragma once

#include "lode/core/box.h"
#include "lode/core/regular_grid.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"

namespace lode {

/// A perspective view in world units. The picture's centre is `target`; its vertical is `up`
/// (any length, not parallel to the viewing direction).
struct Camera {
  Vec3d eye{{0, -1, 0}};
  Vec3d target{{0, 0, 0}};
  Vec3d up{{0, 0, 1}};
  double field_of_view_deg = 30;  ///< The whole vertical angle, 0 < angle <= 170.

  friend bool operator==(const Camera&, const Camera&) = default;
};

/// Refuses cameras that show nothing: non-finite numbers, eye at target, up along the view,
/// field of view outside its range.
[[nodiscard]] Result<void> check_camera(const Camera& camera);

/// The unit vectors of a camera's picture.
struct CameraAxes {
  Vec3d right;
  Vec3d up;
  Vec3d forward;
};
/// Precondition: check_camera(camera) holds.
[[nodiscard]] CameraAxes axes_of(const Camera& camera);

/// Where right, away and up are in a world (columns, in this order): a patient is seen from the
/// front, the head up; worlds without a name have z up and are seen from -y.
[[nodiscard]] Mat3 viewing_axes(Frame frame);

/// A three-quarter view from the front, the right and above that shows all of `bounds`, centred,
/// with a small margin. `axes`: see viewing_axes; `aspect`: width over height.
[[nodiscard]] Camera default_camera(const Box3d& bounds, const Mat3& axes, double aspect);

/// Looks straight down on a flat box, from so far that the picture is orthographic to the eye.
/// The view is along the thinnest side; the picture's axes are the other two.
[[nodiscard]] Camera top_camera(const Box3d& bounds, double aspect);

}  // namespace lode

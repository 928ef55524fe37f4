#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lode/core/box.h"
#include "lode/core/result.h"
#include "lode/render/camera.h"

namespace lode {

/// Moving cameras round a volume, z up: the paths of bench/camera, and of films. `aspect`, of
/// pictures, width over height: from where an orbit is all of the box is in sight, however flat;
/// unset, its height fills the frame's.

/// 360 frames of 1 degree, from a little above.
[[nodiscard]] std::vector<Camera> orbit_path(const Box3d& bounds,
                                             std::optional<double> aspect = {});
/// 200 frames from the orbit's first to half the volume's diagonal from its middle.
[[nodiscard]] std::vector<Camera> fly_in_path(const Box3d& bounds,
                                              std::optional<double> aspect = {});
/// 100 poses that have nothing to do with each other, always the same ones.
[[nodiscard]] std::vector<Camera> jump_path(const Box3d& bounds, std::optional<double> aspect = {});

/// "orbit", "fly-in", "jump", or a file: a JSON array of cameras as in camera files, at most
/// 16 MiB. Errors name the file and the frame.
[[nodiscard]] Result<std::vector<Camera>> camera_path(const std::string& name_or_file,
                                                      const Box3d& bounds,
                                                      std::optional<double> aspect = {});

}  // namespace lode

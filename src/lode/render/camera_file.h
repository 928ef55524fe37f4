#pragma once

#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/render/camera.h"

namespace lode {

/// A camera file is one JSON object, at most 64 KiB, world units:
///
///     { "eye": [x, y, z], "target": [x, y, z], "up": [x, y, z], "field_of_view_deg": 30 }
///
/// eye      where the camera stands; required
/// target   what is in the centre of the picture; required
/// up       what points up in the picture, any length; default [0, 0, 1]
/// field_of_view_deg  the whole vertical angle, 0 < angle <= 170; default 30
///
/// Other keys are refused, so that a misspelt one is not silently ignored. Errors name the file
/// and the field.
[[nodiscard]] Result<Camera> read_camera(const std::string& path);
/// Writes all four fields with enough digits to read back the same numbers.
[[nodiscard]] Result<void> write_camera(const Camera& camera, const std::string& path);

/// A camera path: a JSON array of at least one such object, at most 16 MiB.
[[nodiscard]] Result<std::vector<Camera>> read_cameras(const std::string& path);
[[nodiscard]] Result<void> write_cameras(const std::vector<Camera>& cameras,
                                         const std::string& path);

}  // namespace lode

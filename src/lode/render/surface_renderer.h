#pragma once

#include <optional>
#include <span>

#include "lode/core/box.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/render/camera.h"
#include "lode/render/color.h"
#include "lode/render/image.h"

namespace lode {

/// A soft vertical gradient; the default suits white paper. Transparent ends give a PNG with
/// alpha.
struct Background {
  Color top{255, 255, 255};
  Color bottom{232, 236, 241};
};

struct RenderOptions {
  int width = 1200;                        ///< Pixels, 1..16384.
  int height = 900;                        ///< Pixels, 1..16384.
  std::optional<Camera> camera;            ///< Unset: framing_camera.
  Mat3 axes = Mat3::identity();            ///< For framing_camera; see viewing_axes.
  std::optional<Color> color;              ///< Unset: by isovalue, or a plain warm grey for one.
  std::span<const Vec3f> vertex_colors{};  ///< Linear light, instead of these; empty: not.
  Background background;
  int samples_per_pixel = 12;    ///< 1..4096; the time is proportional to it.
  double ambient_occlusion = 1;  ///< 0 (none) .. 1: how dark hollows get.
  double shadow = 0.8;           ///< 0 (none) .. 1: how dark the lamp's shadow is.
  double line_width_px = 2;      ///< Contour lines, > 0.
  Threads threads;
};

/// The smallest box round the vertices that triangles or lines use; `otherwise` if there is none.
[[nodiscard]] Box3d bounds_of(const Surface& surface, const Box3d& otherwise);

/// The camera that render_surface uses where options.camera is unset: a three-quarter view of the
/// surface, or of `bounds` from above where they are flat and the surface is contour lines.
[[nodiscard]] Camera framing_camera(const Surface& surface, const Box3d& bounds,
                                    const RenderOptions& options);

/// Draws a surface or contour lines by ray casting, without a GPU or window. `bounds`: the
/// volume's, so that surfaces of one volume are framed alike. The same input gives the same
/// pixels for any number of threads. Fails on unusable options, bounds or camera, on surfaces with
/// wrong indices or non-finite positions, and when cancelled.
[[nodiscard]] Result<Image> render_surface(const Surface& surface, const Box3d& bounds,
                                           const RenderOptions& options, Progress& progress);

}  // namespace lode

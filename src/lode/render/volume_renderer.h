#pragma once

#include <optional>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/render/image.h"
#include "lode/render/mesh_volume.h"
#include "lode/render/surface_colors.h"
#include "lode/render/surface_renderer.h"
#include "lode/render/transfer_function.h"

namespace lode {

/// What stands in a volume: isosurfaces, sections, lines. Opaque.
struct OpaqueSurface {
  Surface surface;
  SurfaceColors colors;
};

/// What a picture of a volume shows.
struct VolumePicture {
  const MeshVolume& volume;
  const TransferFunction& function;
  const OpaqueSurface& opaque;
  double boundary_opacity = 0;  ///< Of the mesh's boundary as a grey film, see BoundaryFilm.
};

/// Direct volume rendering, emission and absorption, by casting rays through the cells: the field
/// is linear along a ray in each cell, each segment is cut at the transfer function's knots, and a
/// ray's light is within 1e-4 of its integral (colours up to 1; see LightIntegral). Domains may
/// have any shape, and the camera may be inside.
///
/// What is opaque stops the rays and shows through what is before it, lit as by render_surface().
/// options' camera: unset, a three-quarter view of the volume and the surface. Time is
/// proportional to samples_per_pixel; a single sample is the pixel's middle. The same input gives
/// the same pixels for any number of threads. Fails as render_surface() does, on transfer functions
/// that check_transfer_function() refuses, a boundary_opacity outside 0..1, and when cancelled.
[[nodiscard]] Result<Image> render_volume(const VolumePicture& picture,
                                          const RenderOptions& options, Progress& progress);

}  // namespace lode

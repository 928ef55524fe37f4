#pragma once

#include "lode/core/box.h"
#include "lode/core/result.h"
#include "lode/render/surface_renderer.h"

namespace lode {

/// What all renderers refuse: sizes, samples and strengths out of their limits, bad cameras.
[[nodiscard]] Result<void> check_render_options(const RenderOptions& options);
/// Refuses boxes that are inside out or too large for squares of coordinates.
[[nodiscard]] Result<void> check_render_bounds(const Box3d& bounds);

[[nodiscard]] Box3d union_of(const Box3d& a, const Box3d& b);

}  // namespace lode

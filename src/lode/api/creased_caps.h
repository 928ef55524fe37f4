#pragma once

#include "lode/core/parallel.h"
#include "lode/core/regular_grid.h"
#include "lode/core/surface.h"

namespace lode {

/// For a picture of a surface that was closed at the border: its caps are flat, and where they meet
/// the rest is a crease. Their vertices come again at the end, with their planes' normals, so what
/// was a closed surface is one in pieces that touch.
void crease_caps(const RegularGrid& grid, Threads threads, Surface& surface);

}  // namespace lode

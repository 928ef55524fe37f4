#pragma once

// Deforming what has been extracted.
#include "lode/mappers/surface_cells.h"  // IWYU pragma: export
#include "lode/mappers/warp.h"           // IWYU pragma: export

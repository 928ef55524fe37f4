#pragma once

// Deforming what has been extracted.
#include "lode/mappers/warp.h"  // IWYU pragma: export

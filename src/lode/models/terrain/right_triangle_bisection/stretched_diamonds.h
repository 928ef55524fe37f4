#pragma once

#include "lode/core/height_frame.h"
#include "lode/core/parallel.h"
#include "lode/models/terrain/right_triangle_bisection/own_errors.h"

namespace lode::bisection {

/// Sets the own errors of nodes whose diamonds reach beyond the raster, so that their corners stand
/// on its last column or row: no less than the true ones, and more by rounding of float32 at most.
/// `is_exact`: heights are integers, or multiples of 2^-8 below 2^22; then planes have no error.
template <typename T>
void set_stretched_errors(const RasterRows<T>& rows, const HeightRange& range, bool is_exact,
                          const Lattice& lattice, Threads threads, float* errors);

}  // namespace lode::bisection

#pragma once

#include <span>

#include "lode/mappers/iso_part.h"
#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// Unit normals that point to lower values, at points on lattice edges: minus the gradient by
/// central differences of the full-resolution samples at the edge's ends (one-sided at the border
/// and beside holes), mapped to world space. Zero where the gradient is.
template <int D>
void compute_normals(const Model<D>& model, std::span<const EdgePoint> points, Threads threads,
                     std::span<Vec3f> normals);

}  // namespace lode::diamond

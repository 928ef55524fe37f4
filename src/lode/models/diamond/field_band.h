#pragma once

#include <memory>

#include "lode/core/parallel.h"
#include "lode/mappers/surface_band.h"
#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// The band {|F - isovalue| <= error} of the field at full resolution, F linear on the finest
/// simplices, for surfaces extracted from the model, which must outlive it. Two bits a sample.
[[nodiscard]] std::unique_ptr<SurfaceBand> make_field_band(const Model<3>& model, double isovalue,
                                                           double error, Threads threads);

}  // namespace lode::diamond

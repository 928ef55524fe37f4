#pragma once

#include "lode/models/diamond/field_band.h"
#include "lode/models/diamond/file_parts.h"

namespace lode::diamond {

/// The band of what is loaded of a file: bricks that are wanted fine, and FilePart::kMargin samples
/// round them. `part`, whose model() takes these, must outlive it and not load another chunk.
[[nodiscard]] std::unique_ptr<SurfaceBand> make_part_band(FilePart<3>& part,
                                                          const RegularGrid& field_grid,
                                                          double isovalue, double error,
                                                          Threads threads);

}  // namespace lode::diamond

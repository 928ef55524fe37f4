#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/mappers/surface_band.h"
#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// The band {|F - isovalue| <= error} of the field at full resolution, F linear on the finest
/// simplices, for surfaces extracted from the model, which must outlive it. Two bits a sample.
[[nodiscard]] std::unique_ptr<SurfaceBand> make_field_band(const Model<3>& model, double isovalue,
                                                           double error, Threads threads);

/// Some of a field's samples.
struct FieldPart {
  static constexpr int kBlockLevel = 2;

  const Model<3>& model;  ///< That they are in, with a lattice of its own.
  RegularGrid grid;       ///< The field's.
  Index<3> origin;        ///< Of the model's lattice, in the field's; even.
  /// By block of 4^3 of the model's cells, x fastest: whether they are there, corners included.
  std::vector<std::uint8_t> is_known;

  [[nodiscard]] static Index<3> block_dims(const Index<3>& dims);
};

/// The same for what a surface has in the part's box of the field, which must not leave it. What is
/// not known counts as outside the band.
[[nodiscard]] std::unique_ptr<SurfaceBand> make_field_band(FieldPart part, double isovalue,
                                                           double error, Threads threads);

}  // namespace lode::diamond

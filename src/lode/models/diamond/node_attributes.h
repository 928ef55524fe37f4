#pragma once

#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// A node's own attributes, in field units: what is true of its domain while it is not refined,
/// whatever its descendants have. Nested ones, which are stored, also cover those.
struct NodeAttributes {
  double error = 0;  ///< Largest |F - F'|; infinite where a simplex has holes and present cells.
  double low = std::numeric_limits<double>::infinity();    ///< Smallest sample.
  double high = -std::numeric_limits<double>::infinity();  ///< Largest; < low: no finite sample.
};

/// The simplices that bisecting at the node's centre halves, as far as they lie in cubes of side 2h
/// that overlap the data.
template <int D>
[[nodiscard]] std::vector<Simplex<D>> simplices_of(const Shape<D>& shape, const Diamond<D>& node);

/// Finds them by walking the node's simplices down to the finest, so in time proportional to the
/// samples in its domain. Exact for integers of up to 32 bits; else rounded as double is.
template <int D>
[[nodiscard]] NodeAttributes own_attributes(const Model<D>& model, const Diamond<D>& node);

}  // namespace lode::diamond

#pragma once

#include "lode/models/diamond/coarse_field.h"

namespace lode::diamond {

/// The one question of an isosurface query: is a node to be refined? It is when its nested error
/// exceeds the tolerance (tolerance 0: always), or it reaches across the border
/// (Shape::reaches_across), and its nested range meets the isovalue. All of these are nested, so a
/// refined node's parents are refined, and every simplex of a diamond gets the same answer: the
/// mesh is conforming without looking at neighbours. `Field` is a LatticeField with levels.
template <int D, typename Field = Model<D>>
class Selection {
 public:
  Selection(const Field& model, double isovalue, double tolerance);

  [[nodiscard]] double isovalue() const { return isovalue_; }

  /// For a node of level >= 1, or of level 0 and tier 0.
  [[nodiscard]] bool is_active(int level, std::size_t at) const {
    const NodeLevel& nodes = model_.levels[as_size(level)];
    return static_cast<double>(nodes.low[at]) < relative_above_ &&
           static_cast<double>(nodes.high[at]) >= relative_below_;
  }
  /// Whether all samples below the node are at least the isovalue.
  [[nodiscard]] bool is_inside(int level, std::size_t at) const {
    return static_cast<double>(model_.levels[as_size(level)].low[at]) >= relative_above_;
  }
  /// Tolerance 0: everything is refined, whatever its error.
  [[nodiscard]] bool is_full() const { return is_full_; }
  [[nodiscard]] bool exceeds_tolerance(ErrorCode error) const {
    return is_full_ || error > tolerance_;
  }
  [[nodiscard]] ErrorCode error(int level, std::size_t at) const {
    return model_.levels[as_size(level)].error[at];
  }
  /// Where a stored node's attributes are.
  [[nodiscard]] std::size_t index_of(const Diamond<D>& d) const;

  [[nodiscard]] const Field& model() const { return model_; }

 private:
  const Field& model_;
  double isovalue_;
  double relative_below_;  ///< isovalue above the range reference, rounded down,
  double relative_above_;  ///< and up.
  bool is_full_;
  ErrorCode tolerance_;
};

extern template class Selection<2>;
extern template class Selection<3>;
extern template class Selection<2, CoarseField<2>>;
extern template class Selection<3, CoarseField<3>>;

}  // namespace lode::diamond

#pragma once

#include "lode/models/diamond/coarse_field.h"
#include "lode/models/diamond/node_set.h"

namespace lode::diamond {

/// A field's nodes and the tolerance on their errors: what selections by one isovalue and by many
/// have in common. `Field` is a LatticeField with levels.
template <int D, typename Field = Model<D>>
class ToleranceSelection {
 public:
  ToleranceSelection(const Field& model, double tolerance)
      : model_(model), is_full_(tolerance == 0), tolerance_(tolerance_code(tolerance)) {}

  /// Tolerance 0: everything is refined, whatever its error.
  [[nodiscard]] bool is_full() const { return is_full_; }
  [[nodiscard]] bool exceeds_tolerance(ErrorCode error) const {
    return is_full_ || error > tolerance_;
  }
  /// The largest error that does not, but for tolerance 0.
  [[nodiscard]] ErrorCode tolerance() const { return tolerance_; }
  [[nodiscard]] ErrorCode error(int level, std::size_t at) const {
    return model_.levels[as_size(level)].error[at];
  }
  /// Whether any node is refined for another reason than its error or the border, and which.
  [[nodiscard]] static bool has_wanted() { return false; }
  [[nodiscard]] static bool is_wanted(const Index<D>& /*centre*/) { return false; }
  /// Where a stored node's attributes are.
  [[nodiscard]] std::size_t index_of(const Diamond<D>& d) const;

  [[nodiscard]] const Field& model() const { return model_; }

 private:
  const Field& model_;
  bool is_full_;
  ErrorCode tolerance_;
};

/// An isovalue as stored ranges see it: above the range reference, rounded down and up.
struct RelativeIsovalue {
  double below;
  double above;

  [[nodiscard]] static RelativeIsovalue of(double isovalue, double reference);
};

/// The one question of an isosurface query: is a node to be refined? It is when its nested error
/// exceeds the tolerance (tolerance 0: always), or it reaches across the border
/// (Shape::reaches_across) or is one of a set of wanted nodes, and its nested range meets the
/// isovalue. All of these are nested, so a refined node's parents are refined, and every simplex of
/// a diamond gets the same answer: the mesh is conforming without looking at neighbours.
template <int D, typename Field = Model<D>>
class Selection : public ToleranceSelection<D, Field> {
 public:
  /// `wanted`: may be null; must outlive it.
  Selection(const Field& model, double isovalue, double tolerance,
            const NodeSet<D>* wanted = nullptr)
      : ToleranceSelection<D, Field>(model, tolerance),
        isovalue_(isovalue),
        relative_(RelativeIsovalue::of(isovalue, model.range_reference())),
        wanted_(wanted) {}

  [[nodiscard]] double isovalue() const { return isovalue_; }
  [[nodiscard]] const RelativeIsovalue& relative() const { return relative_; }

  /// For a node of level >= 1, or of level 0 and tier 0.
  [[nodiscard]] bool is_active(int level, std::size_t at) const {
    const NodeLevel& nodes = this->model().levels[as_size(level)];
    return static_cast<double>(nodes.low[at]) < relative_.above &&
           static_cast<double>(nodes.high[at]) >= relative_.below;
  }
  [[nodiscard]] bool has_wanted() const { return wanted_ != nullptr; }
  [[nodiscard]] const NodeSet<D>* wanted() const { return wanted_; }
  [[nodiscard]] bool is_wanted(const Index<D>& centre) const {
    return wanted_ != nullptr && wanted_->contains(centre);
  }
  /// Which side of the isovalue a value is on: values on the same one have no surface between them.
  [[nodiscard]] bool side(double value) const { return value >= isovalue_; }
  /// Whether all values from low to high are on one side.
  [[nodiscard]] bool is_clear(double low, double high) const {
    return low >= isovalue_ || high < isovalue_;
  }

 private:
  double isovalue_;
  RelativeIsovalue relative_;
  const NodeSet<D>* wanted_;
};

extern template class ToleranceSelection<2>;
extern template class ToleranceSelection<3>;
extern template class ToleranceSelection<2, CoarseField<2>>;
extern template class ToleranceSelection<3, CoarseField<3>>;

}  // namespace lode::diamond

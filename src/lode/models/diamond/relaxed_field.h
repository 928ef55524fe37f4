#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "lode/models/diamond/brick_work.h"
#include "lode/models/diamond/critical_nodes.h"
#include "lode/models/diamond/kept_nodes.h"
#include "lode/models/diamond/relaxed_box.h"
#include "lode/models/diamond/selection.h"

namespace lode::diamond {

/// Bricks with the samples round them.
template <typename Samples>
struct SeenBricks {
  const Samples& samples;
  const Model<3>& model;             ///< With their nodes, if a tolerance can refine any.
  std::span<const Index<3>> bricks;  ///< Of the model's.
  Index<3> origin;                   ///< Of the model's lattice in the field's.

  [[nodiscard]] Index<3> in_field(Index<3> brick) const {
    for (std::size_t a = 0; a < 3; ++a) brick[a] += origin[a] / kBrickEdge<3>;
    return brick;
  }
};

/// A field relaxed (see RelaxedBox) where a cut does not refine it, brick by brick: what the cut is
/// known to refine is kept here. `Field`: has the nodes of levels kKeptLevel and coarser, and their
/// samples.
template <typename Field>
class RelaxedField {
 public:
  static constexpr std::int32_t kStep = 1 << kKeptLevel;
  /// Of the stars of finer nodes.
  static constexpr std::int32_t kReach = kStep / 2;
  static_assert(kReach <= FilePart<3>::kMargin);

  RelaxedField(const Field& field, const CriticalQuery& query)
      : field_(field),
        query_(query),
        selection_(field, query.isovalue, query.tolerance),
        refined_(query.refined != nullptr ? *query.refined : NodeSet<3>(field.shape)),
        coarse_(query.isovalue, query.persistence, false),
        has_tolerance_(query.tolerance > 0 && can_refine(field, query.tolerance)) {
    LatticeBox<3> all{{}, {}};
    for (std::size_t i = 0; i < 3; ++i)
      all.upper[i] = ((field.shape.dims[i] - 1) >> kKeptLevel) + 1;
    coarse_.open(all.upper, all);
  }

  [[nodiscard]] const Shape<3>& shape() const { return field_.shape; }
  /// Whether everything is refined, whatever its error.
  [[nodiscard]] bool is_full() const { return selection_.is_full(); }
  /// Whether the tolerance can refine some nodes, so that the bricks' nodes are needed.
  [[nodiscard]] bool has_tolerance() const { return has_tolerance_; }
  [[nodiscard]] ErrorCode tolerance() const { return selection_.tolerance(); }
  [[nodiscard]] int n_fine_levels() const { return std::min(field_.shape.n_levels, kKeptLevel); }
  [[nodiscard]] int n_coarse_levels() const { return field_.shape.n_levels - n_fine_levels(); }
  /// Whether the field's own samples in a brick may be on both sides, or holes.
  [[nodiscard]] bool is_met(const Index<3>& brick) const {
    if (field_.shape.n_levels <= kKeptLevel) return true;
    const bool has_holes = field_.has_holes();
    const NodeLevel& nodes = field_.levels[as_size(kKeptLevel)];
    return any_kept_node<3>(field_.shape, brick, [&](const Index<3>&, std::size_t at) {
      const bool may_be_hole =
          has_holes && (nodes.error[at] == kInfiniteError || nodes.high[at] < nodes.low[at]);
      return may_be_hole || selection_.is_active(kKeptLevel, at);
    });
  }

  /// All that the cut is known to refine, but for the border's.
  [[nodiscard]] NodeSet<3>& refined() { return refined_; }
  [[nodiscard]] const NodeSet<3>& refined() const { return refined_; }
  void add_coarse_beyond_tolerance();
  /// Of a part's bricks those that have stored attributes; their ancestors have larger errors, and
  /// are among them. Others are asked for where they turn.
  template <typename Part>
  void add_beyond_tolerance(const Part& part, const Progress& progress);

  /// Every kStep-th sample; before any brick. Again where more is refined.
  const RelaxedBox& relax_coarse();
  /// A brick of a part, with all that stars of nodes inside it reach; in the part's lattice. Where
  /// everything is refined it has its samples.
  template <typename Part>
  void relax(const Part& part, const Index<3>& brick, RelaxedBox& box) const;

 private:
  [[nodiscard]] static bool can_refine(const Field& field, double tolerance) {
    const double most = field.stats.max - field.stats.min + rounding_slack<3>(field);
    constexpr double kLargest = std::numeric_limits<float>::max() / 4;  // of errors
    return field.has_holes() || tolerance < 2 * most || !(most < kLargest);
  }
  [[nodiscard]] bool is_known_refined(const Index<3>& centre) const {
    return refined_.contains(centre) ||
           field_.shape.reaches_across(centre, common_exponent<3>(centre));
  }

  const Field& field_;
  CriticalQuery query_;
  Selection<3, Field> selection_;
  NodeSet<3> refined_;
  RelaxedBox coarse_;
  bool has_tolerance_;
};

template <typename Field>
void RelaxedField<Field>::add_coarse_beyond_tolerance() {
  for (int level = kKeptLevel; level < field_.shape.n_levels; ++level) {
    const Index<3> dims = field_.shape.grid_dims(level);
    for (std::size_t at = 0; at < n_points<3>(dims); ++at) {
      const Index<3> centre = point_of<3>(dims, at) * (std::int32_t{1} << level);
      if (field_.shape.is_sample(centre) && common_exponent<3>(centre) == level &&
          selection_.exceeds_tolerance(selection_.error(level, at)) &&
          selection_.is_active(level, at))
        refined_.set(centre);
    }
  }
}

template <typename Field>
template <typename Part>
void RelaxedField<Field>::add_beyond_tolerance(const Part& part, const Progress& progress) {
  const Selection<3> selection(part.model, query_.isovalue, query_.tolerance);
  for (const Index<3>& brick : part.bricks) {
    if (progress.is_cancelled()) return;
    const LatticeBox<3> own = own_centres(brick, part.model.shape.dims);
    for (int level = 0; level < n_fine_levels(); ++level) {
      const std::int32_t step = std::int32_t{1} << std::max(level, 1);
      const std::int32_t first = level == 0 ? 1 : 0;  // of level 0 only cubes have any
      for (std::int32_t z = own.lower[2] + first; z < own.upper[2]; z += step)
        for (std::int32_t y = own.lower[1] + first; y < own.upper[1]; y += step)
          for (std::int32_t x = own.lower[0] + first; x < own.upper[0]; x += step) {
            const Index<3> centre{{x, y, z}};
            if (common_exponent<3>(centre) != level) continue;
            const std::size_t at = selection.index_of(diamond_at<3>(centre));
            if (selection.exceeds_tolerance(selection.error(level, at)) &&
                selection.is_active(level, at))
              refined_.set(centre + part.origin);
          }
    }
  }
}

template <typename Field>
const RelaxedBox& RelaxedField<Field>::relax_coarse() {
  parallel_for(coarse_.n_rows(), query_.threads, 64,
               [&](std::size_t row, int) { coarse_.fill_row(field_, row, kStep); });
  coarse_.relax(
      std::max(n_coarse_levels(), 0), [&](const Index<3>& p) { return coarse_.value(p); },
      [&](const Index<3>& p) { return is_known_refined(p * kStep); });
  return coarse_;
}

template <typename Field>
template <typename Part>
void RelaxedField<Field>::relax(const Part& part, const Index<3>& brick, RelaxedBox& box) const {
  const Index<3>& dims = part.samples.shape.dims;
  const LatticeBox<3> own = own_centres(brick, dims);
  LatticeBox<3> round;
  for (std::size_t a = 0; a < 3; ++a) {
    round.lower[a] = std::max(own.lower[a] - kReach, 0);
    round.upper[a] = std::min(own.lower[a] + kBrickEdge<3> + kReach + 1, dims[a]);
  }
  box.open(dims, round);
  for (std::size_t row = 0; row < box.n_rows(); ++row) box.fill_row(part.samples, row, 1);
  if (is_full()) return;
  box.relax(
      n_fine_levels(),
      [&](const Index<3>& p) {
        if (field_.shape.n_levels < kKeptLevel)
          return box.value(p);  // corners of all that there is
        Index<3> coarse = p + part.origin;
        for (std::int32_t& x : coarse.v) x >>= kKeptLevel;
        return coarse_.value(coarse);
      },
      [&](const Index<3>& p) { return is_known_refined(p + part.origin); });
}

}  // namespace lode::diamond

#include "lode/models/diamond/world_error.h"

#include "lode/core/parallel_fill.h"
#include "lode/models/diamond/error_pass.h"
#include "lode/models/diamond/near_samples.h"
#include "lode/models/diamond/paged_model.h"
#include "lode/models/diamond/world_pass.h"

namespace lode::diamond {
namespace {

/// Of a node of level 0, operation by operation as LeafPass.
template <int D, typename C, typename T, typename Field>
class FinestWorldError {
 public:
  FinestWorldError(const Field& field, const Index<D>& centre, const WorldScale<D, C>& scale)
      : field_(field),
        centre_(centre),
        near_(field, centre, 3),
        grid_(field.shape.grid_dims(0)),
        rule_(scale) {}

  [[nodiscard]] C own(const Diamond<D>& node) const {
    return rule_(node, own_error(node), [&](const Index<D>& p) { return value(p); });
  }
  [[nodiscard]] C nested(const Diamond<D>& node) const {
    C share = own(node);
    if (node.tier < D - 1)
      for (const Index<D>& child : children<D>(node))
        share = std::max(share, nested(diamond_at<D>(child)));
    return share;
  }

 private:
  /// Extended beyond the data as far as level 0's cubes go; NaN where there is nothing.
  [[nodiscard]] C value(const Index<D>& p) const {
    for (std::size_t i = 0; i < as_size(D); ++i)
      if (p[i] < 0 || p[i] >= grid_[i]) return std::numeric_limits<C>::quiet_NaN();
    return static_cast<C>(near_value(near_, field_, p, p - centre_));
  }

  /// At this level every sample of the bisected face is the middle of an edge of some node.
  [[nodiscard]] C own_error(const Diamond<D>& node) const {
    C error = midpoint_error(node);
    if (node.tier < D - 1)
      for (const Index<D>& child : children<D>(node))
        error = std::max(error, own_error(diamond_at<D>(child)));
    return error;
  }

  [[nodiscard]] C midpoint_error(const Diamond<D>& node) const {
    if (!field_.shape.is_sample(node.centre)) return 0;
    if (node.tier == D - 1 && field_.has_holes() && field_.is_mixed(node.centre))
      return std::numeric_limits<C>::infinity();
    const auto ends = axis_ends<D>(node);
    const C error = std::abs(value(node.centre) - C(0.5) * (value(ends[0]) + value(ends[1])));
    return std::isnan(error) ? 0 : error;
  }

  const Field& field_;
  Index<D> centre_;
  NearSamples<D, T> near_;
  Index<D> grid_;
  WorldErrorRule<D, C> rule_;
};

template <int D, typename V>
Result<WorldErrors> compute_as(const Model<D>& model, Threads threads, Progress& progress) {
  using C = typename SampleScale<D, V>::C;
  WorldErrors worlds = no_worlds<D>(model.shape, threads);
  std::vector<UninitializedArray<ErrorCode>> errors(worlds.size());
  OwnErrors own(errors.size());
  for (std::size_t level = 1; level < own.size(); ++level) {
    fill_anew(errors[level], worlds[level].size(), ErrorCode{0}, threads);
    own[level] = errors[level];
  }
  NodeLevel leaf;
  leaf.error.resize(worlds[0].size());
  leaf.low.resize(worlds[0].size());
  leaf.high.resize(worlds[0].size());
  LODE_CHECK((find_own_errors<D, V>(model, own, &leaf, &worlds[0], threads, progress)));
  find_worlds<D, C>(model, own, threads, worlds);
  return worlds;
}

}  // namespace

template <int D>
Result<WorldErrors> compute_world_errors(const Model<D>& model, Threads threads,
                                         Progress& progress) {
  return visit_held_type<D>(
      model, [&]<typename V>() { return compute_as<D, V>(model, threads, progress); });
}

namespace {

/// share_of(finest) of a FinestWorldError of the right types.
template <int D, typename Field, typename ShareOf>
double finest_share(const Field& field, const Diamond<D>& node, const WorldScales<D>& scales,
                    const ShareOf& share_of) {
  return visit_storage_type(field.storage, [&]<typename T>() -> double {
    if (is_exact_in_float<D>(field))
      return share_of(FinestWorldError<D, float, T, Field>(field, node.centre, scales.in_float));
    return share_of(FinestWorldError<D, double, T, Field>(field, node.centre, scales.in_double));
  });
}

}  // namespace

template <int D, typename Field>
double finest_own_world(const Field& field, const Diamond<D>& node, const WorldScales<D>& scales) {
  return finest_share<D>(field, node, scales,
                         [&](const auto& finest) -> double { return finest.own(node); });
}

template <int D, typename Field>
WorldCode finest_world_error(const Field& field, const Diamond<D>& node,
                             const WorldScales<D>& scales) {
  return encode_world(float_up(finest_share<D>(
      field, node, scales, [&](const auto& finest) -> double { return finest.nested(node); })));
}

template Result<WorldErrors> compute_world_errors<2>(const Model<2>&, Threads, Progress&);
template Result<WorldErrors> compute_world_errors<3>(const Model<3>&, Threads, Progress&);
template double finest_own_world<2>(const Model<2>&, const Diamond<2>&, const WorldScales<2>&);
template double finest_own_world<3>(const Model<3>&, const Diamond<3>&, const WorldScales<3>&);
template WorldCode finest_world_error<2>(const Model<2>&, const Diamond<2>&, const WorldScales<2>&);
template WorldCode finest_world_error<3>(const Model<3>&, const Diamond<3>&, const WorldScales<3>&);
template WorldCode finest_world_error<2>(const PagedModel<2>&, const Diamond<2>&,
                                         const WorldScales<2>&);
template WorldCode finest_world_error<3>(const PagedModel<3>&, const Diamond<3>&,
                                         const WorldScales<3>&);

}  // namespace lode::diamond

#include "lode/models/diamond/distance_cut.h"

#include <cmath>

#include "lode/models/diamond/leaf_facets.h"
#include "lode/models/diamond/refinable.h"
#include "lode/models/diamond/selection.h"

namespace lode::diamond {
namespace {

/// All of a model in memory.
class WholeWindow : public DistanceWindow {
 public:
  WholeWindow(const Model<3>& model, const IsosurfaceQuery& query, double max_distance,
              const WorldErrors& worlds)
      : model_(model),
        nodes_(model),
        query_(query),
        worlds_(worlds),
        wanted_(model.shape),
        fresh_(model.shape),
        tolerance_(tolerance_code(query.tolerance)),
        max_distance_(max_distance) {
    if (query.wanted != nullptr) wanted_ = *query.wanted;
    query_.wanted = &wanted_;
  }

  Facets full(const Progress& progress) override {
    return own(full_facets(model_, query_, progress));
  }
  Facets cut(const Progress& progress) override {
    const NodeSet<3>* const fresh = is_all_fresh_ ? nullptr : &fresh_;
    return own(cut_facets(model_, query_, fresh, progress));
  }

  /// What is estimated to be far off: it does not matter whether all of it is.
  std::uint64_t insert_guess() override {
    std::uint64_t n = 0;
    const Selection<3> selection(model_, query_.isovalue, query_.tolerance);
    const double edge = WorldScales<3>(model_).in_double.edge;
    for (int level = model_.shape.n_levels - 1; level >= 0; --level) {
      const auto& codes = worlds_[as_size(level)];
      const Index<3> dims = model_.shape.attribute_dims(level);
      for (std::size_t at = 0; at < codes.size(); ++at) {
        const double estimate =
            static_cast<double>(decode_world(codes[at])) * std::ldexp(edge, level);
        if (!(estimate > kFarOffDistances * max_distance_)) continue;
        const Index<3> q = point_of<3>(dims, at);
        Index<3> centre;
        for (std::size_t i = 0; i < 3; ++i) centre[i] = level > 0 ? q[i] << level : 2 * q[i] + 1;
        if (common_exponent<3>(centre) != level || !model_.shape.is_sample(centre)) continue;
        if (selection.is_active(level, at)) n += insert(centre);
      }
    }
    return n;
  }
  std::uint64_t insert(const Index<3>& centre) override {
    std::uint64_t n = 0;
    wanted_.insert(centre, [&](const Index<3>& p) {
      fresh_.set(p);
      ++n;
    });
    return n;
  }
  void forget_new() override {
    is_all_fresh_ = false;
    fresh_.clear();
  }
  bool contains(const Index<3>& centre) const override { return wanted_.contains(centre); }
  bool is_refined(const Simplex<3>& s) const override {
    const Diamond<3> node = diamond_at<3>(s.bisection_point());
    if (wanted_.contains(node.centre) || model_.shape.reaches_across(node.centre, node.level))
      return true;
    return encode_error(static_cast<float>(nodes_.facts_at(node).error)) > tolerance_;
  }
  const Shape<3>& shape() const override { return model_.shape; }

  [[nodiscard]] NodeSet<3> take_nodes() { return std::move(wanted_); }

 private:
  static Facets own(std::vector<Facet> facets) {
    const std::size_t n = facets.size();
    return {std::move(facets), n};
  }

  const Model<3>& model_;
  Refinable<3> nodes_;
  IsosurfaceQuery query_;
  const WorldErrors& worlds_;
  NodeSet<3> wanted_;
  NodeSet<3> fresh_;
  bool is_all_fresh_ = true;
  ErrorCode tolerance_;
  double max_distance_;
};

}  // namespace

Result<DistanceCut> find_distance_cut(const Model<3>& model, const IsosurfaceQuery& query,
                                      double max_distance, const WorldErrors& worlds,
                                      Progress& progress) {
  WholeWindow window(model, query, max_distance, worlds);
  LODE_TRY(const auto report, search_distance(window, max_distance, query.threads, progress));
  return DistanceCut{window.take_nodes(), report};
}

}  // namespace lode::diamond

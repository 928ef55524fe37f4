#include "lode/models/diamond/world_error.h"

#include <atomic>

#include "lode/models/diamond/error_pass.h"

namespace lode::diamond {
namespace {

/// The samples of level 0's grid, extended beyond the data; NaN outside.
template <int D>
class FinestSamples {
 public:
  explicit FinestSamples(const Model<D>& model) : model_(model), dims_(model.shape.grid_dims(0)) {}

  [[nodiscard]] double operator()(const Index<D>& p) const {
    for (std::size_t i = 0; i < as_size(D); ++i)
      if (p[i] < 0 || p[i] >= dims_[i]) return std::numeric_limits<double>::quiet_NaN();
    return model_.value_or_nan(p);
  }

 private:
  const Model<D>& model_;
  Index<D> dims_;
};

template <int D>
class FinestWorldErrors {
 public:
  explicit FinestWorldErrors(const Model<D>& model) : model_(model), rule_(model), value_(model) {}

  [[nodiscard]] double nested(const Diamond<D>& node) const {
    double world = rule_(node, own_error(node), value_);
    if (node.tier < D - 1)
      for (const Index<D>& child : children<D>(node))
        world = std::max(world, nested(diamond_at<D>(child)));
    return world;
  }

 private:
  /// At this level every sample of the bisected face is the middle of an edge of some node.
  [[nodiscard]] double own_error(const Diamond<D>& node) const {
    double error = 0;
    for_each_of_face(node, 0, node.centre, [&](const Index<D>& p) {
      if (std::all_of(p.v.begin(), p.v.end(), [](std::int32_t x) { return (x & 1) == 0; })) return;
      error = std::max(error, midpoint_error(diamond_at<D>(p)));
    });
    return error;
  }

  template <typename Body>
  void for_each_of_face(const Diamond<D>& node, int axis, Index<D> p, const Body& body) const {
    if (axis == D) {
      body(p);
      return;
    }
    const std::int32_t reach = node.is_odd(axis) ? 1 : 0;
    const std::int32_t middle = p[as_size(axis)];
    for (std::int32_t step = -reach; step <= reach; ++step) {
      p[as_size(axis)] = middle + step;
      for_each_of_face(node, axis + 1, p, body);
    }
  }

  [[nodiscard]] double midpoint_error(const Diamond<D>& node) const {
    if (model_.has_holes() && model_.is_mixed(node.centre))
      return std::numeric_limits<double>::infinity();
    if (!model_.shape.is_sample(node.centre)) return 0;
    const auto ends = axis_ends<D>(node);
    const double e = std::abs(value_(node.centre) - 0.5 * (value_(ends[0]) + value_(ends[1])));
    return std::isnan(e) ? 0 : e;
  }

  const Model<D>& model_;
  WorldErrorRule<D> rule_;
  FinestSamples<D> value_;
};

/// The level's samples as one array.
template <int D, typename C>
class LevelSamples {
 public:
  LevelSamples(const Model<D>& model, int level, Threads threads)
      : level_(level), dims_(model.shape.grid_dims(level)), values_(n_points<D>(dims_)) {
    const auto row = as_size(dims_[0]);
    parallel_for(values_.size() / row, threads, 16, [&](std::size_t r, int) {
      for (std::size_t i = r * row; i < (r + 1) * row; ++i)
        values_[i] = static_cast<C>(model.value_or_nan(point_of<D>(dims_, i) * (1 << level)));
    });
  }
  [[nodiscard]] double operator()(const Index<D>& p) const {
    Index<D> q;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      q[i] = p[i] >> level_;
      if (q[i] < 0 || q[i] >= dims_[i]) return std::numeric_limits<double>::quiet_NaN();
    }
    return static_cast<double>(values_[linear_index<D>(dims_, q)]);
  }

 private:
  int level_;
  Index<D> dims_;
  std::vector<C> values_;
};

template <int D, typename C>
class WorldPass {
 public:
  WorldPass(const Model<D>& model, const OwnErrors& own, Threads threads)
      : model_(model), own_(own), threads_(threads) {
    for (int level = 0; level < model.shape.n_levels; ++level)
      worlds_.emplace_back(n_points<D>(model.shape.attribute_dims(level)), 0.0F);
  }

  WorldErrors run() {
    find_finest();
    for (int level = 1; level < model_.shape.n_levels; ++level) {
      const LevelSamples<D, C> samples(model_, level, threads_);
      for (int tier = D - 1; tier >= 0; --tier) find_tier(level, tier, samples);
    }
    WorldErrors result;
    for (const auto& level : worlds_) {
      result.emplace_back(level.size());
      std::transform(level.begin(), level.end(), result.back().begin(), encode_error);
    }
    return result;
  }

 private:
  void find_finest() {
    const FinestWorldErrors<D> finest(model_);
    const Index<D> dims = model_.shape.attribute_dims(0);
    parallel_for(worlds_[0].size(), threads_, 64, [&](std::size_t at, int) {
      Index<D> centre = point_of<D>(dims, at) * 2;
      for (std::int32_t& x : centre.v) ++x;
      worlds_[0][at] = float_up(finest.nested(diamond_at<D>(centre)));
    });
  }

  void find_tier(int level, int tier, const LevelSamples<D, C>& samples) {
    const WorldErrorRule<D> rule(model_);
    const Index<D> dims = model_.shape.grid_dims(level);
    auto& worlds = worlds_[as_size(level)];
    parallel_for(worlds.size(), threads_, 256, [&](std::size_t at, int) {
      const Index<D> q = point_of<D>(dims, at);
      int n_odd = 0;
      for (const std::int32_t x : q.v) n_odd += x & 1;
      if (n_odd != D - tier) return;
      const Diamond<D> node = diamond_at<D>(q * (1 << level));
      const double own = static_cast<double>(decode_error(own_[as_size(level)][at]));
      float world = float_up(rule(node, own, samples));
      for (const Index<D>& child : children<D>(node)) world = std::max(world, stored(child));
      worlds[at] = world;
    });
  }

  /// A child's, 0 where there is none.
  [[nodiscard]] float stored(const Index<D>& centre) const {
    const Diamond<D> node = diamond_at<D>(centre);
    const Index<D> dims = model_.shape.attribute_dims(node.level);
    Index<D> q;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      q[i] = centre[i] >> std::max(node.level, 1);
      if (centre[i] < 0 || q[i] >= dims[i]) return 0;
    }
    return worlds_[as_size(node.level)][linear_index<D>(dims, q)];
  }

  const Model<D>& model_;
  const OwnErrors& own_;
  Threads threads_;
  std::vector<std::vector<float>> worlds_;
};

template <int D, typename C>
Result<WorldErrors> compute_as(const Model<D>& model, Threads threads, Progress& progress) {
  std::vector<std::vector<ErrorCode>> errors(as_size(model.shape.n_levels));
  OwnErrors own(errors.size());
  for (int level = 1; level < model.shape.n_levels; ++level) {
    errors[as_size(level)].resize(n_points<D>(model.shape.grid_dims(level)));
    own[as_size(level)] = errors[as_size(level)];
  }
  LODE_CHECK((find_own_errors<D, C>(model, own, nullptr, threads, progress)));
  return WorldPass<D, C>(model, own, threads).run();
}

}  // namespace

template <int D>
Result<WorldErrors> compute_world_errors(const Model<D>& model, Threads threads,
                                         Progress& progress) {
  return is_exact_in_float<D>(model) ? compute_as<D, float>(model, threads, progress)
                                     : compute_as<D, double>(model, threads, progress);
}

template <int D>
double finest_world_error(const Model<D>& model, const Diamond<D>& node) {
  return FinestWorldErrors<D>(model).nested(node);
}

template Result<WorldErrors> compute_world_errors<2>(const Model<2>&, Threads, Progress&);
template Result<WorldErrors> compute_world_errors<3>(const Model<3>&, Threads, Progress&);
template double finest_world_error<2>(const Model<2>&, const Diamond<2>&);
template double finest_world_error<3>(const Model<3>&, const Diamond<3>&);

}  // namespace lode::diamond

#include "lode/models/diamond/world_error.h"

#include <memory>

#include "lode/models/diamond/error_pass.h"
#include "lode/models/diamond/near_samples.h"

namespace lode::diamond {
namespace {

/// The samples of level 0's grid round a node, extended beyond the data; NaN outside.
template <int D, typename T>
class FinestSamples {
 public:
  FinestSamples(const Model<D>& model, const Index<D>& centre)
      : model_(model), centre_(centre), near_(model, centre, 3), dims_(model.shape.grid_dims(0)) {}

  [[nodiscard]] double operator()(const Index<D>& p) const {
    for (std::size_t i = 0; i < as_size(D); ++i)
      if (p[i] < 0 || p[i] >= dims_[i]) return std::numeric_limits<double>::quiet_NaN();
    return near_value(near_, model_, p, p - centre_);
  }

 private:
  const Model<D>& model_;
  Index<D> centre_;
  NearSamples<D, T> near_;
  Index<D> dims_;
};

template <int D, typename T>
class FinestWorldErrors {
 public:
  FinestWorldErrors(const Model<D>& model, const Index<D>& centre)
      : model_(model), rule_(model), value_(model, centre) {}

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
  FinestSamples<D, T> value_;
};

/// The world errors of level 0's cubes, a brick at a time: each sample's own node is looked at
/// once, in values that lie together.
template <int D, typename C>
class FinestWorldPass {
 public:
  FinestWorldPass(const Model<D>& model, std::vector<float>& worlds)
      : model_(model), rule_(model), dims_(model.shape.grid_dims(0)), worlds_(worlds) {
    values_.resize(power(as_size(kEdge), D));
    midpoint_.resize(values_.size());
    world_.resize(values_.size());
    std::size_t stride = 1;
    for (std::size_t i = 0; i < as_size(D); ++i, stride *= as_size(kEdge)) stride_[i] = stride;
    find_near();
  }

  void run_brick(const Index<D>& brick) {
    base_ = brick * kBrickEdge<D>;
    gather_values<D, C>(model_, brick, 1, values_.data());
    hide_outside();
    for_each_node(
        [&](const Index<D>& p, std::size_t at) { midpoint_[at] = midpoint_error(p, at); });
    const auto value = [&](const Index<D>& p) { return static_cast<double>(values_[place(p)]); };
    for_each_node([&](const Index<D>& p, std::size_t at) {
      const Diamond<D> node = diamond_at<D>(p);
      world_[at] = float_up(rule_(node, largest_near(midpoint_, node.odd, at), value));
    });
    const Index<D> cubes = model_.shape.attribute_dims(0);
    for_each_node([&](const Index<D>& p, std::size_t at) {
      Index<D> q;
      for (std::size_t i = 0; i < as_size(D); ++i) {
        if ((p[i] & 1) == 0 || p[i] - base_[i] == kBrickEdge<D>) return;
        q[i] = p[i] / 2;
      }
      worlds_[linear_index<D>(cubes, q)] =
          static_cast<float>(largest_near(world_, (1U << D) - 1, at));
    });
  }

 private:
  static constexpr std::int32_t kEdge = kBrickSamples<D> + 2;

  /// Around a point, by odd axes: the centres in their face but for its corners.
  void find_near() {
    for (std::size_t code = 0; code < power(3, D); ++code) {
      const Index<D> step = point_of<D>(all_equal<D>(3), code) - all_equal<D>(1);
      std::ptrdiff_t offset = 0;
      std::uint32_t moved = 0;
      for (std::size_t i = 0; i < as_size(D); ++i) {
        if (step[i] != 0) moved |= 1U << i;
        offset += step[i] * static_cast<std::ptrdiff_t>(stride_[i]);
      }
      for (std::uint32_t odd = 1; odd < near_.size(); ++odd)
        if (moved != 0 && (moved & ~odd) == 0 && moved != odd) near_[odd].push_back(offset);
    }
  }

  [[nodiscard]] std::size_t place(const Index<D>& p) const {
    std::size_t at = 0;
    for (std::size_t i = 0; i < as_size(D); ++i) at += as_size(p[i] - base_[i] + 1) * stride_[i];
    return at;
  }

  /// Beyond the grid there is nothing.
  void hide_outside() {
    bool is_inside = true;
    for (std::size_t i = 0; i < as_size(D); ++i)
      is_inside = is_inside && base_[i] > 0 && base_[i] + kBrickEdge<D> + 1 < dims_[i];
    if (is_inside) return;
    const Index<D> edges = all_equal<D>(kEdge);
    for (std::size_t at = 0; at < values_.size(); ++at) {
      const Index<D> p = base_ + point_of<D>(edges, at) - all_equal<D>(1);
      for (std::size_t i = 0; i < as_size(D); ++i)
        if (p[i] < 0 || p[i] >= dims_[i]) values_[at] = std::numeric_limits<C>::quiet_NaN();
    }
  }

  /// body(p, place) for the nodes of level 0 in the brick and on its border.
  template <typename Body>
  void for_each_node(const Body& body) const {
    Index<D> n;
    for (std::size_t i = 0; i < as_size(D); ++i)
      n[i] = std::min(kBrickSamples<D>, dims_[i] - base_[i]);
    Index<D> rows = n;
    rows[0] = 1;
    for (std::size_t r = 0; r < n_points<D>(rows); ++r) {
      Index<D> p = base_ + point_of<D>(rows, r);
      std::int32_t odd = 0;
      for (std::size_t i = 1; i < as_size(D); ++i) odd |= p[i] & 1;
      const std::size_t first = place(p);
      for (std::int32_t x = 0; x < n[0]; ++x, ++p[0])
        if (((odd | p[0]) & 1) != 0) body(p, first + as_size(x));
    }
  }

  [[nodiscard]] double midpoint_error(const Index<D>& p, std::size_t at) const {
    if (model_.has_holes() && model_.is_mixed(p)) return std::numeric_limits<double>::infinity();
    if (!model_.shape.is_sample(p)) return 0;
    const auto ends = axis_ends<D>(diamond_at<D>(p));
    const double e = std::abs(static_cast<double>(values_[at]) -
                              0.5 * (static_cast<double>(values_[place(ends[0])]) +
                                     static_cast<double>(values_[place(ends[1])])));
    return std::isnan(e) ? 0 : e;
  }

  /// The largest of the nodes whose centre lies in the face of the odd axes round `at`.
  template <typename T>
  [[nodiscard]] T largest_near(const std::vector<T>& of, std::uint32_t odd, std::size_t at) const {
    T largest = of[at];
    for (const std::ptrdiff_t offset : near_[odd])
      largest = std::max(largest, *(of.data() + at + offset));
    return largest;
  }

  const Model<D>& model_;
  WorldErrorRule<D> rule_;
  Index<D> dims_;  ///< Of level 0's grid.
  std::vector<float>& worlds_;
  Index<D> base_;
  std::array<std::size_t, as_size(D)> stride_{};
  std::array<std::vector<std::ptrdiff_t>, power(2, D)> near_;
  std::vector<C> values_;
  std::vector<double> midpoint_;
  std::vector<float> world_;
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
    std::vector<std::unique_ptr<FinestWorldPass<D, C>>> passes(as_size(n_workers(threads_)));
    parallel_for(model_.n_bricks(), threads_, 1, [&](std::size_t brick, int worker) {
      auto& pass = passes[as_size(worker)];
      if (!pass) pass = std::make_unique<FinestWorldPass<D, C>>(model_, worlds_[0]);
      pass->run_brick(point_of<D>(model_.brick_dims, brick));
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
  return visit_storage_type(model.storage, [&]<typename T>() {
    return FinestWorldErrors<D, T>(model, node.centre).nested(node);
  });
}

template Result<WorldErrors> compute_world_errors<2>(const Model<2>&, Threads, Progress&);
template Result<WorldErrors> compute_world_errors<3>(const Model<3>&, Threads, Progress&);
template double finest_world_error<2>(const Model<2>&, const Diamond<2>&);
template double finest_world_error<3>(const Model<3>&, const Diamond<3>&);

}  // namespace lode::diamond

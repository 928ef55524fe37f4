#include "lode/models/diamond/refinable.h"

#include "lode/models/diamond/finest_nodes.h"
#include "lode/models/diamond/near_samples.h"
#include "lode/models/diamond/paged_model.h"
#include "lode/models/diamond/star.h"

namespace lode::diamond {
namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();

/// The samples that a node of level 0 needs, from several bricks or pages.
template <int D, typename T>
class GatheredSamples {
 public:
  template <typename Field>
  GatheredSamples(const Field& field, const Index<D>& centre, const FinestNodes<D>& nodes) {
    for (const Index<D>& steps : nodes.samples)
      samples_[index_of(steps)] = static_cast<T>(field.value(centre + steps));
  }
  [[nodiscard]] T at(const Index<D>& steps) const { return samples_[index_of(steps)]; }

 private:
  static constexpr std::int32_t kEdge = 2 * FinestNodes<D>::kReach + 1;
  static std::size_t index_of(const Index<D>& steps) {
    return linear_index<D>(all_equal<D>(kEdge), steps + all_equal<D>(FinestNodes<D>::kReach));
  }
  std::array<T, power(kEdge, D)> samples_{};
};

/// A node's of level 0 and of those below it, all of whose samples are near; none is a hole.
template <int D, typename Near>
void join_near(const FinestNodes<D>& nodes, const Near& near, double& error, Range& range) {
  auto low = near.at({});
  auto high = low;
  for (const Index<D>& steps : nodes.samples) {
    const auto sample = near.at(steps);
    low = std::min(low, sample);
    high = std::max(high, sample);
  }
  range = {static_cast<double>(low), static_cast<double>(high)};
  for (const auto& b : nodes.bisections) {
    const auto middle = static_cast<double>(near.at(b.centre));
    const auto first = static_cast<double>(near.at(b.first));
    const auto second = static_cast<double>(near.at(b.second));
    error = std::max(error, std::abs(middle - 0.5 * (first + second)));
  }
}

/// All values round a node of level 0, no farther than its own samples are, and which of them are
/// holes, or beyond the data.
template <int D>
class SamplesRound {
 public:
  template <typename Field, typename T>
  SamplesRound(const Field& field, const Index<D>& centre, const NearSamples<D, T>& near) {
    for (std::size_t i = 0; i < kSize; ++i) {
      const Index<D> steps = point_of<D>(all_equal<D>(kEdge), i) - all_equal<D>(kReach);
      const Index<D> p = centre + steps;
      values_[i] = near_value(near, field, p, steps);
      const bool is_hole = std::isnan(values_[i]);
      kinds_[i] = !field.shape.is_sample(p) ? kBeyond : is_hole ? kHole : kFinite;
      has_holes_ = has_holes_ || is_hole;
    }
  }
  [[nodiscard]] bool has_holes() const { return has_holes_; }
  [[nodiscard]] double at(const Index<D>& steps) const { return values_[index_of(steps)]; }
  /// As LatticeField's.
  [[nodiscard]] bool is_mixed(const Index<D>& steps) const {
    static const std::array<std::ptrdiff_t, power(3, D)> kRound = [] {
      std::array<std::ptrdiff_t, power(3, D)> offsets;
      for (std::size_t i = 0; i < offsets.size(); ++i)
        offsets[i] = offset_of(point_of<D>(all_equal<D>(3), i) - all_equal<D>(1));
      return offsets;
    }();
    const std::uint8_t* middle = kinds_.data() + index_of(steps);
    if (!has_holes_ || *middle == kBeyond) return false;
    std::uint8_t kinds = 0;
    for (const std::ptrdiff_t offset : kRound) kinds |= middle[offset];
    return kinds == (kHole | kFinite);
  }

 private:
  static constexpr std::uint8_t kBeyond = 0;
  static constexpr std::uint8_t kFinite = 1;
  static constexpr std::uint8_t kHole = 2;
  static constexpr std::int32_t kReach = FinestNodes<D>::kReach;
  static constexpr std::int32_t kEdge = 2 * kReach + 1;
  static constexpr std::size_t kSize = power(as_size(kEdge), D);

  static std::ptrdiff_t offset_of(const Index<D>& steps) {
    std::ptrdiff_t offset = 0;
    for (std::size_t i = as_size(D); i-- > 0;) offset = offset * kEdge + steps[i];
    return offset;
  }
  static std::size_t index_of(const Index<D>& steps) {
    return static_cast<std::size_t>(offset_of(steps + all_equal<D>(kReach)));
  }

  std::array<double, kSize> values_;
  std::array<std::uint8_t, kSize> kinds_;
  bool has_holes_ = false;
};

}  // namespace

template <int D, typename Field>
Refinable<D, Field>::Refinable(const Field& model, Worlds worlds)
    : model_(model),
      worlds_(worlds),
      to_world_(model.info.grid.index_to_world_matrix()),
      world_scales_(model) {
  find_radii();
  const double edge = world_scales_.in_double.edge;
  for (int level = 0; level < model.shape.n_levels; ++level)
    longest_edges_[as_size(level)] = float_up(std::ldexp(edge, level));
}

template <int D, typename Field>
bool Refinable<D, Field>::is_deep(const Diamond<D>& node) const {
  const std::int32_t reach = 4 * node.h();
  for (std::size_t i = 0; i < as_size(D); ++i)
    if (node.centre[i] < reach || node.centre[i] + reach >= model_.shape.dims[i]) return false;
  return true;
}

template <int D, typename Field>
bool Refinable<D, Field>::exists(const Index<D>& centre) const {
  const std::int32_t root = model_.shape.root_side();
  for (std::size_t i = 0; i < as_size(D); ++i)
    if (centre[i] < 0 || centre[i] > root) return false;
  return model_.shape.overlaps_data(bounds_of(diamond_at<D>(centre)));
}

/// A node's ball contains the vertices of its own domain and its children's balls.
template <int D, typename Field>
void Refinable<D, Field>::find_radii() {
  const auto distance = [&](const Index<D>& step) {
    const Index3 q = model_.axes.to_grid(step);
    return length(to_world_ * Vec3d{{double(q[0]), double(q[1]), double(q[2])}});
  };
  // Centres are rounded where the origin is far away.
  const Box3d bounds = model_.info.grid.world_bounds();
  const double rounding = 0x1p-50 * std::max(length(bounds.lower), length(bounds.upper));
  for (int level = 0; level < model_.shape.n_levels; ++level)
    for (int tier = D - 1; tier >= 0; --tier)
      for (std::uint32_t odd = 1; odd < power(2, D); ++odd) {
        if (D - std::popcount(odd) != tier) continue;
        Index<D> centre;
        for (int i = 0; i < D; ++i) centre[as_size(i)] = (((odd >> i) & 1U) != 0 ? 3 : 4) << level;
        const Diamond<D> d = diamond_at<D>(centre);
        double radius = 0;
        for (const Index<D>& v : domain_vertices<D>(d))
          radius = std::max(radius, distance(v - centre));
        for (const Index<D>& child : children<D>(d)) {
          const Diamond<D> c = diamond_at<D>(child);
          radius = std::max(radius, distance(child - centre) + radii_[as_size(c.level)][c.odd]);
        }
        radii_[as_size(level)][odd] = radius * (1 + 1e-12) + rounding;
      }
}

template <int D, typename Field>
Bounds Refinable<D, Field>::bounds(NodeId id) const {
  const Diamond<D> node = diamond_of<D>(id);
  const Index3 q = model_.axes.to_grid(node.centre);
  return {model_.info.grid.to_world({{double(q[0]), double(q[1]), double(q[2])}}),
          radii_[as_size(node.level)][node.odd]};
}

template <int D, typename Field>
StoredFacts Refinable<D, Field>::facts(NodeId id) const {
  const Diamond<D> node = diamond_of<D>(id);
  StoredFacts facts;
  facts.is_at_border = !is_deep(node) && model_.shape.reaches_across(node.centre, node.level);
  if (!Field::has_attributes(node)) {
    add_finest(node, facts);
    return facts;
  }
  const StoredAttributes stored = model_.attributes(node);
  facts.error = decode_error(stored.error);
  facts.low = stored.low;
  facts.high = stored.high;
  if constexpr (std::is_same_v<Field, Model<D>>) {
    if (world_errors_ != nullptr)
      facts.world_error = world_error(
          node.level, (*world_errors_)[as_size(node.level)][model_.attribute_index(node)]);
  } else {
    if (worlds_ != Worlds::none)
      facts.world_error = world_error(node.level, model_.world_error(node));
  }
  return facts;
}

template <int D, typename Field>
void Refinable<D, Field>::prefetch(NodeId id) const {
  const Diamond<D> node = diamond_of<D>(id);
  if (Field::has_attributes(node)) model_.prefetch(node);
}

/// Own error and range, and those of the nodes below, of which those that miss the data are none.
template <int D, typename Field>
template <typename Samples>
void Refinable<D, Field>::join_finest(const Diamond<D>& node, const Index<D>& centre,
                                      const Samples& samples, Finest& facts) const {
  const auto value = [&](const Index<D>& p) { return samples.at(p - centre); };
  const auto join = [&](double f) {
    if (std::isnan(f)) return;
    facts.range.low = std::min(facts.range.low, f);
    facts.range.high = std::max(facts.range.high, f);
  };
  for (const Index<D>& v : domain_vertices<D>(node)) join(value(v));
  const double middle = value(node.centre);
  join(middle);
  if (samples.is_mixed(node.centre - centre)) facts.error = kEndless;
  if (model_.shape.is_sample(node.centre)) {
    const auto ends = axis_ends<D>(node);
    const double e = std::abs(middle - 0.5 * (value(ends[0]) + value(ends[1])));
    if (!std::isnan(e)) facts.error = std::max(facts.error, e + rounding_slack<D>(model_));
  }
  if (node.tier == D - 1) return;
  for (const Index<D>& child : children<D>(node))
    if (exists(child)) join_finest(diamond_at<D>(child), centre, samples, facts);
}

/// Rounded as stored ones are.
template <int D, typename Field>
void Refinable<D, Field>::add_finest(const Diamond<D>& node, StoredFacts& facts) const {
  Finest finest{0, {kEndless, -kEndless}};
  visit_storage_type(model_.storage, [&]<typename T>() {
    const NearSamples<D, T> near(model_, node.centre, FinestNodes<D>::kReach);
    if (model_.has_holes() || !near.is_in_data()) {
      const SamplesRound<D> samples(model_, node.centre, near);
      if (samples.has_holes() || !near.is_in_data())
        return join_finest(node, node.centre, samples, finest);
    }
    const FinestNodes<D>& nodes = finest_nodes<D>(node.centre);
    if (near.is_in_one())
      join_near<D>(nodes, near, finest.error, finest.range);
    else
      join_near<D>(nodes, GatheredSamples<D, T>(model_, node.centre, nodes), finest.error,
                   finest.range);
    finest.error += rounding_slack<D>(model_);
  });
  facts.error = decode_error(encode_error(float_up(finest.error)));
  const double low = finest.range.low - range_reference();
  const double high = finest.range.high - range_reference();
  facts.low = static_cast<float>(low);
  facts.high = static_cast<float>(high);
  constexpr float kFloatEndless = std::numeric_limits<float>::infinity();
  if (static_cast<double>(facts.low) > low) facts.low = std::nextafter(facts.low, -kFloatEndless);
  if (static_cast<double>(facts.high) < high)
    facts.high = std::nextafter(facts.high, kFloatEndless);
  if (worlds_ != Worlds::none || world_errors_ != nullptr)
    facts.world_error = world_error(0, finest_world_error<D>(model_, node, world_scales_));
}

template <int D, typename Field>
void Refinable<D, Field>::add_base(std::vector<NodeId>& out) const {
  if (!model_.shape.has_cells()) return;
  out.push_back(id_of<D>(all_equal<D>(model_.shape.root_side() / 2)));
}

template <int D, typename Field>
void Refinable<D, Field>::add_all_children(NodeId id, std::vector<NodeId>& out) const {
  for (const Index<D>& child : children<D>(diamond_of<D>(id)))
    if (exists(child)) out.push_back(id_of<D>(child));
}

template <int D, typename Field>
void Refinable<D, Field>::add_children(NodeId id, std::vector<NodeId>& out) const {
  const Diamond<D> node = diamond_of<D>(id);
  if (is_deep(node)) {
    for_each_discovered<D>(id, node, [&](NodeId child) { out.push_back(child); });
    return;
  }
  const std::int32_t root = model_.shape.root_side();
  const auto is_first_parent = [&](const Index<D>& child) {
    for (const Index<D>& parent : parents<D>(diamond_at<D>(child), root))
      if (exists(parent)) return parent == node.centre;
    return false;
  };
  for (const Index<D>& child : children<D>(node))
    if (exists(child) && is_first_parent(child)) out.push_back(id_of<D>(child));
}

template <int D, typename Field>
void Refinable<D, Field>::add_parents(NodeId id, std::vector<NodeId>& out) const {
  const Diamond<D> node = diamond_of<D>(id);
  const bool all_exist = is_deep(node);
  for_each_parent<D>(id, node, model_.shape.root_side(), [&](NodeId parent) {
    if (all_exist || exists(parent)) out.push_back(parent);
  });
}

template <int D, typename Field>
std::uint64_t Refinable<D, Field>::n_base_cells() const {
  if (!model_.shape.has_cells()) return 0;
  std::uint64_t n = 0;
  for (const Simplex<D>& s : kuhn_simplices<D>({}, model_.shape.root_side()))
    n += model_.shape.overlaps_data(bounds_of(s)) ? 1 : 0;
  return n;
}

/// What bisecting adds: one for each simplex, unless one half misses the data.
template <int D, typename Field>
std::uint64_t Refinable<D, Field>::n_simplices(NodeId id) const {
  const Diamond<D> node = diamond_of<D>(id);
  constexpr std::array<std::uint64_t, 3> kCounts =
      D == 3 ? std::array<std::uint64_t, 3>{6, 4, 8} : std::array<std::uint64_t, 3>{2, 2};
  if (is_deep(node)) return kCounts[as_size(node.tier)];
  const Star<D>& star = star_of(node);
  std::uint64_t n = 0;
  for (const Simplex<D>& s : star.simplices) {
    const Simplex<D> whole = placed(s, node);
    if (!model_.shape.overlaps_data(bounds_of(whole))) continue;
    --n;
    for (const Simplex<D>& half : bisect(whole))
      n += model_.shape.overlaps_data(bounds_of(half)) ? 1 : 0;
  }
  return n;
}

template <int D, typename Field>
std::vector<Simplex<D>> Refinable<D, Field>::leaves(const Cut& cut) const {
  std::vector<Simplex<D>> result;
  for_each_leaf(
      cut, [](const Simplex<D>&) { return true; },
      [&](const Simplex<D>& leaf) { result.push_back(leaf); });
  return result;
}

template class Refinable<2>;
template class Refinable<3>;
template class Refinable<2, PagedModel<2>>;
template class Refinable<3, PagedModel<3>>;

}  // namespace lode::diamond

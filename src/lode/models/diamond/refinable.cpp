#include "lode/models/diamond/refinable.h"

#include "lode/models/diamond/selection.h"

namespace lode::diamond {
namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();

}  // namespace

template <int D>
std::uint64_t Refinable<D>::id(const Node& node) const {
  std::uint64_t id = 0;
  for (std::size_t i = 0; i < as_size(D); ++i)
    id |= static_cast<std::uint64_t>(node.centre[i]) << (21 * i);
  return id;
}

template <int D>
bool Refinable<D>::exists(const Index<D>& centre) const {
  const std::int32_t root = model_.shape.root_side();
  for (std::size_t i = 0; i < as_size(D); ++i)
    if (centre[i] < 0 || centre[i] > root) return false;
  return model_.shape.overlaps_data(bounds_of(diamond_at<D>(centre)));
}

template <int D>
Box3d Refinable<D>::bounds(const Node& node) const {
  // Descendants of the same level lie up to h away along an odd axis, which is even from then on;
  // the next level's cubes h / 2 further along every axis, and so on: 3h and 2h in all.
  const auto reach = [&](int axis) { return (node.is_odd(axis) ? 3 : 2) * node.h(); };
  Box3d box;
  bool is_first = true;
  for (int corner = 0; corner < (1 << D); ++corner) {
    Index<D> p;
    for (int i = 0; i < D; ++i) {
      const std::int32_t to_side = ((corner >> i) & 1) == 0 ? -reach(i) : reach(i);
      p[as_size(i)] = node.centre[as_size(i)] + to_side;
    }
    p = model_.clamped(p);
    const Index3 q = model_.axes.to_grid(p);
    const Vec3d world = model_.info.grid.to_world({{double(q[0]), double(q[1]), double(q[2])}});
    for (std::size_t i = 0; i < 3; ++i) {
      box.lower[i] = is_first ? world[i] : std::min(box.lower[i], world[i]);
      box.upper[i] = is_first ? world[i] : std::max(box.upper[i], world[i]);
    }
    is_first = false;
  }
  return box;
}

template <int D>
NodeFacts Refinable<D>::facts(const Node& node) const {
  if (node.level == 0 && node.tier > 0) return finest_facts(node);
  const Selection<D> selection(model_, 0, 0);
  const std::size_t at = selection.index_of(node);
  const NodeLevel& level = model_.levels[as_size(node.level)];
  const double reference = model_.range_reference();
  return {static_cast<double>(decode_error(level.error[at])),
          {static_cast<double>(level.low[at]) + reference,
           static_cast<double>(level.high[at]) + reference},
          bounds(node)};
}

template <int D>
void Refinable<D>::join_own(const Node& node, NodeFacts& facts) const {
  const auto join = [&](double f) {
    if (std::isnan(f)) return;
    facts.range.low = std::min(facts.range.low, f);
    facts.range.high = std::max(facts.range.high, f);
  };
  for (const Index<D>& v : domain_vertices<D>(node)) join(model_.value_or_nan(v));
  join(model_.value_or_nan(node.centre));
  if (model_.has_holes() && model_.is_mixed(node.centre)) facts.error = kEndless;
  if (!model_.shape.is_sample(node.centre)) return;
  const auto ends = axis_ends<D>(node);
  const double e = std::abs(model_.value_or_nan(node.centre) -
                            0.5 * (model_.value_or_nan(ends[0]) + model_.value_or_nan(ends[1])));
  if (!std::isnan(e)) facts.error = std::max(facts.error, e + rounding_slack<D>(model_));
}

template <int D>
NodeFacts Refinable<D>::finest_facts(const Node& node) const {
  NodeFacts facts{0, {kEndless, -kEndless}, bounds(node)};
  join_own(node, facts);
  std::vector<Node> below;
  add_children(node, below);
  for (const Node& child : below) {
    const NodeFacts nested = finest_facts(child);
    facts.error = std::max(facts.error, nested.error);
    facts.range.low = std::min(facts.range.low, nested.range.low);
    facts.range.high = std::max(facts.range.high, nested.range.high);
  }
  return facts;
}

template <int D>
void Refinable<D>::add_base(std::vector<Node>& out) const {
  if (!model_.shape.has_cells()) return;
  Index<D> centre;
  for (std::size_t i = 0; i < as_size(D); ++i) centre[i] = model_.shape.root_side() / 2;
  out.push_back(diamond_at<D>(centre));
}

template <int D>
void Refinable<D>::add_children(const Node& node, std::vector<Node>& out) const {
  for (const Index<D>& centre : children<D>(node))
    if (exists(centre)) out.push_back(diamond_at<D>(centre));
}

template <int D>
void Refinable<D>::add_parents(const Node& node, std::vector<Node>& out) const {
  for (const Index<D>& centre : parents<D>(node, model_.shape.root_side()))
    if (exists(centre)) out.push_back(diamond_at<D>(centre));
}

template <int D>
std::vector<Simplex<D>> Refinable<D>::leaves(const Cut<Node>& cut) const {
  std::vector<Simplex<D>> result;
  if (!model_.shape.has_cells()) return result;
  std::vector<Simplex<D>> open = kuhn_simplices<D>({}, model_.shape.root_side());
  while (!open.empty()) {
    const Simplex<D> simplex = open.back();
    open.pop_back();
    if (!model_.shape.overlaps_data(bounds_of(simplex))) continue;
    if (is_finest(simplex) || !cut.contains(id(diamond_at<D>(simplex.bisection_point())))) {
      result.push_back(simplex);
      continue;
    }
    for (const Simplex<D>& half : bisect(simplex)) open.push_back(half);
  }
  return result;
}

template class Refinable<2>;
template class Refinable<3>;

}  // namespace lode::diamond

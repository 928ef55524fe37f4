#include "lode/models/diamond/refinable.h"

#include "lode/models/diamond/selection.h"

namespace lode::diamond {
namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();

template <int D>
bool meets_data(const Shape<D>& shape, const Simplex<D>& simplex) {
  Index<D> lower = simplex.v[0];
  Index<D> upper = simplex.v[0];
  for (const Index<D>& v : simplex.v)
    for (std::size_t i = 0; i < as_size(D); ++i) {
      lower[i] = std::min(lower[i], v[i]);
      upper[i] = std::max(upper[i], v[i]);
    }
  return shape.overlaps_data(lower, upper);
}

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
  const Node node = diamond_at<D>(centre);
  const std::int32_t h = node.h();
  Index<D> lower;
  Index<D> upper;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    lower[i] = std::max(0, centre[i] - h);
    upper[i] = std::min(root, centre[i] + h);
  }
  return model_.shape.overlaps_data(lower, upper);
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

/// Whether some, but not all, of the unit cells round a point are removed by holes.
template <int D>
bool is_mixed(const Model<D>& model, const Index<D>& p) {
  bool has_present = false;
  bool has_removed = false;
  for (int corner = 0; corner < (1 << D); ++corner) {
    Index<D> cell = p;
    bool is_real = true;
    for (int i = 0; i < D; ++i) {
      cell[as_size(i)] -= (corner >> i) & 1;
      is_real =
          is_real && cell[as_size(i)] >= 0 && cell[as_size(i)] < model.shape.dims[as_size(i)] - 1;
    }
    if (is_real) (model.is_removed_cell(cell) ? has_removed : has_present) = true;
  }
  return has_present && has_removed;
}

template <int D>
void Refinable<D>::join_own(const Node& node, NodeFacts& facts) const {
  const auto value = [&](const Index<D>& p) {
    const double f = model_.value(p);
    return model_.has_holes() && model_.is_hole(f) ? std::numeric_limits<double>::quiet_NaN() : f;
  };
  const auto join = [&](double f) {
    if (std::isnan(f)) return;
    facts.range.low = std::min(facts.range.low, f);
    facts.range.high = std::max(facts.range.high, f);
  };
  for (const Index<D>& v : domain_vertices<D>(node)) join(value(v));
  join(value(node.centre));
  if (model_.has_holes() && is_mixed<D>(model_, node.centre)) facts.error = kEndless;
  if (!model_.shape.is_sample(node.centre)) return;
  const auto ends = axis_ends<D>(node);
  const double e = std::abs(value(node.centre) - 0.5 * (value(ends[0]) + value(ends[1])));
  if (!std::isnan(e)) facts.error = std::max(facts.error, e);
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
    if (!meets_data<D>(model_.shape, simplex)) continue;
    const Index<D> edge = simplex.v[0] - simplex.v[as_size(simplex.tag)];
    const bool is_finest = common_exponent<D>(edge) == 0;
    if (is_finest || !cut.contains(id(diamond_at<D>(simplex.bisection_point())))) {
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

#include "lode/models/diamond/node_attributes.h"

namespace lode::diamond {
namespace {

/// Walks one simplex that is not refined. Bisecting an edge, F' at its middle is the mean of F' at
/// its ends: F' is linear on the whole simplex.
template <int D>
class SimplexWalk {
 public:
  using Values = std::array<double, as_size(D) + 1>;

  explicit SimplexWalk(const Model<D>& model) : model_(model) {}

  void run(const Simplex<D>& s) {
    Values linear;
    for (std::size_t i = 0; i < linear.size(); ++i) {
      linear[i] = model_.value_or_nan(s.v[i]);
      join(s.v[i], linear[i]);
    }
    visit(s, linear);
    if (has_removed_ && found_.low <= found_.high)
      found_.error = std::numeric_limits<double>::infinity();
  }
  [[nodiscard]] const NodeAttributes& found() const { return found_; }

 private:
  void visit(const Simplex<D>& s, const Values& linear) {
    const LatticeBox<D> box = bounds_of(s);
    if (!model_.shape.overlaps_data(box)) return;
    if (is_finest(s)) {
      has_removed_ = has_removed_ || (model_.has_holes() && model_.is_removed_cell(box.lower));
      return;
    }
    const auto tag = as_size(s.tag);
    const double middle = 0.5 * (linear[0] + linear[tag]);
    join(s.bisection_point(), middle);
    const auto halves = bisect(s);
    Values half = linear;
    half[tag] = middle;
    visit(halves[0], half);
    for (std::size_t i = 0; i < tag; ++i) half[i] = linear[i + 1];
    visit(halves[1], half);
  }

  void join(const Index<D>& p, double linear) {
    if (!model_.shape.is_sample(p)) return;
    const double f = model_.value_or_nan(p);
    if (std::isnan(f)) return;
    found_.low = std::min(found_.low, f);
    found_.high = std::max(found_.high, f);
    const double error = std::abs(f - linear);
    if (error > found_.error) found_.error = error;
  }

  const Model<D>& model_;
  NodeAttributes found_;
  bool has_removed_ = false;
};

/// Bisects a Kuhn simplex `tier` times and keeps the parts that are bisected at `centre` next.
template <int D>
void add_parts(const Simplex<D>& s, int tier, const Index<D>& centre,
               std::vector<Simplex<D>>& out) {
  if (tier == 0) {
    if (s.bisection_point() == centre) out.push_back(s);
    return;
  }
  for (const Simplex<D>& half : bisect(s)) add_parts(half, tier - 1, centre, out);
}

}  // namespace

template <int D>
std::vector<Simplex<D>> simplices_of(const Shape<D>& shape, const Diamond<D>& node) {
  std::vector<Simplex<D>> result;
  const std::int32_t side = 2 * node.h();
  for (std::uint32_t corner = 0; corner < 1U << D; ++corner) {
    if ((corner & node.odd) != 0) continue;  // along odd axes the cube is centred at the node
    LatticeBox<D> cube;
    for (int i = 0; i < D; ++i) {
      const std::int32_t below = node.is_odd(i) ? node.h() : (corner >> i & 1U) != 0 ? side : 0;
      cube.lower[as_size(i)] = node.centre[as_size(i)] - below;
      cube.upper[as_size(i)] = cube.lower[as_size(i)] + side;
    }
    if (!shape.overlaps_data(cube)) continue;
    for (const Simplex<D>& s : kuhn_simplices<D>(cube.lower, side))
      add_parts(s, node.tier, node.centre, result);
  }
  return result;
}

template <int D>
NodeAttributes own_attributes(const Model<D>& model, const Diamond<D>& node) {
  NodeAttributes result;
  for (const Simplex<D>& s : simplices_of(model.shape, node)) {
    SimplexWalk<D> walk(model);
    walk.run(s);
    result.error = std::max(result.error, walk.found().error);
    result.low = std::min(result.low, walk.found().low);
    result.high = std::max(result.high, walk.found().high);
  }
  return result;
}

template std::vector<Simplex<2>> simplices_of<2>(const Shape<2>&, const Diamond<2>&);
template std::vector<Simplex<3>> simplices_of<3>(const Shape<3>&, const Diamond<3>&);
template NodeAttributes own_attributes<2>(const Model<2>&, const Diamond<2>&);
template NodeAttributes own_attributes<3>(const Model<3>&, const Diamond<3>&);

}  // namespace lode::diamond

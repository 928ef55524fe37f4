#include <cmath>
#include <utility>

#include "lode/models/terrain/right_triangle_bisection/extract.h"
#include "lode/refine/surface_facts.h"

namespace lode::bisection {
namespace {

/// Refines what a demand wants, from the base on.
class Selection {
 public:
  Selection(const Bisection& bisection, const HeightGrid& grid, const HeightRange& range,
            const Demand& demand)
      : bisection_(bisection),
        lattice_(bisection.lattice()),
        grid_(grid),
        range_(range),
        demand_(demand),
        uses_bounds_(demand.uses_bounds()),
        refined_(lattice_) {}

  NodeSet run() {
    for (const LatticePoint node : bisection_.kept())
      if (!lattice_.is_under_corner(node)) refine(node);
    const std::int32_t half = lattice_.side() / 2;
    if (half > 0) look_at({half, half}, half);
    while (!wanted_.empty()) {
      const LatticePoint node = wanted_.back();
      wanted_.pop_back();
      refine(node);
    }
    return std::move(refined_);
  }

 private:
  [[nodiscard]] std::int64_t index(LatticePoint node) const {
    return static_cast<std::int64_t>(lattice_.index(node));
  }
  void look_at(LatticePoint node, std::int32_t reach) {
    if (!lattice_.has_node(node, reach) || refined_.has(index(node))) return;
    const float error = bisection_.error(node);
    // There is nothing to gain. And where the outline passes there is no triangle yet.
    if (error == 0) return;
    if (!std::isinf(error)) {
      const NodeFacts facts = facts_of(node, static_cast<double>(error));
      if (!demand_.touches(facts) || !(to_rank(demand_(facts)) > 0)) return;
    }
    wanted_.push_back(node);
  }
  /// After those that it waits for.
  void refine(LatticePoint wanted) {
    chain_.assign(1, wanted);
    while (!chain_.empty()) {
      const LatticePoint node = chain_.back();
      const std::size_t n_before = chain_.size();
      const Diamond diamond(node);
      if (!refined_.has(index(node)))
        for (const LatticePoint apex : diamond.apexes)
          if (lattice_.has_node(apex, diamond.apex_reach()) && !refined_.has(index(apex)))
            chain_.push_back(apex);
      if (chain_.size() > n_before) continue;
      chain_.pop_back();
      if (!refined_.add(index(node)) || !diamond.has_children()) continue;
      for (const LatticePoint child : diamond.children()) look_at(child, diamond.child_reach());
    }
  }

  [[nodiscard]] NodeFacts facts_of(LatticePoint node, double error) const {
    if (!uses_bounds_) {
      NodeFacts facts;
      facts.error = error;
      facts.range = {range_.lower, range_.upper};
      return facts;
    }
    SurfacePatch patch;
    const Diamond diamond(node);
    for (const LatticePoint corner :
         {diamond.ends[0], diamond.ends[1], diamond.apexes[0], diamond.apexes[1]}) {
      if (!lattice_.has(corner)) continue;
      const LatticePoint place = lattice_.place(corner);
      const Vec<double, 2> at = grid_.world(place.x, place.y);
      patch.add({{at[0], at[1], grid_.height(place.x, place.y)}});
    }
    return patch.facts(error, {range_.lower, range_.upper});
  }

  const Bisection& bisection_;
  const Lattice& lattice_;
  const HeightGrid& grid_;
  const HeightRange& range_;
  const Demand& demand_;
  bool uses_bounds_;
  NodeSet refined_;
  std::vector<LatticePoint> wanted_;
  std::vector<LatticePoint> chain_;
};

}  // namespace

NodeSet select_nodes(const Bisection& bisection, const HeightGrid& grid, const HeightRange& range,
                     const Demand& demand) {
  return Selection(bisection, grid, range, demand).run();
}

}  // namespace lode::bisection

#pragma once

#include "lode/models/diamond/model.h"
#include "lode/refine/one_shot.h"

namespace lode::diamond {

/// The diamond hierarchy as the engine sees it: everything but the stored attributes follows from
/// a node's centre. Nodes whose domain misses the data do not exist.
template <int D>
class Refinable {
 public:
  using Node = Diamond<D>;

  explicit Refinable(const Model<D>& model) : model_(model) {}

  [[nodiscard]] std::uint64_t id(const Node& node) const;
  /// Those of level 0 and tiers above 0 are found from the samples.
  [[nodiscard]] NodeFacts facts(const Node& node) const;
  void add_base(std::vector<Node>& out) const;
  void add_children(const Node& node, std::vector<Node>& out) const;
  void add_parents(const Node& node, std::vector<Node>& out) const;

  /// The simplices of a cut that meet the data, in depth-first order. They may reach across its
  /// end: demands know nothing of the lattice.
  [[nodiscard]] std::vector<Simplex<D>> leaves(const Cut<Node>& cut) const;

 private:
  [[nodiscard]] bool exists(const Index<D>& centre) const;
  [[nodiscard]] NodeFacts finest_facts(const Node& node) const;
  void join_own(const Node& node, NodeFacts& facts) const;
  [[nodiscard]] Box3d bounds(const Node& node) const;

  const Model<D>& model_;
};

extern template class Refinable<2>;
extern template class Refinable<3>;
static_assert(RefinableModel<Refinable<2>> && RefinableModel<Refinable<3>>);

}  // namespace lode::diamond

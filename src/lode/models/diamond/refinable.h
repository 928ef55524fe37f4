#pragma once

#include <array>

#include "lode/models/diamond/world_error.h"
#include "lode/refine/one_shot.h"

namespace lode::diamond {

/// A node's id: its centre, 21 bits a coordinate.
template <int D>
[[nodiscard]] constexpr NodeId id_of(const Index<D>& centre) {
  std::uint64_t id = 0;
  for (std::size_t i = 0; i < as_size(D); ++i)
    id |= static_cast<std::uint64_t>(centre[i]) << (21 * i);
  return NodeId{id};
}

template <int D>
[[nodiscard]] constexpr Index<D> centre_of(NodeId id) {
  Index<D> centre;
  for (std::size_t i = 0; i < as_size(D); ++i)
    centre[i] = static_cast<std::int32_t>((static_cast<std::uint64_t>(id) >> (21 * i)) & 0x1FFFFFU);
  return centre;
}

/// The diamond hierarchy as the engine sees it: everything but the stored attributes follows from
/// a node's centre. Nodes whose domain misses the data do not exist.
template <int D>
class Refinable {
 public:
  /// `world_errors` may be null: then nodes have infinite ones.
  explicit Refinable(const Model<D>& model, const WorldErrors* world_errors = nullptr);

  [[nodiscard]] const Model<D>& model() const { return model_; }

  void add_base(std::vector<NodeId>& out) const;
  /// Of a node's children those whose first parent it is.
  void add_children(NodeId id, std::vector<NodeId>& out) const;
  void add_parents(NodeId id, std::vector<NodeId>& out) const;
  [[nodiscard]] StoredFacts facts(NodeId id) const;
  /// Contains the domains of all nodes below; its radius depends on level and odd axes only.
  [[nodiscard]] Ball bounds(NodeId id) const;
  [[nodiscard]] double range_reference() const { return model_.range_reference(); }
  [[nodiscard]] std::uint64_t n_base_cells() const;
  std::uint64_t apply(NodeId id) const { return n_simplices(id); }
  std::uint64_t undo(NodeId id) const { return n_simplices(id); }

  /// Field error and range of any node; those of level 0 and tiers above 0 are found from the
  /// samples. No bounds.
  [[nodiscard]] NodeFacts facts_at(const Diamond<D>& node) const {
    return without_bounds(facts(id_of<D>(node.centre)), range_reference());
  }
  /// All children in the data, whoever discovers them.
  void add_all_children(NodeId id, std::vector<NodeId>& out) const;

  /// The simplices of a cut that meet the data, in depth-first order. They may reach across its
  /// end: demands know nothing of the lattice.
  [[nodiscard]] std::vector<Simplex<D>> leaves(const Cut& cut) const;

 private:
  struct Finest {
    double error = 0;
    Range range;
  };

  [[nodiscard]] bool exists(const Index<D>& centre) const;
  [[nodiscard]] std::uint64_t n_simplices(NodeId id) const;
  void join_finest(const Diamond<D>& node, Finest& facts) const;
  void add_finest(const Diamond<D>& node, StoredFacts& facts) const;
  void find_radii();

  const Model<D>& model_;
  const WorldErrors* world_errors_;
  std::array<std::array<double, power(2, D)>, 21> radii_{};  ///< By level and odd axes.
  Mat3 to_world_;
};

extern template class Refinable<2>;
extern template class Refinable<3>;
static_assert(RefinableModel<Refinable<2>> && RefinableModel<Refinable<3>>);

}  // namespace lode::diamond

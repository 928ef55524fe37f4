#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lode/delaunay/lattice_mesh.h"
#include "lode/models/terrain/insertions/node_columns.h"
#include "lode/models/terrain/insertions/overlap.h"

namespace lode::insertions {

/// The triangle of a mesh that holds p, on a straight way from another; nothing where the outline
/// stops it, or it takes more than so many steps.
template <typename Mesh>
[[nodiscard]] std::optional<std::uint32_t> walk_to(const Mesh& mesh, std::uint32_t slot,
                                                   delaunay::LatticePoint p, int max_steps) {
  for (int step = 0; step < max_steps; ++step) {
    const auto& corner = mesh.triangles()[slot].corner;
    std::uint32_t out = 0;
    for (; out < 3; ++out)
      if (delaunay::doubled_area(mesh.nodes().unpack(corner[out]),
                                 mesh.nodes().unpack(corner[(out + 1) % 3]), p) < 0)
        break;
    if (out == 3) return slot;
    const std::uint32_t twin = mesh.behind(slot, out);
    if (twin == delaunay::kNoHalfEdge) return {};
    slot = twin / 4;
  }
  return {};
}

/// Which triangle of a mesh each node is in that is to be inserted into it; of several one.
class WaitingNodes {
 public:
  /// The columns outlive it.
  explicit WaitingNodes(const NodeColumns& columns)
      : columns_(columns), slot_with_(columns.n_nodes()), next_(columns.n_nodes()) {}

  /// Where those of a band are before any of it is inserted: on a way of short steps, and some long
  /// ones from page to page. look(p): the slot where walking does not get there in so many, if
  /// there is one. Returns a node that is nowhere, kNone if there is none.
  template <typename Mesh, typename Look>
  [[nodiscard]] std::uint32_t locate(const Mesh& mesh, const Band& band, std::uint32_t time,
                                     int max_steps, const Look& look) {
    first_in_.assign(mesh.triangles().size(), kNone);
    std::uint32_t slot = 0;
    for (std::uint32_t node = band.begin; node < band.end; ++node) {
      if (columns_.times[node] >= time) continue;
      const delaunay::LatticePoint p = columns_.point_of(node);
      std::optional<std::uint32_t> met = walk_to(mesh, slot, p, max_steps);
      if (!met) met = look(p);
      if (!met) return node;
      put(node, slot = *met);
    }
    return kNone;
  }

  /// The slot where removing for a node begins: it holds the vertex, which is no corner; of two
  /// triangles that it lies between the one that was made earlier or later, as the node says.
  /// order(slot): rises with when what is there was made. Nothing where the file lies.
  template <typename Mesh, typename Order>
  [[nodiscard]] std::optional<std::uint32_t> find_seed(const Mesh& mesh, std::uint32_t node,
                                                       const Order& order) const {
    const delaunay::LatticePoint p = columns_.point_of(node);
    const std::uint32_t slot = slot_with_[node];
    const auto& [a, b, c] = mesh.triangles()[slot].corner;
    const LatticeCorners corners{mesh.nodes().unpack(a), mesh.nodes().unpack(b),
                                 mesh.nodes().unpack(c)};
    if (!holds(corners, p) || std::ranges::find(corners, p) != corners.end()) return {};
    for (std::uint32_t i = 0; i < 3; ++i) {
      if (delaunay::doubled_area(corners[i], corners[(i + 1) % 3], p) != 0) continue;
      const std::uint32_t behind = mesh.behind(slot, i);
      if (behind == delaunay::kNoHalfEdge) continue;
      const bool is_later = order(behind / 4) > order(slot);
      return is_later == (columns_.begins_later[node] != 0) ? behind / 4 : slot;
    }
    return slot;
  }

  /// Those that wait in what a node has removed go on to the triangles that were made where they
  /// are.
  template <typename Mesh>
  void hand_on(const Mesh& mesh, std::uint32_t inserted, std::span<const std::uint32_t> slots,
               std::size_t n_removed) {
    first_in_.resize(mesh.triangles().size(), kNone);
    handed_on_.clear();
    for (const std::uint32_t slot : slots.first(n_removed))
      for (std::uint32_t node = std::exchange(first_in_[slot], kNone); node != kNone;
           node = next_[node])
        if (node != inserted) handed_on_.push_back(node);
    for (const std::uint32_t node : handed_on_) {
      const delaunay::LatticePoint p = columns_.point_of(node);
      const auto with = std::ranges::find_if(slots, [&](std::uint32_t slot) {
        const auto& [a, b, c] = mesh.triangles()[slot].corner;
        return holds({mesh.nodes().unpack(a), mesh.nodes().unpack(b), mesh.nodes().unpack(c)}, p);
      });
      if (with != slots.end()) put(node, *with);
    }
  }

 private:
  void put(std::uint32_t node, std::uint32_t slot) {
    slot_with_[node] = slot;
    next_[node] = std::exchange(first_in_[slot], node);
  }

  const NodeColumns& columns_;
  std::vector<std::uint32_t> slot_with_;  ///< By node.
  std::vector<std::uint32_t> first_in_;   ///< By slot, a node that it holds, or kNone,
  std::vector<std::uint32_t> next_;       ///< and by node the next one.
  std::vector<std::uint32_t> handed_on_;
};

}  // namespace lode::insertions

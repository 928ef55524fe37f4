#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/models/tetra_mt/closed_mesh.h"
#include "lode/models/tetra_mt/slot_lists.h"

namespace lode::tetra_mt {

/// A piece of a closed mesh whose edges collapse: tetrahedra by slot, and those round each of its
/// own vertices. Vertices beside these have numbers after them, and the one outside, which is there
/// always, the last one.
class LiveTetrahedra {
 public:
  /// `tetrahedra`: all that have an own vertex.
  LiveTetrahedra(std::uint32_t n_own, std::uint32_t outside, std::vector<Tetrahedron> tetrahedra);

  [[nodiscard]] std::uint32_t n_own() const { return n_own_; }
  [[nodiscard]] std::uint32_t outside() const { return outside_; }
  [[nodiscard]] std::uint32_t n_slots() const {
    return static_cast<std::uint32_t>(tetrahedra_.size());
  }
  [[nodiscard]] const Tetrahedron& corners(std::uint32_t slot) const { return tetrahedra_[slot]; }
  [[nodiscard]] bool is_gone(std::uint32_t slot) const { return tetrahedra_[slot][0] == kNone; }
  /// Slots round an own vertex.
  [[nodiscard]] std::span<const std::uint32_t> star(std::uint32_t vertex) const {
    return stars_.of(vertex);
  }

  /// Tetrahedra with both ends of an edge go; in the others round `removed` it becomes `kept`. All
  /// vertices beside it are own ones, but the one outside. Returns how many cells went.
  std::uint32_t collapse(std::uint32_t removed, std::uint32_t kept);
  /// Slots round an own vertex ascend then, as they do before any collapse.
  void sort_star(std::uint32_t vertex) { stars_.sort(vertex); }

 private:
  std::uint32_t n_own_;
  std::uint32_t outside_;
  std::vector<Tetrahedron> tetrahedra_;
  SlotLists stars_;
};

}  // namespace lode::tetra_mt

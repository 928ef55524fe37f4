#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "lode/core/box.h"
#include "lode/models/tetra_mt/hierarchy.h"

namespace lode::tetra_mt {

/// Finds, from the stars of collapses, which tetrahedra each node brings, and whose they are.
class BroughtTetrahedra {
 public:
  /// `numbers`: of the mesh's vertices in the hierarchy. `nodes`: by collapse. `result` has its
  /// vertices.
  BroughtTetrahedra(const TetraMesh& mesh, const HalfEdgeCollapses& collapses,
                    std::span<const std::uint32_t> numbers, std::span<const std::uint32_t> nodes,
                    Hierarchy& result, Threads threads);

  /// Fills the hierarchy's targets, children, makers, regions and base. Fails where a node would
  /// bring two tetrahedra of the same corners.
  [[nodiscard]] Result<void> run();
  /// By node: of its tetrahedra.
  [[nodiscard]] std::vector<Box3d> take_boxes() { return std::move(boxes_); }

 private:
  struct Brought {
    bool has_target;
    FaceKey key;
    std::uint32_t place;  ///< Of its triangle in the star.
  };
  /// One collapse's part of CollapseStars.
  struct Part {
    std::uint32_t node;
    std::uint32_t target;
    std::span<const std::uint32_t> link;
    std::span<const std::array<std::uint8_t, 3>> triangles;
    std::span<const std::uint32_t> children;
    std::span<const std::uint8_t> makers;
    std::span<const std::uint32_t> labels;
  };

  template <typename Visit>
  void visit_parts(const Visit& visit);
  [[nodiscard]] std::uint32_t number(std::uint32_t vertex) const {
    return vertex < numbers_.size() ? numbers_[vertex] : result_.outside();
  }
  [[nodiscard]] bool has_regions_of_its_own(const Part& part) const;
  void count(const Part& part);
  void fill(const Part& part, std::vector<Brought>& brought);
  void fill_box(const Part& part);
  void fill_region_mask(const Part& part);
  void take_base();

  const TetraMesh& mesh_;
  const HalfEdgeCollapses& collapses_;
  std::span<const std::uint32_t> numbers_;
  std::span<const std::uint32_t> nodes_;
  Hierarchy& result_;
  Threads threads_;
  std::vector<std::uint32_t> first_collapses_;  ///< By piece of the stars.
  std::vector<Box3d> boxes_;
  std::vector<std::uint8_t> is_twice_;  ///< By node: two have the same corners.
};

}  // namespace lode::tetra_mt

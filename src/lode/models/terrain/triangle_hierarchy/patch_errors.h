#pragma once

#include <cstdint>
#include <vector>

#include "lode/models/terrain/triangle_hierarchy/hierarchy.h"
#include "lode/models/terrain/triangle_hierarchy/patch.h"

namespace lode::triangle_hierarchy {

/// By how much a patch errs that stands for a triangle between smaller ones: its places go round
/// the triangle, through the vertices of chains on its edges.
class PatchErrors {
 public:
  PatchErrors() = default;
  PatchErrors(const PatchErrors&) = delete;
  PatchErrors& operator=(const PatchErrors&) = delete;
  virtual ~PatchErrors() = default;

  /// Bounds of the errors at samples in each of the patch's triangles, rounding included; empty:
  /// none are known.
  [[nodiscard]] virtual std::vector<double> of(std::uint32_t triangle,
                                               const Patch& patch) const = 0;
};

/// At all samples in a triangle, and at crossings of edges that are none of the triangle's chains:
/// a sliver between vertices of a chain has no samples, and may be a wall.
class MeasuredPatches final : public PatchErrors {
 public:
  /// Of the raster or points that the hierarchy was built of; must outlive this.
  explicit MeasuredPatches(const ReferenceSurface& surface) : surface_(surface) {}

  [[nodiscard]] std::vector<double> of(std::uint32_t triangle, const Patch& patch) const override;

 private:
  const ReferenceSurface& surface_;
};

/// Without the raster or points, from what the triangle says of itself: a sample in it errs by no
/// more than that, and the patch is nowhere farther from its plane than at the corners of the
/// patch's triangle. Twice what is measured, or so. Chains that were moved onto the lattice may
/// reach out of the triangle; where a node of the raster lies between them and the edge, or of
/// points one may (Hierarchy::crowded), nothing is known.
class BoundedPatches final : public PatchErrors {
 public:
  /// The hierarchy must outlive this. O(vertices).
  explicit BoundedPatches(const Hierarchy& hierarchy);

  [[nodiscard]] std::vector<double> of(std::uint32_t triangle, const Patch& patch) const override;

 private:
  [[nodiscard]] bool has_node_outside(std::uint32_t triangle, const Patch& patch) const;

  const Hierarchy& hierarchy_;
  double rounding_;  ///< Of a height on a plane, by unit of its weights: 2^-48 of the largest.
};

}  // namespace lode::triangle_hierarchy

#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/surface.h"
#include "lode/mappers/collapse_mesh.h"

namespace lode::simplification {

/// The closed components of a surface, and which side of each it encloses. Collapses could turn one
/// inside out that is no wider than rounding, such as round a sample that just is the isovalue.
class ClosedComponents {
 public:
  /// Of an oriented manifold. O(n), near enough.
  explicit ClosedComponents(const Surface& surface);

  /// The vertices, in their order, that collapses have removed in components that enclose their
  /// other side now. `live`: the triangles that there are.
  [[nodiscard]] std::vector<std::uint32_t> removed_where_turned(
      const CollapseMesh& mesh, std::span<const std::uint32_t> live) const;

 private:
  std::vector<std::uint32_t> component_;  ///< By vertex.
  std::vector<double> volumes_;           ///< By component; 0 where it is not closed.
};

}  // namespace lode::simplification

#pragma once

#include <cstdint>
#include <memory>

#include "bench/peers/flying_edges.h"
#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"

namespace lode::bench {

/// Whether each crossed edge has one vertex, or as VTK's filter has it unless it is told otherwise,
/// each corner of a triangle.
enum class PeerVertices : std::uint8_t { shared, apart };

/// vtkContour3DLinearGrid, VTK's threaded marching tetrahedra, on a mesh and its first field copied
/// into VTK's memory beforehand: positions of float32, two threads. Each call of extract() does
/// all the work again, into fresh output.
class LinearContour {
 public:
  explicit LinearContour(const TetraMesh& mesh);
  LinearContour(LinearContour&&) noexcept;
  ~LinearContour();

  /// Fails where the filter ran but left no output.
  [[nodiscard]] Result<PeerCounts> extract(double isovalue, PeerVertices vertices,
                                           PeerNormals normals);

 private:
  class Pipeline;
  std::unique_ptr<Pipeline> pipeline_;
};

}  // namespace lode::bench

#pragma once

#include <cstdint>
#include <memory>

#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"

namespace lode::bench {

/// vtkUnstructuredGridQuadricDecimation, as it comes, on a mesh of tetrahedra and its first field,
/// copied into VTK's memory beforehand. It has one thread. Each call of decimate() does all the
/// work again.
class QuadricDecimation {
 public:
  explicit QuadricDecimation(const TetraMesh& mesh);
  QuadricDecimation(QuadricDecimation&&) noexcept;
  ~QuadricDecimation();

  /// Down to about `n_cells` tetrahedra: how many are left. Fails where none are.
  [[nodiscard]] Result<std::uint64_t> decimate(std::uint64_t n_cells);
  /// What the last call left, with its field.
  [[nodiscard]] TetraMesh mesh() const;

 private:
  class Pipeline;
  std::unique_ptr<Pipeline> pipeline_;
};

}  // namespace lode::bench

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/delaunay/lattice.h"
#include "lode/delaunay/lattice_mesh.h"

namespace lode::delaunay {

/// A triangulated irregular network over nodes of a lattice, whose heights are those of the samples
/// there.
struct Tin {
  std::vector<LatticePoint> vertices;                   ///< In rows.
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Turning left (x to the right, y up).
  /// Per triangle what is behind its edges, as LatticeTriangle::twin; may be empty.
  std::vector<std::array<std::uint32_t, 3>> twins;
  /// Per triangle: no sample in it errs by more; may be empty.
  std::vector<float> errors;
  std::vector<double> heights;  ///< Per vertex, exactly; may be empty.
};

/// Whether a TIN gets twins and errors, 16 bytes a triangle.
enum class TinLinks : std::uint8_t { left_out, kept };

/// The triangles of a mesh in the order of their slots, and their corners in the order of their
/// nodes, which is that of rows. Memory: a bit for each node up to the last corner, and what comes
/// out.
template <typename Nodes>
[[nodiscard]] Tin to_tin(const NodeMesh<Nodes>& mesh, TinLinks links = TinLinks::left_out);

}  // namespace lode::delaunay

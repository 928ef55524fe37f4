#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/models/tetra_mt/live_tetrahedra.h"

namespace lode::tetra_mt {

/// The tetrahedra round a vertex, by the triangles across from it; numbers are places in `link`.
struct Star {
  static constexpr int kMaxLink = 64;
  static constexpr int kMaxTriangles = 2 * kMaxLink - 4;  ///< A sphere's.

  std::uint32_t vertex = kNone;
  int n_link = 0;
  int n_triangles = 0;
  int outside = -1;  ///< The vertex outside, or -1 where the vertex is not on the boundary.
  std::array<std::uint32_t, kMaxLink> link;
  std::array<std::uint64_t, kMaxLink> adjacent;  ///< By link vertex: those it has link edges to.
  std::array<std::array<std::uint8_t, 3>, kMaxTriangles> triangles;
  std::array<std::uint32_t, kMaxTriangles> slots;

  [[nodiscard]] bool is_on_boundary() const { return outside >= 0; }
  [[nodiscard]] bool has(int triangle, int corner) const {
    const auto& t = triangles[static_cast<std::size_t>(triangle)];
    return t[0] == corner || t[1] == corner || t[2] == corner;
  }
};

/// Gathers stars. Holds a number for each vertex.
class StarGatherer {
 public:
  explicit StarGatherer(const LiveTetrahedra& mesh)
      : mesh_(mesh), places_(std::size_t{mesh.outside()} + 1, 0xFF) {}

  /// False where the link is too large: such vertices stay.
  [[nodiscard]] bool gather(std::uint32_t vertex, Star& star);
  /// Whether the link is a sphere. Collapses keep it so.
  [[nodiscard]] static bool is_manifold(const Star& star);
  /// Whether an edge may go, to link vertex `kept`: what both ends' links have in common is the
  /// edge's (Dey, Edelsbrunner, Guha, Nekhayev 1999), and together they have at most `max_link`
  /// vertices.
  [[nodiscard]] bool may_collapse(const Star& star, int kept, int max_link);

 private:
  const LiveTetrahedra& mesh_;
  std::vector<std::uint8_t> places_;  ///< By vertex: its place in the link, while one is looked at.
  std::vector<std::uint32_t> seen_;
};

}  // namespace lode::tetra_mt

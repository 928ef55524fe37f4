#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "lode/models/tetra_mt/patch_deviation.h"
#include "lode/models/tetra_mt/star.h"

namespace lode::tetra_mt {

/// The label of tetrahedra to the vertex outside; on faces of a patch less its place and 1. What is
/// between two such tetrahedra is a face, too: patches end in lines in which sheets meet.
inline constexpr std::uint32_t kOutsideLabel = kNone;
inline constexpr std::uint32_t kMaxPatches = 1U << 20;
[[nodiscard]] constexpr bool is_outside_label(std::uint32_t label) {
  return label >= kOutsideLabel - kMaxPatches;
}
/// 0 of no patch, else one more than its place; and back.
[[nodiscard]] constexpr std::uint32_t patch_mark(std::uint32_t outside_label) {
  return kOutsideLabel - outside_label;
}

/// The faces at a star's vertex that lie between tetrahedra of different labels, as a graph on its
/// link; numbers are places in the link. Where all are on the boundary, it is one cycle.
struct Interfaces {
  static constexpr int kMaxFaces = 3 * Star::kMaxLink - 6;  ///< Edges of a sphere's link.

  /// none: all round the vertex is one region. sheet: a disc that parts two. curve: discs that meet
  /// in a line through the vertex. corner: all else.
  enum class Kind : std::uint8_t { none, sheet, curve, corner };

  /// The link edge across from the vertex, and the triangles beside it; where only the boundary is
  /// looked for, twice the one to the vertex outside.
  struct Face {
    std::array<std::uint8_t, 2> edge;
    std::array<std::uint8_t, 2> triangles;
  };

  Kind kind = Kind::none;
  int n_faces = 0;
  std::array<Face, kMaxFaces> faces;
  std::array<std::uint64_t, Star::kMaxLink> beside;  ///< By link vertex: those it has faces with.
  std::uint64_t on = 0;      ///< Link vertices that have faces: the ends of edges on interfaces.
  std::uint64_t curves = 0;  ///< Those of other than two: the ends of edges in which sheets meet.

  [[nodiscard]] bool has(std::uint64_t set, int place) const { return (set >> place & 1) != 0; }
};

/// A walk along the graph from one link vertex, through one beside it, to the end of the disc: the
/// first one again (left out) of a sheet, the other end of the line of a curve.
struct InterfaceWalk {
  int n = 0;
  std::array<std::uint8_t, Star::kMaxLink> places;
};

/// Of the boundary alone: what a mesh of one region has. Expects the link to be a sphere.
void find_boundary(const Star& star, Interfaces& found);
/// `labels`: by triangle of the star. Any link, but the kind is told of a sphere's only. Faces with
/// the vertex outside are those that have it in their edge; no plane is theirs.
void find_interfaces(const Star& star, std::span<const std::uint32_t> labels, Interfaces& found);

[[nodiscard]] InterfaceWalk walk(const Interfaces& interfaces, int first, int second);

/// Of a vertex at the origin on the outline of a patch, how far it is from the line between the two
/// link vertices beside it on that, `kept` and another; 0 of any other vertex. `at(place)`: a link
/// vertex's position. Expects goes_along().
template <typename At>
[[nodiscard]] double outline_height(const Star& star, const Interfaces& interfaces, int kept,
                                    const At& at) {
  if (!star.is_on_boundary() ||
      !interfaces.has(interfaces.beside[static_cast<std::size_t>(kept)], star.outside))
    return 0;
  const std::uint64_t ends = interfaces.curves & ~(std::uint64_t{1} << kept);
  return distance_to_line(at(kept), at(std::countr_zero(ends)));
}

/// Whether interfaces let an edge collapse, but for where they lie: the vertex goes along its sheet
/// or curve.
[[nodiscard]] bool goes_along(const Interfaces& interfaces, int kept);

/// Whether sheets and curves stay what they are as an edge goes, that to link vertex `kept`, whose
/// own star is `other`. Expects goes_along() and the link condition of the mesh. What the ends'
/// links have in common must be the edge's link not only in the mesh, but also in the complex of
/// all faces between regions and in that of the curves in which these meet: the condition of Dey,
/// Edelsbrunner, Guha and Nekhayev (1999) for 3-complexes, of the mesh together with a cone over
/// these faces, in which they and these curves are what is no manifold.
[[nodiscard]] bool keeps_interfaces(const Star& star, const Interfaces& interfaces, int kept,
                                    const Star& other, const Interfaces& other_interfaces);

}  // namespace lode::tetra_mt

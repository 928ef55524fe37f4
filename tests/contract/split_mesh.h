#pragma once

// The triangle mesh that vertex splits and edge collapses change: Cignoni et al. 2004, section 5.1,
// kept as plainly as possible.

#include <array>
#include <compare>
#include <cstdint>
#include <limits>
#include <set>
#include <span>
#include <vector>

namespace lode::test {

/// A vertex of a hierarchy of splits, numbered as section 5.2 does: first the vertices of the
/// reference mesh, then those that collapses made, in order. So labels fall along every split.
using Label = std::uint32_t;
inline constexpr Label kNoLabel = std::numeric_limits<Label>::max();

/// Counter-clockwise.
struct Triangle {
  std::array<Label, 3> corners{};  ///< The lowest first: a triangle has one form.

  [[nodiscard]] static Triangle of(Label a, Label b, Label c);
  [[nodiscard]] bool has(Label v) const {
    return corners[0] == v || corners[1] == v || corners[2] == v;
  }
  friend auto operator<=>(const Triangle&, const Triangle&) = default;
};

/// Triangles by the vertices they meet at.
class SplitMesh {
 public:
  SplitMesh(std::size_t n_labels, std::span<const Triangle> triangles);

  [[nodiscard]] bool has_vertex(Label v) const { return !stars_[v].empty(); }
  /// The triangles around a vertex; none if it is not in the mesh.
  [[nodiscard]] const std::set<Triangle>& star(Label v) const { return stars_[v]; }
  /// The vertices joined to one by an edge, in ascending order.
  [[nodiscard]] std::vector<Label> neighbours(Label v) const;
  [[nodiscard]] std::vector<Triangle> triangles() const;

  /// All of `old` must be there, none of `replacement`.
  void replace(std::span<const Triangle> old, std::span<const Triangle> replacement);

 private:
  void add(const Triangle& triangle);
  void remove(const Triangle& triangle);

  std::vector<std::set<Triangle>> stars_;  ///< By label.
};

}  // namespace lode::test

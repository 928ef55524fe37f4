#pragma once

// A Multi-Tessellation of a triangulated rectangle, built by collapsing edges: Cignoni et al. 2004,
// sections 3 and 4.2, in two dimensions. Read backwards, a collapse is a vertex split, and the
// splits are the nodes.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/refine/model.h"
#include "tests/contract/split_mesh.h"

namespace lode::test {

struct SplitVertex {
  Vec3d position;
  double value = 0;
  std::uint8_t sides = 0;  ///< Of the rectangle, a bit each: those the vertex lies on.
};

/// A node: its vertex is replaced by two.
struct Split {
  std::array<Label, 2> children{};
  std::vector<Triangle> before;  ///< The star of the vertex,
  std::vector<Triangle> after;   ///< and the stars of its children, which fill the same polygon.
};

struct SplitHierarchy {
  std::vector<SplitVertex> vertices;  ///< By label.
  std::vector<Split> splits;          ///< Of the vertices from n_samples on.
  std::vector<Label> forest_parents;  ///< The vertex whose split makes one; kNoLabel for roots.
  std::size_t n_samples = 0;          ///< Vertices of the reference mesh.
  std::vector<Triangle> reference;    ///< The mesh when everything is split,
  std::vector<Triangle> base;         ///< and when nothing is.
  std::vector<StoredFacts> facts;     ///< By split, nested along the forest.
  std::vector<Bounds> bounds;         ///< The same.

  [[nodiscard]] bool is_node(Label v) const { return v >= n_samples; }
  [[nodiscard]] std::size_t place(Label v) const { return v - n_samples; }
  [[nodiscard]] const Split& split(Label v) const { return splits[place(v)]; }
  [[nodiscard]] Label label(std::size_t place_of_split) const {
    return static_cast<Label>(n_samples + place_of_split);
  }
  [[nodiscard]] double signed_area(const Triangle& triangle) const;
};

/// Jittered samples, a smooth field with noise, and all collapses that keep every mesh valid.
[[nodiscard]] SplitHierarchy build_split_hierarchy(std::uint32_t seed);

/// Fills in facts and bounds.
void find_split_facts(SplitHierarchy& hierarchy);

}  // namespace lode::test

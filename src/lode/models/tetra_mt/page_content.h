#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/vec.h"
#include "lode/models/tetra_mt/box_codes.h"
#include "lode/models/tetra_mt/fact_codes.h"
#include "lode/models/tetra_mt/star.h"

namespace lode::tetra_mt {

/// Nodes are kept, and read from files, by pages of so many; the last one may have fewer. Vertices
/// of the base are counted in pages too, after those of the nodes.
inline constexpr std::uint32_t kPageNodes = 512;
inline constexpr int kPageBits = 9;

[[nodiscard]] constexpr std::uint32_t n_pages_of(std::uint32_t n) {
  return n / kPageNodes + (n % kPageNodes != 0 ? 1 : 0);
}

/// The most tetrahedra that a node brings, and the most children and parents.
inline constexpr std::uint32_t kMaxBrought = Star::kMaxTriangles;

/// Lists one after the other.
template <typename T>
struct Lists {
  std::vector<std::uint32_t> begins{0};
  std::vector<T> items;

  void end_list() { begins.push_back(static_cast<std::uint32_t>(items.size())); }
  [[nodiscard]] std::span<const T> operator[](std::size_t i) const {
    return std::span(items).subspan(begins[i], begins[i + 1] - begins[i]);
  }
  friend bool operator==(const Lists&, const Lists&) = default;
};

/// What a page has for all fields, spread out; by node, from the page's first on.
struct PageContent {
  std::vector<Vec3d> positions;
  std::vector<std::uint32_t> boxes;        ///< BoxCodes round all it discovers.
  std::vector<std::uint32_t> targets;      ///< Vertices.
  std::vector<std::uint8_t> n_discovered;  ///< How many of the children it discovers: the first.
  Lists<std::uint32_t> children;  ///< Nodes: those discovered, then the others; both ascending.
  Lists<std::uint32_t> parents;   ///< Nodes, ascending.
  /// By tetrahedron that a node brings: the place of its maker among the children, or how many
  /// there are where it is of the reference mesh. None where there are no children.
  Lists<std::uint8_t> makers;

  /// By tetrahedron that a node brings with an edge, or none where all are of the region of those
  /// it replaces: PageShape::n_labels.
  Lists<std::uint32_t> regions;

  /// By node: Hierarchy's. None where there is one region at most.
  std::vector<std::uint64_t> region_masks;

  [[nodiscard]] std::size_t n_nodes() const { return targets.size(); }
  friend bool operator==(const PageContent&, const PageContent&) = default;
};

/// What it has for one field.
struct FieldContent {
  std::vector<double> values;
  std::vector<FactCodes> facts;

  friend bool operator==(const FieldContent&, const FieldContent&) = default;
};

}  // namespace lode::tetra_mt

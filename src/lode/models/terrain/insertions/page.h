#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/result.h"
#include "lode/delaunay/lattice.h"
#include "lode/models/terrain/insertions/file_layout.h"

namespace lode::insertions {

/// Nodes of consecutive times; a band's pages have all of them.
struct Band {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
  std::uint32_t first_page = 0;
  std::uint32_t n_pages = 0;
};

/// What the index says of a page.
struct PageEntry {
  delaunay::LatticePoint lower;  ///< Of the rectangle round its nodes.
  delaunay::LatticePoint upper;
  std::uint32_t n_nodes = 0;
  std::uint32_t n_triangles = 0;  ///< That these make.
};

/// Nodes of a band that are near each other, in the order of their times.
struct PageNodes {
  std::vector<std::uint32_t> times;
  std::vector<delaunay::LatticePoint> points;
  std::vector<double> heights;
  std::vector<std::uint32_t> first_made;  ///< By node, and one more: of the page's triangles.
  /// Of two triangles that the vertex lies in, on their edge, the one that was made later is where
  /// removing begins.
  std::vector<bool> begins_later;
};

/// More is refused, so that a page takes little memory whatever a file says.
inline constexpr std::uint32_t kMostPageNodes = 1U << 16;
inline constexpr std::uint32_t kMostPageTriangles = 1U << 22;

/// What a page is coded and decoded with.
struct PageContext {
  PageEntry entry;
  Band band;
  HeightType type = HeightType::float64;
  HeightRange range;
};

/// As docs/format.md says.
[[nodiscard]] std::vector<std::byte> encode_nodes(const PageNodes& nodes,
                                                  const PageContext& context);

/// Fails on all that the context does not allow, without naming the file.
[[nodiscard]] Result<PageNodes> decode_nodes(std::span<const std::byte> bytes,
                                             const PageContext& context);

}  // namespace lode::insertions

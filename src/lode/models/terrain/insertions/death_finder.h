#pragma once

#include <compare>
#include <cstdint>

#include "lode/core/result.h"
#include "lode/models/terrain/insertions/fixed_edges.h"
#include "lode/models/terrain/insertions/open_pages.h"

namespace lode::insertions {

/// A node of a file, and where it is.
struct FileNode {
  std::uint32_t time = kNone;  ///< kNone: none.
  std::uint32_t page = 0;
  std::uint32_t at = 0;  ///< In the page.

  /// By time, and whatever a file says no two are alike.
  friend constexpr auto operator<=>(const FileNode&, const FileNode&) = default;
};

/// Finds which node removes a triangle: the first one after the triangle was made whose vertex lies
/// in its circle, and is not hidden by a fixed edge; of triangles that are split, in the triangle.
/// So no file has to say it.
class DeathFinder {
 public:
  /// The pages must outlive it.
  explicit DeathFinder(OpenPages& pages) : pages_(pages), edges_(pages.file().base()) {}

  /// Of the nodes from a time to before another, where none before that removes the triangle and
  /// it is made by then. Reads the pages that reach into the circle, band by band until there is
  /// one.
  [[nodiscard]] Result<FileNode> find(const delaunay::LatticeCorners& triangle, std::uint32_t begin,
                                      std::uint32_t end);

 private:
  OpenPages& pages_;
  FixedEdges edges_;
};

}  // namespace lode::insertions

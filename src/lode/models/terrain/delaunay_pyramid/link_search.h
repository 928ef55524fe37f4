#pragma once

#include <cstddef>
#include <span>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/predicates.h"
#include "lode/delaunay/tin.h"
#include "lode/models/terrain/delaunay_pyramid/pyramid_file.h"
#include "lode/models/terrain/insertions/box_tree.h"

namespace lode::delaunay_pyramid {

/// What searches begin with: the triangles of level 0, which is read whole.
class LinkStart {
 public:
  [[nodiscard]] static Result<LinkStart> read(const PyramidFile& file, Progress& progress);

  /// Numbered as they are kept.
  [[nodiscard]] const insertions::BoxTree& boxes() const { return boxes_; }
  /// Of all triangles, at whatever level.
  [[nodiscard]] const insertions::LatticeBox& box() const { return box_; }

 private:
  insertions::BoxTree boxes_;
  insertions::LatticeBox box_;
};

/// Of a level's mesh in a file with links, the triangles that hold some places (columns and rows),
/// with their edges, in the order of the whole mesh's, with heights, twins among each other and
/// errors. From the triangles of level 0 that do, down the links (L. De Floriani, 1989); of other
/// levels only the blocks are read that have what is met. Fails when cancelled, and, naming the
/// file, where what is met is not as docs/format.md says, or overlaps.
[[nodiscard]] Result<delaunay::Tin> tin_around(const PyramidFile& file, const LinkStart& start,
                                               std::size_t level,
                                               std::span<const delaunay::Point> places,
                                               Progress& progress);

/// The same of those that a segment meets, and perhaps of some beside it.
[[nodiscard]] Result<delaunay::Tin> tin_along(const PyramidFile& file, const LinkStart& start,
                                              std::size_t level, const delaunay::Point& a,
                                              const delaunay::Point& b, Progress& progress);

}  // namespace lode::delaunay_pyramid

#pragma once

#include <optional>
#include <vector>

#include "lode/delaunay/predicates.h"
#include "lode/models/terrain/triangle_hierarchy/hierarchy.h"

namespace lode::triangle_hierarchy {

/// Finds triangles of any level by descent, without the level's mesh. The hierarchy must outlive
/// it.
class Locator {
 public:
  /// Sorts the triangles of level 0 into a grid of buckets: about 4 bytes for each bucket that one
  /// meets.
  explicit Locator(const Hierarchy& hierarchy);

  /// A triangle of the level's mesh that holds the place, which is in columns and rows, exactly;
  /// nothing where there is none. O(triangles of the bucket, and of the refinements passed).
  [[nodiscard]] std::optional<std::uint32_t> find(int level, delaunay::Point place) const;

  [[nodiscard]] std::uint64_t n_bytes() const {
    return (first_.size() + entries_.size()) * sizeof(std::uint32_t);
  }

 private:
  [[nodiscard]] bool holds(std::uint32_t triangle, const delaunay::Point& fine) const;
  /// About how far a place is out of a triangle; 0 inside.
  [[nodiscard]] double distance_out(std::uint32_t triangle, const delaunay::Point& fine) const;
  [[nodiscard]] std::optional<std::uint32_t> find_nearby(int level, std::uint32_t start,
                                                         const delaunay::Point& fine) const;
  [[nodiscard]] std::int32_t column(double x) const;
  [[nodiscard]] std::int32_t row(double y) const;
  template <typename Visit>
  void visit_buckets(std::uint32_t triangle, const Visit& visit) const;

  const Hierarchy* hierarchy_;
  std::int32_t n_columns_ = 1;  ///< Of buckets.
  std::int32_t n_rows_ = 1;
  double bucket_side_ = 1;  ///< In nodes.
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> entries_;
};

/// A rectangle of samples' columns and rows, with its border.
struct Window {
  LatticePoint lower;
  LatticePoint upper;
};

/// The triangles of a level's mesh that meet a window, by descent, ascending. O(what of each level
/// meets the window, with the triangles of the refinements passed, and level 0).
[[nodiscard]] std::vector<std::uint32_t> find_in_window(const Hierarchy& hierarchy, int level,
                                                        const Window& window);

}  // namespace lode::triangle_hierarchy

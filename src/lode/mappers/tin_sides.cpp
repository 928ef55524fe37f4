#include "lode/mappers/tin_sides.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace lode {
namespace {

/// What a TIN has on a column.
class Side {
 public:
  Side(const delaunay::Tin& tin, std::int32_t column) {
    for (const auto& triangle : tin.triangles)
      for (std::size_t i = 0; i < 3; ++i) {
        const LatticePoint a = tin.vertices[triangle[i]];
        const LatticePoint b = tin.vertices[triangle[(i + 1) % 3]];
        if (a.x == column) rows_.push_back(a.y);
        if (a.x == column && b.x == column)
          edges_.push_back({std::min(a.y, b.y), std::max(a.y, b.y)});
      }
    std::ranges::sort(rows_);
    rows_.erase(std::unique(rows_.begin(), rows_.end()), rows_.end());
    std::ranges::sort(edges_);
  }

  /// Vertices that lie in the middle of edges of another side. Edges of a side do not overlap.
  [[nodiscard]] std::uint64_t n_hanging_in(const Side& other) const {
    std::uint64_t n = 0;
    for (const std::int32_t row : rows_) {
      // The first that does not begin below.
      const auto behind = std::ranges::lower_bound(
          other.edges_, row, {}, [](const std::array<std::int32_t, 2>& edge) { return edge[0]; });
      if (behind == other.edges_.begin()) continue;
      if ((*(behind - 1))[1] > row) ++n;
    }
    return n;
  }

 private:
  std::vector<std::int32_t> rows_;
  std::vector<std::array<std::int32_t, 2>> edges_;  ///< From row to row.
};

}  // namespace

std::uint64_t count_one_sided(const delaunay::Tin& tin, std::int32_t first_column,
                              std::int32_t last_column) {
  const Side first(tin, first_column);
  const Side last(tin, last_column);
  return first.n_hanging_in(last) + last.n_hanging_in(first);
}

}  // namespace lode

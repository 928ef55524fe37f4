#include "lode/models/terrain/triangle_hierarchy/triangle_samples.h"

#include <algorithm>
#include <cmath>

#include "lode/delaunay/triangle_rows.h"

namespace lode::triangle_hierarchy {

SampleErrors measure_samples(const FineGrid& grid, const std::array<Place, 3>& corners,
                             EdgeSet open) {
  const LatticePoint a = corners[0].at;
  const LatticePoint b = corners[1].at;
  const LatticePoint c = corners[2].at;
  const std::int64_t area = delaunay::doubled_area(a, b, c);
  const double inverse = 1 / static_cast<double>(area);
  const double to_b = corners[1].height - corners[0].height;
  const double to_c = corners[2].height - corners[0].height;
  const int bits = grid.bits();
  const std::int64_t first_step = std::int64_t{a.y - b.y} << bits;
  const std::int64_t last_step = std::int64_t{c.y - a.y} << bits;
  SampleErrors made;
  for (delaunay::SparseRows rows(a, b, c, bits); rows.has_row(); rows.next()) {
    if (rows.first() > rows.last()) continue;
    const LatticePoint start = grid.fine({rows.first(), rows.y()});
    std::int64_t first = delaunay::doubled_area(a, b, start);
    std::int64_t last = delaunay::doubled_area(c, a, start);
    for (std::int32_t x = rows.first(); x <= rows.last();
         ++x, first += first_step, last += last_step) {
      const double rise =
          (static_cast<double>(last) * to_b + static_cast<double>(first) * to_c) * inverse;
      const double error = std::abs(grid.sample(x, rows.y()) - (corners[0].height + rise));
      if (error <= made.inner) continue;
      made.closed = std::max(made.closed, error);
      if (!SampleWeights{{first, area - first - last, last}}.may_be_inserted(open)) continue;
      made.inner = error;
      made.at = grid.fine({x, rows.y()});
    }
  }
  return made;
}

std::size_t count_samples(const FineGrid& grid, const std::array<LatticePoint, 3>& corners) {
  std::size_t n = 0;
  for (delaunay::SparseRows rows(corners[0], corners[1], corners[2], grid.bits()); rows.has_row();
       rows.next())
    n += static_cast<std::size_t>(std::max(0, rows.last() - rows.first() + 1));
  return n;
}

}  // namespace lode::triangle_hierarchy

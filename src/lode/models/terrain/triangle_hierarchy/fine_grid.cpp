#include "lode/models/terrain/triangle_hierarchy/fine_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "lode/delaunay/grid_domain.h"
#include "lode/models/terrain/triangle_hierarchy/edge_profile.h"
#include "lode/models/terrain/triangle_hierarchy/triangle_samples.h"

namespace lode::triangle_hierarchy {
namespace {

/// The coarsest of those measured (decision 0044) onto which crossings may move without ever
/// folding a chain of the Delaunay hierarchy; finer ones keep thinner slivers of the adaptive one.
constexpr int kMostBits = 8;
constexpr int kCoordinateBits = 30;

int fine_bits(const HeightGrid& grid) {
  const auto last = static_cast<std::uint32_t>(std::max(grid.n_columns, grid.n_rows) - 1);
  return std::min(kMostBits, kCoordinateBits - static_cast<int>(std::bit_width(last)));
}

}  // namespace

Result<FineGrid> FineGrid::make(const HeightGrid& grid) {
  const HeightRange range = height_range(grid);
  LODE_CHECK(delaunay::check_heights(range));
  LODE_TRY(const delaunay::GridDomain domain, delaunay::find_domain(grid));
  FineGrid made;
  made.set_frame(grid, fine_bits(grid));
  made.set_range(range);
  made.samples_.reserve(static_cast<std::size_t>(grid.n_samples()));
  for (std::int32_t y = 0; y < grid.n_rows; ++y)
    for (std::int32_t x = 0; x < grid.n_columns; ++x)
      made.samples_.push_back(grid.has_height(x, y) ? grid.height(x, y) : 0);
  const delaunay::LatticePacking packing(grid.n_columns);
  std::vector<std::array<LatticePoint, 3>> base;
  base.reserve(domain.triangles.size());
  for (const auto& triangle : domain.triangles)
    base.push_back({made.fine(packing.unpack(triangle[0])), made.fine(packing.unpack(triangle[1])),
                    made.fine(packing.unpack(triangle[2]))});
  made.set_base(std::move(base));
  return made;
}

double FineGrid::height(LatticePoint fine) const {
  const std::int32_t mask = scale() - 1;
  const std::int32_t column = fine.x >> bits();
  const std::int32_t row = fine.y >> bits();
  const double first = sample(column, row);
  const std::int32_t along_row = fine.x & mask;
  const std::int32_t along_column = fine.y & mask;
  if (along_row == 0 && along_column == 0) return first;
  const double next = along_row == 0 ? sample(column, row + 1) : sample(column + 1, row);
  return first + (next - first) * std::ldexp(along_row + along_column, -bits());
}

EdgeSplit FineGrid::worst_crossing(Place a, Place b, Crossings crossings) const {
  return triangle_hierarchy::worst_crossing(*this, a, b, crossings);
}

SampleErrors FineGrid::measure_samples(const std::array<Place, 3>& corners, EdgeSet open) const {
  return triangle_hierarchy::measure_samples(*this, corners, open);
}

std::size_t FineGrid::count_samples(const std::array<LatticePoint, 3>& corners) const {
  return triangle_hierarchy::count_samples(*this, corners);
}

void ReferenceSurface::set_range(const HeightRange& range) {
  slack_ = 0x1p-50 * std::max(std::abs(range.lower), std::abs(range.upper));
}

}  // namespace lode::triangle_hierarchy

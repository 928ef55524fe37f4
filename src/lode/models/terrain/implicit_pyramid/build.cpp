// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), section 8: the implicit Delaunay pyramid.
#include "lode/models/terrain/implicit_pyramid/build.h"

#include <algorithm>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "lode/delaunay/full_tin.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/delaunay/ordered_insertion.h"
#include "lode/models/terrain/implicit_pyramid/thinning.h"
#include "lode/models/terrain/insertions/history_writer.h"

namespace lode::implicit_pyramid {
namespace {

using delaunay::LatticePacking;
using delaunay::OrderedNode;
using insertions::History;

/// The samples that are taken away, as they are to be inserted again; `ends` gets where levels end.
Result<std::vector<OrderedNode>> order_samples(const HeightGrid& grid,
                                               const delaunay::GridDomain& domain,
                                               const LatticePacking& packing,
                                               std::vector<std::uint32_t>& ends,
                                               Progress& progress) {
  LODE_TRY(delaunay::FullTin full, delaunay::to_full_tin(grid));
  std::vector<std::uint32_t> packed;
  packed.reserve(full.tin.vertices.size());
  for (const delaunay::LatticePoint& p : full.tin.vertices) packed.push_back(packing.pack(p));
  // Vertices are in rows, as packed nodes are.
  std::vector<bool> must_stay(packed.size());
  for (const auto& corners : domain.triangles)
    for (const std::uint32_t corner : corners)
      must_stay[static_cast<std::size_t>(std::ranges::lower_bound(packed, corner) -
                                         packed.begin())] = true;
  LODE_TRY(const Thinning thinning, thin(std::move(full.tin), must_stay, progress));
  std::vector<OrderedNode> order;
  for (auto level = thinning.rbegin(); level != thinning.rend(); ++level) {
    for (const RemovedVertex& removed : *level)
      order.push_back({packed[removed.vertex], packed[removed.neighbour]});
    ends.push_back(static_cast<std::uint32_t>(order.size()));
  }
  return order;
}

}  // namespace

Result<History> build(const HeightGrid& grid, Progress& progress) {
  LODE_TRY(const delaunay::GridDomain domain, delaunay::find_domain(grid));
  LODE_TRY(History history,
           insertions::begin_history(grid, domain, insertions::Model::implicit_delaunay_pyramid));
  const LatticePacking packing(grid.n_columns);
  LODE_TRY(const std::vector<OrderedNode> order,
           order_samples(grid, domain, packing, history.level_ends, progress));
  delaunay::LatticeMesh mesh(packing, domain.triangles);
  insertions::HistoryWriter<LatticePacking> writer(history);
  const auto insert = [&](const auto& samples) {
    using T = typename std::decay_t<decltype(samples)>::value_type;
    const delaunay::SampleRows<T> rows{samples.data(), grid.stride, packing};
    return delaunay::insert_in_order(mesh, rows, history.range, order, writer, progress);
  };
  LODE_CHECK(std::visit(insert, grid.heights));
  writer.finish([&](std::uint32_t node) {
    const delaunay::LatticePoint p = packing.unpack(node);
    return grid.height(p.x, p.y);
  });
  // Every sample is a vertex.
  history.max_error = 0;
  return history;
}

}  // namespace lode::implicit_pyramid

// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), section 8: the implicit Delaunay pyramid.
#include "lode/models/terrain/implicit_pyramid/build.h"

#include <algorithm>
#include <array>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "lode/delaunay/full_tin.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/delaunay/ordered_insertion.h"
#include "lode/delaunay/point_insertion.h"
#include "lode/delaunay/tin.h"
#include "lode/models/terrain/implicit_pyramid/thinning.h"
#include "lode/models/terrain/insertions/history_writer.h"

namespace lode::implicit_pyramid {
namespace {

using delaunay::LatticePacking;
using delaunay::OrderedNode;
using insertions::History;
using insertions::PointGround;

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

/// Points that are taken away, as they are to be inserted again.
class PointOrder {
 public:
  explicit PointOrder(const PointGround& ground) : ground_(ground) {}

  /// `ends` gets where levels end.
  Result<std::vector<std::uint32_t>> find(std::vector<std::uint32_t>& ends, Progress& progress) {
    delaunay::PointMesh mesh = make_mesh(ground_, insertions::Model::implicit_delaunay_pyramid);
    LODE_CHECK(delaunay::insert_all_points(mesh, ground_.samples, progress));
    const auto lines = mesh.heal();
    delaunay::Tin full = to_tin(mesh, delaunay::TinLinks::kept);
    number_nodes(mesh);
    for (const std::uint32_t node : nodes_) full.heights.push_back(ground_.samples.heights[node]);
    keep_base();
    std::vector<std::uint32_t> order = keep_lines(lines);
    shuffle(order);
    if (!order.empty()) ends.push_back(static_cast<std::uint32_t>(order.size()));
    LODE_TRY(const Thinning thinning, thin(std::move(full), must_stay_, progress));
    for (auto level = thinning.rbegin(); level != thinning.rend(); ++level) {
      for (const RemovedVertex& removed : *level) order.push_back(nodes_[removed.vertex]);
      ends.push_back(static_cast<std::uint32_t>(order.size()));
    }
    return order;
  }

 private:
  /// As to_tin() numbers vertices.
  void number_nodes(const delaunay::PointMesh& mesh) {
    std::vector<bool> is_vertex(ground_.samples.nodes.size());
    for (const delaunay::LatticeTriangle& triangle : mesh.triangles())
      for (const std::uint32_t corner : triangle.corner) is_vertex[corner] = true;
    for (std::uint32_t node = 0; node < is_vertex.size(); ++node)
      if (is_vertex[node]) nodes_.push_back(node);
    must_stay_.assign(nodes_.size(), false);
  }
  [[nodiscard]] std::size_t vertex_of(std::uint32_t node) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(nodes_, node) - nodes_.begin());
  }
  void keep_base() {
    for (const auto& corners : ground_.triangles)
      for (const std::uint32_t corner : corners) must_stay_[vertex_of(corner)] = true;
  }
  /// Ends of edges that lines have become; returns those that are not of the base.
  std::vector<std::uint32_t> keep_lines(std::span<const std::array<std::uint32_t, 2>> lines) {
    std::vector<std::uint32_t> kept;
    for (const auto& ends : lines)
      for (const std::uint32_t node : ends) {
        if (must_stay_[vertex_of(node)]) continue;
        must_stay_[vertex_of(node)] = true;
        kept.push_back(node);
      }
    return kept;
  }

  /// From one end on, each would leave nearly all of its line to one triangle.
  static void shuffle(std::vector<std::uint32_t>& order) {
    constexpr std::uint32_t kGolden = 0x9e3779b1U;  // odd: different nodes have different products
    std::ranges::sort(order, {}, [](std::uint32_t node) { return node * kGolden; });
  }

  const PointGround& ground_;
  std::vector<std::uint32_t> nodes_;  ///< By vertex of the TIN of all, ascending.
  std::vector<bool> must_stay_;
};

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

Result<History> build(const PointGround& ground, Progress& progress) {
  constexpr auto kModel = insertions::Model::implicit_delaunay_pyramid;
  LODE_TRY(History history, insertions::begin_history(ground, kModel));
  LODE_TRY(const std::vector<std::uint32_t> order,
           PointOrder(ground).find(history.level_ends, progress));
  delaunay::PointMesh mesh = make_mesh(ground, kModel);
  insertions::HistoryWriter<delaunay::ListedNodes> writer(history);
  LODE_CHECK(delaunay::insert_points_in_order(mesh, ground.samples, history.range, order, writer,
                                              progress));
  writer.finish([&](std::uint32_t node) { return ground.samples.heights[node]; });
  history.lines = lines_between(ground, writer.nodes().first(history.n_base_vertices));
  history.max_error = 0;
  return history;
}

}  // namespace lode::implicit_pyramid

#include "lode/models/tetra_mt/midpoint/reference_mesh.h"

#include <algorithm>
#include <utility>

#include "lode/models/tetra_mt/mesh_check.h"
#include "lode/models/tetra_mt/midpoint/coincident.h"
#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"

namespace lode::tetra_mt::midpoint {
namespace {

constexpr std::uint32_t kOften = 4096;

/// The same corners, turned alike, the smallest ones first.
Tetrahedron in_order(Tetrahedron t) {
  bool is_odd = false;
  for (std::size_t i = 1; i < t.size(); ++i)
    for (std::size_t k = i; k > 0 && t[k] < t[k - 1]; --k) {
      std::swap(t[k], t[k - 1]);
      is_odd = !is_odd;
    }
  if (is_odd) std::swap(t[2], t[3]);
  return t;
}

void sort_cells(std::vector<Tetrahedron>& cells) {
  for (Tetrahedron& t : cells) t = in_order(t);
  std::ranges::sort(cells);
}

/// From the base down.
Result<std::vector<Vec3d>> positions_of_leaves(const Forest& forest) {
  const ForestHead& head = forest.head();
  std::vector<Code> codes(head.n_labels());
  for (std::size_t i = 0; i < head.roots.size(); ++i) codes[head.roots[i]] = head.root_codes[i];
  for (std::uint32_t node = head.n_nodes(); node-- > 0;) {
    const Split split = forest.split(node);
    if (split.children.first == kNone) continue;
    const Ends ends = parted(codes[head.n_vertices + node], split.difference, split.placement);
    codes[split.children.first] = ends.first;
    codes[split.children.second] = ends.second;
  }
  LODE_CHECK(forest.check());
  std::vector<Vec3d> positions;
  for (std::uint32_t leaf = 0; leaf < head.n_vertices; ++leaf) {
    const Code& code = codes[leaf];
    const Vec3d& at = positions.emplace_back(forest.position(leaf, code));
    // Else offsets would make up for it, and nodes lie elsewhere than their leaves' do.
    if (head.scales.code(at) != PositionCode{code[0], code[1], code[2]})
      return fail("expected leaf {} to have the code of its place, {}, {}, {}, got another", leaf,
                  at[0], at[1], at[2]);
  }
  LODE_CHECK(forest.check());
  return positions;
}

/// Labels fall along splits, and with them all that is beside a vertex before it is split.
Result<void> split_all(const Forest& forest, MidpointCut& cut, Progress& progress) {
  const std::uint32_t n_nodes = forest.head().n_nodes();
  for (std::uint32_t node = n_nodes; node-- > 0 && !cut.is_damaged();) {
    if (node % kOften == 0) {
      if (progress.is_cancelled()) return cancelled_error();
      progress.report("reading the mesh", 1 - static_cast<double>(node) / n_nodes);
    }
    cut.apply(NodeId{node});
  }
  return cut.check();
}

std::vector<RegionCell> region_cells(const MidpointCut& cut,
                                     std::span<const std::int64_t> region_ids) {
  std::vector<RegionCell> cells;
  if (region_ids.empty()) return cells;
  const bool is_one = region_ids.size() == 1;
  for (const MidpointCut::Cell& cell : cut.slots())
    if (cut.is_inside(cell)) cells.emplace_back(cell.corners, region_ids[is_one ? 0 : cell.region]);
  return cells;
}

}  // namespace

Result<ReferenceMesh> ReferenceMesh::of(const Forest& forest,
                                        std::span<const std::uint32_t> coincident_leaves,
                                        Progress& progress) {
  ReferenceMesh made;
  LODE_TRY(made.positions_, positions_of_leaves(forest));
  made.scales_ = forest.head().scales;
  made.leaves_ = by_place(made.positions_);
  std::size_t n_told = 0;
  for (const CoincidentRun& run : coincident_runs(made.positions_, made.leaves_)) {
    const std::size_t n = run.end - run.begin;
    const auto there = std::span(made.leaves_).subspan(run.begin, n);
    const auto told =
        coincident_leaves.subspan(n_told, std::min(n, coincident_leaves.size() - n_told));
    n_told += told.size();
    std::vector<std::uint32_t> sorted(told.begin(), told.end());
    std::ranges::sort(sorted);
    if (!std::ranges::equal(sorted, there))
      return fail("expected leaves {} to {}, which lie at one place, to be told apart, got others",
                  there.front(), there.back());
    std::ranges::copy(told, there.begin());
  }
  if (n_told != coincident_leaves.size())
    return fail("expected {} leaves that lie where others do, got {}", n_told,
                coincident_leaves.size());
  MidpointCut cut(forest);
  LODE_CHECK(split_all(forest, cut, progress));
  made.cells_ = cut.cells();
  made.regions_ = region_cells(cut, forest.head().region_ids);
  sort_cells(made.cells_);
  return made;
}

Result<std::vector<std::uint32_t>> ReferenceMesh::match(const TetraMesh& mesh) const {
  LODE_CHECK(check_mesh(mesh));
  const std::size_t n = positions_.size();
  if (mesh.positions.size() != n || mesh.tetrahedra.size() != cells_.size())
    return fail("expected the mesh that was built, of {} vertices and {} cells, got {} and {}", n,
                cells_.size(), mesh.positions.size(), mesh.tetrahedra.size());
  const std::vector<std::uint32_t> order = by_place(mesh.positions);
  std::vector<std::uint32_t> vertices(n);
  std::vector<std::uint32_t> leaf_of(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3d& ours = positions_[leaves_[i]];
    const Vec3d& theirs = mesh.positions[order[i]];
    if (!is_same_place(ours, theirs))
      return fail(
          "expected the mesh that was built, with a vertex at {}, {}, {}, got vertex {} at {}, {}, "
          "{}",
          ours[0], ours[1], ours[2], order[i], theirs[0], theirs[1], theirs[2]);
    vertices[leaves_[i]] = order[i];
    leaf_of[order[i]] = leaves_[i];
  }
  if (Scales(mesh).axes() != scales_.axes())
    return fail("expected codes of positions in the steps of the mesh that was built, got others");
  std::vector<Tetrahedron> theirs = mesh.tetrahedra;
  for (Tetrahedron& t : theirs)
    for (std::uint32_t& v : t) v = leaf_of[v];
  sort_cells(theirs);
  const auto [a, b] = std::ranges::mismatch(cells_, theirs);
  if (b != theirs.end())
    return fail("expected the mesh that was built, got one with a cell of vertices {}, {}, {}, {}",
                vertices[(*b)[0]], vertices[(*b)[1]], vertices[(*b)[2]], vertices[(*b)[3]]);
  std::vector<RegionCell> ours = regions_;
  for (auto& [corners, region] : ours)
    for (std::uint32_t& v : corners) v = vertices[v];
  LODE_CHECK(check_same_regions(std::move(ours), tetra_mt::region_cells(mesh)));
  return vertices;
}

}  // namespace lode::tetra_mt::midpoint

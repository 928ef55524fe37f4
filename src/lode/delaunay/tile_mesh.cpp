#include "lode/delaunay/tile_mesh.h"

#include <algorithm>
#include <utility>

#include "lode/delaunay/grid_domain.h"
#include "lode/delaunay/tin_links.h"

namespace lode::delaunay {
namespace {

/// Below, right, above, left: in the order in which the outline turns.
constexpr std::uint32_t kSides = 4;

/// The side that an edge of the outline lies on, or kSides.
std::uint32_t side_of_edge(LatticePoint a, LatticePoint b, LatticePoint last) {
  if (a.y == 0 && b.y == 0) return 0;
  if (a.x == last.x && b.x == last.x) return 1;
  if (a.y == last.y && b.y == last.y) return 2;
  if (a.x == 0 && b.x == 0) return 3;
  return kSides;
}

}  // namespace

/// The triangles of the outline's corners; false: there are none.
Result<bool> TileMesher::start(const LatticePart& part, LatticeTriangles& memory) {
  const LatticePacking packing(last_.x + 1);
  memory.clear();
  is_full_ = true;
  if (cells_ != nullptr) {
    const GridCells own(*cells_, part);
    if (own.n_inside() == 0) return false;
    is_full_ = own.has_all();
    if (!is_full_) {
      LODE_TRY(const auto triangles, triangulate_cells(own, packing));
      const auto twins = find_twins(triangles);
      for (std::size_t t = 0; t < triangles.size(); ++t)
        memory.push_back({triangles[t], twins[t], 0, 0});
      return true;
    }
  }
  const std::uint32_t a = packing.pack({0, 0});
  const std::uint32_t c = packing.pack(last_);
  memory.push_back({{a, packing.pack({last_.x, 0}), c}, {kNoHalfEdge, kNoHalfEdge, 4}, 0, 0});
  memory.push_back({{a, c, packing.pack({0, last_.y})}, {2, kNoHalfEdge, kNoHalfEdge}, 0, 0});
  return true;
}

std::uint32_t& TileMesher::owner_of(std::uint32_t side, LatticePoint from) {
  const auto per_side = static_cast<std::size_t>(std::max(last_.x, last_.y)) + 1;
  return owners_[side * per_side + static_cast<std::size_t>(side % 2 == 0 ? from.x : from.y)];
}

void TileMesher::note_owners(const LatticeMesh& mesh, std::span<const std::uint32_t> slots) {
  for (const std::uint32_t t : slots) {
    const LatticeTriangle& triangle = mesh.triangles()[t];
    for (std::size_t i = 0; i < 3; ++i) {
      if (triangle.twin[i] != kNoHalfEdge) continue;
      const LatticePoint from = mesh.nodes().unpack(triangle.corner[i]);
      const std::uint32_t side =
          side_of_edge(from, mesh.nodes().unpack(triangle.corner[(i + 1) % 3]), last_);
      if (side < kSides) owner_of(side, from) = t;
    }
  }
}

/// Whether the tile has the cell at the step that begins at a place.
bool TileMesher::has_cell(const Side& side, std::int32_t place) const {
  const std::int32_t i = place - side.start;
  if (i < 0 || i >= (side.step.x != 0 ? last_.x : last_.y)) return false;
  if (is_full_) return true;
  const LatticePoint inward{side.number == 1 ? -1 : 0, side.number == 2 ? -1 : 0};
  return cells_->has(origin_.x + side.first.x + i * side.step.x + inward.x,
                     origin_.y + side.first.y + i * side.step.y + inward.y);
}

/// Those between two that are corners already, and have no other between them: the middle one
/// first, so that little is replaced again and again.
void TileMesher::insert_between(LatticeMesh& mesh, const Side& side, std::size_t lower,
                                std::size_t upper) {
  if (upper - lower < 2) return;
  const auto node = [&](std::size_t number) {
    const std::int32_t i = side.seam.places[number] - side.start;
    return LatticePoint{side.first.x + i * side.step.x, side.first.y + i * side.step.y};
  };
  const std::size_t middle = lower + (upper - lower) / 2;
  const std::uint32_t owner = owner_of(side.number, node(side.is_forward ? lower : upper));
  note_owners(mesh, mesh.insert(mesh.nodes().pack(node(middle)), owner));
  insert_between(mesh, side, lower, middle);
  insert_between(mesh, side, middle, upper);
}

void TileMesher::insert_side(LatticeMesh& mesh, const Side& side) {
  const auto& places = side.seam.places;
  std::size_t first = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const bool was_inside = has_cell(side, places[i] - 1);
    const bool is_inside = has_cell(side, places[i]);
    if (was_inside && !is_inside) insert_between(mesh, side, first, i);
    if (is_inside && !was_inside) first = i;
  }
}

Result<LatticeMesh> TileMesher::make(std::size_t tile, const LatticePart& part,
                                     LatticeTriangles memory) {
  origin_ = part.first;
  last_ = {part.last.x - part.first.x, part.last.y - part.first.y};
  LODE_TRY(const bool has_any, start(part, memory));
  LatticeMesh mesh(LatticePacking(last_.x + 1), std::move(memory));
  if (!has_any) return mesh;
  owners_.resize(kSides * (static_cast<std::size_t>(std::max(last_.x, last_.y)) + 1));
  std::vector<std::uint32_t> all(mesh.triangles().size());
  for (std::uint32_t t = 0; t < all.size(); ++t) all[t] = t;
  note_owners(mesh, all);
  const LatticePoint right{1, 0};
  const LatticePoint up{0, 1};
  insert_side(mesh, {seams_.below(tile), origin_.x, {0, 0}, right, true, 0});
  insert_side(mesh, {seams_.right_of(tile), origin_.y, {last_.x, 0}, up, true, 1});
  insert_side(mesh, {seams_.above(tile), origin_.x, {0, last_.y}, right, false, 2});
  insert_side(mesh, {seams_.left_of(tile), origin_.y, {0, 0}, up, false, 3});
  return mesh;
}

}  // namespace lode::delaunay

#include "lode/api/tetra_cut_shape.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lode {
namespace {

using tetra_mt::kNone;
using tetra_mt::PackedHierarchy;
using tetra_mt::Tetrahedron;
using tetra_mt::midpoint::Code;

/// A face, listed at the least of its corners.
struct CutFace {
  std::uint32_t middle;
  std::uint32_t last;
  std::uint32_t cell;
  std::uint8_t across;  ///< The cell's corner that it has not.
  bool is_odd;          ///< Turned the other way than by ascending corners.
};

struct ListedCutFace {
  std::uint32_t first;
  CutFace face;
};

ListedCutFace face_of(const TetraCells& cells, std::uint32_t cell, std::uint8_t across) {
  auto f = tetra_mt::others(cells.corners[cell], across);
  bool is_odd = false;
  const auto order = [&](std::size_t i, std::size_t k) {
    if (f[i] <= f[k]) return;
    std::swap(f[i], f[k]);
    is_odd = !is_odd;
  };
  order(0, 1);
  order(1, 2);
  order(0, 1);
  return {f[0], {f[1], f[2], cell, across, is_odd}};
}

template <typename Visit>
void for_each_face(const TetraCells& cells, const Visit& visit) {
  for (std::uint32_t cell = 0; cell < cells.corners.size(); ++cell)
    for (std::uint8_t across = 0; across < 4; ++across) visit(face_of(cells, cell, across));
}

/// What the cells with one face are.
void add_face(const TetraVertices& vertices, const TetraCells& cells,
              std::span<const CutFace> sides, TetraCutShape& shape) {
  ++shape.n_faces;
  if (sides.size() > 2 || (sides.size() == 2 && sides[0].is_odd == sides[1].is_odd))
    ++shape.n_crowded_faces;
  if (sides.size() != 1) return;
  // Turned outward, a corner's other three are clockwise from there.
  const auto& [a, b, c] = tetra_mt::others(cells.corners[sides[0].cell], sides[0].across);
  const auto& p = vertices.positions;
  shape.outer.push_back({a, b, c});
  shape.area += length(cross(p[b] - p[a], p[c] - p[a])) / 2;
}

void find_faces(const TetraVertices& vertices, const TetraCells& cells, TetraCutShape& shape) {
  std::vector<std::uint64_t> begins(vertices.positions.size() + 2, 0);
  for_each_face(cells, [&](const ListedCutFace& f) { ++begins[f.first + std::size_t{2}]; });
  for (std::size_t v = 1; v < begins.size(); ++v) begins[v] += begins[v - 1];
  std::vector<CutFace> faces(begins.back());
  for_each_face(
      cells, [&](const ListedCutFace& f) { faces[begins[f.first + std::size_t{1}]++] = f.face; });
  const auto key = [](const CutFace& f) { return std::pair(f.middle, f.last); };
  for (std::size_t v = 0; v + 1 < begins.size(); ++v) {
    const auto listed = std::span(faces).subspan(begins[v], begins[v + 1] - begins[v]);
    std::ranges::sort(listed, [&](const CutFace& a, const CutFace& b) {
      return key(a) != key(b) ? key(a) < key(b) : a.cell < b.cell;
    });
    for (std::size_t i = 0, end = 0; i < listed.size(); i = end) {
      while (end < listed.size() && key(listed[end]) == key(listed[i])) ++end;
      add_face(vertices, cells, listed.subspan(i, end - i), shape);
    }
  }
}

/// Of all vertices of midpoints, from the base down: what a vertex splits into has smaller labels.
/// Where a page cannot be loaded, as the forest's check() says, something.
std::vector<Code> codes_by_label(const tetra_mt::midpoint::Forest& forest, std::size_t field) {
  const tetra_mt::midpoint::ForestHead& head = forest.head();
  std::vector<Code> codes(head.n_labels(), Code{});
  for (std::size_t i = 0; i < head.roots.size(); ++i)
    codes[head.roots[i]] = forest.root_code(i, field);
  for (std::uint32_t node = head.n_nodes(); node-- > 0;) {
    const tetra_mt::midpoint::Split split = forest.split(node, field);
    if (split.children.first == kNone) break;
    const auto ends = parted(codes[head.n_vertices + node], split.difference, split.placement);
    codes[split.children.first] = ends.first;
    codes[split.children.second] = ends.second;
  }
  return codes;
}

}  // namespace

TetraVertices::TetraVertices(const PackedHierarchy& hierarchy)
    : has_narrow_positions(hierarchy.head().shape.has_narrow_positions),
      boundary_deviation_(hierarchy.head().boundary_deviation) {
  const std::uint32_t n = hierarchy.head().n_vertices();
  positions.reserve(n);
  for (std::uint32_t v = 0; v < n; ++v) {
    positions.push_back(hierarchy.position(v));
    samples.push_back(v);
  }
  find_extent(n, {hierarchy.head().lower, hierarchy.head().upper});
}

/// Leaves of the base that no cell has are no samples.
TetraVertices::TetraVertices(const tetra_mt::midpoint::Forest& forest)
    : boundary_deviation_(forest.head().boundary_deviation) {
  const tetra_mt::midpoint::ForestHead& head = forest.head();
  const std::vector<Code> codes = codes_by_label(forest, 0);
  std::vector<bool> is_used(head.n_vertices, false);
  std::fill(is_used.begin() + head.n_base_leaves, is_used.end(), true);
  for (const Tetrahedron& t : head.base)
    for (const std::uint32_t v : t)
      if (head.is_leaf(v)) is_used[v] = true;
  for (std::uint32_t v = 0; v < codes.size(); ++v) {
    positions.push_back(forest.position(v, codes[v]));
    if (head.is_leaf(v) && is_used[v]) samples.push_back(v);
  }
  find_extent(head.n_vertices, head.box);
}

/// What a file says of its box has no say in what is allowed.
void TetraVertices::find_extent(std::size_t n, const Box3d& stated) {
  n_of_mesh = n;
  if (n == 0) return;
  Box3d box{positions[0], positions[0]};
  Vec3d most;
  for (const Vec3d& p : std::span(positions).first(n))
    for (std::size_t i = 0; i < 3; ++i) {
      box.lower[i] = std::min(box.lower[i], p[i]);
      box.upper[i] = std::max(box.upper[i], p[i]);
      most[i] = std::max(most[i], std::abs(p[i]));
    }
  size = length(box.upper - box.lower);
  farthest = length(most);
  has_stated_box = box.lower == stated.lower && box.upper == stated.upper;
}

void TetraVertices::take_values(const PackedHierarchy& hierarchy, std::size_t field) {
  values.clear();
  for (std::uint32_t v = 0; v < hierarchy.head().n_vertices(); ++v)
    values.push_back(hierarchy.value(v, field));
}

void TetraVertices::take_values(const tetra_mt::midpoint::Forest& forest, std::size_t field) {
  const std::vector<Code> codes = codes_by_label(forest, field);
  values.clear();
  for (std::uint32_t v = 0; v < codes.size(); ++v)
    values.push_back(forest.value(v, codes[v], field));
}

double TetraVertices::boundary_allowance() const {
  constexpr double kRounding = 1 + 1e-6;  // Of the deviation, and of what is measured.
  return std::max(rounding_allowance(), kRounding * boundary_deviation_);
}

double TetraVertices::rounding_allowance() const {
  constexpr double kShareOfSize = 1e-6;
  constexpr double kRoundings = 64 * 0x1p-24;
  return std::max(kShareOfSize * size, has_narrow_positions ? kRoundings * farthest : 0);
}

TetraCells::TetraCells(const tetra_mt::TetraCut& cut) {
  for (std::uint32_t slot = 0; slot < cut.slots().size(); ++slot) {
    const tetra_mt::TetraCut::Cell& cell = cut.slots()[slot];
    if (!cut.is_inside(cell)) continue;
    corners.push_back(cell.corners);
    makers.push_back(cut.maker(slot));
    regions.push_back(cut.region(slot));
  }
}

TetraCells::TetraCells(const tetra_mt::midpoint::MidpointCut& cut) {
  for (const tetra_mt::midpoint::MidpointCut::Cell& cell : cut.slots()) {
    if (!cut.is_inside(cell)) continue;
    corners.push_back(cell.corners);
    makers.push_back(cut.maker(cell));
    regions.push_back(cell.region);
  }
}

TetraCutShape shape_of(const TetraVertices& vertices, const TetraCells& cells) {
  TetraCutShape shape;
  const auto& p = vertices.positions;
  for (std::size_t i = 0; i < cells.corners.size(); ++i) {
    const Tetrahedron& t = cells.corners[i];
    const double six = dot(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]), p[t[3]] - p[t[0]]);
    shape.volume += six / 6;
    if (!(six > 0)) ++(cells.makers[i] == kNone ? shape.n_bad_reference : shape.n_bad_made);
  }
  find_faces(vertices, cells, shape);
  return shape;
}

Surface outer_surface(const TetraVertices& vertices, const TetraCutShape& shape) {
  Surface surface;
  if (!vertices.has_narrow_positions && !vertices.positions.empty())
    surface.origin = vertices.positions.front();
  std::vector<std::uint32_t> numbers(vertices.positions.size(), kNone);
  for (const auto& triangle : shape.outer) {
    auto& added = surface.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& number = numbers[triangle[k]];
      if (number == kNone) {
        number = static_cast<std::uint32_t>(surface.positions.size());
        const Vec3d p = vertices.positions[triangle[k]] - surface.origin;
        surface.positions.push_back(
            {{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}});
      }
      added[k] = number;
    }
  }
  return surface;
}

}  // namespace lode

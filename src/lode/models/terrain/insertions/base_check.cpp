// How many triangles that turn left lie over a place is the winding number of what is left of
// their edges where those between two cancel: exact, in whole numbers, whatever the triangles.
#include "lode/models/terrain/insertions/base_check.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "lode/delaunay/lattice_side.h"
#include "lode/delaunay/triangulation.h"

namespace lode::insertions {
namespace {

using delaunay::LatticePoint;

/// An edge, from its lower end on.
struct Edge {
  LatticePoint from;
  LatticePoint to;
  bool is_turned = false;  ///< The triangle has it the other way round.

  [[nodiscard]] auto ends() const { return std::tie(from.x, from.y, to.x, to.y); }
};

std::vector<Edge> sorted_edges(std::span<const LatticeCorners> triangles) {
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (const LatticeCorners& corner : triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      Edge edge{corner[i], corner[(i + 1) % 3]};
      if (std::tie(edge.to.x, edge.to.y) < std::tie(edge.from.x, edge.from.y)) {
        std::swap(edge.from, edge.to);
        edge.is_turned = true;
      }
      edges.push_back(edge);
    }
  std::ranges::sort(edges, {}, &Edge::ends);
  return edges;
}

/// A part of the outline, along a column or a row.
struct Side {
  std::int32_t line = 0;
  std::int32_t low = 0;
  std::int32_t high = 0;
  bool is_begin = false;  ///< Of a column: triangles are to its right.

  [[nodiscard]] auto place() const { return std::tie(line, low); }
};

struct Outline {
  std::vector<Side> columns;
  std::vector<Side> rows;
};

/// Takes edges of one triangle; false where one is oblique, or an edge has more than two
/// triangles, or two on one side.
bool read_outline(std::span<const Edge> edges, Outline& outline) {
  for (std::size_t i = 0; i < edges.size();) {
    const Edge& edge = edges[i];
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].ends() == edge.ends()) ++end;
    const std::size_t n = end - i;
    const bool is_inner = n == 2 && edge.is_turned != edges[i + 1].is_turned;
    i = end;
    if (is_inner) continue;
    if (n > 1) return false;
    if (edge.from.x == edge.to.x)
      outline.columns.push_back({edge.from.x, edge.from.y, edge.to.y, edge.is_turned});
    else if (edge.from.y == edge.to.y)
      outline.rows.push_back({edge.from.y, edge.from.x, edge.to.x});
    else
      return false;
  }
  std::ranges::sort(outline.columns, {}, &Side::place);
  std::ranges::sort(outline.rows, {}, &Side::place);
  return true;
}

/// Else a vertex hangs in an edge, or triangles overlap.
bool are_apart(std::span<const Side> sides) {
  return std::ranges::adjacent_find(sides, [](const Side& a, const Side& b) {
           return a.line == b.line && b.low < a.high;
         }) == sides.end();
}

/// What triangles cover of a column, while it moves to the right.
class Covered {
 public:
  /// False where some of it is.
  bool add(std::int32_t low, std::int32_t high) {
    auto after = parts_.lower_bound(low);
    if (after != parts_.end() && after->first < high) return false;
    if (after != parts_.end() && after->first == high) {
      high = after->second;
      after = parts_.erase(after);
    }
    if (after != parts_.begin()) {
      const auto before = std::prev(after);
      if (before->second > low) return false;
      if (before->second == low) {
        before->second = high;
        return true;
      }
    }
    parts_.emplace(low, high);
    return true;
  }
  /// False where some of it is not.
  bool remove(std::int32_t low, std::int32_t high) {
    auto after = parts_.upper_bound(low);
    if (after == parts_.begin()) return false;
    const auto part = std::prev(after);
    const std::int32_t end = part->second;
    if (end < high) return false;
    if (end > high) parts_.emplace(high, end);
    if (part->first == low)
      parts_.erase(part);
    else
      part->second = low;
    return true;
  }

 private:
  std::map<std::int32_t, std::int32_t> parts_;  ///< Ends by begin; they do not touch.
};

}  // namespace

bool cover_part_once(std::span<const LatticePoint> nodes,
                     std::span<const std::array<std::uint32_t, 3>> triangles) {
  using Ends = std::array<std::uint32_t, 2>;
  std::vector<Ends> edges;
  edges.reserve(3 * triangles.size());
  for (const auto& corner : triangles)
    for (std::size_t i = 0; i < 3; ++i) edges.push_back({corner[i], corner[(i + 1) % 3]});
  std::ranges::sort(edges);
  // One that is there twice has two triangles on one side.
  if (std::ranges::adjacent_find(edges) != edges.end()) return false;
  std::vector<Ends> outline;
  for (const auto& [a, b] : edges)
    if (!std::ranges::binary_search(edges, Ends{b, a})) outline.push_back({a, b});
  // What is left to the left of edges that do not cross, and of none to the right, these go round
  // once: the winding number is the number of triangles over a place. So no vertex within hangs in
  // an edge either.
  std::vector<std::uint32_t> number(nodes.size(), delaunay::kNone);
  std::vector<std::uint32_t> n_edges;
  std::vector<delaunay::Point> places;
  for (Ends& edge : outline)
    for (std::uint32_t& end : edge) {
      if (number[end] == delaunay::kNone) {
        number[end] = static_cast<std::uint32_t>(places.size());
        places.push_back(delaunay::to_point(nodes[end]));
        n_edges.push_back(0);
      }
      end = number[end];
      if (++n_edges[end] > kMostOutlineEdges) return false;
    }
  return delaunay::triangulate_region(std::move(places), outline).has_value();
}

bool cover_cells_once(std::span<const LatticeCorners> triangles) {
  Outline outline;
  if (!read_outline(sorted_edges(triangles), outline)) return false;
  if (!are_apart(outline.columns) || !are_apart(outline.rows)) return false;
  Covered covered;
  return std::ranges::all_of(outline.columns, [&](const Side& side) {
    return side.is_begin ? covered.add(side.low, side.high) : covered.remove(side.low, side.high);
  });
}

}  // namespace lode::insertions

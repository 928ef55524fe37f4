#include "lode/models/terrain/hierarchy_file/point_outline.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "lode/delaunay/lattice_side.h"
#include "lode/delaunay/triangulation.h"

namespace lode::hierarchy_file {
namespace {

using delaunay::LatticePoint;

auto place_of(LatticePoint p) { return std::tuple(p.y, p.x); }

bool is_before(const OutlineEdge& a, const OutlineEdge& b) {
  return std::tuple(place_of(a[0]), place_of(a[1])) < std::tuple(place_of(b[0]), place_of(b[1]));
}

bool goes_straight_on(const OutlineEdge& a, const OutlineEdge& b) {
  const std::int64_t along = std::int64_t{a[1].x - a[0].x} * (b[1].x - b[0].x) +
                             std::int64_t{a[1].y - a[0].y} * (b[1].y - b[0].y);
  return delaunay::doubled_area(a[0], a[1], b[1]) == 0 && along > 0;
}

/// Of sorted places the first at one, if it is the only one, else their number.
std::size_t find_only(const std::vector<LatticePoint>& sorted, LatticePoint place) {
  const auto at = std::ranges::lower_bound(sorted, place_of(place), {}, place_of);
  const auto i = static_cast<std::size_t>(at - sorted.begin());
  const bool is_there = i < sorted.size() && sorted[i] == place;
  const bool is_only = is_there && (i + 1 == sorted.size() || sorted[i + 1] != place);
  return is_only ? i : sorted.size();
}

/// The edge after each, where it goes straight on and nothing else is there, else their number.
/// Edges are in order.
std::vector<std::size_t> find_next(const std::vector<OutlineEdge>& edges) {
  std::vector<LatticePoint> starts;
  std::vector<LatticePoint> ends;
  starts.reserve(edges.size());
  ends.reserve(edges.size());
  for (const auto& [start, end] : edges) {
    starts.push_back(start);
    ends.push_back(end);
  }
  std::ranges::sort(ends, {}, place_of);
  std::vector<std::size_t> next;
  next.reserve(edges.size());
  for (const OutlineEdge& edge : edges) {
    const std::size_t after = find_only(starts, edge[1]);
    const bool goes_on = after < edges.size() && find_only(ends, edge[1]) < edges.size() &&
                         goes_straight_on(edge, edges[after]);
    next.push_back(goes_on ? after : edges.size());
  }
  return next;
}

}  // namespace

std::vector<OutlineEdge> join_edges(std::vector<OutlineEdge> edges) {
  std::ranges::sort(edges, is_before);
  const std::vector<std::size_t> next = find_next(edges);
  std::vector<bool> is_later(edges.size());
  for (const std::size_t i : next)
    if (i < edges.size()) is_later[i] = true;
  std::vector<OutlineEdge> joint;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (is_later[i]) continue;
    std::size_t last = i;
    while (next[last] < edges.size()) last = next[last];
    joint.push_back({edges[i][0], edges[last][1]});
  }
  return joint;
}

Result<void> check_goes_round_once(const std::vector<OutlineEdge>& outline) {
  std::map<std::pair<std::int32_t, std::int32_t>, std::uint32_t> numbers;
  std::vector<delaunay::Point> places;
  std::vector<std::uint32_t> n_edges;
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (const OutlineEdge& edge : outline) {
    std::array<std::uint32_t, 2> ends{};
    for (std::size_t i = 0; i < 2; ++i) {
      const auto [found, is_new] =
          numbers.try_emplace({edge[i].x, edge[i].y}, static_cast<std::uint32_t>(places.size()));
      ends[i] = found->second;
      if (is_new) {
        places.push_back(delaunay::to_point(edge[i]));
        n_edges.push_back(0);
      }
      if (++n_edges[ends[i]] > kMostEdgesAtNode)
        return fail("expected up to {} edges of the outline at a node, got more", kMostEdgesAtNode);
    }
    edges.push_back(ends);
  }
  // What is to the left of edges that do not cross, and of none to the right, these go round once.
  const auto region = delaunay::triangulate_region(std::move(places), edges);
  if (!region)
    return fail("expected an outline that goes round what is inside once, got another: {}",
                region.error().message);
  return {};
}

}  // namespace lode::hierarchy_file

#include "lode/delaunay/fixed_lines.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "lode/delaunay/lattice_side.h"
#include "lode/delaunay/tin_links.h"

namespace lode::delaunay {
namespace {

using EdgeList = std::vector<std::array<std::uint32_t, 2>>;

/// The edges of triangles that have nothing behind them.
EdgeList outline_of(std::span<const std::array<std::uint32_t, 3>> triangles) {
  const auto twins = find_twins(triangles);
  EdgeList outline;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i)
      if (twins[t][i] == kNoHalfEdge)
        outline.push_back({triangles[t][i], triangles[t][(i + 1) % 3]});
  return outline;
}

/// Those that edges end at, from small to large.
std::vector<std::uint32_t> ends_of(std::initializer_list<std::span<const EdgeList::value_type>> all,
                                   std::span<const std::uint32_t> single) {
  std::vector<std::uint32_t> ends(single.begin(), single.end());
  for (const auto edges : all)
    for (const auto& edge : edges) ends.insert(ends.end(), edge.begin(), edge.end());
  std::ranges::sort(ends);
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  return ends;
}

}  // namespace

template <typename Nodes>
Result<FixedRegion> fix_lines(const Nodes& nodes,
                              std::span<const std::array<std::uint32_t, 3>> triangles,
                              std::span<const std::array<std::uint32_t, 2>> edges,
                              std::span<const std::uint32_t> single, Progress& progress) {
  EdgeList outline = outline_of(triangles);
  const std::vector<std::uint32_t> ends = ends_of({outline, edges}, single);
  const auto place_of = [&](std::uint32_t node) {
    return static_cast<std::uint32_t>(std::ranges::lower_bound(ends, node) - ends.begin());
  };
  const auto places_of = [&](std::span<const EdgeList::value_type> from) {
    EdgeList places;
    for (const auto& edge : from) places.push_back({place_of(edge[0]), place_of(edge[1])});
    return places;
  };
  std::vector<Point> points;
  points.reserve(ends.size());
  for (const std::uint32_t end : ends) points.push_back(to_point(nodes.unpack(end)));
  LODE_TRY(FixedRegion region,
           triangulate_region(std::move(points), places_of(outline), places_of(edges), progress));
  for (auto& corner : region.triangles)
    for (std::uint32_t& place : corner) place = ends[place];
  for (auto& edge : region.edges)
    for (std::uint32_t& place : edge) place = ends[place];
  return region;
}

template Result<FixedRegion> fix_lines(const LatticePacking&,
                                       std::span<const std::array<std::uint32_t, 3>>,
                                       std::span<const std::array<std::uint32_t, 2>>,
                                       std::span<const std::uint32_t>, Progress&);
template Result<FixedRegion> fix_lines(const ListedNodes&,
                                       std::span<const std::array<std::uint32_t, 3>>,
                                       std::span<const std::array<std::uint32_t, 2>>,
                                       std::span<const std::uint32_t>, Progress&);

}  // namespace lode::delaunay

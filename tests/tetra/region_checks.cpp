#include "tests/tetra/region_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <vector>

namespace lode::test {
namespace {

/// Ascending.
using Simplex = std::vector<std::uint32_t>;

Simplex without(const Simplex& simplex, std::size_t place) {
  Simplex rest = simplex;
  rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(place));
  return rest;
}

/// How many sets are left as all that share something that `parts` gives become one.
template <typename Parts>
int count_components(const std::vector<Simplex>& simplices, const Parts& parts) {
  std::vector<std::size_t> parent(simplices.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i];
    return i;
  };
  std::map<Simplex, std::size_t> first;
  for (std::size_t i = 0; i < simplices.size(); ++i)
    for (const Simplex& part : parts(simplices[i])) {
      const auto at = first.emplace(part, i).first;
      parent[root(i)] = root(at->second);
    }
  int n = 0;
  for (std::size_t i = 0; i < simplices.size(); ++i) n += parent[i] == i ? 1 : 0;
  return n;
}

std::vector<Simplex> corners_of(const Simplex& simplex) {
  std::vector<Simplex> corners;
  for (const std::uint32_t v : simplex) corners.push_back({v});
  return corners;
}

std::vector<Simplex> sides_of(const Simplex& simplex) {
  std::vector<Simplex> sides;
  for (std::size_t i = 0; i < simplex.size(); ++i) sides.push_back(without(simplex, i));
  return sides;
}

/// Sides of other than two of the simplices.
std::vector<Simplex> ends_of(const std::set<Simplex>& simplices) {
  std::map<Simplex, int> counts;
  for (const Simplex& s : simplices)
    for (const Simplex& side : sides_of(s)) ++counts[side];
  std::vector<Simplex> ends;
  for (const auto& [side, n] : counts)
    if (n != 2) ends.push_back(side);
  return ends;
}

Topology describe(const std::set<Simplex>& simplices) {
  Topology topology;
  for (std::set<Simplex> level = simplices; !level.empty();) {
    const std::size_t size = level.begin()->size();
    topology.euler += (size % 2 == 1 ? 1 : -1) * static_cast<int>(level.size());
    std::set<Simplex> lower;
    if (size > 1)
      for (const Simplex& s : level)
        for (Simplex& side : sides_of(s)) lower.insert(std::move(side));
    level = std::move(lower);
  }
  const std::vector<Simplex> all(simplices.begin(), simplices.end());
  topology.n_components = count_components(all, corners_of);
  topology.n_pieces = count_components(all, sides_of);
  topology.n_ends = count_components(ends_of(simplices), corners_of);
  return topology;
}

double area_of(const TetraMesh& mesh, const Simplex& face) {
  const auto& p = mesh.positions;
  return length(cross(p[face[1]] - p[face[0]], p[face[2]] - p[face[0]])) / 2;
}

}  // namespace

Regions describe_regions(const TetraMesh& mesh, const Tetrahedra& tetrahedra,
                         std::span<const std::uint32_t> regions, const PatchMarks& patches) {
  Regions result;
  std::map<std::uint32_t, std::set<Simplex>> solids;
  std::map<Simplex, std::vector<std::uint32_t>> sides;
  for (std::size_t i = 0; i < tetrahedra.size(); ++i) {
    Simplex s(tetrahedra[i].begin(), tetrahedra[i].end());
    std::ranges::sort(s);
    for (Simplex& face : sides_of(s)) sides[face].push_back(regions[i]);
    solids[regions[i]].insert(std::move(s));
    result.volumes[regions[i]] += volume_of(mesh, {tetrahedra[i]});
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::set<Simplex>> sheets;
  std::set<Simplex> all;
  std::map<Simplex, std::set<std::uint32_t>> outlines;  // by edge of the boundary: beside what
  for (auto& [face, of] : sides) {
    if (of.size() == 1) {
      const auto patch = patches.find(face);
      of.push_back(Regions::kOutside - (patch == patches.end() ? 0 : patch->second));
      for (Simplex& side : sides_of(face)) outlines[std::move(side)].insert(of[1]);
    }
    if (of[0] == of[1]) continue;
    const std::pair key = std::minmax(of[0], of[1]);
    sheets[key].insert(face);
    result.areas[key] += area_of(mesh, face);
    all.insert(face);
  }
  for (const auto& [region, solid] : solids) result.solids[region] = describe(solid);
  for (const auto& [key, sheet] : sheets) result.sheets[key] = describe(sheet);
  result.all_sheets = describe(all);
  std::vector<Simplex> curves = ends_of(all);
  for (const auto& [edge, beside] : outlines)
    if (beside.size() > 1) curves.push_back(edge);
  result.curves = describe({curves.begin(), curves.end()});
  return result;
}

void expect_same_regions(const Regions& a, const Regions& b, double share) {
  EXPECT_EQ(a.solids, b.solids);
  EXPECT_EQ(a.sheets, b.sheets);
  EXPECT_EQ(a.all_sheets, b.all_sheets);
  EXPECT_EQ(a.curves, b.curves);
  for (const auto& [region, volume] : a.volumes)
    EXPECT_NEAR(b.volumes.at(region), volume, share * volume) << region;
  for (const auto& [key, area] : a.areas) {
    ASSERT_TRUE(b.areas.contains(key));
    EXPECT_NEAR(b.areas.at(key), area, share * area) << key.first << " " << key.second;
  }
}

}  // namespace lode::test

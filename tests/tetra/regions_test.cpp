// Collapses in meshes of several regions: each stays what it is and where it is.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "lode/models/tetra_mt/half_edge.h"
#include "lode/models/tetra_mt/hierarchy.h"
#include "lode/models/tetra_mt/interfaces.h"
#include "lode/models/tetra_mt/live_tetrahedra.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/trials.h"
#include "tests/tetra/mesh_checks.h"
#include "tests/tetra/region_checks.h"

namespace lode::tetra_mt {
namespace {

using oracles::Cut;
using oracles::Random;
using test::Regions;

/// By a point's cell in a grid.
using RegionOf = std::function<std::uint32_t(int x, int y, int z)>;

struct RegionCase {
  std::string name;
  RegionOf region_of;
  std::size_t most_cells;  ///< At the end, of a field that is constant.
  std::vector<std::array<std::uint32_t, 3>> corners = {};  ///< Some vertices that must stay.
};

int from_middle(int n, int x, int y, int z) {
  const auto away = [&](int c) { return std::abs(2 * c + 1 - n) / 2; };
  return std::max({away(x), away(y), away(z)});
}

std::uint32_t hash(std::uint64_t seed, int x, int y, int z) {
  return static_cast<std::uint32_t>(
      Random(seed + static_cast<std::uint64_t>((z * 64 + y) * 64 + x)).next() >> 32U);
}

/// Of a grid of n cells an axis.
std::vector<RegionCase> region_cases(int n) {
  const auto flag = [](bool is) { return is ? 1U : 0U; };
  return {
      {"halves", [=](int x, int, int) { return flag(2 * x < n); }, 30},
      {"slabs", [=](int x, int, int) { return static_cast<std::uint32_t>(4 * x / n); }, 50},
      {"blocks", [=](int x, int y, int z) { return flag((x / 4 + y / 4 + z / 4) % 2 == 0); }, 400},
      {"four blocks", [=](int x, int y, int) { return flag(x >= 5) + 2 * flag(y >= 7); }, 60},
      {"shells",
       [=](int x, int y, int z) { return static_cast<std::uint32_t>(from_middle(n, x, y, z)) / 2; },
       500},
      {"ball",
       [=](int x, int y, int z) {
         const auto square = [&](int c) { return (2 * c + 1 - n) * (2 * c + 1 - n); };
         return flag(square(x) + square(y) + square(z) < n * n / 3);
       },
       600},
      {"inclusion", [=](int x, int y, int z) { return flag(from_middle(n, x, y, z) < 2); }, 100},
      {"cell", [=](int x, int y, int z) { return flag(x == 4 && y == 5 && z == 6); }, 70},
      {"layer", [=](int, int y, int) { return flag(y == 5); }, 50},
      {"touching at an edge",
       [=](int x, int y, int z) {
         return flag(((x < 5 && y < 5) || (x >= 5 && y >= 5)) && z > 1 && z < 8);
       },
       120,
       {{5, 5, 2}, {5, 5, 8}}},
      {"touching at a vertex",
       [=](int x, int y, int z) {
         return flag((x < 5 && y < 5 && z < 5) || (x >= 5 && y >= 5 && z >= 5));
       },
       130,
       {{5, 5, 5}}},
      {"rod to the boundary",
       [=](int x, int y, int) { return flag(x > 3 && x < 6 && y > 3 && y < 6); }, 120},
      {"handle",
       [=](int x, int y, int z) {
         return flag(from_middle(n, x, y, z) < 4 && (x != n / 2 || y != n / 2) && z == n / 2);
       },
       200},
      {"random blocks", [=](int x, int y, int z) { return hash(7, x / 3, y / 3, z / 3) % 3; },
       3000},
  };
}

TetraMesh mesh_of_regions(int n, Cut cut, const RegionOf& region_of) {
  TetraMesh mesh = oracles::noise_mesh(n + 1, cut, 5);
  for (const auto& t : mesh.tetrahedra) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    const auto cell = [&](std::size_t i) { return static_cast<int>(std::floor(centre[i] * n)); };
    mesh.regions.push_back(region_of(cell(0), cell(1), cell(2)));
  }
  for (std::uint32_t id = 0; id <= std::ranges::max(mesh.regions); ++id)
    mesh.region_ids.push_back(10 + id);
  return mesh;
}

HalfEdgeCollapses simplified(const TetraMesh& mesh, std::uint64_t base_cells = 0, int threads = 2) {
  Progress progress;
  auto result = collapse_half_edges(
      mesh, {.base_cells = base_cells, .rules = {}, .threads = {threads}}, progress);
  EXPECT_TRUE(result) << (result ? "" : result.error().message);
  return result ? std::move(*result) : HalfEdgeCollapses{};
}

void expect_regions_kept(const TetraMesh& mesh, const HalfEdgeCollapses& result) {
  ASSERT_EQ(result.base_regions.size(), result.base.size());
  test::expect_conforming(mesh, result.base);
  // Positions are exact here, but for rounding in sums.
  test::expect_same_regions(test::describe_regions(mesh, mesh.tetrahedra, mesh.regions),
                            test::describe_regions(mesh, result.base, result.base_regions), 1e-9);
}

void expect_corners_kept(const RegionCase& region_case, const std::set<std::uint32_t>& vertices,
                         std::uint32_t n) {
  for (const auto& [x, y, z] : region_case.corners)
    EXPECT_TRUE(vertices.contains((z * n + y) * n + x));
}

std::set<std::uint32_t> vertices_among(const test::Tetrahedra& tetrahedra) {
  std::set<std::uint32_t> vertices;
  for (const auto& t : tetrahedra) vertices.insert(t.begin(), t.end());
  return vertices;
}

TEST(regions, stay_what_and_where_they_are) {
  constexpr int kCells = 10;
  for (const Cut cut :
       oracles::trials<std::vector<Cut>>({Cut::in_five, Cut::in_six}, {Cut::in_six}))
    for (const RegionCase& region_case : region_cases(kCells)) {
      SCOPED_TRACE(region_case.name);
      TetraMesh mesh = mesh_of_regions(kCells, cut, region_case.region_of);
      expect_regions_kept(mesh, simplified(mesh, mesh.tetrahedra.size() / 4));
      std::ranges::fill(mesh.fields[0].values, 1);
      const HalfEdgeCollapses result = simplified(mesh);
      expect_regions_kept(mesh, result);
      expect_corners_kept(region_case, vertices_among(result.base), kCells + 1);
      EXPECT_LT(result.base.size(), region_case.most_cells);
      EXPECT_TRUE(make_hierarchy(mesh, result, {2}));
    }
}

/// Collapses edges of a labelled mesh in a random order, wherever its cells come to lie.
class Shuffle {
 public:
  explicit Shuffle(const TetraMesh& mesh)
      : n_(static_cast<std::uint32_t>(mesh.positions.size())), labels_(mesh.regions) {
    std::vector<Tetrahedron> closed = mesh.tetrahedra;
    EXPECT_TRUE(close_boundary(n_, closed, {1}));
    labels_.resize(closed.size(), kOutsideLabel);
    live_.emplace(n_, n_, std::move(closed));
    gatherer_.emplace(*live_);
  }

  void run(std::uint64_t seed) {
    Random random(seed);
    for (int n_idle = 0; n_idle < 20'000; ++n_idle) {
      const auto v = static_cast<std::uint32_t>(random.below(n_));
      if (!gatherer_->gather(v, star_) || !StarGatherer::is_manifold(star_)) continue;
      const auto kept = static_cast<int>(random.below(static_cast<std::uint64_t>(star_.n_link)));
      if (kept == star_.outside || !may_collapse(kept)) continue;
      live_->collapse(v, star_.link[static_cast<std::size_t>(kept)]);
      n_idle = 0;
    }
  }

  /// Returns what is left.
  test::Tetrahedra expect_regions_kept(const TetraMesh& mesh) const {
    test::Tetrahedra left;
    std::vector<std::uint32_t> regions;
    for (std::uint32_t slot = 0; slot < mesh.tetrahedra.size(); ++slot) {
      if (live_->is_gone(slot)) continue;
      left.push_back(live_->corners(slot));
      regions.push_back(labels_[slot]);
    }
    EXPECT_LT(left.size(), mesh.tetrahedra.size() / 2);
    constexpr double kAnything = 1e30;
    test::expect_same_regions(test::describe_regions(mesh, mesh.tetrahedra, mesh.regions),
                              test::describe_regions(mesh, left, regions), kAnything);
    return left;
  }

 private:
  void find(const Star& star, Interfaces& found) const {
    std::vector<std::uint32_t> labels;
    for (int i = 0; i < star.n_triangles; ++i)
      labels.push_back(labels_[star.slots[static_cast<std::size_t>(i)]]);
    find_interfaces(star, labels, found);
  }
  bool may_collapse(int kept) {
    find(star_, interfaces_);
    if (!goes_along(interfaces_, kept) || !gatherer_->may_collapse(star_, kept, Star::kMaxLink) ||
        !gatherer_->gather(star_.link[static_cast<std::size_t>(kept)], other_))
      return false;
    find(other_, other_interfaces_);
    return keeps_interfaces(star_, interfaces_, kept, other_, other_interfaces_);
  }

  std::uint32_t n_;
  std::vector<std::uint32_t> labels_;
  std::optional<LiveTetrahedra> live_;
  std::optional<StarGatherer> gatherer_;
  Star star_;
  Star other_;
  Interfaces interfaces_;
  Interfaces other_interfaces_;
};

TEST(regions, stay_what_they_are_by_what_links_have_in_common_alone) {
  constexpr int kCells = 8;
  for (const RegionCase& region_case : region_cases(kCells))
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      SCOPED_TRACE(region_case.name);
      const TetraMesh mesh = mesh_of_regions(kCells, Cut::in_six, region_case.region_of);
      Shuffle shuffle(mesh);
      shuffle.run(seed);
      const test::Tetrahedra left = shuffle.expect_regions_kept(mesh);
      expect_corners_kept(region_case, vertices_among(left), kCells + 1);
    }
}

TEST(regions, of_any_shape_stay) {
  // A region by tetrahedron: hardly anything may go, and nothing that must not.
  TetraMesh mesh = oracles::noise_mesh(6, Cut::in_five, 3);
  Random random(1);
  for (const double share : {0.02, 0.1, 0.5}) {
    mesh.regions.clear();
    mesh.region_ids = {0, 1, 2, 3};
    for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i)
      mesh.regions.push_back(
          random.uniform() < share ? 1 + static_cast<std::uint32_t>(random.below(3)) : 0);
    expect_regions_kept(mesh, simplified(mesh));
  }
}

TEST(regions, are_the_same_for_any_number_of_threads_and_one_is_none) {
  TetraMesh mesh = mesh_of_regions(
      24, Cut::in_five, [](int x, int y, int z) { return hash(3, x / 6, y / 6, z / 6) % 4; });
  const HalfEdgeCollapses one = simplified(mesh, 20'000, 1);
  const HalfEdgeCollapses three = simplified(mesh, 20'000, 3);
  EXPECT_EQ(one.base, three.base);
  EXPECT_EQ(one.base_regions, three.base_regions);
  EXPECT_LT(one.base.size(), 20'200U);
  std::ranges::fill(mesh.regions, 2U);
  const HalfEdgeCollapses alike = simplified(mesh, 20'000);
  mesh.regions.clear();
  mesh.region_ids.clear();
  EXPECT_EQ(alike.base, simplified(mesh, 20'000).base);
  EXPECT_TRUE(alike.base_regions.empty());
}

TEST(regions, are_by_tetrahedron_and_have_ids) {
  TetraMesh mesh = mesh_of_regions(2, Cut::in_five, [](int x, int, int) { return x == 0; });
  Progress progress;
  mesh.regions[7] = 2;
  auto result = collapse_half_edges(mesh, {}, progress);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().message, "tetrahedron 7: expected a region below 2, got 2");
  mesh.regions.resize(9);
  result = collapse_half_edges(mesh, {}, progress);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().message, "expected no regions or 40, got 9");
}

}  // namespace
}  // namespace lode::tetra_mt

#include "lode/mappers/collapse_undo.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <set>

#include "lode/mappers/collapse_proof.h"
#include "lode/mappers/surface_checks.h"
#include "tests/mappers/point_band.h"
#include "tests/mappers/shape_surfaces.h"

namespace lode::simplification {
namespace {

/// Collapses edges at random, wherever that is a homeomorphism, by looking at all triangles.
class RandomCollapses {
 public:
  /// `band`: no sample outside it is swept; or null.
  RandomCollapses(const Surface& surface, unsigned seed, const SurfaceBand* band = nullptr)
      : random_(seed), band_(band) {
    const std::size_t n = surface.positions.size();
    mesh.positions.resize(n);
    mesh.next_point.resize(n);
    mesh.attached_to.resize(n);
    mesh.last.resize(n);
    std::copy(surface.positions.begin(), surface.positions.end(), mesh.positions.begin());
    std::fill(mesh.last.begin(), mesh.last.end(), kNone);
    mesh.triangles.resize(surface.triangles.size());
    for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
      mesh.triangles[t] = {surface.triangles[t], kNone};
      for (const std::uint32_t v : surface.triangles[t]) attach(v, t);
    }
  }

  void run(int n_tries) {
    for (int i = 0; i < n_tries; ++i) {
      const WorkTriangle& t = mesh.triangles[random_() % mesh.triangles.size()];
      const auto k = random_() % 3;
      if (t.is_dead()) continue;
      const std::uint32_t kept = t.v[k];
      const std::uint32_t removed = t.v[(k + 1) % 3];
      if (may_collapse(kept, removed) && (band_ == nullptr || sweeps_nothing(kept, removed)))
        collapse(kept, removed);
    }
  }

  CollapseMesh mesh;

 private:
  void attach(std::uint32_t v, std::uint32_t t) {
    if (!attached_.insert(v).second) return;
    mesh.attached_to[v] = t;
    mesh.next_point[v] = mesh.triangles[t].points;
    mesh.triangles[t].points = v;
  }
  [[nodiscard]] static bool has(const WorkTriangle& t, std::uint32_t v) {
    return !t.is_dead() && (t.v[0] == v || t.v[1] == v || t.v[2] == v);
  }
  /// Of a vertex: its neighbours, and how many triangles each has with it.
  [[nodiscard]] std::multiset<std::uint32_t> link_of(std::uint32_t v) const {
    std::multiset<std::uint32_t> link;
    for (const WorkTriangle& t : mesh.triangles)
      if (has(t, v))
        for (const std::uint32_t x : t.v)
          if (x != v) link.insert(x);
    return link;
  }
  [[nodiscard]] bool may_collapse(std::uint32_t kept, std::uint32_t removed) const {
    const auto of_kept = link_of(kept);
    const auto of_removed = link_of(removed);
    const auto is_at_border = [](const std::multiset<std::uint32_t>& link) {
      return std::ranges::any_of(link, [&](std::uint32_t x) { return link.count(x) == 1; });
    };
    const std::size_t n_dead = of_kept.count(removed);
    if (n_dead == 2 && is_at_border(of_kept) && is_at_border(of_removed)) return false;
    if (of_kept.size() <= 6 || of_removed.size() <= 6) return false;  // not near a tetrahedron
    const std::set<std::uint32_t> all(of_removed.begin(), of_removed.end());
    const auto n_common = static_cast<std::size_t>(
        std::ranges::count_if(all, [&](std::uint32_t x) { return of_kept.count(x) > 0; }));
    return n_common == n_dead;
  }
  [[nodiscard]] bool sweeps_nothing(std::uint32_t kept, std::uint32_t removed) const {
    const auto place = [this](std::uint32_t v) { return widened(mesh.positions[v]); };
    const Vec3d to = widened(0.5F * (mesh.positions[kept] + mesh.positions[removed]));
    for (const WorkTriangle& t : mesh.triangles)
      for (std::size_t k = 0; k < 3 && !t.is_dead(); ++k) {
        const std::uint32_t x = t.v[(k + 1) % 3];
        const std::uint32_t y = t.v[(k + 2) % 3];
        const bool is_swept = t.v[k] == kept || (t.v[k] == removed && x != kept && y != kept);
        if (is_swept && band_->may_hold_fixed({place(t.v[k]), to, place(x), place(y)}))
          return false;
      }
    return true;
  }
  void collapse(std::uint32_t kept, std::uint32_t removed) {
    const auto number = static_cast<std::uint32_t>(mesh.collapses.size());
    Collapse c{.kept = kept,
               .removed = removed,
               .dead = {kNone, kNone},
               .kept_position = mesh.positions[kept].v,
               .last_kept = mesh.last[kept],
               .last_removed = mesh.last[removed]};
    std::vector<std::uint32_t> points;
    std::uint32_t home = kNone;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      WorkTriangle& triangle = mesh.triangles[t];
      if (!has(triangle, removed)) continue;
      if (has(triangle, kept)) {
        c.dead[c.dead[0] == kNone ? 0 : 1] = t;
        for (std::uint32_t p = triangle.points; p != kNone; p = mesh.next_point[p])
          points.push_back(p);
        triangle.points = kDead;
      } else {
        home = t;
        for (std::uint32_t& v : triangle.v)
          if (v == removed) v = kept;
      }
    }
    for (const std::uint32_t p : points) {
      mesh.attached_to[p] = home;
      mesh.next_point[p] = mesh.triangles[home].points;
      mesh.triangles[home].points = p;
    }
    mesh.positions[kept] = 0.5F * (mesh.positions[kept] + mesh.positions[removed]);
    mesh.last[kept] = mesh.last[removed] = number;
    mesh.collapses.resize(number + 1);
    mesh.collapses[number] = c;
  }

  std::mt19937 random_;
  const SurfaceBand* band_;
  std::set<std::uint32_t> attached_;
};

Surface live_surface(const CollapseMesh& mesh) {
  Surface surface;
  std::vector<std::uint32_t> number(mesh.positions.size(), kNone);
  for (const WorkTriangle& t : mesh.triangles) {
    if (t.is_dead()) continue;
    auto& corners = surface.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& n = number[t.v[k]];
      if (n == kNone) {
        n = static_cast<std::uint32_t>(surface.positions.size());
        surface.positions.push_back(mesh.positions[t.v[k]]);
      }
      corners[k] = n;
    }
  }
  return surface;
}

/// All of it is as the definition says: triangles are the original ones whose corners have gone
/// into three vertices, and each original vertex is attached to one of them.
void expect_consistent(const CollapseMesh& mesh, const Surface& original) {
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<std::uint32_t, 3> roots{};
    for (std::size_t k = 0; k < 3; ++k) roots[k] = mesh.root_of(original.triangles[t][k]);
    const bool is_there = roots[0] != roots[1] && roots[1] != roots[2] && roots[2] != roots[0];
    ASSERT_EQ(!mesh.triangles[t].is_dead(), is_there);
    if (is_there) {
      ASSERT_EQ(mesh.triangles[t].v, roots);
    }
  }
  std::vector<int> n_times(original.positions.size(), 0);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    if (!mesh.triangles[t].is_dead())
      for (std::uint32_t p = mesh.triangles[t].points; p != kNone; p = mesh.next_point[p]) {
        ++n_times[p];
        ASSERT_EQ(mesh.attached_to[p], t);
      }
  for (const int n : n_times) ASSERT_EQ(n, 1);
}

class CollapseUndoOrder : public testing::TestWithParam<std::tuple<UndoOrder, unsigned, int>> {
 protected:
  static Surface make(int shape) {
    if (shape == 0) return test::make_torus(20, 9, 5, 2);
    if (shape == 1) return test::make_sphere(8, 3, {{1, 2, 3}});
    return test::make_patch(
        11, [](std::uint32_t x, std::uint32_t y) { return 0.1 * ((12 * y + x) % 5); });
  }
};

INSTANTIATE_TEST_SUITE_P(all, CollapseUndoOrder,
                         testing::Combine(testing::Values(UndoOrder::splits, UndoOrder::stars),
                                          testing::Range(0U, 6U), testing::Range(0, 3)));

/// Some at random, and in the end all.
TEST_P(CollapseUndoOrder, leaves_a_manifold_and_in_the_end_the_original) {
  const auto [order, seed, shape] = GetParam();
  const Surface original = make(shape);
  const TopologyReport before = check_topology(original, {});
  RandomCollapses collapsed(original, seed);
  collapsed.run(3000);
  CollapseMesh& mesh = collapsed.mesh;
  const std::size_t n = mesh.collapses.size();
  ASSERT_GT(n, original.positions.size() / 2);
  expect_consistent(mesh, original);
  CollapseUndo stars(mesh, original, live_triangles(mesh, {1}), order, nullptr, 0);
  std::vector<std::uint32_t> in_turn(n);
  std::iota(in_turn.begin(), in_turn.end(), 0U);
  std::shuffle(in_turn.begin(), in_turn.end(), std::mt19937(seed + 100));
  std::size_t n_undone = 0;
  std::vector<std::uint32_t> changed;
  for (const std::uint32_t c : in_turn) {
    if (mesh.last[mesh.collapses[c].removed] != c) continue;  // another has taken it with it
    n_undone += stars.undo(c, changed);
    expect_consistent(mesh, original);
    const Surface surface = live_surface(mesh);
    ASSERT_TRUE(check_well_formed(surface));
    const TopologyReport after = check_topology(surface, {});
    ASSERT_TRUE(after.is_clean_manifold());
    ASSERT_EQ(after.euler_number, before.euler_number);
    ASSERT_EQ(after.components.size(), before.components.size());
  }
  EXPECT_EQ(n_undone, n);
  for (std::uint32_t t = 0; t < original.triangles.size(); ++t)
    EXPECT_EQ(mesh.triangles[t].v, original.triangles[t]);
  for (std::uint32_t v = 0; v < original.positions.size(); ++v)
    EXPECT_EQ(mesh.positions[v], original.positions[v]);
}

/// In any order, until it says that it is stuck.
TEST(collapse_undo, moves_no_sample_outside_the_band_to_another_side) {
  int n_stuck = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> shift(-0.6, 0.6);
    Surface original =
        seed % 2 == 0 ? test::make_sphere(8, 3, {{1, 2, 3}}) : test::make_torus(20, 9, 5, 2);
    for (Vec3f& p : original.positions)
      for (float& x : p.v) x += static_cast<float>(shift(random) / 3);
    std::vector<Vec3d> points(60);
    for (Vec3d& p : points) {
      p = widened(original.positions[random() % original.positions.size()]);
      for (double& x : p.v) x += shift(random);
    }
    const test::PointBand band(points, 0);
    RandomCollapses collapsed(original, seed, &band);
    collapsed.run(2000);
    CollapseMesh& mesh = collapsed.mesh;
    std::vector<std::uint32_t> in_turn(mesh.collapses.size());
    std::iota(in_turn.begin(), in_turn.end(), 0U);
    std::shuffle(in_turn.begin(), in_turn.end(), random);
    CollapseUndo stars(mesh, original, live_triangles(mesh, {1}), UndoOrder::splits, &band, 0);
    std::vector<std::uint32_t> changed;
    for (const std::uint32_t c : in_turn) {
      if (mesh.last[mesh.collapses[c].removed] == c) stars.undo(c, changed);
      if (stars.is_stuck()) break;
    }
    n_stuck += stars.is_stuck() ? 1 : 0;
    const Surface surface = live_surface(mesh);
    for (const Vec3d& p : points) ASSERT_EQ(test::winding(surface, p), test::winding(original, p));
  }
  EXPECT_GT(n_stuck, 0);
  EXPECT_LT(n_stuck, 30);
}

/// Stars reach far; a vertex is split with few others.
TEST(collapse_undo, takes_little_along_to_split_a_vertex) {
  const Surface original = test::make_torus(60, 24, 9, 3);
  std::array<std::size_t, 2> n_undone{};
  for (const UndoOrder order : {UndoOrder::splits, UndoOrder::stars})
    for (unsigned seed = 0; seed < 3; ++seed) {
      RandomCollapses collapsed(original, seed);
      collapsed.run(20'000);
      CollapseUndo stars(collapsed.mesh, original, live_triangles(collapsed.mesh, {1}), order,
                         nullptr, 0);
      std::vector<std::uint32_t> changed;
      n_undone[order == UndoOrder::splits ? 0 : 1] +=
          stars.undo(static_cast<std::uint32_t>(collapsed.mesh.collapses.size() / 2), changed);
    }
  EXPECT_LT(10 * n_undone[0], n_undone[1]);
}

/// Points stay attached to what they were near, which is not near enough: those of original
/// triangles that are back, too.
TEST(collapse_undo, all_goes_back_where_nothing_is_near_enough) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    const Surface original = test::make_sphere(9, 4, {{1, 2, 3}});
    RandomCollapses collapsed(original, seed);
    collapsed.run(2000);
    CollapseMesh& mesh = collapsed.mesh;
    std::vector<std::uint32_t> live = live_triangles(mesh, {1});
    CollapseUndo stars(mesh, original, live, UndoOrder::splits, nullptr, 1e6F);
    const SimplifyOptions options{.max_distance = 1e-4, .threads = {1}};
    Progress progress;
    CollapseProof proof(original, mesh, stars, options, 3, 0, progress);
    std::vector<std::uint32_t> changed;
    for (const std::uint32_t t : live)
      if (stars.maker(t) != kNone) changed.push_back(t);
    while (!changed.empty()) {
      const auto bad = proof.find_bad(live, changed);
      ASSERT_TRUE(bad);
      changed.clear();
      for (const std::uint32_t c : *bad) {
        ASSERT_LT(c, mesh.collapses.size());
        if (mesh.last[mesh.collapses[c].removed] == c) stars.undo(c, changed);
      }
      sort_unique(changed);
      live = live_triangles(mesh, {1});
    }
    for (std::uint32_t t = 0; t < original.triangles.size(); ++t)
      ASSERT_EQ(mesh.triangles[t].v, original.triangles[t]);
  }
}

}  // namespace
}  // namespace lode::simplification

// What verification finds of hierarchies that are right, and of such that were tampered with.

#include "lode/api/tetra_verification.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "lode/api/files.h"
#include "lode/models/tetra_mt/random_cut.h"
#include "lode/models/tetra_mt/structure_check.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/trials.h"

namespace lode {
namespace {

using tetra_mt::Hierarchy;
using tetra_mt::PackedHierarchy;

/// Noise in a cube with a cavity.
TetraMesh holed_noise(int n) {
  TetraMesh mesh = oracles::noise_mesh(n, oracles::Cut::in_five, 21);
  std::erase_if(mesh.tetrahedra, [&](const auto& t) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    return length(centre - Vec3d{{0.5, 0.5, 0.4}}) < 0.2;
  });
  return mesh;
}

Hierarchy hierarchy_of(const TetraMesh& mesh) {
  Progress progress;
  const auto collapses = tetra_mt::collapse_half_edges(
      mesh, {.base_cells = 100, .rules = {}, .threads = {2}}, progress);
  EXPECT_TRUE(collapses);
  auto hierarchy = tetra_mt::make_hierarchy(mesh, *collapses, {2});
  EXPECT_TRUE(hierarchy);
  return std::move(*hierarchy);
}

/// Names of the checks that a hierarchy of a mesh does not pass.
std::vector<std::string> failed_checks(const Hierarchy& hierarchy, const TetraMesh& mesh) {
  const auto packed = PackedHierarchy::pack(hierarchy, mesh.tetrahedra.size(), {2});
  Progress progress;
  const auto report =
      verify_hierarchy(*source_of(packed), {.n_random_cuts = 4, .threads = {2}}, progress);
  EXPECT_TRUE(report) << report.error().message;
  std::vector<std::string> names;
  for (const VerifyReport::Check& check : report->checks)
    if (!check.passed) names.push_back(check.name);
  return names;
}

class tetra_verification : public testing::Test {
 protected:
  /// Names of what fails after a change.
  [[nodiscard]] std::vector<std::string> failures(
      const std::function<void(Hierarchy&)>& change) const {
    Hierarchy hierarchy = hierarchy_;
    change(hierarchy);
    return failed_checks(hierarchy, mesh_);
  }
  static bool has(const std::vector<std::string>& names, const std::string& name) {
    return std::ranges::find(names, name) != names.end();
  }

  TetraMesh mesh_ = holed_noise(11);
  Hierarchy hierarchy_ = hierarchy_of(mesh_);
};

TEST_F(tetra_verification, finds_nothing_wrong_with_what_was_built) {
  const auto packed = PackedHierarchy::pack(hierarchy_, mesh_.tetrahedra.size(), {2});
  Progress progress;
  const auto report = verify_hierarchy(*source_of(packed), {.threads = {2}}, progress);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->checks.size(), 19U);
  for (const VerifyReport::Check& check : report->checks) {
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
    EXPECT_GT(check.count, 0U) << check.name;
  }
  // The same for any number of threads.
  const auto other = verify_hierarchy(*source_of(packed), {.threads = {1}}, progress);
  for (std::size_t i = 0; i < report->checks.size(); ++i)
    EXPECT_EQ(other->checks[i].detail, report->checks[i].detail);
}

TEST_F(tetra_verification, finds_errors_that_are_stated_too_small) {
  EXPECT_EQ(
      failures([](Hierarchy& h) {
        for (StoredFacts& facts : h.facts) facts.error *= 0.9F;
      }),
      (std::vector<std::string>{"errors at vertices <= stored errors", "errors of the base",
                                "errors at 0.3 of the base's", "errors at 0.1 of the base's",
                                "errors at 0.03 of the base's", "errors at 0.01 of the base's"}));
}

/// Noise in a ball, with a hierarchy whose boundary may move.
struct MovingBall {
  TetraMesh mesh;
  Hierarchy hierarchy;

  explicit MovingBall(double tolerance) : mesh(oracles::noise_mesh(10, oracles::Cut::in_six, 7)) {
    for (Vec3d& p : mesh.positions) {
      const Vec3d d = p - Vec3d{{0.5, 0.5, 0.5}};
      const double most = std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])});
      p = most > 0 ? d * (most / length(d)) : d;
    }
    tetra_mt::CollapseRules rules;
    rules.boundary_tolerance = tolerance;
    Progress progress;
    const auto collapses = tetra_mt::collapse_half_edges(
        mesh, {.base_cells = 200, .rules = rules, .threads = {2}}, progress);
    EXPECT_TRUE(collapses);
    auto made = tetra_mt::make_hierarchy(mesh, *collapses, {2});
    EXPECT_TRUE(made);
    hierarchy = std::move(*made);
  }
  /// Of its checks, after errors and the boundary's deviation were multiplied.
  [[nodiscard]] std::vector<std::string> failures(double errors, double deviation) const {
    Hierarchy changed = hierarchy;
    for (StoredFacts& facts : changed.facts) facts.error *= static_cast<float>(errors);
    changed.boundary_deviation *= deviation;
    return failed_checks(changed, mesh);
  }
};

TEST(tetra_verification_of_moving_boundaries, excuses_no_errors_that_are_stated_too_small) {
  for (const double tolerance : oracles::trials<std::vector<double>>({0.004, 0.03, 0.1}, {0.03})) {
    const MovingBall ball(tolerance);
    ASSERT_GT(ball.hierarchy.boundary_deviation, 0);
    EXPECT_EQ(ball.failures(1, 1), std::vector<std::string>()) << tolerance;
    // A deviation that is more than the boundary's is true, too, but must not help either.
    for (const double deviation : {1.0, 1e9})
      for (const double share : {0.9, 0.5, 0.0}) {
        const auto names = ball.failures(share, deviation);
        EXPECT_TRUE(std::ranges::find(names, "errors at vertices <= stored errors") != names.end())
            << tolerance << ", " << deviation << ", " << share;
      }
    const auto names = ball.failures(1, 0.1);
    EXPECT_TRUE(std::ranges::find(names, "boundary of random cuts where it was") != names.end())
        << tolerance;
  }
}

/// A cube turned, with a linear field: floats put vertices of its flat boundary beside each other's
/// planes, where F' is continued from the cells, by which nothing is off.
TEST(tetra_verification_of_oblique_boundaries, allows_what_rounding_to_floats_leaves_outside) {
  for (const double angle : {0.3, 0.7, 1.1}) {
    TetraMesh mesh = oracles::noise_mesh(5, oracles::Cut::in_six, 3);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      Vec3d& p = mesh.positions[v];
      const Vec3d turned{{std::cos(angle) * p[0] - std::sin(angle) * p[1],
                          std::sin(angle) * p[0] + std::cos(angle) * p[1], p[2]}};
      p = {{turned[0], std::cos(angle) * turned[1] - std::sin(angle) * turned[2],
            std::sin(angle) * turned[1] + std::cos(angle) * turned[2]}};
      for (std::size_t k = 0; k < 3; ++k) p[k] = static_cast<float>(p[k]);
      mesh.fields[0].values[v] = dot(p, Vec3d{{1, 2, 3}});
    }
    const Hierarchy hierarchy = hierarchy_of(mesh);
    EXPECT_LT(hierarchy.base.size(), mesh.tetrahedra.size() / 2);
    EXPECT_EQ(failed_checks(hierarchy, mesh), std::vector<std::string>()) << angle;
  }
}

TEST_F(tetra_verification, finds_ranges_that_are_stated_too_narrow_and_facts_that_are_not_nested) {
  EXPECT_TRUE(has(failures([](Hierarchy& h) {
                    for (StoredFacts& facts : h.facts)
                      facts.high = facts.low + (facts.high - facts.low) * 0.4F;
                  }),
                  "values of vertices in stored ranges"));
  EXPECT_TRUE(has(failures([](Hierarchy& h) {
                    for (std::uint32_t node = 0; node < h.n_nodes(); ++node)
                      if (h.parents_of(node).empty()) h.facts[node].error = 0;
                  }),
                  "stored values nested"));
}

TEST_F(tetra_verification, finds_vertices_that_were_moved) {
  // Of a node's vertex in the middle of faces of the boundary, and of one inside.
  for (const bool is_at_boundary : {true, false}) {
    const auto found = failures([&](Hierarchy& h) {
      for (std::uint32_t v = h.n_base_vertices; v < h.positions.size(); ++v) {
        Vec3d& p = h.positions[v];
        const bool is_on_top = p[2] == 1 && p[0] > 0.2 && p[0] < 0.8 && p[1] > 0.2 && p[1] < 0.8;
        const bool is_inside =
            p[2] > 0.7 && p[2] < 0.9 && p[0] > 0.1 && p[0] < 0.9 && p[1] > 0.1 && p[1] < 0.9;
        if (is_at_boundary ? !is_on_top : !is_inside) continue;
        if (is_at_boundary)
          p[2] = 0.99;
        else
          p = p + Vec3d{{0.25, 0, 0}};
        return;
      }
    });
    EXPECT_TRUE(has(found, is_at_boundary ? "boundary of random cuts where it was"
                                          : "no cell of random cuts is flat or turned round"));
    EXPECT_EQ(has(found, "volume of random cuts"), is_at_boundary);
  }
}

TEST_F(tetra_verification, finds_links_that_do_not_fit_together) {
  const auto with_parents = [](const Hierarchy& h) {
    std::uint32_t node = 0;
    while (h.parents_of(node).size() < 2) ++node;
    return node;
  };
  // A parent that does not know of it.
  EXPECT_EQ(failures([&](Hierarchy& h) {
              std::uint32_t& parent = h.parents[h.parent_begins[with_parents(h)]];
              parent = parent == 0 ? 1 : parent - 1;
            }),
            (std::vector<std::string>{"parents and children name each other"}));
  // A discoverer that is no parent: nothing discovers it.
  EXPECT_TRUE(has(failures([&](Hierarchy& h) { h.discoverers[with_parents(h)] = tetra_mt::kNone; }),
                  "nodes discovered once, from the roots"));
  // A target with no tetrahedron of the node.
  EXPECT_EQ(failures([&](Hierarchy& h) {
              std::uint32_t& target = h.targets[with_parents(h)];
              target = target == 0 ? 1 : 0;
            }),
            (std::vector<std::string>{"nodes apply and undo in any order"}));
}

TEST_F(tetra_verification, finds_tetrahedra_of_other_makers) {
  const auto found = failures([](Hierarchy& h) {
    for (std::uint32_t node = 0; node < h.n_nodes(); ++node) {
      if (h.children_of(node).size() < 2) continue;
      for (std::uint64_t i = h.maker_begins[node]; i < h.maker_begins[node + 1]; ++i)
        h.makers[i] = h.makers[i] == 0 ? 1 : h.makers[i];
    }
  });
  EXPECT_TRUE(has(found, "nodes apply and undo in any order"));
}

TEST_F(tetra_verification, compares_with_the_original_bit_for_bit) {
  const auto packed = PackedHierarchy::pack(hierarchy_, mesh_.tetrahedra.size(), {2});
  Progress progress;
  const auto found = [&](const TetraMesh& original) {
    const auto report =
        compare_with_original(*source_of(packed), original, std::array<std::size_t, 1>{}, progress);
    EXPECT_TRUE(report);
    std::string details;
    for (const VerifyReport::Check& check : report->checks) details += check.detail;
    return details;
  };
  // In another order, and each cell from another corner on.
  TetraMesh same = mesh_;
  std::ranges::reverse(same.tetrahedra);
  for (auto& t : same.tetrahedra) t = {t[1], t[2], t[0], t[3]};
  EXPECT_EQ(found(same), "");
  TetraMesh other = mesh_;
  other.fields[0].values[7] *= 1 + 0x1p-52;
  EXPECT_NE(found(other), "");
  other = mesh_;
  other.positions[7][1] += 0x1p-20;
  EXPECT_NE(found(other), "");
  other = mesh_;
  std::swap(other.tetrahedra[3][0], other.tetrahedra[3][1]);
  EXPECT_NE(found(other), "");
  other = mesh_;
  other.tetrahedra.pop_back();
  EXPECT_NE(found(other), "");
}

/// Of the check of that name; empty where there is none.
std::string detail_of(const VerifyReport& report, const std::string& name) {
  const auto at = std::ranges::find(report.checks, name, &VerifyReport::Check::name);
  return at == report.checks.end() ? std::string() : at->detail;
}

TEST_F(tetra_verification, says_that_no_sheets_of_the_boundary_meet) {
  const auto packed = PackedHierarchy::pack(hierarchy_, mesh_.tetrahedra.size(), {2});
  Progress progress;
  const auto report = verify_hierarchy(*source_of(packed), {.threads = {2}}, progress);
  ASSERT_TRUE(report);
  EXPECT_EQ(detail_of(*report, "sheets of the boundary that meet"), "none");
}

/// Two sheets that touch, not joined, as the mesh has them: right, as they were read.
TEST_F(tetra_verification, takes_seams_of_the_reference_for_right) {
  TetraMesh mesh = oracles::noise_mesh(9, oracles::Cut::in_six, 4);
  // Vertices in the middle plane twice, for cells on its two sides.
  std::vector<std::uint32_t> twins(mesh.positions.size());
  const std::size_t n = mesh.positions.size();
  for (std::uint32_t v = 0; v < n; ++v) {
    twins[v] = v;
    if (mesh.positions[v][0] != 0.5) continue;
    twins[v] = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back(Vec3d(mesh.positions[v]));
    mesh.fields[0].values.push_back(mesh.fields[0].values[v] + (v % 3 == 0 ? 0.1 : 0));
  }
  for (auto& t : mesh.tetrahedra) {
    const bool is_right =
        std::ranges::all_of(t, [&](std::uint32_t v) { return mesh.positions[v][0] >= 0.5; });
    if (is_right)
      for (std::uint32_t& v : t) v = twins[v];
  }
  const auto packed = PackedHierarchy::pack(hierarchy_of(mesh), mesh.tetrahedra.size(), {2});
  Progress progress;
  const auto report = verify_hierarchy(*source_of(packed), {.threads = {2}}, progress);
  ASSERT_TRUE(report);
  for (const VerifyReport::Check& check : report->checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
  // The planes' halves lie on one another, and the report says so under a name that is true.
  EXPECT_NE(detail_of(*report, "sheets of the boundary that meet")
                .find("pairs of outer faces in the reference, up to "),
            std::string::npos);
  const auto compared =
      compare_with_original(*source_of(packed), mesh, std::array<std::size_t, 1>{}, progress);
  ASSERT_TRUE(compared);
  EXPECT_TRUE(compared->passed());
}

TEST_F(tetra_verification, of_files_reads_every_byte) {
  const std::string path = fmt::format("{}lode_tetra_verify_{}.lode", testing::TempDir(), getpid());
  Progress progress;
  ASSERT_TRUE(TetraDataset::build_file(mesh_, path, {.threads = {2}}, progress));
  EXPECT_TRUE(holds_tetrahedra(path));
  EXPECT_TRUE(verify_every_byte(path, {2}, progress)->passed());
  const auto opened = TetraDataset::open(path);
  ASSERT_TRUE(opened);
  EXPECT_TRUE(opened->verify({.n_random_cuts = 2, .threads = {2}}, progress)->passed());
  EXPECT_TRUE(opened->verify_against(mesh_, std::array<std::size_t, 1>{}, progress)->passed());
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(std::filesystem::file_size(path) * 2 / 3));
  file.put('?').put('?');
  file.close();
  const auto broken = verify_every_byte(path, {2}, progress);
  ASSERT_FALSE(broken);
  EXPECT_NE(broken.error().message.find(path), std::string::npos);
  std::filesystem::remove(path);
}

TEST_F(tetra_verification, can_be_stopped) {
  const auto packed = PackedHierarchy::pack(hierarchy_, mesh_.tetrahedra.size(), {2});
  Progress progress;
  progress.cancel();
  EXPECT_FALSE(verify_hierarchy(*source_of(packed), {}, progress));
  EXPECT_FALSE(
      compare_with_original(*source_of(packed), mesh_, std::array<std::size_t, 1>{}, progress));
}

}  // namespace
}  // namespace lode

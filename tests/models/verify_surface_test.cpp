// What is wrong with a surface is found, and the first of it named.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "lode/api/dataset.h"
#include "tests/oracles/random.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

Dataset ball() {
  RegularGrid grid;
  grid.dims = {{21, 20, 19}};
  const Volume volume = oracles::volume_of<float>(
      grid, [](const Index3& p) { return std::hypot(p[0] - 10.2, p[1] - 9.3, p[2] - 9.1); });
  Progress progress;
  return Dataset::build(*make_memory_source(volume), {.threads = {2}}, progress).value();
}

/// The checks of a ball's surface that fail once `spoil` has been at it.
std::vector<VerifyReport::Check> failures_of(const std::function<void(Surface&)>& spoil) {
  static const Dataset kBall = ball();
  const ExtractOptions options{.isovalues = {6.5}, .max_error = 0.1, .threads = {2}};
  Progress progress;
  Surface surface;
  EXPECT_TRUE(kBall.extract(options, surface, progress));
  spoil(surface);
  const auto report = kBall.verify_surface(surface, options, progress);
  EXPECT_TRUE(report);
  std::vector<VerifyReport::Check> failed;
  for (const auto& check : report->checks)
    if (!check.passed) failed.push_back(check);
  return failed;
}

/// A check of this name fails, and its detail holds these words.
void expect_failure(const std::vector<VerifyReport::Check>& failed, const std::string& name,
                    const std::vector<std::string>& words) {
  for (const auto& check : failed) {
    if (check.name.find(name) == std::string::npos) continue;
    for (const std::string& word : words)
      EXPECT_NE(check.detail.find(word), std::string::npos) << check.name << ": " << check.detail;
    return;
  }
  ADD_FAILURE() << "no failure of: " << name;
}

TEST(verify_surface, a_whole_surface_passes) {
  EXPECT_TRUE(failures_of([](Surface&) {}).empty());
}

TEST(verify_surface, a_missing_triangle_leaves_a_gap) {
  const auto failed = failures_of([](Surface& s) { s.triangles.erase(s.triangles.begin() + 4); });
  expect_failure(failed, "ends only at", {"3 stray edges", "the edge from vertex", " at ("});
  expect_failure(failed, "complete", {"1 cells missing", "the query's triangle 4 at ("});
}

TEST(verify_surface, an_empty_surface_is_missed) {
  const auto failed = failures_of([](Surface& s) { s.clear(); });
  ASSERT_EQ(failed.size(), 1U);
  expect_failure(failed, "complete", {"cells missing", "the query's triangle 0"});
}

TEST(verify_surface, a_triangle_turned_round_is_inconsistent) {
  const auto failed =
      failures_of([](Surface& s) { std::swap(s.triangles[7][0], s.triangles[7][1]); });
  expect_failure(failed, "consistent orientation", {"3 bad", "the edge from vertex"});
  expect_failure(failed, "complete", {"1 cells turned", "triangle 7 at ("});
}

TEST(verify_surface, a_surface_turned_as_a_whole_is_not_the_query_s) {
  const auto failed = failures_of([](Surface& s) {
    for (auto& t : s.triangles) std::swap(t[0], t[1]);
  });
  ASSERT_EQ(failed.size(), 1U);
  expect_failure(failed, "complete", {"cells turned", "triangle 0 at ("});
}

TEST(verify_surface, a_triangle_twice_makes_edges_of_three) {
  const auto failed = failures_of([](Surface& s) { s.triangles.push_back(s.triangles[5]); });
  expect_failure(failed, "manifold edges", {"3 bad", "the edge from vertex"});
  expect_failure(failed, "no self-intersection", {"first: triangle 5 at (", " and triangle "});
  expect_failure(failed, "complete", {"1 cells that the query does not make"});
}

TEST(verify_surface, a_moved_vertex_is_beyond_the_tolerance) {
  const auto failed = failures_of([](Surface& s) { s.positions[11][0] += 0.8F; });
  expect_failure(failed, "|F - isovalue|", {"largest 0.", " of 0.1 + ", "at (", "in triangle"});
}

TEST(verify_surface, a_vertex_outside_the_volume_is_named) {
  const auto failed = failures_of([](Surface& s) { s.positions[11][0] = 30; });
  expect_failure(failed, "|F - isovalue|", {"outside the volume", "first: triangle"});
}

TEST(verify_surface, without_holes_there_are_no_twins) {
  const auto failed = failures_of([](Surface& s) {
    const std::uint32_t v = s.triangles[3][0];
    const auto twin = static_cast<std::uint32_t>(s.positions.size());
    s.positions.push_back(s.positions[v]);
    if (!s.normals.empty()) s.normals.push_back(s.normals[v]);
    s.triangles[3][0] = twin;
  });
  expect_failure(failed, "no duplicate vertex", {"1 duplicates", "first: vertices", " at ("});
}

TEST(verify_surface, vertices_and_triangles_of_no_use_are_named) {
  const auto unused = failures_of([](Surface& s) {
    s.positions.push_back({{1, 2, 3}});
    if (!s.normals.empty()) s.normals.push_back(s.normals[0]);
  });
  ASSERT_EQ(unused.size(), 1U);
  expect_failure(unused, "no unused vertex", {"1 bad", "vertex", "at (1, 2, 3)"});
  const auto flat = failures_of([](Surface& s) { s.triangles[2][1] = s.triangles[2][0]; });
  expect_failure(flat, "no degenerate cell", {"1 bad; first: triangle 2 at ("});
}

}  // namespace
}  // namespace lode

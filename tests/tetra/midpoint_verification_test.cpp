// What verification finds of hierarchies of midpoints that are right, and of such that were
// tampered with; and probing, held against half edges.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "lode/api/tetra_verification.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/tetra/midpoint_fixtures.h"

namespace lode {
namespace {

using tetra_mt::midpoint::Forest;
using tetra_mt::midpoint::ForestField;
using tetra_mt::midpoint::NodeCodes;
using MidpointHierarchy = tetra_mt::midpoint::Hierarchy;

/// Noise in a cube with a cavity; points in it are of no cell.
TetraMesh noise_round_a_cavity() {
  TetraMesh mesh = oracles::noise_mesh(11, oracles::Cut::in_five, 21);
  std::erase_if(mesh.tetrahedra, [&](const auto& t) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    return length(centre - Vec3d{{0.5, 0.5, 0.4}}) < 0.2;
  });
  return mesh;
}

class midpoint_verification : public testing::Test {
 protected:
  [[nodiscard]] VerifyReport verified(const MidpointHierarchy& hierarchy) const {
    const Forest forest(hierarchy);
    Progress progress;
    const auto report = verify_hierarchy(*source_of(forest), {.threads = {2}}, progress);
    EXPECT_TRUE(report) << report.error().message;
    return report ? *report : VerifyReport{};
  }
  /// Names of what fails after a change.
  [[nodiscard]] std::vector<std::string> failures(
      const std::function<void(MidpointHierarchy&)>& change) const {
    MidpointHierarchy hierarchy = hierarchy_;
    change(hierarchy);
    std::vector<std::string> names;
    for (const VerifyReport::Check& check : verified(hierarchy).checks)
      if (!check.passed) names.push_back(check.name);
    return names;
  }
  static bool has(const std::vector<std::string>& names, const std::string& name) {
    return std::ranges::find(names, name) != names.end();
  }

  TetraMesh mesh_ = noise_round_a_cavity();
  MidpointHierarchy hierarchy_ = test::midpoints_of(mesh_, 150);
};

TEST_F(midpoint_verification, finds_nothing_wrong_with_what_was_built) {
  const VerifyReport report = verified(hierarchy_);
  EXPECT_EQ(report.checks.size(), 19U);
  for (const VerifyReport::Check& check : report.checks) {
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
    EXPECT_GT(check.count, 0U) << check.name;
  }
  const Forest forest(hierarchy_);
  Progress progress;
  const auto compared =
      compare_with_original(*source_of(forest), mesh_, std::array<std::size_t, 1>{}, progress);
  ASSERT_TRUE(compared) << compared.error().message;
  EXPECT_TRUE(compared->passed());
}

TetraMesh noise_in_a_ball() {
  TetraMesh mesh = oracles::noise_mesh(10, oracles::Cut::in_six, 7);
  for (Vec3d& p : mesh.positions) {
    const Vec3d d = p - Vec3d{{0.5, 0.5, 0.5}};
    const double most = std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])});
    p = most > 0 ? d * (most / length(d)) : d;
  }
  return mesh;
}

TEST_F(midpoint_verification, allows_what_is_said_of_a_moving_boundary_and_no_more) {
  const TetraMesh mesh = noise_in_a_ball();
  Progress progress;
  const auto collapses = tetra_mt::midpoint::collapse_edges(
      mesh, {.boundary_tolerance = 0.03, .threads = {2}}, progress);
  ASSERT_TRUE(collapses) << collapses.error().message;
  auto hierarchy = tetra_mt::midpoint::make_hierarchy(mesh, *collapses, {2});
  ASSERT_TRUE(hierarchy) << hierarchy.error().message;
  EXPECT_GT(hierarchy->boundary_deviation, 0.005);
  for (const VerifyReport::Check& check : verified(*hierarchy).checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
  hierarchy->boundary_deviation *= 0.05;
  std::vector<std::string> failed;
  for (const VerifyReport::Check& check : verified(*hierarchy).checks)
    if (!check.passed) failed.push_back(check.name);
  EXPECT_TRUE(has(failed, "boundary of random cuts where it was"));
}

TEST_F(midpoint_verification, looks_at_all_fields) {
  const TetraMesh mesh = test::with_fields(mesh_);
  MidpointHierarchy hierarchy = test::midpoints_of(mesh, 150);
  /// Fields that some check says is wrong.
  const auto wrong = [&] {
    const VerifyReport report = verified(hierarchy);
    std::vector<std::string> names;
    for (const MeshField& field : mesh.fields) {
      std::size_t n = 0;
      bool is_wrong = false;
      for (const VerifyReport::Check& check : report.checks) {
        if (!check.name.ends_with(": " + field.name)) continue;
        ++n;
        is_wrong = is_wrong || !check.passed;
      }
      EXPECT_EQ(n, 8U) << field.name;
      if (is_wrong) names.push_back(field.name);
    }
    return names;
  };
  EXPECT_EQ(wrong(), std::vector<std::string>{});
  const Forest forest(hierarchy);
  Progress progress;
  const std::array<std::size_t, 5> all{0, 1, 2, 3, 4};
  EXPECT_TRUE(compare_with_original(*source_of(forest), mesh, all, progress)->passed());
  TetraMesh other = mesh;
  other.fields[3].values[mesh_.tetrahedra[100][2]] += 1e-6;
  EXPECT_FALSE(compare_with_original(*source_of(forest), other, all, progress)->passed());
  // Of one alone what is stated is too small.
  for (auto& record : hierarchy.further[0].nodes) {
    NodeCodes::Parts parts = NodeCodes::parts(record.facts());
    parts.error -= std::min(parts.error, 8U);
    record = {record.difference, NodeCodes::word(parts), record.place()};
  }
  EXPECT_EQ(wrong(), std::vector<std::string>{"waves"});
}

TEST_F(midpoint_verification, finds_what_is_stated_too_small) {
  const auto lowered = failures([](MidpointHierarchy& h) {
    const auto lower = [](std::uint32_t word) {
      NodeCodes::Parts parts = NodeCodes::parts(word);
      parts.error -= std::min(parts.error, 8U);
      return NodeCodes::word(parts);
    };
    for (auto& node : h.nodes) node.facts = lower(node.facts);
    for (std::uint32_t& word : h.root_facts) word = lower(word);
  });
  EXPECT_TRUE(has(lowered, "errors at vertices <= stored errors"));
  EXPECT_TRUE(has(lowered, "errors of the base"));
  EXPECT_FALSE(has(lowered, "stored values nested"));
  const auto narrowed = failures([](MidpointHierarchy& h) {
    for (auto& node : h.nodes) {
      NodeCodes::Parts parts = NodeCodes::parts(node.facts);
      parts.high = parts.low;
      node.facts = NodeCodes::word(parts);
    }
  });
  EXPECT_TRUE(has(narrowed, "values of vertices in stored ranges"));
  const auto shrunk = failures([](MidpointHierarchy& h) {
    NodeCodes::Parts parts = NodeCodes::parts(h.nodes.back().facts);
    parts.radius = 1;
    h.nodes.back().facts = NodeCodes::word(parts);
  });
  EXPECT_EQ(shrunk, (std::vector<std::string>{"stored values nested"}));
}

/// Queries look at what balls hold alone: one that is too small makes answers wrong in silence.
TEST_F(midpoint_verification, finds_balls_that_hold_less_than_their_nodes_change) {
  const auto failed = failures([](MidpointHierarchy& h) {
    // The last to be split: nothing is nested in it.
    NodeCodes::Parts parts = NodeCodes::parts(h.nodes.front().facts);
    parts.radius = 0;
    h.nodes.front().facts = NodeCodes::word(parts);
  });
  EXPECT_EQ(failed, (std::vector<std::string>{"nodes apply and undo in any order"}));
}

TEST_F(midpoint_verification, takes_no_size_from_what_a_file_says_of_its_box) {
  const auto widened = failures([](MidpointHierarchy& h) { h.box.upper = h.box.upper * 1e9; });
  EXPECT_EQ(widened, (std::vector<std::string>{"the box that is stated is that of the vertices"}));
  const auto closed = failures([](MidpointHierarchy& h) { h.box.upper = h.box.lower; });
  EXPECT_TRUE(has(closed, "the box that is stated is that of the vertices"));
}

TEST_F(midpoint_verification, finds_a_range_that_is_wider_than_the_values) {
  const std::vector<std::string> expected{"the range that is stated is that of the values"};
  const auto with_knots = [](NodeCodes::Knots knots, ForestField& field) {
    field.codes = NodeCodes(knots, field.codes.largest_error());
  };
  EXPECT_EQ(failures([&](MidpointHierarchy& h) {
              ForestField& field = h.fields.front();
              NodeCodes::Knots knots{};
              std::ranges::copy(field.codes.knots(), knots.begin());
              field.high = knots.back() = std::nextafter(field.high, 10.0);
              with_knots(knots, field);
            }),
            expected);
  EXPECT_EQ(failures([&](MidpointHierarchy& h) {
              ForestField& field = h.fields.front();
              NodeCodes::Knots knots{};
              std::ranges::copy(field.codes.knots(), knots.begin());
              field.low = knots.front() = field.low - 1;
              with_knots(knots, field);
            }),
            expected);
}

TEST_F(midpoint_verification, finds_vertices_that_are_elsewhere_and_masks_that_are_wrong) {
  const auto moved = failures([](MidpointHierarchy& h) {
    for (std::size_t i = 0; i < h.nodes.size(); i += 50) h.nodes[i].difference[0] += 1 << 27;
  });
  EXPECT_FALSE(moved.empty());
  EXPECT_EQ(failures([](MidpointHierarchy& h) {
              for (std::size_t i = 0; i < h.nodes.size(); i += 9) h.nodes[i].mask[0] ^= 5;
            }),
            (std::vector<std::string>{"nodes apply and undo in any order"}));
  EXPECT_FALSE(
      failures([](MidpointHierarchy& h) { h.wide[h.deep[7]] = h.wide[h.deep[8]]; }).empty());
  const Forest forest(hierarchy_);
  TetraMesh other = mesh_;
  other.fields[0].values[other.tetrahedra[100][2]] += 1e-9;
  Progress progress;
  const auto compared =
      compare_with_original(*source_of(forest), other, std::array<std::size_t, 1>{}, progress);
  ASSERT_TRUE(compared);
  EXPECT_FALSE(compared->passed());
}

/// Full resolution is the same mesh however it is refined; coarser answers have true bounds.
TEST_F(midpoint_verification, probing_has_the_values_of_half_edges_and_true_bounds) {
  Progress progress;
  auto half = TetraDataset::build(mesh_, {.base_share = 0.02, .threads = {2}}, progress);
  auto middle = TetraDataset::build(
      mesh_, {.base_share = 0.02, .placement = Placement::midpoint, .threads = {2}}, progress);
  ASSERT_TRUE(half && middle);
  oracles::Random random(4);
  std::vector<Vec3d> points;
  for (int i = 0; i < 300; ++i)
    points.push_back({{random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)}});
  std::vector<ProbedPoint> expected;
  ASSERT_TRUE(half->probe(points, {}, expected, progress));
  for (const double tolerance : {0.0, 0.05, 0.3}) {
    std::vector<ProbedPoint> found;
    const auto report = middle->probe(points, {.max_error = tolerance}, found, progress);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_LE(report->achieved_error, tolerance);
    ASSERT_EQ(found.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_EQ(found[i].is_inside, expected[i].is_inside);
      if (!expected[i].is_inside || !found[i].is_inside) continue;
      EXPECT_LE(found[i].value.low, expected[i].value.high);
      EXPECT_GE(found[i].value.high, expected[i].value.low);
      if (tolerance == 0) {
        EXPECT_NEAR(found[i].value.value, expected[i].value.value, 1e-9);
        EXPECT_TRUE(found[i].is_exact);
      }
    }
    const auto sums = middle->integrate({.max_error = tolerance}, progress);
    const auto true_sums = half->integrate({}, progress);
    ASSERT_TRUE(sums && true_sums);
    for (const auto number : {&IntegralReport::volume, &IntegralReport::integral,
                              &IntegralReport::minimum, &IntegralReport::maximum}) {
      EXPECT_LE(((*sums).*number).low, ((*true_sums).*number).high);
      EXPECT_GE(((*sums).*number).high, ((*true_sums).*number).low);
    }
  }
}

TEST_F(midpoint_verification, probing_several_fields_has_the_values_of_each) {
  const TetraMesh mesh = test::with_fields(mesh_);
  Progress progress;
  auto half = TetraDataset::build(mesh, {.base_share = 0.02, .threads = {2}}, progress);
  auto middle = TetraDataset::build(
      mesh, {.base_share = 0.02, .placement = Placement::midpoint, .threads = {2}}, progress);
  ASSERT_TRUE(half && middle);
  oracles::Random random(5);
  std::vector<Vec3d> points;
  for (int i = 0; i < 200; ++i)
    points.push_back({{random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)}});
  const std::vector<std::size_t> along{3, 1};
  std::vector<ProbedPoint> expected;
  ASSERT_TRUE(half->probe(points, {.along = along}, expected, progress));
  const auto meets = [](const BoundedNumber& a, const BoundedNumber& b) {
    return a.low <= b.high && b.low <= a.high;
  };
  for (const double tolerance : {0.0, 0.3}) {
    std::vector<ProbedPoint> found;
    ASSERT_TRUE(middle->probe(points, {.max_error = tolerance, .along = along}, found, progress));
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!expected[i].is_inside || !found[i].is_inside) continue;
      for (std::size_t f = 0; f < along.size(); ++f) {
        const BoundedNumber& own = found[i].along[f].value;
        const BoundedNumber& right = expected[i].along[f].value;
        EXPECT_TRUE(meets(own, right)) << own.low << " to " << own.high << ", " << right.value;
        if (tolerance == 0) EXPECT_NEAR(own.value, right.value, 1e-6 * (1 + std::abs(right.value)));
      }
    }
    const auto sums = middle->integrate({.max_error = tolerance, .along = along}, progress);
    const auto right = half->integrate({.along = along}, progress);
    ASSERT_TRUE(sums && right);
    for (std::size_t f = 0; f < along.size(); ++f)
      for (const auto number :
           {&FieldIntegral::integral, &FieldIntegral::minimum, &FieldIntegral::maximum})
        EXPECT_TRUE(meets(sums->along[f].*number, right->along[f].*number));
  }
}

}  // namespace
}  // namespace lode

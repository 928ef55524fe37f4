// Marching by rows of bits against marching the leaves that the traversal finds one by one.
#include "lode/models/diamond/row_marcher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "lode/mappers/simplex_isosurface.h"
#include "lode/models/diamond/brick_work.h"
#include "lode/models/diamond/extract.h"
#include "tests/models/all_targets.h"
#include "tests/models/rough_volume.h"
#include "tests/models/stored_fixtures.h"
#include "tests/oracles/analytic_fields.h"
#include "tests/oracles/synthetic_volumes.h"
#include "tests/oracles/trials.h"

namespace lode::diamond {
namespace {

using Triangle = std::array<Vec3f, 3>;

/// In order; each begins with its least corner, in its orientation.
std::vector<Triangle> ordered(std::vector<Triangle> triangles) {
  for (Triangle& t : triangles)
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

std::vector<Triangle> triangles_of(const Surface& surface) {
  std::vector<Triangle> triangles;
  for (const auto& t : surface.triangles)
    triangles.push_back(
        {surface.positions[t[0]], surface.positions[t[1]], surface.positions[t[2]]});
  return ordered(std::move(triangles));
}

/// What the simplices of the cut give, marched one by one.
struct Expected {
  std::vector<Triangle> triangles;
  std::size_t n_vertices = 0;
  double achieved = 0;
};

Expected marched_one_by_one(const Model<3>& model, const IsosurfaceQuery& query) {
  const LatticeFrame frame = LatticeFrame::of(model.info.grid);
  IsoPart<3> part;
  SimplexIsosurface<3> mapper(frame, query.isovalue, part);
  for (const ActiveSimplex<3>& s : active_simplices<3>(model, query))
    mapper.add(to_lattice<3>(model.axes, s.vertex, s.value));
  Expected expected;
  expected.n_vertices = part.points.size();
  const auto position = [&](std::uint32_t v) {
    const Vec3d p = frame.position(part.points[v].lattice_position());
    return Vec3f{{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}};
  };
  for (const auto& cell : part.cells)
    expected.triangles.push_back({position(cell[0]), position(cell[1]), position(cell[2])});
  expected.triangles = ordered(std::move(expected.triangles));

  const Selection<3> selection(model, query.isovalue, query.tolerance, query.wanted);
  CoarseCut<3> cut;
  CoarseTraversal<3, Selection<3>>(selection, cut).run();
  TraversalStats stats = cut.stats;
  BrickTraversal<3> traversal(selection);
  for (const BrickWork<3>& work : work_of(cut)) {
    traversal.open(point_of<3>(model.brick_dims, work.brick));
    for (std::size_t s = work.begin; s < work.end; ++s)
      traversal.visit(cut.brick_simplices[s].second, stats, [](const BrickSimplex<3>&) {});
  }
  expected.achieved = static_cast<double>(decode_error(stats.achieved));
  return expected;
}

void expect_same(const Model<3>& model, const IsosurfaceQuery& query) {
  const Expected expected = marched_one_by_one(model, query);
  Surface surface;
  Progress progress;
  const auto report = extract_isosurface<3>(model, query, surface, progress);
  ASSERT_TRUE(report) << report.error().message;
  // Between holes some edges have two vertices.
  if (!model.has_holes()) EXPECT_EQ(surface.positions.size(), expected.n_vertices);
  EXPECT_TRUE(triangles_of(surface) == expected.triangles);
  EXPECT_EQ(report->achieved_error, expected.achieved);
}

/// At isovalues, as shares of the range, on samples, between them and outside, and at tolerances
/// that leave leaves of all kinds.
void expect_same_surfaces(const Model<3>& model,
                          const std::vector<double>& isovalues = {0.5, 0.37, 1.0, 0.0, -0.1}) {
  const double width = model.stats.max - model.stats.min;
  for (const double at : isovalues)
    for (const double share : oracles::trials<std::vector<double>>(
             {0.0, 0.003, 0.01, 0.03, 0.1, 0.4, 3.0}, {0.0, 0.01, 3.0})) {
      if (share == 0 && !model.has_holes()) continue;  // the kernel of full resolution
      const double isovalue = std::round(model.stats.min + at * width);
      SCOPED_TRACE(fmt::format("isovalue {} tolerance {}", isovalue, share * width));
      expect_same(model, {.isovalue = isovalue, .tolerance = share * width, .threads = {2}});
    }
}

class row_marcher_shapes : public ::testing::TestWithParam<Index3> {};

TEST_P(row_marcher_shapes, finds_what_simplices_give) {
  expect_same_surfaces(test::built<3>(test::rough_volume<std::uint8_t>(GetParam(), 0)));
  expect_same_surfaces(test::built<3>(test::rough_volume<std::int16_t>(GetParam(), 0)));
  expect_same_surfaces(test::built<3>(test::rough_volume<std::uint16_t>(GetParam(), 0)));
  expect_same_surfaces(test::built<3>(test::rough_volume<float>(GetParam(), 0)));
  expect_same_surfaces(test::built<3>(test::rough_volume<double>(GetParam(), 0)));
}

TEST_P(row_marcher_shapes, leaves_bricks_beside_holes_alone) {
  for (const double share : {0.00003, 0.001, 0.03})
    expect_same_surfaces(test::built<3>(test::rough_volume<float>(GetParam(), share)));
}

TEST_P(row_marcher_shapes, finds_the_same_in_noise) {
  expect_same_surfaces(
      test::built<3>(test::random_samples(GetParam(), ScalarType::uint8, test::Holes::none)),
      {0.5});
  expect_same_surfaces(
      test::built<3>(test::random_samples(GetParam(), ScalarType::float32, test::Holes::none)),
      {0.8});
}

/// Smaller than a brick, one brick, a sample more and less, some with cubes half outside.
INSTANTIATE_TEST_SUITE_P(dims, row_marcher_shapes,
                         ::testing::Values(Index3{{2, 2, 2}}, Index3{{3, 4, 2}}, Index3{{9, 5, 17}},
                                           Index3{{33, 33, 33}},
                                           oracles::trials<Index3>({{34, 32, 37}}, {{34, 12, 37}}),
                                           oracles::trials<Index3>({{40, 66, 35}}, {{34, 66, 5}}),
                                           Index3{{70, 3, 64}}));

TEST(row_marcher, finds_coarse_leaves) {
  expect_same_surfaces(
      test::built<3>(oracles::linear_ramp({{130, 66, 97}}, ScalarType::float32, {{1, 0.5, 0.25}})));
  expect_same_surfaces(test::built<3>(oracles::sample(oracles::Field::gaussians40, 65)));
}

TEST(row_marcher, refines_what_is_wanted) {
  for (const Index3& dims : {Index3{{33, 33, 33}}, Index3{{38, 45, 70}}}) {
    const Model<3> model = test::built<3>(test::rough_volume<float>(dims, 0));
    oracles::Random random(3);
    NodeSet<3> wanted(model.shape);
    for (int i = 0; i < 200; ++i) {
      Index<3> p;
      for (std::size_t axis = 0; axis < 3; ++axis)
        p[axis] = static_cast<std::int32_t>(
            random.below(static_cast<std::uint64_t>(model.shape.dims[axis])));
      wanted.insert(p, [](const Index<3>&) {});
    }
    for (const double tolerance : {1.0, 8.0, 1000.0})
      expect_same(model, {.isovalue = 103, .tolerance = tolerance, .wanted = &wanted});
  }
}

TEST(row_marcher, gives_the_same_bytes_on_every_processor) {
  const Model<3> bytes = test::built<3>(test::rough_volume<std::uint8_t>({{41, 67, 36}}, 0));
  const Model<3> floats = test::built<3>(test::rough_volume<float>({{41, 67, 36}}, 0));
  for (const Model<3>* model : {&bytes, &floats}) {
    const IsosurfaceQuery query{.isovalue = 103, .tolerance = 1.5, .threads = {1}};
    Surface expected;
    Progress progress;
    ASSERT_TRUE(extract_isosurface<3>(*model, query, expected, progress));
    test::for_each_target([&] {
      Surface surface;
      ASSERT_TRUE(extract_isosurface<3>(*model, query, surface, progress));
      EXPECT_TRUE(surface.positions == expected.positions &&
                  surface.triangles == expected.triangles);
    });
  }
}

}  // namespace
}  // namespace lode::diamond

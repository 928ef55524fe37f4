// Surfaces between two steps of refinement, against the steps' own.

#include "lode/models/diamond/morph.h"

#include <gtest/gtest.h>

#include "lode/mappers/surface_edits.h"
#include "lode/mappers/surface_topology.h"
#include "lode/models/diamond/extract.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"
#include "tests/models/morph_fixtures.h"

namespace lode::diamond {
namespace {

template <int D>
Surface extracted(const Model<D>& model, double isovalue, double tolerance) {
  Surface surface;
  Progress progress;
  const IsosurfaceQuery query{
      .isovalue = isovalue, .tolerance = tolerance, .threads = {1}, .with_normals = D == 3};
  EXPECT_TRUE(extract_isosurface<D>(model, query, surface, progress));
  return surface;
}

/// A surface that is refined from step to step.
template <int D>
struct Walk {
  const Model<D>& model;
  double isovalue;
  NotedRefinable<D> nodes;
  Engine<NotedRefinable<D>> engine;

  Walk(const Model<D>& walked, double c)
      : model(walked), isovalue(c), nodes(walked), engine(nodes) {}

  MorphStep<D> step_to(double tolerance) {
    nodes.forget();
    engine.set_query(isovalue_demand(isovalue, tolerance));
    engine.finish();
    Progress progress;
    return MorphStep<D>::find(nodes, engine.cut(), nodes.added(), {isovalue, D == 3}, progress)
        .value();
  }
};

constexpr std::array kTolerances{60.0, 30.0, 15.0, 5.0, 0.0};

/// Calls body(step, coarser, finer) for all steps but the first.
template <int D, typename Body>
void for_each_step(const Model<D>& model, double isovalue, const Body& body) {
  Walk<D> walk(model, isovalue);
  Surface coarser;
  for (const double tolerance : kTolerances) {
    SCOPED_TRACE(tolerance);
    const MorphStep<D> step = walk.step_to(tolerance);
    Surface finer = extracted<D>(model, isovalue, tolerance);
    if (tolerance != kTolerances.front()) body(step, coarser, finer);
    coarser = std::move(finer);
  }
}

/// How far a vertex may be from where its edge is crossed: what margin takes, on both surfaces, on
/// the longest edge there can be.
template <int D>
double allowance(const Model<D>& model) {
  const LatticeFrame frame = LatticeFrame::of(model.info.grid);
  return 4 * frame.margin * length(frame.to_world * Vec3d{{1, 1, 1}}) * model.shape.root_side();
}

std::vector<Vec3d> vertices_of(const Surface& surface) {
  std::vector<Vec3d> vertices;
  for (std::uint32_t v = 0; v < surface.positions.size(); ++v)
    vertices.push_back(surface.world_position(v));
  return vertices;
}

template <int D>
void expect_both_ends(const Model<D>& model, double isovalue) {
  for_each_step<D>(
      model, isovalue, [&](const auto& step, const Surface& coarser, const Surface& finer) {
        EXPECT_EQ(named_cells(step.surface(1)), named_cells(finer));
        const Surface start = step.surface(0);
        EXPECT_LE(farthest_from(coarser, vertices_of(start)), allowance(model));
        EXPECT_NEAR(size_of_all(start), size_of_all(coarser), 1e-4 * size_of_all(coarser));
      });
}

TEST(morph, goes_from_the_coarser_surface_to_the_finer_one) {
  expect_both_ends<3>(ramp_and_noise<3>({{9, 9, 9}}, 1), 45);
  expect_both_ends<3>(ramp_and_noise<3>({{14, 6, 7}}, 2), 40);
}

TEST(morph, goes_from_the_coarser_contours_to_the_finer_ones) {
  expect_both_ends<2>(ramp_and_noise<2>({{33, 33, 1}}, 3), 45);
  expect_both_ends<2>(ramp_and_noise<2>({{50, 1, 23}}, 4), 45);
}

TEST(morph, goes_from_end_to_end_round_holes) {
  expect_both_ends<3>(ramp_and_noise<3>({{12, 10, 9}}, 5, 0.01), 45);
}

/// Both ends of each boundary edge lie in one face of the data's box, and nothing beyond.
template <int D>
void expect_boundary_at_border(const Surface& surface, const RegularGrid& grid) {
  const Box3d box = grid.world_bounds();
  const double rounding = crop_rounding(box, box, surface.origin);
  for (const Vec3d& p : vertices_of(surface))
    for (std::size_t i = 0; i < 3; ++i) {
      ASSERT_GE(p[i], box.lower[i] - rounding);
      ASSERT_LE(p[i], box.upper[i] + rounding);
    }
  for (const auto& edge : find_boundary_edges(surface, {1})) {
    const Vec3d a = surface.world_position(edge[0]);
    const Vec3d b = surface.world_position(edge[1]);
    bool is_at_border = false;
    for (std::size_t i = 0; i < 3; ++i)
      for (const double face : {box.lower[i], box.upper[i]})
        is_at_border = is_at_border || (grid.dims[i] > 1 && std::abs(a[i] - face) <= rounding &&
                                        std::abs(b[i] - face) <= rounding);
    ASSERT_TRUE(is_at_border);
  }
}

template <int D>
void expect_manifolds(const Model<D>& model, double isovalue) {
  for_each_step<D>(model, isovalue, [&](const auto& step, const Surface&, const Surface&) {
    for (const double moment : {0.0, 0.1, 0.5, 0.9, 1.0}) {
      const Surface surface = step.surface(moment);
      EXPECT_TRUE(check_topology(surface, {.may_pinch = {}, .threads = {1}}).is_clean_manifold())
          << moment;
      expect_boundary_at_border<D>(surface, model.info.grid);
      EXPECT_EQ(surface.origins.empty(), moment < 1);
    }
  });
}

TEST(morph, is_a_manifold_that_ends_at_the_border_at_any_moment) {
  expect_manifolds<3>(ramp_and_noise<3>({{17, 17, 17}}, 6), 45);
  expect_manifolds<3>(ramp_and_noise<3>({{21, 6, 9}}, 7), 40);
  expect_manifolds<3>(ramp_and_noise<3>({{2, 40, 3}}, 8), 50);
  expect_manifolds<2>(ramp_and_noise<2>({{50, 23, 1}}, 9), 45);
}

TEST(morph, is_a_manifold_beside_holes_once_pinches_are_split) {
  const Model<3> model = ramp_and_noise<3>({{18, 14, 13}}, 10, 0.01);
  for_each_step<3>(model, 45, [](const auto& step, const Surface&, const Surface&) {
    for (const double moment : {0.0, 0.3, 0.7, 1.0}) {
      Surface surface = step.surface(moment);
      split_pinched_vertices(surface);
      EXPECT_TRUE(check_topology(surface, {.may_pinch = {}, .threads = {1}}).is_clean_manifold());
    }
  });
}

template <int D>
void expect_origins_on(const Model<D>& model, double isovalue) {
  for_each_step<D>(model, isovalue, [&](const auto& step, const Surface& coarser, const Surface&) {
    const Surface end = step.surface(1);
    ASSERT_EQ(end.origins.size(), end.positions.size());
    std::vector<Vec3d> origins;
    for (const Vec3f& origin : end.origins)
      if (!std::isnan(origin[0]))
        origins.push_back(end.origin + Vec3d{{origin[0], origin[1], origin[2]}});
    EXPECT_GT(origins.size(), 0U);
    EXPECT_LT(origins.size(), end.positions.size());  // some sides change in noise
    EXPECT_LE(farthest_from(coarser, origins), allowance(model));
  });
}

TEST(morph, names_origins_on_the_coarser_surface) {
  expect_origins_on<3>(ramp_and_noise<3>({{9, 9, 9}}, 11), 45);
  expect_origins_on<2>(ramp_and_noise<2>({{33, 33, 1}}, 12), 45);
}

TEST(morph, stands_still_where_nothing_is_added) {
  const Model<3> model = ramp_and_noise<3>({{17, 17, 17}}, 13);
  Walk<3> walk(model, 45);
  (void)walk.step_to(10);
  const MorphStep<3> step = walk.step_to(10);
  const Surface surface = step.surface(1);
  EXPECT_EQ(step.surface(0).positions, surface.positions);
  EXPECT_EQ(step.surface(0.5).positions, surface.positions);
  EXPECT_EQ(surface.origins, surface.positions);
}

TEST(morph, stops_when_cancelled) {
  const Model<3> model = ramp_and_noise<3>({{17, 17, 17}}, 14);
  Walk<3> walk(model, 45);
  (void)walk.step_to(10);
  Progress progress;
  progress.cancel();
  EXPECT_FALSE(
      MorphStep<3>::find(walk.nodes, walk.engine.cut(), walk.nodes.added(), {45, false}, progress));
}

}  // namespace
}  // namespace lode::diamond

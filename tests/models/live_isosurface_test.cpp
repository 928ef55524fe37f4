// The surface kept through an engine's steps against the one extracted at once.

#include "lode/models/diamond/live_isosurface.h"

#include <gtest/gtest.h>

#include "lode/models/diamond/build.h"
#include "lode/models/diamond/extract.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"
#include "tests/models/morph_fixtures.h"
#include "tests/models/surface_cells.h"
#include "tests/oracles/analytic_fields.h"

namespace lode::diamond {
namespace {

/// An engine with a surface that follows it, and a reader that takes batches.
template <int D>
struct Follower {
  LiveRefinable<D> nodes;
  LiveIsosurface<D> surface;
  Engine<LiveRefinable<D>> engine;
  SurfaceMirror mirror;

  Follower(const Model<D>& model, double isovalue, Inheritance inheritance = Inheritance::on)
      : nodes(model), surface(nodes, isovalue, false, inheritance), engine(nodes) {
    nodes.follow(&surface);
  }
  Follower(const Follower&) = delete;

  void finish(double tolerance, FocusChange focus) {
    engine.set_query(isovalue_demand(surface.isovalue(), tolerance), {}, focus);
    while (engine.step())
      if (engine.standing().n_steps % 100 == 0) take();
    take();
  }
  void take() {
    SurfaceBatch batch;
    while (!surface.gather(50, batch)) {
    }
    mirror.apply(batch);
  }
};

template <int D>
std::vector<std::array<Vec3f, 3>> one_shot_cells(const Model<D>& model, double isovalue,
                                                 double tolerance) {
  Surface surface;
  Progress progress;
  const IsosurfaceQuery query{.isovalue = isovalue, .tolerance = tolerance, .threads = {1}};
  EXPECT_TRUE(extract_isosurface<D>(model, query, surface, progress));
  return cells_of(surface);
}

template <int D>
void expect_one_shot_surfaces(const Model<D>& model, double isovalue) {
  Follower<D> follower(model, isovalue);
  FocusChange focus = FocusChange::changed;
  for (const double tolerance : {60.0, 20.0, 5.0, 0.0, 10.0, 1e30, 3.0}) {
    follower.finish(tolerance, focus);
    const auto expected = one_shot_cells<D>(model, isovalue, tolerance);
    const Surface found = follower.mirror.to_surface();
    ASSERT_EQ(cells_of(found), expected) << "tolerance " << tolerance;
    ASSERT_EQ(follower.surface.n_cells(), expected.size());
    ASSERT_EQ(follower.surface.n_vertices(), found.positions.size());
    focus = FocusChange::same;
  }
}

TEST(live_isosurface, adds_up_to_the_surface_of_one_shot) {
  expect_one_shot_surfaces<3>(ramp_and_noise<3>({{17, 17, 17}}, 1), 45);
  expect_one_shot_surfaces<3>(ramp_and_noise<3>({{21, 6, 9}}, 2), 40);
  expect_one_shot_surfaces<3>(ramp_and_noise<3>({{2, 40, 3}}, 3), 50);
}

TEST(live_isosurface, adds_up_to_the_contours_of_one_shot) {
  expect_one_shot_surfaces<2>(ramp_and_noise<2>({{33, 33, 1}}, 4), 45);
  expect_one_shot_surfaces<2>(ramp_and_noise<2>({{50, 1, 23}}, 5), 45);
}

TEST(live_isosurface, adds_up_where_there_are_holes) {
  expect_one_shot_surfaces<3>(ramp_and_noise<3>({{18, 14, 13}}, 6, 0.01), 45);
}

TEST(live_isosurface, gives_what_nobody_took_again) {
  const Model<3> model = ramp_and_noise<3>({{17, 17, 17}}, 8);
  Follower<3> follower(model, 45);
  for (const double tolerance : {30.0, 10.0, 20.0}) {
    follower.engine.set_query(isovalue_demand(45, tolerance), {}, FocusChange::changed);
    follower.engine.finish();
    SurfaceBatch lost;
    follower.surface.gather(300, lost);
    follower.surface.take_back(lost);
  }
  follower.take();
  EXPECT_EQ(cells_of(follower.mirror.to_surface()), one_shot_cells<3>(model, 45, 20));
}

TEST(live_isosurface, interpolates_a_third_of_the_vertices) {
  const Volume volume = oracles::sample(oracles::Field::gaussians40, 65);
  const auto source = make_memory_source(volume);
  Progress progress;
  const Model<3> model = build<3>(*source, {.threads = {2}}, progress).value();
  Follower<3> follower(model, 1.0);
  follower.finish(0, FocusChange::changed);
  const LiveCounts& counts = follower.surface.counts();
  EXPECT_GT(static_cast<double>(counts.n_without),
            2.5 * static_cast<double>(counts.n_interpolations));
}

TEST(live_isosurface, is_the_same_without_inheritance) {
  const Model<3> model = ramp_and_noise<3>({{18, 14, 13}}, 9, 0.01);
  Follower<3> follower(model, 45, Inheritance::off);
  for (const double tolerance : {10.0, 30.0, 0.0}) {
    follower.finish(tolerance, FocusChange::changed);
    ASSERT_EQ(cells_of(follower.mirror.to_surface()), one_shot_cells<3>(model, 45, tolerance));
  }
}

TEST(live_isosurface, interpolates_every_vertex_of_every_node_without_inheritance) {
  // A ball that stays clear of the border, where parts of a node's star are missing.
  const Volume volume = oracles::sample(oracles::Field::sphere, 33, {.scale = -1});
  const auto source = make_memory_source(volume);
  Progress progress;
  const Model<3> model = build<3>(*source, {.threads = {2}}, progress).value();
  Follower<3> follower(model, -0.7, Inheritance::off);
  const std::uint64_t n_at_base = follower.surface.counts().n_interpolations;
  follower.finish(0, FocusChange::changed);
  const LiveCounts& counts = follower.surface.counts();
  EXPECT_EQ(counts.n_interpolations, n_at_base + counts.n_without);
}

}  // namespace
}  // namespace lode::diamond

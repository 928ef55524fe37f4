// The surface kept through an engine's steps against the one extracted at once.

#include "lode/models/diamond/live_isosurface.h"

#include <gtest/gtest.h>

#include "lode/mappers/surface_match.h"
#include "lode/models/diamond/build.h"
#include "lode/models/diamond/extract.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"
#include "tests/oracles/analytic_fields.h"
#include "tests/oracles/random.h"

namespace lode::diamond {
namespace {

/// Cells by their corners' positions, each from its least corner on, in order.
std::vector<std::array<Vec3f, 3>> cells_of(const Surface& surface) {
  std::vector<std::array<Vec3f, 3>> cells;
  for (const auto& t : surface.triangles) {
    std::array<Vec3f, 3> cell{surface.positions[t[0]], surface.positions[t[1]],
                              surface.positions[t[2]]};
    std::rotate(cell.begin(), std::min_element(cell.begin(), cell.end()), cell.end());
    cells.push_back(cell);
  }
  for (const auto& l : surface.lines)
    cells.push_back({surface.positions[l[0]], surface.positions[l[1]], surface.positions[l[1]]});
  std::sort(cells.begin(), cells.end());
  return cells;
}

template <int D>
Model<D> noisy_model(const Index3& dims, std::uint64_t seed, double hole_share = 0) {
  oracles::Random random(seed);
  RegularGrid grid;
  grid.dims = dims;
  grid.spacing = {{0.5, 1, 2}};
  std::vector<float> samples(static_cast<std::size_t>(grid.n_samples()));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto x = static_cast<double>(i % 13);
    samples[i] = static_cast<float>(5 * x + random.uniform(0, 40));
    if (random.uniform(0, 1) < hole_share) samples[i] = std::numeric_limits<float>::quiet_NaN();
  }
  const Volume volume = make_volume<float>(grid, samples);
  const auto source = make_memory_source(volume);
  Progress progress;
  return build<D>(*source, {.threads = {2}}, progress).value();
}

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
  void restart(double isovalue) {
    surface.restart(isovalue);
    surface.begin(engine.cut());
    for (const NodeId id : engine.cut().applied()) surface.add_leaves(id, engine.cut());
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
  expect_one_shot_surfaces<3>(noisy_model<3>({{17, 17, 17}}, 1), 45);
  expect_one_shot_surfaces<3>(noisy_model<3>({{21, 6, 9}}, 2), 40);
  expect_one_shot_surfaces<3>(noisy_model<3>({{2, 40, 3}}, 3), 50);
}

TEST(live_isosurface, adds_up_to_the_contours_of_one_shot) {
  expect_one_shot_surfaces<2>(noisy_model<2>({{33, 33, 1}}, 4), 45);
  expect_one_shot_surfaces<2>(noisy_model<2>({{50, 1, 23}}, 5), 45);
}

TEST(live_isosurface, adds_up_where_there_are_holes) {
  expect_one_shot_surfaces<3>(noisy_model<3>({{18, 14, 13}}, 6, 0.01), 45);
}

TEST(live_isosurface, restarts_with_another_isovalue_on_the_same_cut) {
  const Model<3> model = noisy_model<3>({{17, 17, 17}}, 7);
  Follower<3> follower(model, 40);
  follower.finish(10, FocusChange::changed);
  for (const double isovalue : {41.0, 60.0, 20.0, 500.0, 45.0}) {
    follower.restart(isovalue);
    follower.finish(10, FocusChange::changed);
    ASSERT_EQ(cells_of(follower.mirror.to_surface()), one_shot_cells<3>(model, isovalue, 10));
  }
}

TEST(live_isosurface, gives_what_nobody_took_again) {
  const Model<3> model = noisy_model<3>({{17, 17, 17}}, 8);
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
  const Model<3> model = noisy_model<3>({{18, 14, 13}}, 9, 0.01);
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

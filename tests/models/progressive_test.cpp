#include "lode/api/progressive.h"

#include <gtest/gtest.h>

#include "tests/models/morph_fixtures.h"
#include "tests/oracles/analytic_fields.h"

namespace lode {
namespace {

Dataset dataset_of(oracles::Field field, const Index3& dims) {
  const Volume volume = oracles::sample(field, dims);
  const auto source = make_memory_source(volume);
  Progress progress;
  return Dataset::build(*source, {}, progress).value();
}

struct Walked {
  std::vector<ProgressiveStep> steps;
  Surface last;
};

/// Each step against the extraction with its tolerance.
Walked walk(const Dataset& dataset, const ExtractOptions& options) {
  Progress progress;
  auto surfaces = ProgressiveSurface::begin(dataset, options, progress).value();
  Walked walked;
  while (surfaces.advance(progress).value()) {
    const ProgressiveStep& step = surfaces.step();
    walked.last = surfaces.surface(1);
    EXPECT_EQ(walked.last.origins.empty(), step.is_first || walked.last.positions.empty());
    EXPECT_LE(step.achieved_error, step.max_error);
    ExtractOptions one_shot = options;
    one_shot.max_error = step.max_error;
    Surface expected;
    EXPECT_TRUE(dataset.extract(one_shot, expected, progress));
    EXPECT_EQ(diamond::named_cells(walked.last), diamond::named_cells(expected));
    EXPECT_EQ(walked.last.isovalues, expected.isovalues);
    walked.steps.push_back(step);
  }
  EXPECT_LE(static_cast<int>(walked.steps.size()), surfaces.most_steps());
  return walked;
}

TEST(progressive_surface, answers_falling_tolerances_up_to_the_one_asked_for) {
  const Dataset dataset = dataset_of(oracles::Field::gyroid, {{33, 30, 17}});
  const double base_error = dataset.describe().base_error;
  const Walked walked = walk(dataset, {.isovalues = {0.1}, .max_error = 0.01});
  ASSERT_GT(walked.steps.size(), 3U);
  EXPECT_TRUE(walked.steps.front().is_first);
  EXPECT_LE(walked.steps.front().max_error, base_error);
  for (std::size_t k = 1; k < walked.steps.size(); ++k) {
    EXPECT_FALSE(walked.steps[k].is_first);
    EXPECT_GT(walked.steps[k].new_nodes, 0U);
    EXPECT_LT(walked.steps[k].max_error, walked.steps[k - 1].max_error);
  }
  EXPECT_EQ(walked.steps.back().max_error, 0.01);
}

TEST(progressive_surface, ends_at_full_resolution_where_no_error_is_allowed) {
  const Dataset dataset = dataset_of(oracles::Field::marschner_lobb, {{20, 17, 18}});
  EXPECT_EQ(walk(dataset, {.isovalues = {0.5}, .max_error = 0.0}).steps.back().max_error, 0);
}

TEST(progressive_surface, goes_through_contours_clip_boxes_and_turned_surfaces) {
  const Dataset flat = dataset_of(oracles::Field::gyroid, {{40, 33, 1}});
  EXPECT_FALSE(walk(flat, {.isovalues = {0.1}, .max_error = 0.01}).last.lines.empty());
  const Dataset dataset = dataset_of(oracles::Field::gyroid, {{33, 30, 17}});
  const Box3d box{{{-0.5, -0.6, -0.4}}, {{0.3, 0.7, 0.6}}};
  walk(dataset, {.isovalues = {0.1},
                 .max_error = 0.02,
                 .orientation = Orientation::from_higher_values,
                 .normals = Normals::off});
  Progress progress;
  auto cropped = ProgressiveSurface::begin(
                     dataset, {.isovalues = {0.1}, .max_error = 0.1, .clip = box}, progress)
                     .value();
  while (cropped.advance(progress).value())
    for (const double moment : {0.5, 1.0})
      for (const Vec3f& p : cropped.surface(moment).positions) {
        EXPECT_GE(p[0], -0.5001F);
        EXPECT_LE(p[1], 0.7001F);
      }
}

TEST(progressive_surface, has_one_empty_step_where_the_isovalue_meets_nothing) {
  const Dataset dataset = dataset_of(oracles::Field::sphere, {{9, 9, 9}});
  const Walked walked = walk(dataset, {.isovalues = {50}});
  EXPECT_EQ(walked.steps.size(), 1U);
  EXPECT_TRUE(walked.last.is_empty());
}

TEST(progressive_surface, refuses_several_isovalues_and_stops_when_cancelled) {
  const Dataset dataset = dataset_of(oracles::Field::sphere, {{9, 9, 9}});
  Progress progress;
  EXPECT_FALSE(ProgressiveSurface::begin(dataset, {.isovalues = {0.5, 0.6}}, progress));
  auto surfaces = ProgressiveSurface::begin(dataset, {.isovalues = {0.5}}, progress).value();
  progress.cancel();
  EXPECT_FALSE(surfaces.advance(progress));
}

}  // namespace
}  // namespace lode

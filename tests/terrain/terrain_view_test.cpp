// Meshes for a view: held against a camera of the test's own, sample by sample.
#include "lode/api/terrain_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>

#include "lode/api/built_terrain.h"
#include "lode/api/terrain_picture.h"
#include "lode/api/terrain_selection.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr int kColumns = 61;
constexpr int kRows = 51;

double ridges(std::int32_t x, std::int32_t y) {
  return std::round(60 * std::sin(0.21 * x + 0.05 * y) * std::cos(0.17 * y) + (x * 7 + y * 5) % 9) +
         300;
}

/// Where pictures have a raster, worked out by hand: metres of a step of its columns, rows and
/// heights, the columns to the east and the rows to the south of its middle.
struct Setting {
  const char* name;
  HeightGrid grid;
  HorizontalMetric metric{};
  double exaggeration = 1;
  Vec3d steps;

  [[nodiscard]] Vec3d place(double column, double row, double height) const {
    const HeightRange range = height_range(grid);
    return {{(column - (kColumns - 1) / 2.0) * steps[0], ((kRows - 1) / 2.0 - row) * steps[1],
             (height - (range.lower + range.upper) / 2) * steps[2]}};
  }
};

HeightGrid placed(const std::array<double, 6>& to_world, const char* unit) {
  HeightGrid grid = delaunay::test::make_grid<float>(kColumns, kRows, ridges);
  for (std::int32_t x = 20; x < 24; ++x) delaunay::test::set_missing(grid, x, 30);
  grid.to_world = to_world;
  grid.vertical_unit = unit;
  return grid;
}

Setting plain_metres() {
  return {"metres", placed({5e5, 10, 0, 4e6, 0, -10}, "metre"), {}, 1, {{10, 10, 1}}};
}

/// Of coordinates in US survey feet, heights in feet, three times.
Setting feet() {
  HorizontalMetric metric;
  metric.is_known = true;
  metric.length_unit = 1200.0 / 3937;
  const double side = 30 * metric.length_unit;
  return {"feet", placed({2e6, 30, 0, 7e5, 0, -30}, "foot"), metric, 3, {{side, side, 3 * 0.3048}}};
}

/// Of degrees on WGS 84 round 60 degrees north.
Setting degrees() {
  constexpr double kStep = 0.0001;
  constexpr double kFlattening = 1 / 298.257223563;
  HorizontalMetric metric;
  metric.is_known = true;
  metric.ellipsoid = kWgs84Ellipsoid;
  metric.angle_unit = kPi / 180;
  const double latitude = 60 * kPi / 180;
  const double e2 = kFlattening * (2 - kFlattening);
  const double w = std::sqrt(1 - e2 * std::sin(latitude) * std::sin(latitude));
  const double east = 6378137 / w * std::cos(latitude);
  const double north = 6378137 * (1 - e2) / (w * w * w);
  const double top = 60 + kStep * (kRows - 1) / 2;
  return {"degrees",
          placed({10, kStep, 0, top, 0, -kStep}, ""),
          metric,
          2,
          {{east * kStep * kPi / 180, north * kStep * kPi / 180, 2}}};
}

/// Looks from one place to another, z up.
struct LittleCamera {
  Camera camera;
  int width = 640;
  int height = 360;

  /// Right, down and depth, in pixels but for the depth.
  [[nodiscard]] Vec3d project(const Vec3d& p) const {
    const Vec3d away = camera.target - camera.eye;
    const Vec3d z = away * (1 / std::sqrt(dot(away, away)));
    const Vec3d side{{away[1] * camera.up[2] - away[2] * camera.up[1],
                      away[2] * camera.up[0] - away[0] * camera.up[2],
                      away[0] * camera.up[1] - away[1] * camera.up[0]}};
    const Vec3d x = side * (1 / std::sqrt(dot(side, side)));
    const Vec3d y{
        {z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]}};
    const Vec3d from = p - camera.eye;
    const double depth = dot(from, z);
    const double focal = height / 2.0 / std::tan(camera.field_of_view_deg * kPi / 360);
    return {{width / 2.0 + focal * dot(from, x) / depth,
             height / 2.0 + focal * dot(from, y) / depth, depth}};
  }
  [[nodiscard]] bool has(const Vec3d& at) const {
    return at[2] > 0 && at[0] >= 0 && at[0] <= width && at[1] >= 0 && at[1] <= height;
  }
  /// Between two points one above the other, if one is in the picture.
  [[nodiscard]] std::optional<double> pixels_between(const Vec3d& a, const Vec3d& b) const {
    const Vec3d p = project(a);
    const Vec3d q = project(b);
    if (!has(p) && !has(q)) return {};
    if (!(p[2] > 0 && q[2] > 0)) return kInfinite;
    return std::hypot(p[0] - q[0], p[1] - q[1]);
  }
};

/// From afar, steeply, close to the ground and in the terrain's midst, tilted.
std::vector<LittleCamera> cameras(const Setting& setting) {
  const double size = setting.steps[0] * kColumns;
  const double top = setting.place(0, 0, height_range(setting.grid).upper)[2];
  return {
      {{{{0, -1.6 * size, 0.7 * size}}, {{0, 0, 0}}, {{0, 0, 1}}, 20}},
      {{{{0.2 * size, 0.1 * size, 2 * size}}, {{0, 0, 0}}, {{0, 1, 0}}, 24}},
      {{{{-0.4 * size, -0.3 * size, top + 0.02 * size}}, {{size, size, -top}}, {{0, 0, 1}}, 50}},
      {{{{0, 0, top + 0.01 * size}}, {{size, 0.3 * size, 0}}, {{0.3, 0.1, 1}}, 100}, 500, 500}};
}

/// Calls visit(column, row, height in the TIN) for all samples in each of its triangles. `scale`:
/// its nodes are so many to a cell.
template <typename Visit>
void visit_samples(const delaunay::Tin& tin, std::int32_t scale, const HeightGrid& grid,
                   const Visit& visit) {
  for (const auto& t : tin.triangles) {
    std::array<delaunay::LatticePoint, 3> c;
    for (std::size_t i = 0; i < 3; ++i) c[i] = tin.vertices[t[i]];
    const auto [x0, x1] = std::minmax({c[0].x, c[1].x, c[2].x});
    const auto [y0, y1] = std::minmax({c[0].y, c[1].y, c[2].y});
    for (std::int32_t y = (y0 + scale - 1) / scale; y * scale <= y1; ++y)
      for (std::int32_t x = (x0 + scale - 1) / scale; x * scale <= x1; ++x) {
        std::array<double, 3> share{};
        for (std::size_t i = 0; i < 3; ++i)
          share[i] = static_cast<double>(
              delaunay::doubled_area(c[(i + 1) % 3], c[(i + 2) % 3], {x * scale, y * scale}));
        if (share[0] < 0 || share[1] < 0 || share[2] < 0 || !grid.has_height(x, y)) continue;
        double height = 0;
        for (std::size_t i = 0; i < 3; ++i)
          height += share[i] * tin.heights[t[i]] / (share[0] + share[1] + share[2]);
        visit(x, y, height);
      }
  }
}

/// What samples and the TIN show.
struct Seen {
  double worst_px = 0;
  double worst_outside = 0;  ///< Of samples that are not in the picture, units of the heights.
  int n_inside = 0;
};

Seen seen_by(const LittleCamera& camera, const delaunay::Tin& tin, const Setting& setting,
             std::int32_t scale = 1) {
  Seen seen;
  visit_samples(tin, scale, setting.grid, [&](std::int32_t x, std::int32_t y, double height) {
    const double own = setting.grid.height(x, y);
    const auto px = camera.pixels_between(setting.place(x, y, own), setting.place(x, y, height));
    seen.n_inside += px ? 1 : 0;
    if (px) seen.worst_px = std::max(seen.worst_px, *px);
    if (!px) seen.worst_outside = std::max(seen.worst_outside, std::abs(own - height));
  });
  return seen;
}

TerrainFocus focus_of(const LittleCamera& camera, const Setting& setting, double max_error_px) {
  TerrainFocus focus;
  focus.view = TerrainView{.view = {camera.camera, camera.width, camera.height},
                           .exaggeration = setting.exaggeration,
                           .max_error_px = max_error_px};
  focus.metric = setting.metric;
  return focus;
}

class terrain_view : public testing::TestWithParam<TerrainModel> {
 protected:
  [[nodiscard]] static bool has_gaps() { return lode::has_gaps(GetParam()); }
  BuiltTerrain build(const HeightGrid& grid, double finest = 0) {
    auto made = BuiltTerrain::build(grid, {.model = GetParam(), .levels = {finest}}, progress_);
    EXPECT_TRUE(made) << made.error().message;
    return *std::move(made);
  }
  SelectedTerrain select(const BuiltTerrain& built, const TerrainOptions& options) {
    const auto links = has_gaps() ? delaunay::TinLinks::left_out : delaunay::TinLinks::kept;
    auto made = built.terrain().origin().select(options, links, progress_);
    EXPECT_TRUE(made) << made.error().message;
    return *std::move(made);
  }

  Progress progress_;
};

TEST_P(terrain_view, errs_by_no_more_pixels_than_asked_where_a_camera_sees_it) {
  for (const Setting& setting : {plain_metres(), feet(), degrees()}) {
    SCOPED_TRACE(setting.name);
    const BuiltTerrain built = build(setting.grid);
    const auto all = select(built, {.max_error = 0}).tin.triangles.size();
    for (const LittleCamera& camera : cameras(setting))
      for (const double max_error_px : oracles::trials<std::vector<double>>(
               {0.4, 6.0}, {setting.exaggeration == 1 ? 0.4 : 6.0})) {
        const SelectedTerrain made =
            select(built, {.focus = focus_of(camera, setting, max_error_px)});
        const Seen seen = seen_by(camera, made.tin, setting);
        ASSERT_GT(seen.n_inside, 60);
        const TerrainViewReport& report = made.report.view.value();
        EXPECT_LE(seen.worst_px, max_error_px);
        EXPECT_LE(seen.worst_px, report.achieved_px * (1 + 1e-6));
        EXPECT_LE(report.achieved_px, max_error_px);
        EXPECT_TRUE(made.report.is_within_error);
        EXPECT_FALSE(made.report.is_uniform);
        EXPECT_GT(report.n_shown, 0U);
        EXPECT_EQ(report.exaggeration, setting.exaggeration);
        EXPECT_EQ(report.is_vertical_unit_known, setting.grid.vertical_unit != "");
        EXPECT_LE(made.report.triangles, all);
        if (!has_gaps()) delaunay::test::expect_fills(made.tin, setting.grid);
      }
  }
}

/// Anywhere over the terrain and round it, often close to the ground.
LittleCamera random_camera(const Setting& setting, oracles::Random& random) {
  const double size = setting.steps[0] * kColumns;
  const HeightRange range = height_range(setting.grid);
  const auto at = [&](double lowest) {
    const double height = setting.place(0, 0, range.lower)[2] * (1 - lowest) +
                          setting.place(0, 0, range.upper)[2] * lowest;
    const double above = random.below(2) == 0 ? 0.02 * size : size;
    return Vec3d{{random.uniform(-size, size), random.uniform(-size, size),
                  height + random.uniform(0, above)}};
  };
  return {{at(1), at(0), {{0, 0, 1}}, random.uniform(10, 90)}, 400, 300};
}

TEST_P(terrain_view, says_of_any_camera_that_what_was_asked_is_met) {
  oracles::Random random(11);
  for (const Setting& setting : {plain_metres(), feet()}) {
    const BuiltTerrain built = build(setting.grid);
    for (int trial = 0; trial < oracles::trials(40, 6); ++trial) {
      SCOPED_TRACE(testing::Message() << setting.name << ", camera " << trial);
      const LittleCamera camera = random_camera(setting, random);
      const double max_error_px = std::exp2(random.uniform(-2, 4));
      const SelectedTerrain made =
          select(built, {.focus = focus_of(camera, setting, max_error_px)});
      EXPECT_TRUE(made.report.is_within_error);
      EXPECT_LE(made.report.view->achieved_px, max_error_px);
      EXPECT_LE(seen_by(camera, made.tin, setting).worst_px,
                made.report.view->achieved_px * (1 + 1e-6));
    }
  }
}

TEST_P(terrain_view, has_no_more_triangles_than_it_takes) {
  const Setting setting = plain_metres();
  const BuiltTerrain built = build(setting.grid);
  const LittleCamera camera = cameras(setting)[0];
  const SelectedTerrain made = select(built, {.focus = focus_of(camera, setting, 12)});
  // All of it is seen, and the bound is not far from what it bounds.
  const Seen seen = seen_by(camera, made.tin, setting);
  EXPECT_GT(seen.worst_px, 6);
  // The tolerance that is 12 pixels where the terrain is nearest holds everywhere, and takes more.
  const double nearest = std::hypot(1.1, 0.7) * setting.steps[0] * kColumns;
  const double focal = camera.height / 2.0 / std::tan(10 * kPi / 180);
  const SelectedTerrain uniform = select(built, {.max_error = 12 * nearest / focal});
  EXPECT_LT(made.report.triangles, uniform.report.triangles + uniform.report.triangles / 10);
  // Half of it is not.
  const SelectedTerrain half = select(built, {.focus = focus_of(cameras(setting)[2], setting, 12)});
  EXPECT_GT(seen_by(cameras(setting)[2], half.tin, setting).worst_outside, 12);
}

TEST_P(terrain_view, keeps_its_tolerances_outside_and_in_other_foci) {
  const Setting setting = plain_metres();
  const BuiltTerrain built = build(setting.grid);
  const LittleCamera camera = cameras(setting)[2];
  TerrainFocus focus = focus_of(camera, setting, 3);
  const SelectedTerrain alone = select(built, {.focus = focus});
  focus.max_error_outside = 7;
  const SelectedTerrain bounded = select(built, {.focus = focus});
  EXPECT_GT(seen_by(camera, alone.tin, setting).worst_outside, 7);
  EXPECT_LE(seen_by(camera, bounded.tin, setting).worst_outside, 7 + 1e-9);
  EXPECT_LE(seen_by(camera, bounded.tin, setting).worst_px, 3);
  // Behind the camera: the first columns of the last rows.
  focus.boxes = {{{{5e5, 4e6 - 500}}, {{5e5 + 60, 4e6 - 440}}}};
  const SelectedTerrain joined = select(built, {.max_error = 1, .focus = focus});
  EXPECT_LE(seen_by(camera, joined.tin, setting).worst_px, 3);
  double in_box = 0;
  visit_samples(joined.tin, 1, setting.grid, [&](std::int32_t x, std::int32_t y, double height) {
    if (x <= 6 && y >= 44) in_box = std::max(in_box, std::abs(setting.grid.height(x, y) - height));
  });
  EXPECT_LE(in_box, 1 + 1e-9);
  EXPECT_GT(joined.report.triangles, bounded.report.triangles);
  EXPECT_LT(joined.report.triangles, select(built, {.max_error = 1}).report.triangles);
}

TEST_P(terrain_view, holds_a_tolerance_of_heights_where_it_is_seen) {
  const Setting setting = plain_metres();
  const BuiltTerrain built = build(setting.grid);
  const LittleCamera camera = cameras(setting)[2];
  TerrainFocus focus = focus_of(camera, setting, 100);
  focus.view->max_error_px.reset();
  focus.view->has_tolerance = true;
  const SelectedTerrain made = select(built, {.max_error = 12, .focus = focus});
  double inside = 0;
  visit_samples(made.tin, 1, setting.grid, [&](std::int32_t x, std::int32_t y, double height) {
    const double own = setting.grid.height(x, y);
    if (camera.has(camera.project(setting.place(x, y, own))))
      inside = std::max(inside, std::abs(own - height));
  });
  EXPECT_LE(inside, 12 + 1e-9);
  EXPECT_GT(inside, 6);
  EXPECT_GT(seen_by(camera, made.tin, setting).worst_outside, 12);
}

TEST_P(terrain_view, is_coarse_where_a_view_shows_nothing_and_says_so) {
  const Setting setting = plain_metres();
  const BuiltTerrain built = build(setting.grid);
  LittleCamera camera{{{{0, 0, 2000}}, {{0, 10, 4000}}, {{0, 1, 0}}, 40}};
  const SelectedTerrain made = select(built, {.focus = focus_of(camera, setting, 0.1)});
  EXPECT_EQ(made.report.view->n_shown, 0U);
  EXPECT_EQ(made.report.view->achieved_px, 0);
  EXPECT_EQ(made.report.triangles, select(built, {.max_error = 1e6}).report.triangles);
  if (!has_gaps()) EXPECT_TRUE(made.report.is_focus_empty);
}

TEST_P(terrain_view, says_where_the_model_is_too_coarse) {
  // These have all samples.
  if (GetParam() == TerrainModel::implicit_delaunay_pyramid || is_on_squares(GetParam())) return;
  const Setting setting = plain_metres();
  const BuiltTerrain built = build(setting.grid, 5);
  const LittleCamera camera = cameras(setting)[2];
  const SelectedTerrain made = select(built, {.focus = focus_of(camera, setting, 0.5)});
  EXPECT_FALSE(made.report.is_within_error);
  EXPECT_GT(made.report.view->achieved_px, 0.5);
  EXPECT_LE(seen_by(camera, made.tin, setting).worst_px, made.report.view->achieved_px);
}

TEST_P(terrain_view, exaggerates_as_pictures_do) {
  Setting setting = plain_metres();
  const BuiltTerrain built = build(setting.grid);
  TerrainPictureReport picture;
  ASSERT_TRUE(
      draw_terrain(setting.grid, {}, {.render = {.width = 64, .height = 48}}, picture, progress_));
  TerrainFocus focus;
  focus.view = TerrainView{.view = {picture.camera, 64, 48}, .max_error_px = 1};
  const SelectedTerrain made = select(built, {.focus = focus});
  EXPECT_EQ(made.report.view->exaggeration, picture.exaggeration);
  setting.exaggeration = setting.steps[2] = picture.exaggeration;
  const LittleCamera camera{picture.camera, 64, 48};
  const Seen seen = seen_by(camera, made.tin, setting);
  EXPECT_EQ(seen.worst_outside, 0) << "all of the raster is in its picture";
  EXPECT_LE(seen.worst_px, 1);
  EXPECT_GT(seen.worst_px, 0.2);
}

INSTANTIATE_TEST_SUITE_P(models, terrain_view,
                         testing::Values(TerrainModel::delaunay_pyramid,
                                         TerrainModel::ternary_triangulation,
                                         TerrainModel::implicit_delaunay_pyramid,
                                         TerrainModel::quaternary_triangulation,
                                         TerrainModel::right_triangle_bisection),
                         [](const auto& model) { return name_of(model.param); });

/// Its vertices are nodes of a lattice finer than the raster; what it was built of mends it.
TEST(terrain_view_of_levels, errs_by_no_more_pixels_than_asked_where_a_camera_sees_it) {
  Progress progress;
  for (const Setting& setting : {plain_metres(), feet(), degrees()}) {
    SCOPED_TRACE(setting.name);
    const auto built = BuiltTerrain::build(
        setting.grid,
        {.model = TerrainModel::hierarchical_delaunay, .levels = {64, 16, 4, 1, 0.25, 0}},
        progress);
    ASSERT_TRUE(built) << built.error().message;
    const Terrain terrain = built->terrain();
    const auto& origin = terrain.origin();
    const std::int32_t scale = (origin.frame().n_columns - 1) / (setting.grid.n_columns - 1);
    const auto all = origin.select({.max_error = 0}, delaunay::TinLinks::left_out, progress);
    ASSERT_TRUE(all);
    for (const LittleCamera& camera : cameras(setting))
      for (const double max_error_px : oracles::trials<std::vector<double>>(
               {0.4, 6.0}, {setting.exaggeration == 1 ? 0.4 : 6.0})) {
        const auto made = origin.select({.focus = focus_of(camera, setting, max_error_px)},
                                        delaunay::TinLinks::kept, progress);
        ASSERT_TRUE(made) << made.error().message;
        const Seen seen = seen_by(camera, made->tin, setting, scale);
        ASSERT_GT(seen.n_inside, 60);
        const TerrainViewReport& report = made->report.view.value();
        EXPECT_LE(seen.worst_px, max_error_px);
        EXPECT_LE(seen.worst_px, report.achieved_px * (1 + 1e-6));
        EXPECT_LE(report.achieved_px, max_error_px);
        EXPECT_TRUE(made->report.is_within_error);
        EXPECT_LE(made->report.triangles, all->report.triangles);
        delaunay::test::expect_fills(made->tin, setting.grid, scale);
      }
  }
}

TEST(terrain_view_of_squares, says_what_their_triangles_err_by) {
  const Setting setting = plain_metres();
  Progress progress;
  const auto built = BuiltTerrain::build(
      setting.grid, {.model = TerrainModel::surface_quadtree, .levels = {0}}, progress);
  ASSERT_TRUE(built);
  for (const LittleCamera& camera : cameras(setting)) {
    const auto made = built->terrain().origin().select({.focus = focus_of(camera, setting, 2)},
                                                       delaunay::TinLinks::left_out, progress);
    ASSERT_TRUE(made);
    const double achieved = made->report.view->achieved_px;
    EXPECT_LE(seen_by(camera, made->tin, setting).worst_px, achieved);
    EXPECT_EQ(made->report.is_within_error, achieved <= 2);
  }
}

TEST(terrain_view_refusals, name_what_they_expect) {
  const Setting setting = plain_metres();
  Progress progress;
  const auto refusal = [&](TerrainModel model, const auto& change) {
    auto built = BuiltTerrain::build(setting.grid, {.model = model, .levels = {1}}, progress);
    EXPECT_TRUE(built);
    TerrainOptions options{.focus = focus_of(cameras(setting)[0], setting, 1)};
    change(*options.focus);
    const auto made = extract_terrain(built->terrain(), options, progress);
    return made ? std::string() : made.error().message;
  };
  const auto as_it_is = [](TerrainFocus&) {};
  EXPECT_EQ(refusal(TerrainModel::delaunay_pyramid, as_it_is), "");
  EXPECT_EQ(refusal(TerrainModel::hierarchical_delaunay, as_it_is), "");
  EXPECT_EQ(refusal(TerrainModel::adaptive_triangulation, as_it_is), "");
  EXPECT_NE(refusal(TerrainModel::restricted_quadtree, as_it_is).find("got a focus"),
            std::string::npos);
  EXPECT_FALSE(extract_terrain(setting.grid, {.focus = focus_of(cameras(setting)[0], setting, 1)},
                               progress));
  const auto refused = [&](const char* why, const auto& change) {
    const std::string message = refusal(TerrainModel::delaunay_pyramid, change);
    EXPECT_NE(message.find(why), std::string::npos) << message;
  };
  refused("eye and target", [](TerrainFocus& focus) {
    focus.view->view.camera.target = focus.view->view.camera.eye;
  });
  refused("1 x 1 pixels", [](TerrainFocus& focus) { focus.view->view.width = 0; });
  refused("in pixels: expected a number >= 0",
          [](TerrainFocus& focus) { focus.view->max_error_px = -1; });
  refused("expected a tolerance", [](TerrainFocus& focus) { focus.view->max_error_px.reset(); });
  refused("exaggeration", [](TerrainFocus& focus) { focus.view->exaggeration = 0; });
}

}  // namespace
}  // namespace lode::test

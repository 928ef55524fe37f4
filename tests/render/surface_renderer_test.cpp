#include "lode/render/surface_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <string>

#include "lode/render/ray_scene.h"
#include "tests/render/shapes.h"

namespace lode {
namespace {

const Box3d kCube{{{-1, -1, -1}}, {{1, 1, 1}}};
constexpr Background kTransparent{{255, 255, 255, 0}, {255, 255, 255, 0}};

RenderOptions small_options() {
  RenderOptions options;
  options.width = 160;
  options.height = 120;
  return options;
}

Image render(const Surface& surface, const Box3d& bounds, const RenderOptions& options) {
  Progress progress;
  auto image = render_surface(surface, bounds, options, progress);
  EXPECT_TRUE(image) << image.error().message;
  return image ? *image : Image{};
}

std::string error_of(const Surface& surface, const Box3d& bounds, const RenderOptions& options) {
  Progress progress;
  const auto image = render_surface(surface, bounds, options, progress);
  return image ? std::string() : image.error().message;
}

int largest_difference(const Image& a, const Image& b) {
  EXPECT_EQ(a.pixels.size(), b.pixels.size());
  int largest = 0;
  for (std::size_t i = 0; i < std::min(a.pixels.size(), b.pixels.size()); ++i) {
    largest = std::max(
        {largest, std::abs(a.pixels[i].r - b.pixels[i].r), std::abs(a.pixels[i].g - b.pixels[i].g),
         std::abs(a.pixels[i].b - b.pixels[i].b), std::abs(a.pixels[i].a - b.pixels[i].a)});
  }
  return largest;
}

double covered_pixels(const Image& image) {
  double sum = 0;
  for (const Color& pixel : image.pixels) sum += pixel.a / 255.0;
  return sum;
}

/// The longest run of covered pixels in a row.
int longest_run(const Image& image) {
  int longest = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0, n = 0; x < image.width; ++x) {
      n = image.at(x, y).a > 127 ? n + 1 : 0;
      longest = std::max(longest, n);
    }
  return longest;
}

double lightness(const Color& pixel) {
  const Vec3f light = to_linear(pixel);
  return double{light[0]} + double{light[1]} + double{light[2]};
}

// A square in z = 0 seen straight from above.
Surface make_square(double half) {
  return test::parametric_surface(8, 8, [&](double u, double v) {
    return test::to_float({{half * (2 * u - 1), half * (2 * v - 1), 0}});
  });
}

Camera camera_above() {
  return {.eye = {{0, 0, 8}}, .target = {{0, 0, 0}}, .up = {{0, 1, 0}}, .field_of_view_deg = 20};
}

TEST(surface_renderer, covers_the_area_of_a_sphere) {
  RenderOptions options = small_options();
  options.background = kTransparent;
  options.camera = Camera{.eye = {{3, -4, 2}}, .target = {{0, 0, 0}}, .field_of_view_deg = 30};
  const Image image = render(test::make_sphere({{0, 0, 0}}, 0.9), kCube, options);
  // The sphere's outline is a cone round the view's axis: a circle in the picture.
  const double slope = std::tan(std::asin(0.9 / std::sqrt(29.0)));
  const double radius_px = slope / std::tan(15 * std::numbers::pi / 180) * options.height / 2;
  const double expected = std::numbers::pi * radius_px * radius_px;
  EXPECT_NEAR(covered_pixels(image), expected, 0.01 * expected);
}

TEST(surface_renderer, gives_the_same_pixels_for_any_number_of_threads) {
  const Surface torus = test::make_torus(0.7, 0.28);
  RenderOptions options = small_options();
  options.threads.count = 1;
  const Image one = render(torus, kCube, options);
  for (const int count : {2, 3, 8}) {
    options.threads.count = count;
    EXPECT_EQ(render(torus, kCube, options), one) << count << " threads";
  }
}

TEST(surface_renderer, draws_only_the_background_of_an_empty_surface) {
  RenderOptions options = small_options();
  options.background = {{10, 20, 30}, {200, 100, 50}};
  const Image image = render({}, kCube, options);
  ASSERT_EQ(image.pixels.size(), 160U * 120U);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 1; x < image.width; ++x) EXPECT_EQ(image.at(x, y), image.at(0, y));
  }
  EXPECT_NEAR(image.at(0, 0).r, 10, 2);
  EXPECT_NEAR(image.at(0, 119).r, 200, 2);
}

TEST(surface_renderer, draws_the_same_picture_at_any_scale_and_place) {
  RenderOptions options = small_options();
  const Image reference = render(test::make_sphere({{0, 0, 0}}, 0.8), kCube, options);
  for (const double scale : {1e-9, 1.0, 1e12}) {
    Surface surface = test::make_sphere({{0, 0, 0}}, 0.8 * scale);
    surface.origin = Vec3d{{1e6, -2e6, 3e6}} * scale;
    const Box3d bounds{surface.origin + kCube.lower * scale, surface.origin + kCube.upper * scale};
    // World coordinates of 3e6 radii keep 1e-10 of a radius: far below a pixel, but a sample on
    // an edge may fall to its other side.
    EXPECT_LE(largest_difference(render(surface, bounds, options), reference), 24) << scale;
  }
}

TEST(surface_renderer, looks_the_same_whichever_way_triangles_turn) {
  Surface torus = test::make_torus(0.7, 0.28);
  const Image reference = render(torus, kCube, small_options());
  for (auto& [a, b, c] : torus.triangles) std::swap(b, c);
  // Rounding in Embree may move a sample or two across an edge; the light must not change.
  EXPECT_LE(largest_difference(render(torus, kCube, small_options()), reference), 24);
}

TEST(surface_renderer, lights_the_inside_of_an_open_surface) {
  Surface bowl = test::make_sphere({{0, 0, 0}}, 0.9);
  std::erase_if(bowl.triangles, [&](const auto& t) { return bowl.positions[t[0]][2] > 0.1f; });
  RenderOptions options = small_options();
  options.camera = camera_above();
  options.background = kTransparent;
  EXPECT_GT(lightness(render(bowl, kCube, options).at(80, 60)), 0.2);
}

TEST(surface_renderer, shows_no_acne_on_a_plane) {
  for (const double tilt : {0.0, 60.0, 80.0}) {
    const double angle = tilt * std::numbers::pi / 180;
    RenderOptions options = small_options();
    options.color = Color{180, 180, 180};
    options.camera = camera_above();
    options.camera->eye = {{0, -8 * std::sin(angle), 8 * std::cos(angle)}};
    const Image image = render(make_square(1), kCube, options);
    const Color middle = image.at(80, 60);
    // Half a dozen pixels round the middle: light turns slowly with the view, acne does not.
    for (int y = 58; y <= 62; ++y) {
      for (int x = 74; x <= 86; ++x) EXPECT_NEAR(image.at(x, y).r, middle.r, 2) << tilt;
    }
  }
}

TEST(surface_renderer, darkens_hollows_and_casts_shadows) {
  Surface scene = make_square(1);
  const Surface ball = test::make_sphere({{0, 0, 0.3}}, 0.3, 48);
  const auto shift = static_cast<std::uint32_t>(scene.positions.size());
  scene.positions.insert(scene.positions.end(), ball.positions.begin(), ball.positions.end());
  for (const auto& [a, b, c] : ball.triangles) {
    scene.triangles.push_back({a + shift, b + shift, c + shift});
  }
  RenderOptions lit = small_options();
  lit.camera = camera_above();
  lit.ambient_occlusion = 0;
  lit.shadow = 0;
  RenderOptions hollow = lit;
  hollow.ambient_occlusion = 1;
  RenderOptions shadowed = lit;
  shadowed.shadow = 1;
  const Image bright = render(scene, kCube, lit);
  const Image occluded = render(scene, kCube, hollow);
  const Image shaded = render(scene, kCube, shadowed);
  // The ball's outline ends 13 pixels off the middle; the lamp, at the upper left, outshines the
  // sky where it reaches, so hollows are darkest in the shadow.
  RenderOptions both = hollow;
  both.shadow = 1;
  const Image dark = render(scene, kCube, both);
  EXPECT_LT(lightness(occluded.at(80 + 14, 60)), lightness(bright.at(80 + 14, 60)));
  EXPECT_LT(lightness(dark.at(80 + 12, 60 + 14)), 0.95 * lightness(shaded.at(80 + 12, 60 + 14)));
  EXPECT_NEAR(lightness(occluded.at(45, 30)), lightness(bright.at(45, 30)), 0.05);
  EXPECT_LT(lightness(shaded.at(80 + 12, 60 + 14)), 0.8 * lightness(bright.at(80 + 12, 60 + 14)));
  EXPECT_EQ(shaded.at(80 - 20, 60 - 20), bright.at(80 - 20, 60 - 20));
}

TEST(surface_renderer, colours_each_isovalue) {
  Surface scene = test::make_sphere({{-0.5, 0, 0}}, 0.4, 32);
  const Surface right = test::make_sphere({{0.5, 0, 0}}, 0.4, 32);
  scene.isovalues.assign(scene.positions.size(), 10.0f);
  const auto shift = static_cast<std::uint32_t>(scene.positions.size());
  scene.positions.insert(scene.positions.end(), right.positions.begin(), right.positions.end());
  scene.isovalues.resize(scene.positions.size(), 20.0f);
  for (const auto& [a, b, c] : right.triangles) {
    scene.triangles.push_back({a + shift, b + shift, c + shift});
  }
  RenderOptions options = small_options();
  options.camera = camera_above();
  const Image image = render(scene, kCube, options);
  EXPECT_GT(image.at(60, 60).b, image.at(60, 60).r);    // The first colour is a blue,
  EXPECT_GT(image.at(100, 60).r, image.at(100, 60).b);  // the second an orange.
  options.color = Color{128, 128, 128};
  const Image grey = render(scene, kCube, options);
  EXPECT_NEAR(grey.at(60, 60).r, grey.at(100, 60).r, 25);
}

TEST(surface_renderer, draws_contour_lines_from_above_with_their_width) {
  Surface circle;
  constexpr std::uint32_t kN = 200;
  for (std::uint32_t i = 0; i < kN; ++i) {
    const double phi = 2 * std::numbers::pi * i / kN;
    circle.positions.push_back(
        test::to_float({{50 + 40 * std::cos(phi), 50 + 40 * std::sin(phi), 7}}));
    circle.lines.push_back({i, (i + 1) % kN});
  }
  const Box3d bounds{{{0, 0, 7}}, {{100, 100, 7}}};
  RenderOptions options = small_options();
  options.background = kTransparent;
  options.line_width_px = 3;
  const Image image = render(circle, bounds, options);
  // A side of 100 fills the height but for the margin of 6 %.
  const double radius_px = 0.4 * options.height / 1.06;
  EXPECT_NEAR(covered_pixels(image) / (2 * std::numbers::pi * radius_px * 3), 1, 0.05);
  EXPECT_EQ(image.at(80, 60).a, 0);
}

TEST(surface_renderer, draws_lines_without_length_as_round_dots) {
  Surface dots;
  for (std::uint32_t i = 0; i < 16; ++i) {
    dots.positions.push_back(
        {{10 + 23.0F * static_cast<float>(i % 4), 11 + 23.0F * static_cast<float>(i / 4), 7}});
    dots.lines.push_back({i, i});
  }
  const Box3d bounds{{{0, 0, 7}}, {{100, 100, 7}}};
  RenderOptions options = small_options();
  options.background = kTransparent;
  options.line_width_px = 2;
  const Image image = render(dots, bounds, options);
  const double radius_px = kDotRadius * options.line_width_px / 2;
  EXPECT_NEAR(covered_pixels(image) / (16 * std::numbers::pi * radius_px * radius_px), 1, 0.05);
  EXPECT_NEAR(longest_run(image), 2 * radius_px, 1);
}

TEST(surface_renderer, uses_given_normals_and_survives_useless_ones) {
  Surface sphere = test::make_sphere({{0, 0, 0}}, 0.9);
  const Image reference = render(sphere, kCube, small_options());
  for (const Vec3f& p : sphere.positions) sphere.normals.push_back(normalized(p));
  EXPECT_LE(largest_difference(render(sphere, kCube, small_options()), reference), 16);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Vec3f& useless : {Vec3f{}, Vec3f{{nan, nan, nan}}}) {
    std::fill(sphere.normals.begin(), sphere.normals.end(), useless);
    EXPECT_LE(largest_difference(render(sphere, kCube, small_options()), reference), 40);
  }
}

TEST(surface_renderer, draws_what_lies_outside_the_bounds_and_degenerate_triangles) {
  Surface sphere = test::make_sphere({{3, 0, 0}}, 2);
  sphere.triangles.push_back({0, 0, 0});
  RenderOptions options = small_options();
  options.background = kTransparent;
  EXPECT_GT(covered_pixels(render(sphere, kCube, options)), 100);
  const Box3d point{{{3, 0, 0}}, {{3, 0, 0}}};
  options.camera = Camera{.eye = {{3, -20, 0}}, .target = {{3, 0, 0}}};
  EXPECT_GT(covered_pixels(render(sphere, point, options)), 100);
}

TEST(surface_renderer, refuses_broken_surfaces) {
  const float infinity = std::numeric_limits<float>::infinity();
  const Surface sphere = test::make_sphere({{0, 0, 0}}, 1, 8);
  Surface broken = sphere;
  broken.triangles[7][1] = 1000000;
  EXPECT_NE(error_of(broken, kCube, small_options()).find("triangle 7"), std::string::npos);
  broken = sphere;
  broken.lines.push_back({0, 1000000});
  EXPECT_NE(error_of(broken, kCube, small_options()).find("line 0"), std::string::npos);
  broken = sphere;
  broken.positions[3][2] = infinity;
  EXPECT_NE(error_of(broken, kCube, small_options()).find("vertex 3"), std::string::npos);
  broken = sphere;
  broken.origin[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(error_of(broken, kCube, small_options()).find("origin"), std::string::npos);
  broken = sphere;
  broken.normals.resize(2);
  EXPECT_NE(error_of(broken, kCube, small_options()).find("normals"), std::string::npos);
  broken = sphere;
  broken.isovalues.resize(2);
  EXPECT_NE(error_of(broken, kCube, small_options()).find("isovalues"), std::string::npos);
}

TEST(surface_renderer, refuses_unusable_options_and_bounds) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<RenderOptions> bad(7, small_options());
  bad[0].width = 0;
  bad[1].height = 100000;
  bad[2].samples_per_pixel = 0;
  bad[3].ambient_occlusion = nan;
  bad[4].shadow = 2;
  bad[5].line_width_px = 0;
  bad[6].camera = Camera{.eye = {{0, 0, 0}}};
  for (std::size_t i = 0; i < bad.size(); ++i) EXPECT_NE(error_of({}, kCube, bad[i]), "") << i;
  EXPECT_NE(error_of({}, {{{nan, 0, 0}}, {{1, 1, 1}}}, small_options()), "");
  EXPECT_NE(error_of({}, {{{2, 0, 0}}, {{1, 1, 1}}}, small_options()), "");
}

TEST(surface_renderer, stops_when_cancelled) {
  const Surface sphere = test::make_sphere({{0, 0, 0}}, 0.9, 32);
  RenderOptions options = small_options();
  options.height = 600;
  Progress before;
  before.cancel();
  const auto none = render_surface(sphere, kCube, options, before);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().message, cancelled_error().message);

  Progress* running = nullptr;
  double furthest = 0;
  Progress progress([&](std::string_view phase, double fraction, std::uint64_t) {
    if (phase != "rendering") return;
    furthest = std::max(furthest, fraction);
    running->cancel();
  });
  running = &progress;
  const auto half = render_surface(sphere, kCube, options, progress);
  ASSERT_FALSE(half);
  EXPECT_EQ(half.error().message, cancelled_error().message);
  EXPECT_LT(furthest, 0.5);
}

TEST(surface_renderer, reports_progress_that_rises_to_the_end) {
  std::vector<double> fractions;
  Progress progress([&](std::string_view phase, double fraction, std::uint64_t) {
    if (phase == "rendering") fractions.push_back(fraction);
  });
  ASSERT_TRUE(render_surface({}, kCube, small_options(), progress));
  ASSERT_FALSE(fractions.empty());
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
}

}  // namespace
}  // namespace lode

#include "lode/render/volume_renderer.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/models/all_targets.h"
#include "tests/render/shapes.h"
#include "tests/render/tetra_fixtures.h"

namespace lode::test {
namespace {

const TransferFunction kSmoke{
    {{0, {{0.1, 0.2, 0.9}}, 0.2}, {3, {{0.9, 0.6, 0.1}}, 6}, {7, {{1, 1, 1}}, 1}}};

RenderOptions small_picture(int threads = 1) {
  RenderOptions options;
  options.width = 90;
  options.height = 70;
  options.samples_per_pixel = 4;
  options.threads = {threads};
  return options;
}

Image rendered(const SimplexMesh& mesh, const TransferFunction& function,
               const OpaqueSurface& opaque, const RenderOptions& options) {
  Progress progress;
  const auto volume = MeshVolume::build(mesh, options.threads);
  EXPECT_TRUE(volume);
  auto image = render_volume({*volume, function, opaque}, options, progress);
  EXPECT_TRUE(image) << image.error().message;
  return image ? *image : Image{};
}

OpaqueSurface ball() {
  OpaqueSurface opaque{make_sphere({{0.5, 0.5, 0.5}}, 0.3, 32), {}};
  opaque.colors.uniform = {{0.8f, 0.1f, 0.1f}};
  return opaque;
}

int largest_difference(const Image& a, const Image& b) {
  int largest = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    for (const auto channel : {&Color::r, &Color::g, &Color::b, &Color::a})
      largest = std::max(largest, std::abs(a.pixels[i].*channel - b.pixels[i].*channel));
  return largest;
}

TEST(volume_renderer, has_the_same_pixels_for_any_number_of_threads) {
  SimplexMesh mesh = cube_mesh(6);
  shake(mesh, 6, 5);
  EXPECT_EQ(rendered(mesh, kSmoke, ball(), small_picture(1)),
            rendered(mesh, kSmoke, ball(), small_picture(3)));
}

TEST(volume_renderer, clear_volumes_leave_backdrop_and_surface_as_they_are) {
  const SimplexMesh mesh = cube_mesh(2);
  const TransferFunction clear{{{0, {{1, 1, 1}}, 0}}};
  RenderOptions options = small_picture();
  options.camera = Camera{{{2, -2, 1.5}}, {{0.5, 0.5, 0.5}}, {{0, 0, 1}}, 30};
  options.color = Color{200, 42, 42};
  OpaqueSurface opaque = ball();
  opaque.colors.uniform = to_linear(*options.color);
  Progress progress;
  const Box3d unit{{{0, 0, 0}}, {{1, 1, 1}}};
  const auto surface = render_surface(opaque.surface, unit, options, progress);
  ASSERT_TRUE(surface);
  EXPECT_LE(largest_difference(rendered(mesh, clear, opaque, options), *surface), 1);
  const auto nothing = render_surface({}, unit, options, progress);
  ASSERT_TRUE(nothing);
  EXPECT_EQ(rendered(mesh, clear, {}, options), *nothing);
  EXPECT_EQ(rendered({}, kSmoke, {}, options), *nothing);
}

TEST(volume_renderer, dense_volumes_hide_surfaces_and_thin_ones_veil_them) {
  const SimplexMesh mesh = cube_mesh(3);
  const RenderOptions options = small_picture();
  const TransferFunction dense{{{0, {{0.2, 0.5, 0.2}}, 500}}};
  const Image hidden = rendered(mesh, dense, ball(), options);
  EXPECT_EQ(hidden, rendered(mesh, dense, {}, options));
  EXPECT_EQ(hidden.at(45, 35), to_srgb({{0.2f, 0.5f, 0.2f}}));
  const TransferFunction thin{{{0, {{0.2, 0.5, 0.2}}, 0.5}}};
  const Image veiled = rendered(mesh, thin, ball(), options);
  EXPECT_GT(veiled.at(45, 35).r, veiled.at(45, 35).g);
  EXPECT_GT(rendered(mesh, thin, {}, options).at(45, 35).g, veiled.at(45, 35).g);
}

TEST(volume_renderer, transparent_backdrops_keep_what_the_volume_lets_through) {
  RenderOptions options = small_picture();
  options.background = {Color{0, 0, 0, 0}, Color{0, 0, 0, 0}};
  const double extinction = 1;
  const Image image = rendered(cube_mesh(2), {{{0, {{0.25, 1, 0.5}}, extinction}}}, {}, options);
  const Color middle = image.at(45, 35);
  EXPECT_GT(middle.a, 255 * (1 - std::exp(-1.0)));
  EXPECT_LT(middle.a, 255 * (1 - std::exp(-1.75)));
  EXPECT_EQ(to_srgb(to_linear(middle)).g, 255);
  EXPECT_NEAR(middle.r, to_srgb({{0.25f, 0, 0}}).r, 1);
  EXPECT_EQ(image.at(0, 0), (Color{0, 0, 0, 0}));
}

TEST(volume_renderer, has_the_same_pixels_for_all_vectors_of_the_processor) {
  SimplexMesh mesh = cube_mesh(6);
  shake(mesh, 6, 6);
  const Image best = rendered(mesh, kSmoke, {}, small_picture());
  for_each_target([&] { EXPECT_EQ(rendered(mesh, kSmoke, {}, small_picture()), best); });
}

TEST(volume_renderer, boundaries_are_films_denser_where_met_aslant) {
  const SimplexMesh mesh = cube_mesh(3);
  const auto volume = MeshVolume::build(mesh, {});
  ASSERT_TRUE(volume);
  RenderOptions options = small_picture();
  options.camera = Camera{{{0.5, -3, 0.5}}, {{0.5, 0.5, 0.5}}, {{0, 0, 1}}, 40};
  options.background = {Color{0, 0, 0, 0}, Color{0, 0, 0, 0}};
  const TransferFunction clear{{TransferKnot{}}};
  Progress progress;
  const auto image = render_volume({*volume, clear, {}, 0.2}, options, progress);
  ASSERT_TRUE(image);
  // Two films straight through.
  EXPECT_NEAR(image->at(45, 35).a, 255 * (1 - 0.8 * 0.8), 1);
  int densest = 0;
  for (const Color& pixel : image->pixels) densest = std::max<int>(densest, pixel.a);
  EXPECT_GT(densest, 110);
  EXPECT_EQ(image->at(1, 1).a, 0);
}

TEST(volume_renderer, what_cannot_be_drawn_is_refused) {
  const SimplexMesh mesh = cube_mesh(1);
  const auto volume = MeshVolume::build(mesh, {});
  ASSERT_TRUE(volume);
  Progress progress;
  EXPECT_FALSE(render_volume({*volume, {}, {}}, {}, progress));
  EXPECT_FALSE(render_volume({*volume, kSmoke, {}, 1.5}, small_picture(), progress));
  RenderOptions options = small_picture();
  options.width = 0;
  EXPECT_FALSE(render_volume({*volume, kSmoke, {}}, options, progress));
  OpaqueSurface broken = ball();
  broken.surface.triangles.push_back({0, 1, 1u << 30});
  EXPECT_FALSE(render_volume({*volume, kSmoke, broken}, small_picture(), progress));
  progress.cancel();
  EXPECT_FALSE(render_volume({*volume, kSmoke, {}}, small_picture(), progress));
}

TEST(volume_renderer, extreme_cameras_and_functions_give_pictures) {
  SimplexMesh mesh = cube_mesh(2);
  RenderOptions options = small_picture(2);
  options.samples_per_pixel = 1;
  const Vec3d middle{{0.5, 0.5, 0.5}};
  for (const Camera& camera : {Camera{{{1e100, 3, 2}}, middle, {{0, 0, 1}}, 1},
                               Camera{middle, {{1, 1, 1}}, {{0, 0, 1}}, 170},
                               Camera{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 0, 1}}, 90},
                               Camera{{{5, 5, 5}}, {{9, 9, 9}}, {{0, 0, 1}}, 40},
                               Camera{{{0.5, 0.5, 1}}, {{0.5, 0.5, 0}}, {{0, 1, 0}}, 60}}) {
    options.camera = camera;
    rendered(mesh, kSmoke, {}, options);
    rendered(mesh, {{{0, {{1, 1, 1}}, 1e100}, {1e-9, {{0, 0, 0}}, 0}}}, {}, options);
  }
  for (Vec3d& p : mesh.positions) p = p * 1e140;
  for (double& value : mesh.values) value *= 1e140;
  options.camera.reset();
  rendered(mesh, kSmoke, {}, options);
  rendered(mesh, {{{0, {{1, 1, 1}}, 1e100}, {1e-280, {{0, 0, 0}}, 0}}}, {}, options);
  rendered(mesh, {{{-1e300, {{1, 1, 1}}, 0}, {1e300, {{0, 0, 0}}, 1e100}}}, {}, options);
  for (Vec3d& p : mesh.positions) p = {{1, 2, 3}};
  rendered(mesh, kSmoke, {}, options);
}

}  // namespace
}  // namespace lode::test

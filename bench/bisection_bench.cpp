// Bisection of right triangles: milliseconds of finding all errors and of a mesh within a
// tolerance, on a tile of 512^2 samples, spectral fractals and etopo5; squares beside Martini
// (github.com/mapbox/martini), where LODE_MARTINI names its npm package, with ratios on one thread.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "bench/data_directory.h"
#include "bench/peers/martini.h"
#include "bench/timing.h"
#include "lode/api/built_terrain.h"
#include "lode/api/files.h"
#include "lode/api/picture_frame.h"
#include "lode/api/terrain_selection.h"
#include "lode/io/crs_metric.h"
#include "lode/models/terrain/right_triangle_bisection/extract.h"
#include "lode/models/terrain/right_triangle_bisection/locate.h"
#include "tests/oracles/fractal_terrain.h"

namespace lode::bench {
namespace {

using bisection::Bisection;
using bisection::find_triangle;
using bisection::height_in;

constexpr std::int32_t kMartiniSide = 4097;  ///< Of larger ones it keeps gigabytes.

struct Settings {
  int n_runs = 21;
  std::uint64_t seed = 3;
};

/// Prints median and smallest, in milliseconds, and returns the median.
template <typename Work>
double print_times(const std::string& name, int n_runs, const Work& work) {
  std::vector<double> ms;
  std::size_t n = 0;
  for (int i = 0; i < n_runs; ++i) {
    const auto start = Clock::now();
    n = work();
    ms.push_back(1000 * seconds_since(start));
  }
  fmt::print("{:44} {:>10.3f} {:>10.3f} {:>12}\n", name, median(ms), *std::ranges::min_element(ms),
             n);
  std::fflush(stdout);
  return median(ms);
}

/// What one thread took, as MartiniTimes has it.
struct OwnTimes {
  double errors_ms = 0;
  std::vector<double> mesh_ms{};
};

void race_martini(const std::string& name, const HeightGrid& grid,
                  const std::vector<double>& tolerances, const OwnTimes& own, int n_runs) {
  const auto peer = time_martini(grid, tolerances, n_runs);
  if (!peer) {
    fmt::print("{}: Martini: {}\n", name, peer.error().message);
    return;
  }
  fmt::print("{:44} {:>10.3f} {:>23}  ours {:.1f} times as fast\n",
             fmt::format("{}: Martini, errors", name), peer->errors_ms, "",
             peer->errors_ms / own.errors_ms);
  for (std::size_t k = 0; k < tolerances.size(); ++k) {
    const MartiniTimes::Mesh& mesh = peer->meshes[k];
    fmt::print("{:44} {:>10.3f} {:>10} {:>12}  ours {:.1f} times as fast; it errs by {:g}\n",
               fmt::format("{}: Martini, \"within {}\"", name, tolerances[k]), mesh.ms, "",
               mesh.n_triangles, mesh.ms / own.mesh_ms[k], mesh.true_error);
  }
  std::fflush(stdout);
}

void measure(const std::string& name, const HeightGrid& grid, const std::vector<double>& tolerances,
             const Settings& settings) {
  Progress progress;
  const auto built = Bisection::build(grid, {}, progress);
  if (!built) {
    fmt::print("{}: {}\n", name, built.error().message);
    return;
  }
  OwnTimes own;
  for (const int n_threads : {2, 1})
    own.errors_ms = print_times(
        fmt::format("{}: errors, {} threads", name, n_threads), settings.n_runs,
        [&] { return Bisection::build(grid, {n_threads}, progress)->lattice().size(); });
  for (const double tolerance : tolerances) {
    double ms = 0;
    for (const int n_threads : {2, 1})
      ms = print_times(
          fmt::format("{}: within {}, {} threads", name, tolerance, n_threads), settings.n_runs,
          [&] { return tin_within(*built, grid, tolerance, {n_threads}).triangles.size(); });
    own.mesh_ms.push_back(ms);
  }
  if (std::max(grid.n_columns, grid.n_rows) <= kMartiniSide)
    race_martini(name, grid, tolerances, own, settings.n_runs);
}

/// Heights at random places from the errors alone, one thread: millions a second.
void ask_heights(const std::string& name, const HeightGrid& grid, double tolerance) {
  constexpr int kPlaces = 1'000'000;
  Progress progress;
  const auto tree = Bisection::build(grid, {}, progress);
  if (!tree) return;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> column(0, grid.n_columns - 1);
  std::uniform_real_distribution<double> row(0, grid.n_rows - 1);
  std::vector<std::array<double, 2>> places(kPlaces);
  for (auto& place : places) place = {column(random), row(random)};
  double sum = 0;
  const double seconds = median_seconds([&] {
    const auto start = Clock::now();
    for (const auto& [x, y] : places)
      if (const auto found = find_triangle(*tree, tolerance, x, y))
        sum += height_in(*found, grid, x, y);
    return seconds_since(start);
  });
  fmt::print("{:44} {:>10.3f} million heights a second (mean {:.3f})\n",
             fmt::format("{}: heights within {}", name, tolerance), kPlaces / seconds / 1e6,
             sum / 7 / kPlaces);
}

void measure_file(const std::string& name, const HeightReadOptions& options,
                  const std::vector<double>& tolerances, const Settings& settings) {
  const auto path = data_directory() / "terrain" / name;
  Progress progress;
  const auto raster = read_heights(path.string(), options, progress);
  if (!raster) {
    fmt::print("{}: skipped, {}\n", name, raster.error().message);
    return;
  }
  measure(name.substr(0, name.find('_')), raster->grid, tolerances, settings);
}

/// The periodic fractal with its first column and row once more at the end.
HeightGrid closed_fractal(std::int32_t side, std::uint64_t seed) {
  using Samples = HeightGrid::Samples<std::uint16_t>;
  const HeightGrid open = oracles::make_fractal_terrain(side, seed);
  HeightGrid grid = make_height_grid<std::uint16_t>(side + 1, side + 1);
  const auto& from = std::get<Samples>(open.heights);
  auto& to = std::get<Samples>(grid.heights);
  for (std::int32_t y = 0; y <= side; ++y)
    for (std::int32_t x = 0; x <= side; ++x)
      to[static_cast<std::size_t>(y * grid.stride + x)] =
          from[static_cast<std::size_t>(y % side * open.stride + x % side)];
  return grid;
}

/// A flight over etopo5 from the Atlantic to the Himalaya, down from 3000 to 150 km of its picture
/// with heights ten times: each frame's mesh within a pixel of 1920 x 1080, made anew.
void fly(const HeightGrid& grid, const std::string& name, double exaggeration,
         const Settings& settings) {
  constexpr int kFrames = 100;
  Progress progress;
  const auto built = BuiltTerrain::build(
      grid, {.model = TerrainModel::right_triangle_bisection, .levels = {0}}, progress);
  const auto metric = io::read_metric(grid.crs);
  if (!built || !metric) return;
  const auto frame = picture_frame(grid, height_range(grid), *metric, exaggeration);
  if (!frame) return;
  std::vector<double> ms;
  std::vector<double> n_triangles;
  double worst_px = 0;
  for (int i = 0; i < kFrames * std::max(1, settings.n_runs / 21); ++i) {
    const double t = static_cast<double>(i % kFrames) / (kFrames - 1);
    const double height = 3e6 * std::pow(150e3 / 3e6, t);
    Vec3d target = frame->place(
        {{-40 + 126 * t + 360 * (grid.to_world[0] >= 0 && -40 + 126 * t < 0), 10 + 18 * t}}, 0);
    Camera camera;
    camera.target = target;
    camera.eye = target + Vec3d{{-1.2 * height, -0.4 * height, height}};
    camera.field_of_view_deg = 45;
    TerrainFocus focus;
    focus.metric = *metric;
    focus.view =
        TerrainView{.view = {camera, 1920, 1080}, .exaggeration = exaggeration, .max_error_px = 1};
    const auto start = Clock::now();
    const auto made =
        built->terrain().origin().select({.focus = focus}, delaunay::TinLinks::left_out, progress);
    ms.push_back(1000 * seconds_since(start));
    if (!made) {
      fmt::print("{}: {}\n", name, made.error().message);
      return;
    }
    n_triangles.push_back(static_cast<double>(made->report.triangles));
    worst_px = std::max(worst_px, made->report.view->achieved_px);
  }
  fmt::print("{:44} {:>10.3f} {:>10.3f} {:>12}  most {:.1f} ms, {} triangles; worst {:.3f} px\n",
             fmt::format("{}: frames of a flight, {} times", name, exaggeration), median(ms),
             *std::ranges::min_element(ms), median(n_triangles), *std::ranges::max_element(ms),
             *std::ranges::max_element(n_triangles), worst_px);
}

int run(const Settings& settings) {
  fmt::print("{:44} {:>10} {:>10} {:>12}\n", "", "median ms", "fastest ms", "triangles");
  measure_file("fuji_terrain_rgb_512x512.png", {.encoding = HeightEncoding::terrain_rgb},
               {30, 10, 1}, settings);
  const HeightGrid tile = closed_fractal(512, settings.seed);
  measure("fractal 513^2", tile, {655.35}, settings);
  const HeightGrid fractal = closed_fractal(4096, settings.seed);
  measure("fractal 4097^2", fractal, {655.35, 196.605, 65.535}, settings);
  measure_file("etopo5_4320x2161_int16.tif", {}, {1000, 100}, settings);
  Progress progress;
  const auto path = data_directory() / "terrain" / "etopo5_4320x2161_int16.tif";
  if (const auto etopo = read_heights(path.string(), {}, progress)) {
    for (const double tolerance : {1000.0, 100.0, 0.0})
      ask_heights("etopo5", etopo->grid, tolerance);
    for (const double exaggeration : {1.0, 10.0})
      fly(etopo->grid, "etopo5", exaggeration, settings);
  }
  return 0;
}

}  // namespace
}  // namespace lode::bench

int main(int argc, char** argv) {
  lode::bench::Settings settings;
  CLI::App app("Bisection of right triangles: errors and meshes");
  app.add_option("--seed", settings.seed, "Of the fractal");
  app.add_option("--runs", settings.n_runs, "Of each, an odd number")->check(CLI::Range(1, 999));
  CLI11_PARSE(app, argc, argv);
  return lode::bench::run(settings);
}

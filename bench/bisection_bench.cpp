// Bisection of right triangles: milliseconds of finding all errors and of a mesh within a
// tolerance, on a tile of 512^2 samples, a spectral fractal of 4097^2 and etopo5. It races nobody:
// what Martini and hmm take of the same is in docs/models/right_triangle_bisection.md.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "bench/data_directory.h"
#include "bench/timing.h"
#include "lode/api/files.h"
#include "lode/models/terrain/right_triangle_bisection/extract.h"
#include "tests/oracles/fractal_terrain.h"

namespace lode::bench {
namespace {

using bisection::Bisection;

struct Settings {
  int n_runs = 21;
  std::uint64_t seed = 3;
};

/// Median and smallest, in milliseconds.
template <typename Work>
void print_times(const std::string& name, int n_runs, const Work& work) {
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
}

void measure(const std::string& name, const HeightGrid& grid, const std::vector<double>& tolerances,
             const Settings& settings) {
  Progress progress;
  const auto built = Bisection::build(grid, {}, progress);
  if (!built) {
    fmt::print("{}: {}\n", name, built.error().message);
    return;
  }
  for (const int n_threads : {1, 2})
    print_times(fmt::format("{}: errors, {} threads", name, n_threads), settings.n_runs,
                [&] { return Bisection::build(grid, {n_threads}, progress)->lattice().size(); });
  for (const double tolerance : tolerances)
    print_times(fmt::format("{}: within {}", name, tolerance), settings.n_runs,
                [&] { return tin_within(*built, grid, tolerance).triangles.size(); });
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

int run(const Settings& settings) {
  fmt::print("{:44} {:>10} {:>10} {:>12}\n", "", "median ms", "fastest ms", "triangles");
  measure_file("fuji_terrain_rgb_512x512.png", {.encoding = HeightEncoding::terrain_rgb},
               {30, 10, 1}, settings);
  const HeightGrid tile = closed_fractal(512, settings.seed);
  measure("fractal 513^2", tile, {655.35}, settings);
  const HeightGrid fractal = closed_fractal(4096, settings.seed);
  measure("fractal 4097^2", fractal, {655.35, 196.605, 65.535}, settings);
  measure_file("etopo5_4320x2161_int16.tif", {}, {1000, 100}, settings);
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

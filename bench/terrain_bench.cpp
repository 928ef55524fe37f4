// The Delaunay selector on a spectral fractal of 4096^2 samples of 16 bits: seconds, on two threads
// in tiles and levels and on one in the strict order, triangles, and whether what came is right;
// beside hmm (github.com/fogleman/hmm), a greedy insertion in C++ on one thread, where a program of
// that name is in PATH or named by LODE_HMM. Its seconds, of the processor, hold reading a PNG and
// writing an STL file. At the end how many times as fast as hmm the orders are.

#include <fmt/format.h>
#include <png.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "bench/timing.h"
#include "lode/api/terrain.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/delaunay/tile_insertion.h"
#include "lode/delaunay/tin.h"
#include "tests/oracles/fractal_terrain.h"

namespace lode::bench {
namespace {

constexpr double kRange = 65535;

struct Settings {
  std::int32_t side = 4096;
  std::uint64_t seed = 3;
  int n_runs = 3;
  bool is_unchecked = false;
  int n_threads = 2;
  std::vector<double> errors{0.01, 0.001, 0.0003};  ///< Shares of the range of heights.
};

struct Run {
  double seconds = 0;
  std::uint64_t n_triangles = 0;
  std::uint64_t n_vertices = 0;
};

/// The same in tiles, until they are put together with numbered corners.
Run select_in_tiles(const HeightGrid& grid, double max_error, Threads threads) {
  const auto start = Clock::now();
  Progress progress;
  auto tiles = delaunay::insert_in_tiles<std::uint16_t>(
      grid, 0, kRange, {.max_error = max_error, .threads = threads}, progress);
  if (!tiles) return {};
  const delaunay::Tin tin = delaunay::to_tin(*tiles, threads);
  return {seconds_since(start), tin.triangles.size(), tin.vertices.size()};
}

/// The selector itself: the domain and insertion, until there is a mesh.
Run select(const HeightGrid& grid, double max_error, InsertionOrder order, Threads threads) {
  const auto start = Clock::now();
  if (order == InsertionOrder::tiles) return select_in_tiles(grid, max_error, threads);
  const delaunay::LatticePacking packing(grid.n_columns);
  const auto domain = delaunay::find_domain(grid);
  delaunay::LatticeMesh mesh(packing, domain->triangles);
  const auto& samples = std::get<HeightGrid::Samples<std::uint16_t>>(grid.heights);
  Progress progress;
  (void)delaunay::insert_greedily(
      mesh, delaunay::SampleRows<std::uint16_t>{samples.data(), grid.stride, packing}, 0, kRange,
      {.max_error = max_error, .order = order, .threads = threads}, progress);
  const double seconds = seconds_since(start);
  const delaunay::Tin tin = delaunay::to_tin(mesh);
  return {seconds, tin.triangles.size(), tin.vertices.size()};
}

/// "right", or the first check that fails.
std::string check(const HeightGrid& grid, double max_error, InsertionOrder order) {
  Progress progress;
  const auto made = extract_terrain(grid, {.max_error = max_error, .order = order}, progress);
  if (!made) return made.error().message;
  const auto shape = order == InsertionOrder::tiles ? TinShape::tiles : TinShape::delaunay;
  const auto report =
      verify_terrain(grid, made->surface, {.max_error = max_error, .shape = shape}, progress);
  if (!report) return report.error().message;
  for (const VerifyReport::Check& one : report->checks)
    if (!one.passed) return one.name + ": " + one.detail;
  return "right";
}

/// By error.
using Medians = std::vector<Run>;

Medians race(const HeightGrid& grid, const Settings& settings, InsertionOrder order) {
  Medians medians;
  for (const double share : settings.errors) {
    std::vector<Run> runs;
    for (int i = 0; i < settings.n_runs; ++i)
      runs.push_back(select(grid, share * kRange, order, {settings.n_threads}));
    const auto by_time = [](const Run& a, const Run& b) { return a.seconds < b.seconds; };
    std::sort(runs.begin(), runs.end(), by_time);
    medians.push_back(runs[runs.size() / 2]);
    fmt::print("{:8} {:>8} {:>10.3f} {:>10.3f} {:>12} {:>12}  {}\n", name_of(order), share,
               runs[runs.size() / 2].seconds, runs.front().seconds, runs.front().n_triangles,
               runs.front().n_vertices,
               settings.is_unchecked ? "not checked" : check(grid, share * kRange, order));
    std::fflush(stdout);
  }
  return medians;
}

/// LODE_HMM, else hmm in PATH, else "".
std::string find_hmm() {
  if (const char* named = std::getenv("LODE_HMM")) return named;
  const char* path = std::getenv("PATH");
  for (std::string rest = path == nullptr ? "" : path; !rest.empty();) {
    const std::string folder = rest.substr(0, rest.find(':'));
    rest.erase(0, std::min(rest.size(), folder.size() + 1));
    if (access((folder + "/hmm").c_str(), X_OK) == 0) return folder + "/hmm";
  }
  return "";
}

bool write_png(const std::string& path, const HeightGrid& grid) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return false;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  const auto n = static_cast<png_uint_32>(grid.n_columns);
  png_set_compression_level(png, 1);
  png_set_IHDR(png, info, n, static_cast<png_uint_32>(grid.n_rows), 16, PNG_COLOR_TYPE_GRAY,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  png_set_swap(png);
  const auto& samples = std::get<HeightGrid::Samples<std::uint16_t>>(grid.heights);
  for (std::int32_t y = 0; y < grid.n_rows; ++y)
    png_write_row(png, reinterpret_cast<const png_byte*>(samples.data() + y * grid.stride));
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return std::fclose(file) == 0;
}

/// Processor seconds of a program, or nothing where it fails.
std::optional<double> run_program(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const auto used = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  const pid_t child = fork();
  if (child == 0) {
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  int status = 0;
  rusage usage{};
  if (child < 0 || wait4(child, &status, 0, &usage) != child || status != 0) return std::nullopt;
  return used(usage.ru_utime) + used(usage.ru_stime);
}

/// The count that an STL file states.
std::uint32_t stl_triangles(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, 80> head{};
  std::uint32_t n = 0;
  file.read(head.data(), head.size());
  file.read(reinterpret_cast<char*>(&n), sizeof n);
  return file ? n : 0;
}

std::optional<Medians> race_hmm(const HeightGrid& grid, const std::vector<double>& errors) {
  const std::string program = find_hmm();
  if (program.empty()) {
    fmt::print("hmm: skipped, neither LODE_HMM nor PATH has it\n");
    return std::nullopt;
  }
  std::string folder = std::filesystem::temp_directory_path() / "lode_bench_XXXXXX";
  if (mkdtemp(folder.data()) == nullptr) return std::nullopt;
  Medians found;
  const std::string png = folder + "/fractal.png";
  const std::string stl = folder + "/fractal.stl";
  if (write_png(png, grid))
    for (const double share : errors) {
      const auto seconds =
          run_program({program, png, stl, "-z", "1000", "-e", fmt::format("{}", share), "-q"});
      found.push_back({seconds.value_or(0), stl_triangles(stl), 0});
      if (seconds)
        fmt::print("{:8} {:>8} {:>10.3f} {:>10} {:>12}\n", "hmm", share, *seconds, "",
                   stl_triangles(stl));
      else
        fmt::print("{:8} {:>8} failed\n", "hmm", share);
      std::fflush(stdout);
    }
  std::filesystem::remove_all(folder);
  return found;
}

void compare(InsertionOrder order, const Medians& own, const Medians& hmm,
             const std::vector<double>& errors) {
  for (std::size_t i = 0; i < hmm.size(); ++i) {
    if (hmm[i].n_triangles == 0 || own[i].n_triangles == 0) continue;
    const auto more =
        static_cast<double>(own[i].n_triangles) / static_cast<double>(hmm[i].n_triangles) - 1;
    fmt::print("{:8} {:>8} {:>9.1f} times as fast as hmm, {:+.2f} % triangles\n", name_of(order),
               errors[i], hmm[i].seconds / own[i].seconds, 100 * more);
  }
}

int run(const Settings& settings) {
  const HeightGrid grid = oracles::make_fractal_terrain(settings.side, settings.seed);
  fmt::print(
      "fractal of {0} x {0} samples, seed {1}; seconds of {2} runs, {3} threads in tiles and "
      "levels\n",
      settings.side, settings.seed, settings.n_runs, settings.n_threads);
  fmt::print("{:8} {:>8} {:>10} {:>10} {:>12} {:>12}  {}\n", "order", "error", "median s",
             "fastest s", "triangles", "vertices", "checked");
  constexpr std::array kOrders{InsertionOrder::tiles, InsertionOrder::levels,
                               InsertionOrder::strict};
  std::array<Medians, kOrders.size()> medians;
  for (std::size_t i = 0; i < kOrders.size(); ++i) medians[i] = race(grid, settings, kOrders[i]);
  const auto hmm = race_hmm(grid, settings.errors);
  for (std::size_t i = 0; hmm && i < kOrders.size(); ++i)
    compare(kOrders[i], medians[i], *hmm, settings.errors);
  return 0;
}

}  // namespace
}  // namespace lode::bench

int main(int argc, char** argv) {
  lode::bench::Settings settings;
  CLI::App app("The Delaunay selector on a spectral fractal, beside hmm");
  app.add_option("--side", settings.side, "Samples along a side, a power of two");
  app.add_option("--seed", settings.seed, "Of the fractal");
  app.add_option("--runs", settings.n_runs, "Of each, an odd number")->check(CLI::Range(1, 99));
  app.add_option("--threads", settings.n_threads)->check(CLI::Range(1, 64));
  app.add_option("--errors", settings.errors, "Shares of the range of heights")
      ->delimiter(',')
      ->check(CLI::PositiveNumber);
  app.add_flag("--unchecked", settings.is_unchecked, "Do not verify what comes");
  CLI11_PARSE(app, argc, argv);
  return lode::bench::run(settings);
}

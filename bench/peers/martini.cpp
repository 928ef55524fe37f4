#include "bench/peers/martini.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <utility>

namespace lode::bench {
namespace {

using Place = std::array<std::int64_t, 2>;

/// 2^n + 1.
std::int32_t martini_side(const HeightGrid& grid) {
  const auto cells = static_cast<std::uint32_t>(std::max(grid.n_columns, grid.n_rows) - 1);
  return static_cast<std::int32_t>(std::bit_ceil(std::max(cells, 1U))) + 1;
}

/// Of a raster that its last row and column continue.
double height_at(const HeightGrid& grid, const Place& at) {
  return grid.height(static_cast<std::int32_t>(std::min<std::int64_t>(at[0], grid.n_columns - 1)),
                     static_cast<std::int32_t>(std::min<std::int64_t>(at[1], grid.n_rows - 1)));
}

void write_heights(const HeightGrid& grid, std::int32_t side, const std::string& path) {
  std::vector<float> heights;
  heights.reserve(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  for (std::int32_t y = 0; y < side; ++y)
    for (std::int32_t x = 0; x < side; ++x)
      heights.push_back(static_cast<float>(height_at(grid, {x, y})));
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(heights.data()),
             static_cast<std::streamsize>(heights.size() * sizeof(float)));
}

std::vector<std::uint32_t> read_numbers(std::ifstream& file, std::size_t n) {
  std::vector<std::uint32_t> numbers(n);
  file.read(reinterpret_cast<char*>(numbers.data()),
            static_cast<std::streamsize>(n * sizeof(std::uint32_t)));
  if (!file) numbers.clear();
  return numbers;
}

/// Twice the area, of a triangle.
std::int64_t turn(const Place& a, const Place& b, const Place& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// The largest difference at the raster's samples in a triangle.
double error_in(const HeightGrid& grid, const std::array<Place, 3>& corners) {
  const std::int64_t area = turn(corners[0], corners[1], corners[2]);
  if (area == 0) return 0;
  const auto [left, right] = std::minmax({corners[0][0], corners[1][0], corners[2][0]});
  const auto [top, bottom] = std::minmax({corners[0][1], corners[1][1], corners[2][1]});
  std::array<double, 3> heights{};
  for (std::size_t k = 0; k < 3; ++k) heights[k] = height_at(grid, corners[k]);
  double worst = 0;
  for (std::int64_t y = top; y <= std::min<std::int64_t>(bottom, grid.n_rows - 1); ++y)
    for (std::int64_t x = left; x <= std::min<std::int64_t>(right, grid.n_columns - 1); ++x) {
      double height = 0;
      bool is_inside = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int64_t part = turn(corners[(k + 1) % 3], corners[(k + 2) % 3], {x, y});
        is_inside = is_inside && (part == 0 || (part > 0) == (area > 0));
        height += heights[k] * static_cast<double>(part) / static_cast<double>(area);
      }
      if (is_inside) worst = std::max(worst, std::abs(height - height_at(grid, {x, y})));
    }
  return worst;
}

double true_error(const HeightGrid& grid, const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<std::uint32_t> counts = read_numbers(file, 2);
  if (counts.empty()) return std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::uint32_t> places = read_numbers(file, std::size_t{2} * counts[0]);
  const std::vector<std::uint32_t> corners = read_numbers(file, std::size_t{3} * counts[1]);
  if (places.empty() || corners.empty()) return std::numeric_limits<double>::quiet_NaN();
  double worst = 0;
  for (std::size_t t = 0; t + 2 < corners.size(); t += 3) {
    std::array<Place, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t at = std::size_t{2} * corners[t + k];
      triangle[k] = {places[at], places[at + 1]};
    }
    worst = std::max(worst, error_in(grid, triangle));
  }
  return worst;
}

/// What a command prints, or an Error.
Result<std::string> output_of(const std::string& command) {
  std::FILE* const pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return fail("skipped, cannot run: {}", command);
  std::string text;
  std::array<char, 4096> part{};
  while (const std::size_t n = std::fread(part.data(), 1, part.size(), pipe))
    text.append(part.data(), n);
  if (pclose(pipe) != 0) return fail("skipped, failed: {}", command);
  return text;
}

Result<MartiniTimes> parse(const std::string& text) {
  MartiniTimes times;
  std::istringstream lines(text);
  std::string word;
  while (lines >> word) {
    MartiniTimes::Mesh mesh;
    if (word == "errors" && lines >> times.errors_ms) continue;
    if (word != "mesh" || !(lines >> mesh.ms >> mesh.n_triangles))
      return fail("skipped, expected its times, got '{}'", text);
    times.meshes.push_back(mesh);
  }
  return times;
}

}  // namespace

Result<MartiniTimes> time_martini(const HeightGrid& grid, const std::vector<double>& tolerances,
                                  int n_runs) {
  const char* const package = std::getenv("LODE_MARTINI");
  if (package == nullptr)
    return fail("skipped, LODE_MARTINI does not name the folder of the npm package");
  std::string folder = std::filesystem::temp_directory_path() / "lode_bench_XXXXXX";
  if (mkdtemp(folder.data()) == nullptr) return fail("skipped, no temporary folder");
  const std::string heights = folder + "/heights";
  const std::int32_t side = martini_side(grid);
  write_heights(grid, side, heights);
  std::string command = fmt::format("node '{}/peers/martini.mjs' '{}' '{}' {} {}",
                                    LODE_BENCH_SOURCES, package, heights, side, n_runs);
  for (const double tolerance : tolerances) command += fmt::format(" {}", tolerance);
  const auto printed = output_of(command);
  Result<MartiniTimes> times = printed ? parse(*printed) : printed.error();
  if (times && times->meshes.size() != tolerances.size())
    times = fail("skipped, expected {} meshes", tolerances.size());
  for (std::size_t k = 0; times && k < tolerances.size(); ++k)
    times->meshes[k].true_error = true_error(grid, fmt::format("{}.{}", heights, k));
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  return times;
}

}  // namespace lode::bench

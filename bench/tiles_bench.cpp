// Tiles of a large raster: etopo5 beside itself, mirrored so that it goes on, and perturbed, from
// file to folder. Samples a second, and how much memory it comes to need. It races nobody: no
// maker of quantized-mesh tiles is packaged. `--side 40000` writes a raster of 3.2 GB.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <variant>
#include <vector>

#include "bench/data_directory.h"
#include "bench/timing.h"
#include "lode/api/files.h"
#include "lode/api/terrain_tiles.h"
#include "lode/core/peak_memory.h"

namespace lode::bench {
namespace {

/// Of the whole raster, and degrees between samples.
constexpr std::int32_t kSide = 40'000;
constexpr double kStep = 0.0025;

struct Settings {
  std::int32_t side = 4000;
  std::int32_t first_column = 0;  ///< Of 40,000 by 40,000 samples in 100 by 100 degrees.
  std::int32_t first_row = 0;
  double max_error = 100;
  std::uint64_t most_bytes = std::uint64_t{512} << 20;
  int n_threads = 2;
  std::string folder;  ///< To make all in, and to keep; empty: temporary.
};

/// Pseudo-random, -8 to 7 metres (SplitMix64's last steps).
int perturbation(std::int32_t row, std::int32_t column) {
  std::uint64_t x = (static_cast<std::uint64_t>(row) << 32U) | static_cast<std::uint32_t>(column);
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9U;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBU;
  return static_cast<int>(x >> 60U) - 8;
}

/// There and back again, without a step.
std::int32_t mirrored(std::int32_t i, std::int32_t n) {
  const std::int32_t at = i % (2 * n - 2);
  return at < n ? at : 2 * n - 2 - at;
}

/// Writes `path`.bil and its header, which GDAL reads as EHdr.
bool write_raster(const std::string& path, const HeightGrid& etopo, const Settings& settings) {
  static_assert(std::endian::native == std::endian::little);
  const auto* samples = std::get_if<HeightGrid::Samples<std::int16_t>>(&etopo.heights);
  if (samples == nullptr) return false;
  std::ofstream header(path + ".hdr");
  header << fmt::format(
      "ncols {0}\nnrows {0}\nnbands 1\nnbits 16\npixeltype signedint\nbyteorder I\nlayout bil\n"
      "ulxmap {1}\nulymap {2}\nxdim {3}\nydim {3}\n",
      settings.side, (settings.first_column - kSide / 2 + 0.5) * kStep,
      (kSide / 2 - settings.first_row - 0.5) * kStep, kStep);
  std::ofstream projection(path + ".prj");
  projection << "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563]],"
                "PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]]\n";
  std::ofstream file(path + ".bil", std::ios::binary);
  std::vector<std::int16_t> row(static_cast<std::size_t>(settings.side));
  for (std::int32_t y = 0; y < settings.side; ++y) {
    const std::int32_t whole_y = settings.first_row + y;
    const std::int16_t* from = samples->data() + mirrored(whole_y, etopo.n_rows) * etopo.stride;
    for (std::int32_t x = 0; x < settings.side; ++x) {
      const std::int32_t whole_x = settings.first_column + x;
      row[static_cast<std::size_t>(x)] = static_cast<std::int16_t>(
          from[mirrored(whole_x, etopo.n_columns)] + perturbation(whole_y, whole_x));
    }
    file.write(reinterpret_cast<const char*>(row.data()),
               static_cast<std::streamsize>(row.size() * sizeof row[0]));
  }
  return header.flush().good() && projection.flush().good() && file.flush().good();
}

void print(const TerrainTileReport& report, double seconds, const Settings& settings) {
  fmt::print("{:>5} {:>8} {:>12} {:>12} {:>14} {:>10} {:>10}\n", "level", "tiles", "triangles",
             "vertices", "bytes", "error, m", "measured");
  for (std::size_t i = 0; i < report.levels.size(); ++i) {
    const TerrainTileReport::Level& level = report.levels[i];
    fmt::print("{:>5} {:>8} {:>12} {:>12} {:>14} {:>10.6g} {:>10.6g}\n", i, level.n_tiles,
               level.n_triangles, level.n_vertices, level.n_bytes, level.max_error, level.error);
  }
  const double samples = static_cast<double>(settings.side) * settings.side;
  fmt::print("{:.1f} s, {:.3f} million samples a second\n", seconds, 1e-6 * samples / seconds);
}

int run(const Settings& settings) {
  Progress progress;
  const auto path = data_directory() / "terrain" / "etopo5_4320x2161_int16.tif";
  std::string folder = settings.folder;
  if (folder.empty()) {
    folder = std::filesystem::temp_directory_path() / "lode_bench_XXXXXX";
    if (mkdtemp(folder.data()) == nullptr) return 1;
  } else {
    std::filesystem::create_directories(folder);
  }
  const std::string raster = folder + "/etopo5_tiled";
  {
    const auto etopo = read_heights(path.string(), {}, progress);
    if (!etopo) {
      fmt::print("skipped: {}\n", etopo.error().message);
      return 0;
    }
    if (!write_raster(raster, etopo->grid, settings)) {
      fmt::print("{}: could not be written\n", raster);
      return 1;
    }
  }
  fmt::print("{0} x {0} samples of {1:.6g} degrees, within {2} m, {3} threads, limit {4} MB\n",
             settings.side, kStep, settings.max_error, settings.n_threads,
             settings.most_bytes >> 20U);
  std::fflush(stdout);
  const PeakMemory memory;
  const auto start = Clock::now();
  const auto report = write_terrain_tiles(raster + ".bil", {},
                                          {.max_error = settings.max_error,
                                           .most_bytes = settings.most_bytes,
                                           .threads = {settings.n_threads}},
                                          folder + "/tiles", progress);
  const double seconds = seconds_since(start);
  if (report)
    print(*report, seconds, settings);
  else
    fmt::print("{}\n", report.error().message);
  if (const auto bytes = memory.bytes()) fmt::print("{} MB more memory at most\n", *bytes >> 20U);
  if (settings.folder.empty()) std::filesystem::remove_all(folder);
  return report ? 0 : 1;
}

}  // namespace
}  // namespace lode::bench

int main(int argc, char** argv) {
  lode::bench::Settings settings;
  CLI::App app("Tiles of etopo5 beside itself");
  app.add_option("--side", settings.side, "Samples along a side")
      ->check(CLI::Range(2, lode::bench::kSide));
  app.add_option("--first-column", settings.first_column, "Of the whole")
      ->check(CLI::Range(0, lode::bench::kSide));
  app.add_option("--first-row", settings.first_row, "Of the whole")
      ->check(CLI::Range(0, lode::bench::kSide));
  app.add_option("--max-error", settings.max_error, "Of the finest level, metres");
  app.add_option("--memory-limit", settings.most_bytes, "Of what is kept of the raster, bytes");
  app.add_option("--threads", settings.n_threads)->check(CLI::Range(1, 64));
  app.add_option("--folder", settings.folder, "To make everything in, and to keep");
  CLI11_PARSE(app, argc, argv);
  return lode::bench::run(settings);
}

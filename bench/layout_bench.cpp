// What the layout of a .lode file costs and saves: its size against zstd, and how much of it
// queries touch, against the same samples in row-major order and in plain bricks.
//
// Lode: header and directory, the coarse levels that are read first, and every block that the query
// reads, each counted once, as they are stored. Starts from a closed file.
// The rivals are told which samples the answer has at the corners of its simplices, and touch the
// least that holds these: no index, no search, no neighbours for normals, nothing read in vain. A
// reader of such a file knows neither them nor what error they leave; it would touch more.
//   pages     4 KiB pages of the raw samples, x fastest
//   slabs     whole slices of the raw samples along z
//   bricks    of 64^3 and 32^3 samples, each compressed by zstd, level 3
//   whole     the raw samples
// Queries, at one isovalue of each volume:
//   overview  the best surface of 20,000 simplices
//   coarse    the surface within 10, 3 and 1 % of the range
//   isovalue  the surface refined until no error is left
//   region    the same in the box round the middle that has 1/64 of the samples; the rivals need
//   the
//             cells in it that the isovalue crosses
// Sizes: "zstd" is level 3 of the raw samples as one stream. "beside" is all that is no data. Rates
// are raw bytes of all blocks in a second of one thread's processor time, fastest of three runs.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "bench/layout/lode_reads.h"
#include "bench/report.h"
#include "bench/volume_cases.h"
#include "lode/store/codec.h"

namespace lode::bench {
namespace {

constexpr double kRefinedFully = 1e-6;  ///< Of the range: above 0, as nothing is loaded whole then.

constexpr std::uint64_t kOverviewCells = 20000;

struct Case {
  VolumeCase volume;
  Volume samples;
  std::string path;  ///< Of the .lode file.
  double range = 0;
  PlainBricks bricks_64, bricks_32;
};

double size_per_sample(const Case& c, std::uint64_t n_bytes) {
  return static_cast<double>(n_bytes) / static_cast<double>(c.samples.info.grid.n_samples());
}

Row size_row(const Case& c, const FileFacts& facts) {
  const std::uint64_t zstd = store::zstd_compress(c.samples.samples).size();
  const double data = size_per_sample(c, facts.data_bytes);
  const double attributes = size_per_sample(c, facts.attribute_bytes);
  const double other = size_per_sample(c, facts.other_bytes);
  fmt::print(
      "{:<18} {:>8.4f} {:>8.4f} {:>6.3f} {:>10.4f} {:>9.5f} {:>7.4f} {:>7} {:>6.0f} {:>6.0f}\n",
      c.volume.name, data, size_per_sample(c, zstd), data / size_per_sample(c, zstd), attributes,
      other, attributes + other, facts.n_blocks, facts.write_rate / 1e6, facts.read_rate / 1e6);
  return {.name = "size/" + c.volume.name,
          .counts = {{"samples", static_cast<double>(c.samples.info.grid.n_samples())},
                     {"raw_bytes", static_cast<double>(c.samples.samples.size())},
                     {"data_bytes", static_cast<double>(facts.data_bytes)},
                     {"zstd_3_bytes", static_cast<double>(zstd)},
                     {"attribute_bytes", static_cast<double>(facts.attribute_bytes)},
                     {"other_bytes", static_cast<double>(facts.other_bytes)},
                     {"blocks", static_cast<double>(facts.n_blocks)},
                     {"write_bytes_per_s", facts.write_rate},
                     {"read_bytes_per_s", facts.read_rate}}};
}

/// Touched by Lode, and what the rivals touch of it, as multiples of Lode's bytes.
Row touch_row(const Case& c, const std::string& query, const Touched& lode,
              const SampleSet& samples) {
  const std::size_t size = size_of(c.samples.info.type);
  Row row{.name = query + "/" + c.volume.name,
          .counts = {{"lode_blocks", static_cast<double>(lode.blocks)},
                     {"lode_bytes", static_cast<double>(lode.bytes)},
                     {"whole_bytes", static_cast<double>(c.samples.samples.size())}}};
  fmt::print("{:<18} {:<13} {:>6} {:>9.1f}", c.volume.name, query, lode.blocks,
             static_cast<double>(lode.bytes) / 1e3);
  const auto add = [&](const std::string& name, const Touched& touched) {
    row.counts[name + "_blocks"] = static_cast<double>(touched.blocks);
    row.counts[name + "_bytes"] = static_cast<double>(touched.bytes);
    fmt::print(" {:>8} {:>6.2f}", touched.blocks,
               static_cast<double>(touched.bytes) / static_cast<double>(lode.bytes));
  };
  add("pages", touched_pages(samples, size));
  add("slabs", touched_slabs(samples, size));
  add("bricks_64", c.bricks_64.touched(samples));
  add("bricks_32", c.bricks_32.touched(samples));
  fmt::print(" {:>6.2f}\n", row.counts["whole_bytes"] / row.counts["lode_bytes"]);
  return row;
}

/// The box round the middle of the volume with a quarter of its samples along each axis.
IndexBox middle_of(const Index3& dims) {
  IndexBox box;
  for (std::size_t i = 0; i < 3; ++i) {
    box.lower[i] = dims[i] * 3 / 8;
    box.upper[i] = std::max(box.lower[i] + 2, dims[i] * 5 / 8);
  }
  return box;
}

/// The box of world space between its outermost samples.
Box3d world_box(const RegularGrid& grid, const IndexBox& box) {
  Box3d world;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3d p;
    for (std::size_t i = 0; i < 3; ++i)
      p[i] = (corner >> i & 1) != 0 ? box.upper[i] - 1 : box.lower[i];
    p = grid.to_world(p);
    for (std::size_t i = 0; i < 3; ++i) {
      world.lower[i] = corner == 0 ? p[i] : std::min(world.lower[i], p[i]);
      world.upper[i] = corner == 0 ? p[i] : std::max(world.upper[i], p[i]);
    }
  }
  return world;
}

Result<void> run_queries(const Case& c, std::vector<Row>& rows) {
  LODE_TRY(const Touched base, read_for_overview(c.path, c.volume.isovalue, kOverviewCells));
  LODE_TRY(const SampleSet corners, corners_of_overview(c.path, c.volume.isovalue, kOverviewCells));
  rows.push_back(touch_row(c, "overview", base, corners));
  struct Coarse {
    const char* name;
    double relative_error;
  };
  constexpr Coarse kTolerances[] = {{"coarse 10 %", 0.1},
                                    {"coarse 3 %", 0.03},
                                    {"coarse 1 %", 0.01},
                                    {"isovalue", kRefinedFully}};
  for (const auto& [name, relative_error] : kTolerances) {
    const double tolerance = relative_error * c.range;
    LODE_TRY(const Touched lode, read_for_surface(c.path, c.volume.isovalue, tolerance));
    LODE_TRY(const SampleSet samples, corners_of_cut(c.path, c.volume.isovalue, tolerance));
    rows.push_back(touch_row(c, name, lode, samples));
  }
  const RegularGrid& grid = c.samples.info.grid;
  const IndexBox box = middle_of(grid.dims);
  LODE_TRY(const Touched lode,
           read_for_box(c.path, c.volume.isovalue, kRefinedFully * c.range, world_box(grid, box)));
  rows.push_back(touch_row(c, "region", lode, crossed_cells(c.samples, c.volume.isovalue, box)));
  return {};
}

void print_size_heading() {
  fmt::print(
      "Bytes a sample: data, zstd -3 of the raw samples, their ratio, attributes, header and\n"
      "directory, all beside the data; blocks; MB/s written and read\n{:<18} {:>8} {:>8} {:>6} "
      "{:>10} {:>9} {:>7} {:>7} {:>6} {:>6}\n",
      "volume", "data", "zstd", "ratio", "attributes", "directory", "beside", "blocks", "write",
      "read");
}

void print_touch_heading() {
  fmt::print(
      "\nTouched: blocks and kB of Lode; of each rival how many, and bytes over Lode's\n"
      "{:<18} {:<13} {:>6} {:>9} {:>8} {:>6} {:>8} {:>6} {:>8} {:>6} {:>8} {:>6} {:>6}\n",
      "volume", "query", "blocks", "kB", "pages", "ratio", "slabs", "ratio", "64^3", "ratio",
      "32^3", "ratio", "whole");
}

/// Those of volume_cases() that come from files, the smallest volumes, and the bundled sample.
std::vector<VolumeCase> layout_cases() {
  std::vector<VolumeCase> cases;
  cases.push_back({.name = "samples_tooth",
                   .file = std::filesystem::absolute("samples/tooth.nrrd").string(),
                   .isovalue = 600.5});
  cases.push_back({.name = "fuel", .file = "fuel_64x33x32_uint8.nrrd", .isovalue = 80.5});
  cases.push_back({.name = "neghip",
                   .file = "neghip_66x66x66_uint8.raw",
                   .raw_dims = Index3{{66, 66, 66}},
                   .isovalue = 60.5});
  cases.push_back(
      {.name = "iron_protein", .file = "iron_protein_68x68x68_uint8.vtk", .isovalue = 60.5});
  for (VolumeCase& c : volume_cases())
    if (!c.field) cases.push_back(std::move(c));
  return cases;
}

Result<Case> open_case(const VolumeCase& volume, const std::string& path) {
  LODE_TRY(Volume samples, load(volume));
  PlainBricks bricks_64(samples, 64);
  PlainBricks bricks_32(samples, 32);
  return Case{volume, std::move(samples), path, 0, std::move(bricks_64), std::move(bricks_32)};
}

Result<void> run_case(const VolumeCase& volume, const std::string& path, bool with_queries,
                      std::vector<Row>& rows) {
  LODE_TRY(Case c, open_case(volume, path));
  Progress progress;
  LODE_TRY(const auto dataset,
           Dataset::build(*make_memory_source(c.samples), {.threads = {2}}, progress));
  const DatasetInfo info = dataset.describe();
  c.range = info.range_max - info.range_min;
  LODE_TRY(const FileFacts facts, write_file(dataset, path));
  if (with_queries) return run_queries(c, rows);
  rows.push_back(size_row(c, facts));
  return {};
}

int run(const std::string& only, const std::string& json_path) {
  const std::string path = (std::filesystem::temp_directory_path() /
                            fmt::format("lode_layout_bench_{}.lode", ::getpid()))
                               .string();
  std::vector<Row> rows;
  for (const bool with_queries : {false, true}) {
    if (with_queries)
      print_touch_heading();
    else
      print_size_heading();
    for (const VolumeCase& volume : layout_cases()) {
      if (volume.name.find(only) == std::string::npos) continue;
      if (const auto done = run_case(volume, path, with_queries, rows); !done)
        fmt::print("{:<18} {}\n", volume.name, done.error().message);
      std::fflush(stdout);
    }
  }
  std::filesystem::remove(path);
  if (json_path.empty()) return 0;
  if (const auto written = write_json(rows, json_path); !written) {
    fmt::print(stderr, "layout_bench: {}\n", written.error().message);
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace lode::bench

int main(int argc, char** argv) {
  CLI::App app("Sizes of .lode files, and what queries touch of them.");
  std::string only;
  std::string json_path;
  app.add_option("--only", only, "Only cases whose name contains this");
  app.add_option("--json", json_path, "Also write the rows to this file");
  CLI11_PARSE(app, argc, argv);
  return lode::bench::run(only, json_path);
}

// Build and extraction of regular volumes, with VTK's Flying Edges (and quadric decimation after
// it) on the same samples in the same run. Both sides use two threads and start from memory.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include <hwy/highway.h>

#include "bench/floor.h"
#include "bench/peers/flying_edges.h"
#include "bench/report.h"
#include "bench/surface_distance.h"
#include "bench/volume_cases.h"
#include "lode/api/dataset.h"
#include "lode/core/stopwatch.h"

namespace lode::bench {
namespace {

constexpr Threads kThreads{2};

struct Settings {
  std::string only;  ///< Only cases whose name contains this.
  std::string json_path;
  bool is_simplified = false;  ///< Only the rows of simplification.
  bool is_full = false;        ///< Only those of full resolution without normals.
};

struct Timed {
  Seconds seconds;
  std::uint64_t triangles = 0;
  double achieved_error = 0;
  std::uint64_t surface_bytes = 0;  ///< Ours.
};

/// Whose memory the surface takes: that of the last run, as the interface offers, or new one.
enum class Memory { reused, fresh };

template <typename T>
std::uint64_t bytes_of(const std::vector<T>& array) {
  return array.size() * sizeof(T);
}

Result<Timed> time_ours(const Dataset& dataset, const VolumeCase& volume_case, double max_error,
                        Normals normals, Memory memory = Memory::reused,
                        SurfaceStyle style = SurfaceStyle::tetra) {
  Timed timed;
  Surface surface;
  Progress progress;
  const ExtractOptions options{.isovalues = {volume_case.isovalue},
                               .max_error = max_error,
                               .style = style,
                               .normals = normals,
                               .threads = kThreads};
  const Work work = [&]() -> Result<void> {
    if (memory == Memory::fresh) surface = Surface();
    LODE_TRY(const ExtractReport report, dataset.extract(options, surface, progress));
    timed.triangles = report.triangles;
    timed.achieved_error = report.achieved_error;
    return {};
  };
  LODE_TRY(timed.seconds, time_runs(volume_case.name, work));
  timed.surface_bytes =
      bytes_of(surface.positions) + bytes_of(surface.isovalues) + bytes_of(surface.triangles);
  return timed;
}

template <typename Extract>
Result<Timed> time_peer(const VolumeCase& volume_case, const Extract& extract) {
  Timed timed;
  const Work work = [&]() -> Result<void> {
    LODE_TRY(const PeerCounts counts, extract());
    timed.triangles = counts.triangles;
    return {};
  };
  LODE_TRY(timed.seconds, time_runs(volume_case.name, work));
  return timed;
}

Row versus(std::string name, const Timed& ours, std::string peer, const Timed& theirs,
           const std::string& note) {
  return {.name = std::move(name),
          .ours_s = ours.seconds.median,
          .peer = std::move(peer),
          .peer_s = theirs.seconds.median,
          .ours_fastest_s = ours.seconds.fastest,
          .peer_fastest_s = theirs.seconds.fastest,
          .counts = {{"ours_triangles", static_cast<double>(ours.triangles)},
                     {"peer_triangles", static_cast<double>(theirs.triangles)},
                     {"ours_achieved_error", ours.achieved_error}},
          .note = note};
}

Row build_row(std::string name, double n_samples, const Seconds& seconds) {
  return {.name = std::move(name),
          .ours_s = seconds.median,
          .peer = {},
          .peer_s = {},
          .ours_fastest_s = seconds.fastest,
          .peer_fastest_s = {},
          .counts = {{"samples", n_samples}, {"samples_per_s", n_samples / seconds.median}},
          .note = fmt::format("{:.1f} M samples/s, fastest {:.1f}",
                              n_samples / seconds.median / 1e6, n_samples / seconds.fastest / 1e6)};
}

/// The whole build, and the part of it that finds errors and ranges: what comes after the last time
/// that it said it was reading.
Result<Dataset> run_build(const VolumeCase& volume_case, const Volume& volume, Table& table) {
  std::optional<Stopwatch> since_reading;
  Progress progress([&](std::string_view phase, double, std::uint64_t) {
    if (phase == "reading") since_reading.emplace();
  });
  std::vector<double> attributes;
  const auto source = make_memory_source(volume);
  std::optional<Dataset> dataset;
  const Work work = [&]() -> Result<void> {
    dataset.reset();
    LODE_TRY(dataset, Dataset::build(*source, {.threads = kThreads}, progress));
    if (since_reading) attributes.push_back(since_reading->seconds());
    return {};
  };
  LODE_TRY(const Seconds seconds, time_runs(volume_case.name, work));
  const auto n_samples = static_cast<double>(volume.info.grid.n_samples());
  table.add(build_row("build/" + volume_case.name, n_samples, seconds));
  if (!attributes.empty()) {
    std::sort(attributes.begin(), attributes.end());
    table.add(build_row("errors_ranges/" + volume_case.name, n_samples,
                        {attributes[attributes.size() / 2], attributes.front()}));
  }
  return std::move(*dataset);
}

/// Full resolution against moving its bytes once.
Result<void> run_floor(const VolumeCase& volume_case, const Volume& volume, const Timed& ours,
                       Table& table) {
  Floor floor(volume, volume_case.isovalue, ours.surface_bytes);
  Timed moved;
  LODE_TRY(moved.seconds, time_runs(volume_case.name, [&]() -> Result<void> {
             floor.run(kThreads);
             return {};
           }));
  table.add(versus("floor/" + volume_case.name, ours, "moving its bytes once", moved,
                   fmt::format("{:.1f} MB of crossed blocks read, {:.1f} MB written",
                               static_cast<double>(floor.bytes_read()) / 1e6,
                               static_cast<double>(floor.bytes_written()) / 1e6)));
  return {};
}

Result<Timed> run_full(const VolumeCase& volume_case, const Volume& volume, const Dataset& dataset,
                       Normals normals, Table& table) {
  const bool with_normals = normals == Normals::on;
  FlyingEdges peer(volume, volume_case.isovalue, with_normals ? PeerNormals::on : PeerNormals::off);
  LODE_TRY(const Timed ours, time_ours(dataset, volume_case, 0, normals));
  LODE_TRY(const Timed theirs, time_peer(volume_case, [&] { return peer.extract(); }));
  table.add(versus((with_normals ? "full_normals/" : "full/") + volume_case.name, ours,
                   with_normals ? "vtkFlyingEdges3D, normals" : "vtkFlyingEdges3D", theirs,
                   peer.note()));
  if (!with_normals) LODE_CHECK(run_floor(volume_case, volume, ours, table));
  return theirs;
}

/// Full resolution with vertices on the grid's edges alone, as Flying Edges has them.
Result<void> run_cubes(const VolumeCase& volume_case, const Dataset& dataset, const Timed& peer,
                       Table& table) {
  for (const Memory memory : {Memory::reused, Memory::fresh}) {
    const bool is_fresh = memory == Memory::fresh;
    LODE_TRY(const Timed ours,
             time_ours(dataset, volume_case, 0, Normals::off, memory, SurfaceStyle::cubes));
    table.add(versus((is_fresh ? "cubes_fresh/" : "cubes/") + volume_case.name, ours,
                     "vtkFlyingEdges3D", peer,
                     is_fresh ? "memory of its own each time" : "vertices on grid edges"));
  }
  return {};
}

/// Full resolution with new memory each time, and without the longest vectors.
Result<void> run_full_otherwise(const VolumeCase& volume_case, const Dataset& dataset,
                                const Timed& peer, Table& table) {
  LODE_TRY(const Timed fresh, time_ours(dataset, volume_case, 0, Normals::off, Memory::fresh));
  table.add(versus("full_fresh/" + volume_case.name, fresh, "vtkFlyingEdges3D", peer,
                   "memory of its own each time"));
#if HWY_ARCH_X86
  for (const SurfaceStyle style : {SurfaceStyle::tetra, SurfaceStyle::cubes}) {
    hwy::DisableTargets(HWY_AVX3 | HWY_AVX3_DL);
    hwy::GetChosenTarget().DeInit();
    auto narrow = time_ours(dataset, volume_case, 0, Normals::off, Memory::reused, style);
    hwy::DisableTargets(0);
    hwy::GetChosenTarget().DeInit();
    if (!narrow) return narrow.error();
    const std::string name = style == SurfaceStyle::cubes ? "cubes_avx2/" : "full_avx2/";
    table.add(
        versus(name + volume_case.name, *narrow, "vtkFlyingEdges3D", peer, "without AVX-512"));
  }
#endif
  return {};
}

Result<void> run_adaptive(const VolumeCase& volume_case, const Volume& volume,
                          const Dataset& dataset, const Timed& full_peer, Table& table) {
  const DatasetInfo info = dataset.describe();
  const double max_error = volume_case.relative_error * (info.range_max - info.range_min);
  LODE_TRY(const Timed ours, time_ours(dataset, volume_case, max_error, Normals::off));
  const std::string note =
      fmt::format("max error {:.2g} % of the range", 100 * volume_case.relative_error);
  table.add(versus("adaptive/" + volume_case.name, ours, "vtkFlyingEdges3D (full resolution)",
                   full_peer, note));
  FlyingEdges peer(volume, volume_case.isovalue, PeerNormals::off);
  const auto decimate = [&] { return peer.extract_and_decimate(ours.triangles); };
  LODE_TRY(const Timed decimated, time_peer(volume_case, decimate));
  table.add(versus("adaptive_decimated/" + volume_case.name, ours,
                   "vtkFlyingEdges3D + vtkQuadricDecimation", decimated, note));
  return {};
}

/// Simplified within one voxel, against decimation to as many triangles. Each side's surface is
/// held against its own full resolution; only ours promises anything.
Result<void> run_simplified(const VolumeCase& volume_case, const Volume& volume,
                            const Dataset& dataset, SurfaceStyle style, Table& table) {
  const Vec3d& spacing = volume.info.grid.spacing;
  const double voxel = std::min({spacing[0], spacing[1], spacing[2]});
  ExtractOptions options{.isovalues = {volume_case.isovalue},
                         .max_error = 0,
                         .style = style,
                         .normals = Normals::off,
                         .threads = kThreads};
  Progress progress;
  Surface full;
  LODE_CHECK(dataset.extract(options, full, progress));
  options.simplify = Simplify::edges;
  options.simplify_distance = voxel;
  Timed ours;
  Surface surface;
  double proven = 0;
  const Work work = [&]() -> Result<void> {
    LODE_TRY(const ExtractReport report, dataset.extract(options, surface, progress));
    ours.triangles = report.triangles;
    proven = report.simplified->proven_distance;
    return {};
  };
  LODE_TRY(ours.seconds, time_runs(volume_case.name, work));
  FlyingEdges peer(volume, volume_case.isovalue, PeerNormals::off);
  const auto decimate = [&] { return peer.extract_and_decimate(ours.triangles); };
  LODE_TRY(const Timed theirs, time_peer(volume_case, decimate));
  const Surface decimated = peer.surface();
  LODE_CHECK(peer.extract());
  const TwoSidedDistance own = measure_distance(full, surface, voxel / 3, kThreads);
  const TwoSidedDistance other = measure_distance(peer.surface(), decimated, voxel / 3, kThreads);
  const std::string name = style == SurfaceStyle::cubes ? "simplified_cubes/" : "simplified/";
  table.add(versus(name + volume_case.name, ours, "vtkFlyingEdges3D + vtkQuadricDecimation", theirs,
                   fmt::format("in voxels, measured from and to full resolution{}: ours {:.3f} and "
                               "{:.3f} (proven {:.3f}), theirs {:.3f} and {:.3f}",
                               style == SurfaceStyle::cubes ? ", in cubes" : "",
                               own.from_first / voxel, own.from_second / voxel, proven / voxel,
                               other.from_first / voxel, other.from_second / voxel)));
  return {};
}

Result<void> run_case(const VolumeCase& volume_case, const Settings& settings, Table& table) {
  LODE_TRY(const Volume volume, load(volume_case));
  LODE_TRY(const Dataset dataset, run_build(volume_case, volume, table));
  const auto simplify = [&]() -> Result<void> {
    LODE_CHECK(run_simplified(volume_case, volume, dataset, SurfaceStyle::tetra, table));
    return run_simplified(volume_case, volume, dataset, SurfaceStyle::cubes, table);
  };
  if (settings.is_simplified) return simplify();
  LODE_TRY(const Timed peer, run_full(volume_case, volume, dataset, Normals::off, table));
  LODE_CHECK(run_cubes(volume_case, dataset, peer, table));
  LODE_CHECK(run_full_otherwise(volume_case, dataset, peer, table));
  if (settings.is_full) return {};
  LODE_CHECK(run_full(volume_case, volume, dataset, Normals::on, table));
  LODE_CHECK(run_adaptive(volume_case, volume, dataset, peer, table));
  return simplify();
}

int run(const Settings& settings) {
  print_heading(describe_peer());
  Table table;
  for (const VolumeCase& volume_case : volume_cases()) {
    if (volume_case.name.find(settings.only) == std::string::npos) continue;
    if (auto done = run_case(volume_case, settings, table); !done)
      table.add({.name = volume_case.name, .note = done.error().message});
  }
  return write_table(table, "volume_bench", settings.json_path);
}

}  // namespace
}  // namespace lode::bench

int main(int argc, char** argv) {
  lode::bench::keep_freed_memory();
  CLI::App app("Times building and extracting volumes against VTK.");
  lode::bench::Settings settings;
  app.add_option("--only", settings.only, "Only cases whose name contains this");
  app.add_flag("--simplified", settings.is_simplified, "Only build and simplified surfaces");
  app.add_flag("--full", settings.is_full, "Only build and full resolution, without normals");
  app.add_option("--json", settings.json_path, "Also write the rows to this file");
  CLI11_PARSE(app, argc, argv);
  return lode::bench::run(settings);
}

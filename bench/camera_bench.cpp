// Moving cameras: recorded paths replayed, one update a frame, as a session does it but on this
// thread. Per path: updates, time, achieved pixels, triangles changed, and the share of nodes that
// lie at full resolution, where no hierarchy can save anything.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>

#include "bench/volume_cases.h"
#include "lode/api/live_query.h"
#include "lode/render/camera_path.h"

namespace lode::bench {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

struct Settings {
  std::string only = "gaussians40_513";
  std::string path;
  double max_error_px = 1;
};

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

struct Measured {
  std::vector<double> ms;
  std::vector<double> steps_ms;
  std::vector<double> updates;
  std::vector<double> cells_changed;
  double achieved_px = 0;
  std::size_t n_cells = 0;
  Standing standing;
};

/// One frame: the new camera to the answer, and the batch that tells the reader.
void advance(LiveQuery& live, const Query& query, Measured& measured) {
  const auto start = Clock::now();
  auto step_start = start;
  live.set_query(query);
  std::size_t n_steps = 0;
  while (live.step()) {
    const auto now = Clock::now();
    measured.steps_ms.push_back(
        std::chrono::duration<double, std::milli>(now - step_start).count());
    step_start = now;
    ++n_steps;
  }
  SurfaceBatch batch;
  while (!live.gather(4096, batch)) {
  }
  measured.ms.push_back(milliseconds_since(start));
  measured.updates.push_back(static_cast<double>(n_steps));
  measured.cells_changed.push_back(static_cast<double>(batch.cells.size()));
}

void replay(const std::string& name, LiveQuery& live, Query query,
            const std::vector<Camera>& cameras) {
  Measured measured;
  query.view->camera = cameras.front();
  advance(live, query, measured);  // from wherever the last path ended
  const double first_ms = measured.ms.front();
  measured = {};
  for (std::size_t i = 1; i < cameras.size(); ++i) {
    query.view->camera = cameras[i];
    advance(live, query, measured);
    if (i % 20 == 0) measured.achieved_px = std::max(measured.achieved_px, live.achieved_px());
  }
  const Standing standing = live.standing();
  fmt::print(
      "{:<8} {:>8.1f} {:>8.2f} {:>8.2f} {:>8.2f} {:>9.0f} {:>9.0f} {:>8.2f} {:>9} {:>9} {:>8.3f} "
      "{:>7.3f}\n",
      name, first_ms, percentile(measured.ms, 0.5), percentile(measured.ms, 0.99),
      percentile(measured.ms, 1), percentile(measured.updates, 0.5),
      percentile(measured.cells_changed, 0.5), measured.achieved_px, standing.n_applied,
      live.n_cells(), percentile(measured.steps_ms, 0.999), live.finest_share());
  std::fflush(stdout);
}

Result<void> run_case(const VolumeCase& volume_case, const Settings& settings) {
  LODE_TRY(const auto volume, load(volume_case));
  const auto source = make_memory_source(volume);
  Progress progress;
  LODE_TRY(const auto dataset, Dataset::build(*source, {.threads = {2}}, progress));
  const auto start = Clock::now();
  LODE_TRY(const auto live, open_live_query(dataset, {}, progress));
  fmt::print("{}: world errors in {:.0f} ms, {} px at 1920 x 1080\n", volume_case.name,
             milliseconds_since(start), settings.max_error_px);
  fmt::print("{:<8} {:>8} {:>8} {:>8} {:>8} {:>9} {:>9} {:>8} {:>9} {:>9} {:>8} {:>7}\n", "path",
             "first ms", "median", "99 %", "worst", "steps", "slots", "px", "nodes", "triangles",
             "step ms", "finest");
  Query query;
  query.isovalues = {volume_case.isovalue};
  query.max_error_px = settings.max_error_px;
  query.view = View{};
  const Box3d bounds = dataset.describe().volume.grid.world_bounds();
  for (const char* path : {"orbit", "fly-in", "jump"}) {
    if (!settings.path.empty() && settings.path != path) continue;
    LODE_TRY(const auto cameras, camera_path(path, bounds));
    replay(path, *live, query, cameras);
  }
  return {};
}

}  // namespace
}  // namespace lode::bench

int main(int argc, char** argv) {
  using namespace lode::bench;
  CLI::App app("Camera paths");
  Settings settings;
  app.add_option("--only", settings.only, "Cases whose name contains this");
  app.add_option("--path", settings.path, "orbit, fly-in or jump");
  app.add_option("--max-error-px", settings.max_error_px, "Tolerance in pixels");
  CLI11_PARSE(app, argc, argv);
  for (const VolumeCase& volume_case : volume_cases()) {
    if (volume_case.name.find(settings.only) == std::string::npos) continue;
    if (const auto done = run_case(volume_case, settings); !done)
      fmt::print("{}: {}\n", volume_case.name, done.error().message);
  }
  return 0;
}

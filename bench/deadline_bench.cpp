// Answers by a deadline: how late they come, and how good they are. The model is open; a surface
// counts once it is in memory as a Surface with normals.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <random>

#include "bench/volume_cases.h"
#include "lode/api/focused_surface.h"

namespace lode::bench {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Lateness over 100 deadlines between 5 and 200 ms.
Result<void> measure_lateness(const std::string& name, const Dataset& dataset, double isovalue) {
  std::mt19937 random(1);
  std::vector<double> late_ms;
  Surface surface;
  Progress progress;
  for (int i = 0; i < 100; ++i) {
    FocusedOptions options;
    options.query.isovalues = {isovalue};
    options.deadline_s = 0.005 + 0.195 * static_cast<double>(random() % 1000) / 1000;
    const auto start = Clock::now();
    LODE_TRY(const auto report, extract_focused(dataset, options, surface, progress));
    late_ms.push_back(
        1000 * (report.standing.is_settled ? 0.0 : seconds_since(start) - *options.deadline_s));
  }
  std::sort(late_ms.begin(), late_ms.end());
  fmt::print("{:<18} late by: median {:>6.2f} ms, 99 % {:>6.2f} ms, worst {:>6.2f} ms\n", name,
             late_ms[50], late_ms[98], late_ms[99]);
  return {};
}

/// Error bounds at shares of the time that the whole answer takes.
Result<void> measure_progress(const std::string& name, const Dataset& dataset, double isovalue,
                              double tolerance) {
  Surface surface;
  Progress progress;
  FocusedOptions options;
  options.query.isovalues = {isovalue};
  options.query.max_error = tolerance;
  auto start = Clock::now();
  LODE_TRY(const auto whole, extract_focused(dataset, options, surface, progress));
  const double seconds = seconds_since(start);
  fmt::print("{:<18} whole {:.0f} ms, {} triangles, error bound {:.4g}; relative to it after", name,
             1000 * seconds, surface.triangles.size(), whole.standing.error_bound);
  for (const double share : {0.01, 0.03, 0.1, 0.3}) {
    options.deadline_s = share * seconds;
    LODE_TRY(const auto part, extract_focused(dataset, options, surface, progress));
    fmt::print(" {:.0f} %: {:.1f}", 100 * share,
               part.standing.error_bound / whole.standing.error_bound);
  }
  fmt::print("\n");
  return {};
}

Result<void> run_case(const VolumeCase& volume_case) {
  LODE_TRY(const auto volume, load(volume_case));
  const auto source = make_memory_source(volume);
  Progress progress;
  LODE_TRY(const auto dataset, Dataset::build(*source, {.threads = {2}}, progress));
  const DatasetInfo info = dataset.describe();
  LODE_CHECK(measure_lateness(volume_case.name, dataset, volume_case.isovalue));
  return measure_progress(volume_case.name, dataset, volume_case.isovalue,
                          volume_case.relative_error * (info.range_max - info.range_min));
}

}  // namespace
}  // namespace lode::bench

int main(int argc, char** argv) {
  return lode::bench::run_cases(argc, argv, "Answers by a deadline", lode::bench::run_case);
}

#include "bench/papers/tables_1_2.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "bench/papers/live_run.h"
#include "bench/timing.h"
#include "lode/models/diamond/build.h"

namespace lode::bench {
namespace {

using diamond::Inheritance;

std::string milliseconds(double seconds) { return fmt::format("{:.1f}", seconds * 1e3); }

std::string share_text(double share) { return fmt::format("{:.0f} %", 100 * share); }

/// Empty where the paper has none.
std::string paper_seconds(double seconds) {
  return seconds > 0 ? fmt::format("{}", seconds) : std::string();
}

Table preprocessing_table() {
  return {"preprocessing",
          "Table 1: preprocessing (ours: the build in memory, by the clock, the shortest of seven)",
          {{"data", "data set"},
           {"samples", "samples"},
           {"one_thread_ms", "one thread, ms"},
           {"two_threads_ms", "two threads, ms"},
           {"paper_data", "the paper's"},
           {"paper_s", "its time, s"}},
          {}};
}

Table counts_table() {
  return {"extraction_counts",
          "Table 2: vertices interpolated with and without inheritance. Resolution: the share of "
          "the nodes that full resolution (tolerance 0) refines, best first",
          {{"data", "data set"},
           {"isovalue", "isovalue"},
           {"resolution", "resolution"},
           {"nodes", "nodes"},
           {"triangles", "triangles"},
           {"error_left", "error left"},
           {"with", "interpolated with"},
           {"without", "without"},
           {"factor", "factor"}},
          {}};
}

Table times_table() {
  return {"extraction_times",
          "Table 2: extraction with and without inheritance, ms; the paper's in seconds",
          {{"data", "data set"},
           {"resolution", "resolution"},
           {"engine_ms", "engine alone"},
           {"with_ms", "with"},
           {"without_ms", "without"},
           {"factor", "factor"},
           {"normals_with_ms", "normals: with"},
           {"normals_without_ms", "without"},
           {"normals_factor", "factor"},
           {"one_shot_ms", "one-shot"},
           {"paper_with_s", "paper: with, s"},
           {"paper_without_s", "without, s"},
           {"paper_factor", "factor"}},
          {}};
}

}  // namespace

Tables12::Tables12()
    : preprocessing_(preprocessing_table()), counts_(counts_table()), times_(times_table()) {}

void Tables12::add_build(const PaperCase& paper_case, const Volume& volume) {
  const auto source = make_memory_source(volume);
  const auto build_with = [&](int n_threads) {
    return [&source, n_threads] {
      Progress progress;
      const auto start = Clock::now();
      LODE_EXPECTS(diamond::build<3>(*source, {.threads = {n_threads}}, progress));
      return seconds_since(start);
    };
  };
  const std::array<TimedWork, 2> works = {build_with(1), build_with(2)};
  const auto seconds = run_in_turns(works);
  preprocessing_.rows.push_back({paper_case.name, fmt::format("{}", volume.info.grid.n_samples()),
                                 milliseconds(std::ranges::min(seconds[0])),
                                 milliseconds(std::ranges::min(seconds[1])), paper_case.paper,
                                 paper_seconds(paper_case.build_s)});
}

double Tables12::add_counts(const Step& step) {
  LiveSettings settings{.isovalue = step.data.volume.isovalue, .most_nodes = step.most_nodes};
  const LiveRun with = run_live(step.model, settings);
  settings.inheritance = Inheritance::off;
  const LiveRun without = run_live(step.model, settings);
  counts_.rows.push_back(
      {step.data.name, fmt::format("{}", settings.isovalue), share_text(step.paper.share),
       fmt::format("{}", with.n_applied), fmt::format("{}", with.n_triangles),
       fmt::format("{:.3g}", with.error_left), fmt::format("{}", with.n_interpolations),
       fmt::format("{}", without.n_interpolations),
       fmt::format("{:.2f}", static_cast<double>(without.n_interpolations) /
                                 static_cast<double>(with.n_interpolations))});
  return with.error_left;
}

void Tables12::add_times(const Step& step, double error_left) {
  const double isovalue = step.data.volume.isovalue;
  const LiveSettings with{.isovalue = isovalue, .most_nodes = step.most_nodes};
  LiveSettings alone = with, without = with;
  alone.has_surface = false;
  without.inheritance = Inheritance::off;
  LiveSettings normals_with = with, normals_without = without;
  normals_with.with_normals = normals_without.with_normals = true;
  std::vector<TimedWork> works;
  for (const LiveSettings& settings : {alone, with, without, normals_with, normals_without})
    works.emplace_back([&step, settings] { return run_live(step.model, settings).seconds; });
  Surface surface;
  works.emplace_back([&] { return run_one_shot(step.model, isovalue, error_left, surface); });
  const auto seconds = run_in_turns(works);
  const auto ms = [&](std::size_t i) { return milliseconds(median(seconds[i])); };
  const auto factor = [&](std::size_t i) {
    return fmt::format("{:.2f}", median_ratio(seconds[i + 1], seconds[i]));
  };
  const auto& paper = step.paper;
  const std::string paper_factor =
      paper.with_s > 0 ? fmt::format("{:.1f}", paper.without_s / paper.with_s) : std::string();
  times_.rows.push_back({step.data.name, share_text(paper.share), ms(0), ms(1), ms(2), factor(1),
                         ms(3), ms(4), factor(3), ms(5), paper_seconds(paper.with_s),
                         paper_seconds(paper.without_s), paper_factor});
}

Result<void> Tables12::add_extractions(const PaperCase& paper_case, const Volume& volume) {
  const auto source = make_memory_source(volume);
  Progress progress;
  LODE_TRY(const auto model, diamond::build<3>(*source, {.threads = {2}}, progress));
  const LiveSettings full{.isovalue = paper_case.volume.isovalue, .has_surface = false};
  const auto n_full = static_cast<double>(run_live(model, full).n_applied);
  for (const PaperCase::Extraction& paper : paper_case.extractions) {
    const Step step{paper_case, paper, model,
                    static_cast<std::uint64_t>(std::llround(paper.share * n_full))};
    add_times(step, add_counts(step));
  }
  return {};
}

}  // namespace lode::bench

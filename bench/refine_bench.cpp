// The refinement engine on diamonds: node refinements and undoings a second on one core, and what
// a node of the cut costs in memory. No peer does this; paper 003's system made 60,000 a second in
// 2002.

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "bench/timing.h"
#include "bench/volume_cases.h"
#include "lode/models/diamond/build.h"
#include "lode/models/diamond/refinable.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"

namespace lode::bench {
namespace {

using Nodes = diamond::Refinable<3>;

void measure(const std::string& name, const diamond::Model<3>& model, double isovalue,
             double tolerance) {
  Nodes nodes(model);
  const Demand demand = isovalue_demand(isovalue, tolerance);
  double undo_seconds = 0;
  double again_seconds = 0;
  Standing standing;
  std::size_t n_bytes = 0;
  std::size_t n_candidates = 0;
  const double apply_seconds = median_seconds([&] {
    Engine<Nodes> engine(nodes);
    auto start = Clock::now();
    engine.set_query(demand);
    engine.finish();
    const double seconds = seconds_since(start);
    standing = engine.standing();
    n_bytes = engine.n_bytes();
    n_candidates = engine.cut().size() - engine.cut().n_applied();
    start = Clock::now();
    engine.set_query(isovalue_demand(isovalue, 1e300), {}, FocusChange::same);
    engine.finish();
    undo_seconds = seconds_since(start);
    start = Clock::now();
    engine.set_query(demand, {}, FocusChange::same);
    engine.finish();
    again_seconds = seconds_since(start);
    return seconds;
  });
  const auto n = static_cast<double>(standing.n_applied);
  // As under a moving camera, which undoes about as many as it refines.
  const double both = 2 * n / (undo_seconds + again_seconds);
  fmt::print("{:<18} {:>10} {:>10} {:>10.2f} {:>10.2f} {:>10.2f} {:>10.2f} {:>10.1f}\n", name,
             standing.n_applied, n_candidates, n / apply_seconds / 1e6, n / undo_seconds / 1e6,
             n / again_seconds / 1e6, both / 1e6, static_cast<double>(n_bytes) / n);
  std::fflush(stdout);
}

Result<void> run(const std::string& only) {
  fmt::print("{:<18} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10}\n", "case", "applied",
             "candidates", "M apply/s", "M undo/s", "M again/s", "M both/s", "bytes/node");
  for (const VolumeCase& volume_case : volume_cases()) {
    if (!only.empty() && volume_case.name.find(only) == std::string::npos) continue;
    auto volume = load(volume_case);
    if (!volume) {
      fmt::print("{:<18} {}\n", volume_case.name, volume.error().message);
      continue;
    }
    const auto source = make_memory_source(*volume);
    Progress progress;
    LODE_TRY(const auto model, diamond::build<3>(*source, {.threads = {2}}, progress));
    measure(volume_case.name, model, volume_case.isovalue,
            volume_case.relative_error * (model.stats.max - model.stats.min));
  }
  return {};
}

}  // namespace
}  // namespace lode::bench

int main(int argc, char** argv) {
  CLI::App app("Refinement engine");
  std::string only;
  app.add_option("--only", only, "Only cases whose name contains this");
  CLI11_PARSE(app, argc, argv);
  if (const auto done = lode::bench::run(only); !done) {
    fmt::print(stderr, "{}\n", done.error().message);
    return 1;
  }
  return 0;
}

#include "bench/papers/live_run.h"

#include "bench/timing.h"
#include "lode/models/diamond/extract.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"

namespace lode::bench {
namespace {

/// Counts the nodes that are looked at.
class CountedNodes : public diamond::LiveRefinable<3> {
 public:
  using LiveRefinable::LiveRefinable;

  [[nodiscard]] StoredFacts facts(NodeId id) const {
    ++n_visited_;
    return LiveRefinable::facts(id);
  }
  [[nodiscard]] std::uint64_t n_visited() const { return n_visited_; }

 private:
  mutable std::uint64_t n_visited_ = 0;
};

}  // namespace

LiveRun run_live(const diamond::Model<3>& model, const LiveSettings& settings) {
  CountedNodes nodes(model);
  Engine<CountedNodes> engine(nodes);
  const Demand demand = isovalue_demand(settings.isovalue, 0);
  std::optional<diamond::LiveIsosurface<3>> surface;
  const double start = processor_seconds();
  if (settings.has_surface)
    nodes.follow(
        &surface.emplace(nodes, settings.isovalue, settings.with_normals, settings.inheritance));
  engine.set_query(demand);
  engine.run([&] { return engine.cut().n_applied() >= settings.most_nodes; });
  LiveRun run{.seconds = processor_seconds() - start};
  run.n_applied = engine.cut().n_applied();
  run.n_visited = nodes.n_visited();
  run.error_left = engine.standing().error_bound;
  if (surface) {
    run.n_triangles = surface->n_cells();
    run.n_interpolations = surface->counts().n_interpolations;
  }
  return run;
}

double run_one_shot(const diamond::Model<3>& model, double isovalue, double tolerance,
                    Surface& surface) {
  Progress progress;
  const diamond::IsosurfaceQuery query{
      .isovalue = isovalue, .tolerance = tolerance, .threads = {1}, .replaces = true};
  const double start = processor_seconds();
  LODE_EXPECTS(diamond::extract_isosurface<3>(model, query, surface, progress));
  return processor_seconds() - start;
}

std::vector<std::vector<double>> run_in_turns(std::span<const TimedWork> works) {
  constexpr double kLongRound = 2;
  std::vector<std::vector<double>> seconds(works.size());
  double first_round = 0;
  for (int round = 0; round < (first_round > kLongRound ? 3 : 7); ++round)
    for (std::size_t i = 0; i < works.size(); ++i) {
      seconds[i].push_back(works[i]());
      if (round == 0) first_round += seconds[i].back();
    }
  return seconds;
}

double median_ratio(std::span<const double> a, std::span<const double> b) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < a.size(); ++i) ratios.push_back(a[i] / b[i]);
  return median(ratios);
}

}  // namespace lode::bench

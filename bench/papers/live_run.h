#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "lode/models/diamond/live_isosurface.h"

namespace lode::bench {

struct LiveSettings {
  double isovalue = 0;
  std::uint64_t most_nodes = std::numeric_limits<std::uint64_t>::max();  ///< Where it stops.
  diamond::Inheritance inheritance = diamond::Inheritance::on;
  bool with_normals = false;
  bool has_surface = true;  ///< False: the engine alone.
};

/// A refinement from the base towards full resolution (tolerance 0), best first, on one thread.
struct LiveRun {
  std::uint64_t n_applied = 0;
  std::uint64_t n_visited = 0;  ///< Nodes whose error and range were looked at.
  std::uint64_t n_triangles = 0;
  std::uint64_t n_interpolations = 0;
  double error_left = 0;
  double seconds = 0;  ///< Of the processor.
};

[[nodiscard]] LiveRun run_live(const diamond::Model<3>& model, const LiveSettings& settings);

/// The processor's seconds of a one-shot extraction on one thread; aborts where that fails. The
/// surface's memory is reused.
[[nodiscard]] double run_one_shot(const diamond::Model<3>& model, double isovalue, double tolerance,
                                  Surface& surface);

/// Work that returns the seconds that count.
using TimedWork = std::function<double()>;

/// The seconds of each work, called in turns so that whatever slows the machine down slows all:
/// seven rounds, three where one takes longer than two seconds.
[[nodiscard]] std::vector<std::vector<double>> run_in_turns(std::span<const TimedWork> works);

/// Median of a / b, round by round.
[[nodiscard]] double median_ratio(std::span<const double> a, std::span<const double> b);

}  // namespace lode::bench

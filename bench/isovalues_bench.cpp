// A hundred isovalues evenly over a volume's range, both ends included: counted in one pass,
// against a hundred passes that count one each, and against extracting each without normals into
// the memory of the last. Two threads, from memory.

#include <fmt/format.h>

#include "bench/timing.h"
#include "bench/volume_cases.h"
#include "lode/api/dataset.h"

namespace lode::bench {
namespace {

constexpr int kIsovalues = 100;
constexpr int kRounds = 5;
constexpr int kAdaptiveRounds = 1;  ///< Each of them takes half a minute.
constexpr double kMark = 0.25;      ///< Of the single passes' time.
constexpr Threads kThreads{2};

std::vector<double> isovalues_of(const DatasetInfo& info) {
  std::vector<double> isovalues;
  isovalues.reserve(kIsovalues);
  for (int i = 0; i < kIsovalues; ++i)
    isovalues.push_back(info.range_min + (info.range_max - info.range_min) * i / (kIsovalues - 1));
  return isovalues;
}

/// Seconds of each way, by round: what others do to the machine meets all of them.
struct Rounds {
  std::vector<double> together, one_by_one, extracted, ratio;
  std::uint64_t n_triangles = 0;
};

Result<void> run_round(const Dataset& dataset, const std::vector<double>& isovalues,
                       double max_error, Rounds& rounds) {
  Progress progress;
  CountOptions options{.isovalues = isovalues, .max_error = max_error, .threads = kThreads};
  auto start = Clock::now();
  LODE_TRY(const CountReport all, dataset.count(options, progress));
  rounds.together.push_back(seconds_since(start));
  rounds.n_triangles = 0;
  start = Clock::now();
  for (const IsovalueCount& expected : all.counts) {
    options.isovalues = {expected.isovalue};
    LODE_TRY(const CountReport one, dataset.count(options, progress));
    if (one.counts.front().triangles != expected.triangles ||
        one.counts.front().vertices != expected.vertices)
      return fail("isovalue {}: expected {} triangles as alone, got {}", expected.isovalue,
                  one.counts.front().triangles, expected.triangles);
    rounds.n_triangles += expected.triangles;
  }
  rounds.one_by_one.push_back(seconds_since(start));
  rounds.ratio.push_back(rounds.together.back() / rounds.one_by_one.back());
  Surface surface;
  start = Clock::now();
  for (const double isovalue : isovalues)
    LODE_CHECK(dataset.extract({.isovalues = {isovalue},
                                .max_error = max_error,
                                .normals = Normals::off,
                                .threads = kThreads},
                               surface, progress));
  rounds.extracted.push_back(seconds_since(start));
  return {};
}

Result<void> run(const VolumeCase& volume_case) {
  LODE_TRY(const Volume volume, load(volume_case));
  const auto source = make_memory_source(volume);
  Progress progress;
  LODE_TRY(const Dataset dataset, Dataset::build(*source, {.threads = kThreads}, progress));
  const DatasetInfo info = dataset.describe();
  const std::vector<double> isovalues = isovalues_of(info);
  for (const double share : {0.0, 0.005, volume_case.relative_error}) {
    if (share == 0.005 && volume_case.relative_error == 0.005) continue;
    Rounds rounds;
    for (int i = 0; i < (share == 0 ? kRounds : kAdaptiveRounds); ++i)
      LODE_CHECK(run_round(dataset, isovalues, share * (info.range_max - info.range_min), rounds));
    const double ratio = median(rounds.ratio);
    fmt::print("{:<18} {:>9.3g} {:>14} {:>10.1f} {:>12.1f} {:>8.3f} {:>6} {:>12.1f}\n",
               volume_case.name, 100 * share, rounds.n_triangles, 1e3 * median(rounds.together),
               1e3 * median(rounds.one_by_one), ratio, ratio <= kMark ? "met" : "missed",
               1e3 * median(rounds.extracted));
    std::fflush(stdout);
  }
  return {};
}

}  // namespace
}  // namespace lode::bench

int main(int argc, char** argv) {
  fmt::print("{:<18} {:>9} {:>14} {:>10} {:>12} {:>8} {:>6} {:>12}\n", "case", "error, %",
             "triangles", "100, ms", "1 by 1, ms", "ratio", "0.25", "extract, ms");
  return lode::bench::run_cases(argc, argv, "Counts many isovalues in one pass and one by one.",
                                lode::bench::run);
}

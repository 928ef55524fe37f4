#include "bench/report.h"

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>

#include "lode/core/atomic_file.h"

namespace lode::bench {
namespace {

// Keeps the time of each repetition and prints nothing: our table compares, Google's lists.
class Collector final : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context& /*context*/) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs)
      if (run.run_type == Run::RT_Iteration && !run.error_occurred)
        seconds_.push_back(run.real_accumulated_time / static_cast<double>(run.iterations));
  }

  [[nodiscard]] std::vector<double> seconds() const { return seconds_; }

 private:
  std::vector<double> seconds_;
};

std::string milliseconds(const std::optional<double>& seconds) {
  return seconds ? fmt::format("{:.2f}", *seconds * 1e3) : std::string("-");
}

/// Of triangles or cells: `whose` they are, "ours" or "peer".
std::string count(const Row& row, const std::string& whose) {
  auto found = row.counts.find(whose + "_triangles");
  if (found == row.counts.end()) found = row.counts.find(whose + "_cells");
  return found == row.counts.end() ? std::string("-") : fmt::format("{:.0f}", found->second);
}

nlohmann::json number_or_null(const std::optional<double>& number) {
  return number ? nlohmann::json(*number) : nlohmann::json(nullptr);
}

nlohmann::json to_json_value(const Row& row) {
  nlohmann::json value;
  value["name"] = row.name;
  value["ours_s"] = number_or_null(row.ours_s);
  value["peer"] = row.peer.empty() ? nlohmann::json(nullptr) : nlohmann::json(row.peer);
  value["peer_s"] = number_or_null(row.peer_s);
  value["ratio"] = number_or_null(row.ratio());
  value["ours_fastest_s"] = number_or_null(row.ours_fastest_s);
  value["peer_fastest_s"] = number_or_null(row.peer_fastest_s);
  value["fastest_ratio"] = number_or_null(row.fastest_ratio());
  value["counts"] = row.counts;
  if (!row.note.empty()) value["note"] = row.note;
  return value;
}

std::optional<double> quotient(const std::optional<double>& a, const std::optional<double>& b) {
  if (!a || !b || *b <= 0) return std::nullopt;
  return *a / *b;
}

std::string ratio_text(const std::optional<double>& ratio) {
  return ratio ? fmt::format("{:.3f}", *ratio) : std::string("-");
}

}  // namespace

std::optional<double> Row::ratio() const { return quotient(ours_s, peer_s); }

std::optional<double> Row::fastest_ratio() const {
  return quotient(ours_fastest_s, peer_fastest_s);
}

Result<Seconds> time_runs(const std::string& name, const Work& work, int n_runs) {
  LODE_CHECK(work());
  std::optional<Error> error;
  benchmark::RegisterBenchmark(name.c_str(),
                               [&](benchmark::State& state) {
                                 for ([[maybe_unused]] auto _ : state)
                                   if (auto done = work(); !done) error = done.error();
                               })
      ->Iterations(1)
      ->Repetitions(n_runs)
      ->UseRealTime();
  Collector collector;
  benchmark::RunSpecifiedBenchmarks(&collector, "all");
  benchmark::ClearRegisteredBenchmarks();
  if (error) return *error;
  std::vector<double> seconds = collector.seconds();
  if (seconds.size() != static_cast<std::size_t>(n_runs))
    return fail("{}: expected {} timed runs, got {}", name, n_runs, seconds.size());
  std::ranges::sort(seconds);
  return Seconds{seconds[seconds.size() / 2], seconds[0]};
}

void print_heading(const std::string& peer, int n_runs, Counted counted) {
  const std::string unit = counted == Counted::cells ? "cells" : "tri";
  fmt::print("Median of {} runs after a warm-up, then the fastest; ratio = ours / peer; peer: {}\n",
             n_runs, peer);
  fmt::print("{:<34} {:>9} {:>9} {:>7} {:>9} {:>9} {:>7} {:>10} {:>10}  {}\n", "name", "ours ms",
             "peer ms", "ratio", "fastest", "peer", "ratio", "ours " + unit, "peer " + unit,
             "note");
  std::fflush(stdout);
}

void print_row(const Row& row) {
  fmt::print("{:<34} {:>9} {:>9} {:>7} {:>9} {:>9} {:>7} {:>10} {:>10}  {}\n", row.name,
             milliseconds(row.ours_s), milliseconds(row.peer_s), ratio_text(row.ratio()),
             milliseconds(row.ours_fastest_s), milliseconds(row.peer_fastest_s),
             ratio_text(row.fastest_ratio()), count(row, "ours"), count(row, "peer"), row.note);
  std::fflush(stdout);
}

std::string to_json(const std::vector<Row>& rows) {
  nlohmann::json values = nlohmann::json::array();
  for (const Row& row : rows) values.push_back(to_json_value(row));
  return values.dump(2) + "\n";
}

Result<void> write_json(const std::vector<Row>& rows, const std::string& path) {
  LODE_TRY(AtomicFile file, AtomicFile::create(path));
  LODE_CHECK(file.write(to_json(rows)));
  return file.commit();
}

int write_table(const Table& table, const std::string& program, const std::string& json_path) {
  if (json_path.empty()) return 0;
  if (const auto written = write_json(table.rows(), json_path); !written) {
    fmt::print(stderr, "{}: {}\n", program, written.error().message);
    return 1;
  }
  return 0;
}

void keep_freed_memory() {
  constexpr int kLargestThreshold = 32 << 20;  // that glibc takes
  mallopt(M_MMAP_THRESHOLD, kLargestThreshold);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
}

}  // namespace lode::bench

// From a closed .lode file to a surface in memory: the first consistent one, one within ten times
// the tolerance, and the answer; and what loading the whole file first takes. The operating system
// is asked to forget the file before each run.

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <thread>

#include "bench/timing.h"
#include "bench/volume_cases.h"
#include "lode/api/session.h"

namespace lode::bench {
namespace {

/// Bytes that this process has asked for so far.
std::uint64_t n_bytes_read() {
  std::ifstream io("/proc/self/io");
  std::string key;
  std::uint64_t n = 0;
  io >> key >> n;
  return n;
}

/// Asks the system to; on some file systems it does not.
void forget(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return;
  ::fsync(file);
  ::posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED);
  ::close(file);
}

/// A batch that was taken, by then; ms < 0: none was.
struct Moment {
  double ms = -1;    ///< Since the program set out to open the file.
  double share = 0;  ///< Read, of the file.
  double error_bound = 0;
  std::int64_t n_triangles = 0;
};
struct Run {
  Moment first, soon, near, whole;
};

std::int64_t count_triangles(const SurfaceMirror& mirror) {
  return std::ranges::count_if(mirror.cells(),
                               [](const auto& cell) { return cell != SurfaceBatch::kRemoved; });
}

/// What the batches of the first 50 ms add up to; counted afterwards, so as not to delay them.
void find_early(const std::vector<std::pair<Moment, SurfaceBatch>>& early, Run& run) {
  SurfaceMirror mirror;
  for (const auto& [moment, change] : early) {
    mirror.apply(change);
    run.soon = moment;
    run.soon.n_triangles = count_triangles(mirror);
    if (run.first.ms < 0 && run.soon.n_triangles > 0) run.first = run.soon;
  }
}

Result<Run> run_once(const std::string& path, const Query& query, bool loads_first) {
  const auto size = static_cast<double>(std::filesystem::file_size(path));
  forget(path);
  const std::uint64_t n_before = n_bytes_read();
  const auto start = Clock::now();
  Progress progress;
  LODE_TRY(const Dataset dataset, Dataset::open(path, {2}));
  if (loads_first) LODE_CHECK(dataset.load(progress));
  LODE_TRY(auto session, Session::open(dataset, query, {.with_views = false}, progress));
  Run run;
  std::vector<std::pair<Moment, SurfaceBatch>> early;
  for (;;) {
    const auto batch = session.take();
    if (!batch) {
      std::this_thread::sleep_for(std::chrono::microseconds(100));
      continue;
    }
    if (batch->fault) return *batch->fault;
    Moment now{1000 * seconds_since(start), 0, batch->standing.error_bound};
    now.share = static_cast<double>(n_bytes_read() - n_before) / size;
    if (now.ms <= 50 || (early.empty() && !batch->change.cells.empty()))
      early.emplace_back(now, std::move(batch->change));
    if (run.near.ms < 0 && now.error_bound <= 10 * *query.max_error) run.near = now;
    if (!batch->standing.is_settled) continue;
    run.whole = now;
    find_early(early, run);
    if (run.soon.ms > 50) run.soon = {};
    return run;
  }
}

void print(const char* name, std::vector<Run> runs, Moment Run::*moment) {
  std::ranges::sort(runs, {}, [&](const Run& run) { return (run.*moment).ms; });
  const Moment& median = (runs[runs.size() / 2].*moment);
  fmt::print("    {:<30} ", name);
  if (median.ms < 0) return fmt::print("none\n");
  fmt::print("{:>8.1f} ms, worst of 7 {:>8.1f} ms; {:>5.1f} % read, bound {:.4g}", median.ms,
             (runs.back().*moment).ms, 100 * median.share, median.error_bound);
  if (median.n_triangles > 0) fmt::print(", {} triangles", median.n_triangles);
  fmt::print("\n");
}

Result<void> run_case(const VolumeCase& volume_case, const std::string& path) {
  Query query;
  std::int64_t n_samples = 0;
  {
    LODE_TRY(const auto volume, load(volume_case));
    Progress progress;
    LODE_TRY(const auto dataset,
             Dataset::build(*make_memory_source(volume), {.threads = {2}}, progress));
    const DatasetInfo info = dataset.describe();
    query.isovalues = {volume_case.isovalue};
    query.max_error = volume_case.relative_error * (info.range_max - info.range_min);
    n_samples = info.volume.grid.n_samples();
    LODE_CHECK(dataset.save(path, {2}, progress));
  }
  fmt::print("{}: {:.1f} M samples, file of {:.1f} MB, tolerance {:.3g}\n", volume_case.name,
             1e-6 * static_cast<double>(n_samples),
             1e-6 * static_cast<double>(std::filesystem::file_size(path)), *query.max_error);
  for (const bool loads_first : {false, true}) {
    std::vector<Run> runs;
    for (int i = 0; i < 7; ++i) {
      LODE_TRY(const Run run, run_once(path, query, loads_first));
      runs.push_back(run);
    }
    fmt::print("  {}\n", loads_first ? "loaded first" : "page by page");
    print("first surface", runs, &Run::first);
    print("the last one within 50 ms", runs, &Run::soon);
    print("within 10 times the tolerance", runs, &Run::near);
    print("the answer", runs, &Run::whole);
  }
  return {};
}

}  // namespace
}  // namespace lode::bench

int main(int argc, char** argv) {
  using namespace lode::bench;
  const auto path =
      std::filesystem::temp_directory_path() / fmt::format("lode_open_bench_{}.lode", ::getpid());
  const int status = run_cases(argc, argv, "From a closed file to a surface",
                               [&](const VolumeCase& c) { return run_case(c, path.string()); });
  std::filesystem::remove(path);
  return status;
}

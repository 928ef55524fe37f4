#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <memory>

#include "command.h"
#include "describe.h"
#include "input.h"
#include "lode/api/focused_surface.h"
#include "parse.h"
#include "stopwatch.h"
#include "text.h"

namespace lode::cli {
namespace {

struct BenchArguments {
  std::string input;
  std::string isovalue;
  std::string memory_limit;
  ReadingArguments reading;
};

/// Bytes a second that this machine moves at best: what no command can beat.
struct Floors {
  double copy = 0;  ///< Memory to memory, one thread.
  double read = 0;  ///< The file, front to back, after the system was asked to forget it.
};

double copy_rate() {
  constexpr std::size_t kBytes = std::size_t{64} << 20;
  std::vector<std::byte> from(kBytes, std::byte{1});
  std::vector<std::byte> to(kBytes, std::byte{2});
  double best = 0;
  for (int i = 0; i < 4; ++i) {
    const Stopwatch watch;
    std::memcpy(to.data(), from.data(), kBytes);
    best = std::max(best, static_cast<double>(kBytes) / watch.seconds());
    from[static_cast<std::size_t>(i)] = to[static_cast<std::size_t>(i) + 1];  // not left out
  }
  return best;
}

Result<double> read_rate(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return fail("{}: cannot open the file", path);
  ::posix_fadvise(descriptor, 0, 0, POSIX_FADV_DONTNEED);
  std::vector<std::byte> buffer(std::size_t{4} << 20);
  std::uint64_t n_bytes = 0;
  const Stopwatch watch;
  for (ssize_t n = 1; n > 0 && n_bytes < std::uint64_t{4} << 30;) {
    n = ::read(descriptor, buffer.data(), buffer.size());
    n_bytes += static_cast<std::uint64_t>(std::max<ssize_t>(n, 0));
  }
  const double seconds = watch.seconds();
  ::close(descriptor);
  return seconds > 0 ? static_cast<double>(n_bytes) / seconds : 0;
}

/// A file that is gone when the command is.
class TemporaryFile {
 public:
  TemporaryFile()
      : path_(
            (std::filesystem::temp_directory_path() / fmt::format("lode-bench-{}.lode", ::getpid()))
                .string()) {}
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    std::error_code status;
    std::filesystem::remove(path_, status);
  }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

struct BenchReport {
  Json json;
  Table table{{"what", "seconds", "rate", "read", "result"}};
};

std::string per_second(double n, const char* unit) { return fmt::format("{:.1f} {}", n, unit); }

Result<void> bench_build(const BenchArguments& arguments, std::uint64_t memory_limit,
                         const std::string& output, Session& session, BenchReport& report) {
  LODE_TRY(ReadOptions options, to_read_options(arguments.reading, session.threads()));
  options.memory_limit = static_cast<std::size_t>(memory_limit / 8);
  options.cache_limit = static_cast<std::size_t>(memory_limit / 4);
  LODE_TRY(auto source, open_foreign_volume(arguments.input, options));
  LODE_TRY(const auto built, build_file_from(arguments.input, *source, output,
                                             {.threads = session.threads(),
                                              .unfinished = Unfinished::nothing,
                                              .memory_limit = memory_limit},
                                             session.progress()));
  const auto n = static_cast<double>(built.info.volume.grid.n_samples());
  const double seconds = built.seconds.total;
  const std::uint64_t n_read = built.io.n_file_bytes_read + built.io.n_spool_bytes_read;
  Json& json = report.json["build"];
  json["seconds"] = seconds;
  json["samples_per_second"] = n / seconds;
  json["bytes_read"] = n_read;
  json["bytes_written"] = built.file_bytes + built.io.n_spool_bytes_written;
  report.table.add({"build", fmt::format("{:.3f}", seconds),
                    per_second(n / seconds / 1e6, "M samples/s"), format_bytes(n_read),
                    format_bytes(built.file_bytes)});
  return {};
}

/// The first surface from a closed file, of some 20,000 simplices.
Result<void> bench_first(const std::string& path, double isovalue, Session& session,
                         BenchReport& report) {
  const Stopwatch watch;
  LODE_TRY(const Dataset dataset, Dataset::open(path, session.threads()));
  FocusedOptions options;
  options.query.isovalues = {isovalue};
  options.query.budget.max_cells = 20000;
  options.threads = session.threads();
  Surface surface;
  LODE_TRY(const auto first, extract_focused(dataset, options, surface, session.progress()));
  const double seconds = watch.seconds();
  const std::size_t n = surface.triangles.size() + surface.lines.size();
  Json& json = report.json["first_surface"];
  json["seconds"] = seconds;
  json["cells"] = n;
  json["error_bound"] = first.standing.error_bound;
  report.table.add({"first surface", fmt::format("{:.3f}", seconds), "", "",
                    fmt::format("{} cells, error {}", format_count(n),
                                format_number(first.standing.error_bound))});
  return {};
}

Result<void> bench_extractions(const std::string& path, double isovalue, std::uint64_t memory_limit,
                               Session& session, BenchReport& report) {
  for (const double share : {0.3, 0.1, 0.03, 0.005}) {
    // From a closed file each time, as a command does it.
    const Stopwatch watch;
    LODE_TRY(const Dataset dataset, Dataset::open(path, session.threads()));
    const DatasetInfo info = dataset.describe();
    ExtractOptions options;
    options.isovalues = {isovalue};
    options.max_error = share * (info.range_max - info.range_min);
    options.threads = session.threads();
    options.memory_limit = memory_limit;
    Surface surface;
    LODE_TRY(const auto done, dataset.extract(options, surface, session.progress()));
    const double seconds = watch.seconds();
    const auto n = static_cast<double>(done.triangles + done.lines);
    Json json;
    json["max_error"] = done.max_error;
    json["seconds"] = seconds;
    json["cells"] = done.triangles + done.lines;
    json["bytes_read"] = done.bytes_read;
    report.json["extractions"].push_back(json);
    report.table.add({fmt::format("extract within {}", format_number(done.max_error)),
                      fmt::format("{:.3f}", seconds), per_second(n / seconds / 1e6, "M cells/s"),
                      format_bytes(done.bytes_read),
                      fmt::format("{} cells", format_count(done.triangles + done.lines))});
  }
  return {};
}

Result<Outcome> run_bench(const BenchArguments& arguments, Session& session) {
  std::uint64_t memory_limit = physical_memory() / 4;
  if (!arguments.memory_limit.empty()) {
    LODE_TRY(memory_limit, parse_bytes("--memory-limit", arguments.memory_limit));
  }
  BenchReport report;
  report.json["command"] = "bench";
  report.json["input"] = arguments.input;
  const TemporaryFile temporary;
  const bool is_foreign = !is_lode_path(arguments.input);
  const std::string path = is_foreign ? temporary.path() : arguments.input;
  if (is_foreign) LODE_CHECK(bench_build(arguments, memory_limit, path, session, report));
  LODE_TRY(const Dataset dataset, Dataset::open(path, session.threads()));
  const DatasetInfo info = dataset.describe();
  double isovalue = 0.5 * (info.range_min + info.range_max);
  if (!arguments.isovalue.empty()) {
    LODE_TRY(isovalue, parse_number("--isovalue", arguments.isovalue));
  }
  report.json["isovalue"] = isovalue;
  Floors floors{.copy = copy_rate()};
  LODE_TRY(floors.read, read_rate(path));
  LODE_CHECK(bench_first(path, isovalue, session, report));
  LODE_CHECK(bench_extractions(path, isovalue, memory_limit, session, report));
  report.json["floors"]["copy_bytes_per_second"] = floors.copy;
  report.json["floors"]["read_bytes_per_second"] = floors.read;
  Outcome outcome;
  outcome.json = report.json;
  outcome.text =
      report.table.to_string() +
      fmt::format(
          "floors: memory is copied at {}/s by one thread, this file is read at "
          "{}/s\nisovalue {}\n",
          format_bytes(static_cast<std::uint64_t>(floors.copy)),
          format_bytes(static_cast<std::uint64_t>(floors.read)), format_number(isovalue));
  return outcome;
}

Result<void> check_bench(const BenchArguments& arguments) {
  if (!arguments.memory_limit.empty())
    if (auto limit = parse_bytes("--memory-limit", arguments.memory_limit); !limit)
      return limit.error();
  if (!arguments.isovalue.empty())
    if (auto value = parse_number("--isovalue", arguments.isovalue); !value) return value.error();
  return check_reading_options(arguments.reading, arguments.input);
}

}  // namespace

Command add_bench_command(CLI::App& program) {
  auto arguments = std::make_shared<BenchArguments>();
  CLI::App* app = program.add_subcommand(
      "bench", "Measure building and extracting on this machine, with this data");
  app->footer("Example:\n  lode bench scan.nrrd --isovalue 1200");
  app->add_option("file", arguments->input,
                  ".lode file, or a volume, which is built into a temporary file")
      ->type_name("FILE")
      ->required();
  app->add_option("--isovalue", arguments->isovalue, "Surface to extract (default: mid-range)")
      ->type_name("V");
  app->add_option("--memory-limit", arguments->memory_limit,
                  "Memory for building and for the hierarchy, such as 512M (default: a quarter of "
                  "the machine's)")
      ->type_name("BYTES");
  add_reading_options(*app, arguments->reading);
  return {app, [arguments] { return check_bench(*arguments); },
          [arguments](Session& session) { return run_bench(*arguments, session); }};
}

}  // namespace lode::cli

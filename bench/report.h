#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lode/core/result.h"

namespace lode::bench {

/// One line of a benchmark: ours against a peer's, on the same input in the same run.
struct Row {
  std::string name;
  std::optional<double> ours_s;
  std::string peer;  ///< Empty where nothing comparable exists.
  std::optional<double> peer_s;
  std::optional<double> ours_fastest_s;
  std::optional<double> peer_fastest_s;
  std::map<std::string, double> counts;  ///< ours_triangles or ours_cells, peer_..., samples, ...
  std::string note;                      ///< Why it was skipped, or how the inputs differ.

  /// ours_s / peer_s: below 1 we are faster.
  [[nodiscard]] std::optional<double> ratio() const;
  [[nodiscard]] std::optional<double> fastest_ratio() const;
};

/// Of what takes up to a few seconds.
inline constexpr int kUsualRuns = 7;

/// Seconds of several runs. Where a machine is shared, and taken away for longer than a run, the
/// fastest says what the work costs; the median what was seen.
struct Seconds {
  double median = 0;
  double fastest = 0;
};

/// Does the timed work once. A bad Result ends the measurement.
using Work = std::function<Result<void>()>;

/// `n_runs`, an odd number, of `work` after one that does not count, timed by Google Benchmark
/// under `name`.
[[nodiscard]] Result<Seconds> time_runs(const std::string& name, const Work& work,
                                        int n_runs = kUsualRuns);

/// What the counts ours_... and peer_... that a table shows are of.
enum class Counted : std::uint8_t { triangles, cells };

/// Prints one row as soon as it is known, aligned under print_heading's.
void print_heading(const std::string& peer, int n_runs = kUsualRuns,
                   Counted counted = Counted::triangles);
void print_row(const Row& row);

/// [{"name", "ours_s", "peer", "peer_s", "ratio", "ours_fastest_s", "peer_fastest_s",
/// "fastest_ratio", "counts", "note"}, ...], missing values null.
[[nodiscard]] std::string to_json(const std::vector<Row>& rows);
/// Writes to_json(rows) whole or not at all.
[[nodiscard]] Result<void> write_json(const std::vector<Row>& rows, const std::string& path);

/// Prints each row when it is known and keeps it for the JSON.
class Table {
 public:
  void add(Row row) {
    print_row(row);
    rows_.push_back(std::move(row));
  }
  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }

 private:
  std::vector<Row> rows_;
};

/// Ends a program: write_json() where a path is given, and its exit code.
[[nodiscard]] int write_table(const Table& table, const std::string& program,
                              const std::string& json_path);

/// Freed memory stays with the process: after the warm-up neither side waits for fresh pages.
void keep_freed_memory();

}  // namespace lode::bench

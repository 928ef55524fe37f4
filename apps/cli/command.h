#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "data_kind.h"
#include "lode/api/dataset.h"
#include "progress_bar.h"

namespace lode::cli {

/// Keeps keys in the order in which they are set, so that output reads like the tables.
using Json = nlohmann::ordered_json;

/// What every command takes.
struct CommonOptions {
  bool json = false;
  bool quiet = false;
  int threads = 0;  ///< 0: all the machine has.
};

/// The standard option values, progress and stderr of one run of one command.
class Session {
 public:
  Session(const CommonOptions& options, Progress& progress, ProgressBar& bar)
      : options_(options), progress_(progress), bar_(bar) {}

  [[nodiscard]] Threads threads() const { return {options_.threads}; }
  [[nodiscard]] Progress& progress() { return progress_; }
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }
  /// One line on stderr, unless --quiet.
  void note(const std::string& message);
  /// As note, but shown even with --quiet, and kept for the "warnings" of the JSON output.
  void warn(const std::string& message);
  /// What main says after "stopped; " when a signal ends the command.
  void set_leftover(std::string leftover) { leftover_ = std::move(leftover); }
  [[nodiscard]] const std::string& leftover() const { return leftover_; }
  /// The reason why the command will not exit with 0.
  void fail(const std::string& message);

 private:
  const CommonOptions& options_;
  Progress& progress_;
  ProgressBar& bar_;
  std::vector<std::string> warnings_;
  std::string leftover_ = "no output was written";
};

/// What a command has to say on stdout, in both forms; main prints one of them.
struct Outcome {
  Json json;
  std::string text;
  int exit_code = 0;
};

/// One sub-command. `check` looks at the arguments alone (an error exits with 2), `run` does the
/// work (an error exits with 1).
struct Command {
  CLI::App* app = nullptr;
  std::function<Result<void>()> check;
  std::function<Result<Outcome>(Session&)> run;
  /// Of commands for several kinds of data, whose options then depend on the kind.
  std::optional<HelpFooter> footer{};
};

[[nodiscard]] Command add_info_command(CLI::App& program);
[[nodiscard]] Command add_attach_command(CLI::App& program);
[[nodiscard]] Command add_bench_command(CLI::App& program);
[[nodiscard]] Command add_build_command(CLI::App& program);
[[nodiscard]] Command add_count_command(CLI::App& program);
[[nodiscard]] Command add_extract_command(CLI::App& program);
[[nodiscard]] Command add_probe_command(CLI::App& program);
[[nodiscard]] Command add_height_command(CLI::App& program);
[[nodiscard]] Command add_neighbours_command(CLI::App& program);
[[nodiscard]] Command add_compare_command(CLI::App& program);
[[nodiscard]] Command add_profile_command(CLI::App& program);
[[nodiscard]] Command add_contours_command(CLI::App& program);
[[nodiscard]] Command add_features_command(CLI::App& program);
[[nodiscard]] Command add_sight_command(CLI::App& program);
[[nodiscard]] Command add_tiles_command(CLI::App& program);
[[nodiscard]] Command add_verify_command(CLI::App& program);
[[nodiscard]] Command add_render_command(CLI::App& program);

}  // namespace lode::cli

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <system_error>

#include "command.h"
#include "describe.h"
#include "input.h"
#include "stopwatch.h"
#include "text.h"

namespace lode::cli {
namespace {

struct BuildArguments {
  std::string input;
  std::string output;
  ReadingArguments reading;
};

bool holds_bytes(const std::string& path) {
  std::error_code status;
  return std::filesystem::is_regular_file(path, status) &&
         std::filesystem::file_size(path, status) > 0;
}

Result<void> check_build(const BuildArguments& arguments) {
  // What is no file, or empty, is left to the reader, which says so.
  if (is_lode_path(arguments.input) && holds_bytes(arguments.input))
    return fail("{}: expected a file of another format to build from, got a .lode file",
                arguments.input);
  if (!is_lode_path(arguments.output))
    return fail("{}: expected an output that ends in .lode", arguments.output);
  LODE_CHECK(check_paths_differ({arguments.input}, {arguments.output}));
  if (auto options = to_read_options(arguments.reading); !options) return options.error();
  return {};
}

struct BuildSeconds {
  double build = 0;
  double save = 0;
};

Outcome report_build(const BuildArguments& arguments, const DatasetInfo& info,
                     const BuildSeconds& seconds, std::uintmax_t file_bytes) {
  const auto n_samples = static_cast<std::uint64_t>(info.volume.grid.n_samples());
  const auto n = static_cast<double>(n_samples);
  const double rate = seconds.build > 0 ? n / seconds.build / 1e6 : 0;
  Outcome outcome;
  outcome.json["command"] = "build";
  outcome.json["input"] = arguments.input;
  outcome.json["output"] = arguments.output;
  outcome.json.update(to_json(info));
  outcome.json["file_bytes"] = file_bytes;
  Json& json_seconds = outcome.json["seconds"];
  json_seconds["total"] = seconds.build + seconds.save;
  json_seconds["build"] = seconds.build;
  json_seconds["save"] = seconds.save;
  Table table;
  table.add({"model", info.model});
  table.add({"samples", format_count(n_samples)});
  table.add({"value range", describe_range(info)});
  table.add({"base error", format_number(info.base_error)});
  table.add({"read and build", fmt::format("{} ({:.1f} million samples a second)",
                                           format_seconds(seconds.build), rate)});
  table.add({"save", format_seconds(seconds.save)});
  table.add({"file size", fmt::format("{} ({:.3f} bytes per sample)", format_bytes(file_bytes),
                                      static_cast<double>(file_bytes) / n)});
  table.add({"output", arguments.output});
  outcome.text = table.to_string();
  return outcome;
}

Result<Outcome> run_build(const BuildArguments& arguments, Session& session) {
  LODE_TRY(const ReadOptions options, to_read_options(arguments.reading));
  LODE_CHECK(check_writable(arguments.output));
  LODE_TRY(auto source, open_volume(arguments.input, options));
  const Stopwatch build_watch;
  LODE_TRY(Dataset dataset, build_opened(arguments.input, *source, {.threads = session.threads()},
                                         session.progress()));
  BuildSeconds seconds{.build = build_watch.seconds()};
  const Stopwatch save_watch;
  LODE_CHECK(dataset.save(arguments.output, session.threads(), session.progress()));
  seconds.save = save_watch.seconds();
  std::error_code status;
  const std::uintmax_t bytes = std::filesystem::file_size(arguments.output, status);
  return report_build(arguments, dataset.describe(), seconds, status ? 0 : bytes);
}

}  // namespace

Command add_build_command(CLI::App& program) {
  auto arguments = std::make_shared<BuildArguments>();
  CLI::App* app = program.add_subcommand("build", "Turn a volume into a .lode file");
  app->footer("Example:\n  lode build scan.nrrd scan.lode");
  app->add_option("input", arguments->input, "Volume to read")->type_name("IN")->required();
  app->add_option("output", arguments->output, "File to write")->type_name("OUT.lode")->required();
  add_reading_options(*app, arguments->reading);
  return {app, [arguments] { return check_build(*arguments); },
          [arguments](Session& session) { return run_build(*arguments, session); }};
}

}  // namespace lode::cli

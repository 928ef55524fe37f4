#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>

#include "command.h"
#include "describe.h"
#include "extraction_options.h"
#include "input.h"
#include "parse.h"
#include "text.h"
#include "tolerance.h"

namespace lode::cli {
namespace {

struct CountArguments {
  std::string input;
  std::string evenly = "32";
  std::string memory_limit;
  ExtractionArguments extraction;  ///< Only isovalues and tolerance.
  ReadingArguments reading;
};

/// Isovalues at equal distances.
struct EvenIsovalues {
  std::int64_t n = 0;
  std::optional<double> first;  ///< Unset: inside the range of the values.
  double last = 0;

  [[nodiscard]] std::vector<double> in(double range_min, double range_max) const {
    const auto n_steps = static_cast<double>(first ? std::max<std::int64_t>(n - 1, 1) : n + 1);
    const double low = first ? *first : range_min;
    const double high = first ? last : range_max;
    std::vector<double> isovalues;
    isovalues.reserve(static_cast<std::size_t>(n));
    // Multiplied first: steps of whole numbers that are whole come out so.
    for (std::int64_t i = 0; i < n; ++i) {
      const auto k = static_cast<double>(first ? i : i + 1);
      isovalues.push_back(k == n_steps ? high : low + (high - low) * k / n_steps);
    }
    return isovalues;
  }
};

Result<EvenIsovalues> parse_evenly(const std::string& text) {
  constexpr std::int64_t kMost = 100'000;
  const auto first_colon = text.find(':');
  if (first_colon == std::string::npos) {
    LODE_TRY(const std::int64_t n, parse_integer("--isovalues", text, 1, kMost));
    return EvenIsovalues{.n = n, .first = {}};
  }
  const auto second_colon = text.find(':', first_colon + 1);
  if (second_colon == std::string::npos)
    return fail("--isovalues: expected N, or A:B:N with A < B, got '{}'", text);
  LODE_TRY(const double first, parse_number("--isovalues", text.substr(0, first_colon)));
  LODE_TRY(
      const double last,
      parse_number("--isovalues", text.substr(first_colon + 1, second_colon - first_colon - 1)));
  LODE_TRY(const std::int64_t n,
           parse_integer("--isovalues", text.substr(second_colon + 1), 2, kMost));
  if (first >= last) return fail("--isovalues: expected N, or A:B:N with A < B, got '{}'", text);
  return EvenIsovalues{.n = n, .first = first, .last = last};
}

/// But for the isovalues, which may follow from the range.
Result<CountOptions> to_count_options(const CountArguments& arguments) {
  CountOptions options;
  LODE_TRY(const ExtractOptions extraction, to_extract_options(arguments.extraction));
  options.isovalues = extraction.isovalues;
  options.max_error = extraction.max_error;
  if (!arguments.memory_limit.empty()) {
    LODE_TRY(options.memory_limit, parse_bytes("--memory-limit", arguments.memory_limit));
  }
  return options;
}

Result<void> check_count(const CountArguments& arguments) {
  if (auto options = to_count_options(arguments); !options) return options.error();
  if (auto evenly = parse_evenly(arguments.evenly); !evenly) return evenly.error();
  return check_reading_options(arguments.reading, arguments.input);
}

Json count_json(const CountArguments& arguments, const Input& input, const CountOptions& options,
                const CountReport& report, const std::vector<std::string>& warnings) {
  Json json;
  json["command"] = "count";
  json["input"] = arguments.input;
  json["model"] = input.info.model;
  json["built_in_memory"] = input.was_built;
  json["max_error"] = report.max_error;
  json["max_error_is_default"] = !options.max_error.has_value();
  add_units(json, input.info.volume.units);
  json["counts"] = Json::array();
  for (const IsovalueCount& count : report.counts) {
    Json& one = json["counts"].emplace_back();
    one["isovalue"] = count.isovalue;
    one["triangles"] = count.triangles;
    one["lines"] = count.lines;
    one["vertices"] = count.vertices;
  }
  json["seconds"]["count"] = report.seconds;
  json["seconds"]["open"] = input.open_seconds;
  json["warnings"] = warnings;
  return json;
}

std::string count_text(const Input& input, const CountOptions& options, const CountReport& report) {
  Table head;
  head.add({"range", format_range(input.info.range_min, input.info.range_max)});
  ExtractOptions like;
  like.max_error = options.max_error;
  head.add({"max error", describe_tolerance(like, report.max_error)});
  add_units(head, input.info.volume.units);
  head.add({"count", format_seconds(report.seconds)});
  head.add({input.was_built ? "read and build" : "open", format_seconds(input.open_seconds)});
  const bool is_lines = input.info.model == "diamond2d";
  Table table({"isovalue", is_lines ? "lines" : "triangles", "vertices"});
  for (const IsovalueCount& count : report.counts)
    table.add({fmt::format("{}", count.isovalue),
               format_count(is_lines ? count.lines : count.triangles),
               format_count(count.vertices)});
  return head.to_string() + '\n' + table.to_string();
}

Result<Outcome> run_count(const CountArguments& arguments, Session& session) {
  LODE_TRY(CountOptions options, to_count_options(arguments));
  LODE_TRY(const EvenIsovalues evenly, parse_evenly(arguments.evenly));
  options.threads = session.threads();
  LODE_TRY(const Input input, open_input(session, arguments.input, arguments.reading));
  set_share(arguments.extraction.max_error, input.info.range_min, input.info.range_max,
            options.max_error);
  if (options.isovalues.empty())
    options.isovalues = evenly.in(input.info.range_min, input.info.range_max);
  LODE_TRY(const CountReport report, input.dataset.count(options, session.progress()));
  return Outcome{count_json(arguments, input, options, report, session.warnings()),
                 count_text(input, options, report)};
}

}  // namespace

Command add_count_command(CLI::App& program) {
  auto arguments = std::make_shared<CountArguments>();
  CLI::App* app = program.add_subcommand(
      "count", "Count the triangles of many isovalues' surfaces at once, to choose one");
  app->footer(
      "All isovalues are counted in one pass, and no surface is made: the numbers are those that\n"
      "`lode extract` gives of each, with the same --max-error.\n\n"
      "Examples:\n  lode count scan.lode\n"
      "  lode count scan.lode --isovalues 100:1500:29 --max-error 0\n"
      "  lode count scan.lode --isovalue 300 --isovalue 1200 --json");
  app->add_option("file", arguments->input, ".lode file, or a volume to build in memory")
      ->type_name("FILE")
      ->required();
  CLI::Option* evenly = app->add_option("--isovalues", arguments->evenly,
                                        "N evenly inside the range of the values, or from A to B, "
                                        "both included (default: 32)");
  evenly->type_name("N|A:B:N");
  app->add_option("--isovalue", arguments->extraction.isovalues, "This one; may be repeated")
      ->type_name("V")
      ->allow_extra_args(false)
      ->excludes(evenly);
  app->add_option("--max-error", arguments->extraction.max_error,
                  "Tolerance in field units, or with % of the range of values; 0 is full "
                  "resolution (default: 0.5%)")
      ->type_name("E");
  app->add_option("--memory-limit", arguments->memory_limit,
                  "Memory for the hierarchy, such as 512M (default: a quarter of the machine's); "
                  "beyond it isovalues are counted one by one")
      ->type_name("BYTES");
  add_reading_options(*app, arguments->reading);
  return {app, [arguments] { return check_count(*arguments); },
          [arguments](Session& session) { return run_count(*arguments, session); }};
}

}  // namespace lode::cli

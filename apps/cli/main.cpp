#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <exception>
#include <new>
#include <sstream>
#include <string>
#include <vector>

#include "command.h"
#include "signals.h"
#include "text.h"

namespace lode::cli {
namespace {

constexpr int kFailure = 1;
constexpr int kUsage = 2;
constexpr int kSignalBase = 128;

/// Says what went wrong on stderr, and where JSON was asked for also on stdout, so that a reader
/// of it always gets its one object.
int report_error(const std::string& message, int exit_code, bool is_json) {
  print_error(fmt::format("lode: {}\n", message));
  if (is_json) {
    Json json;
    json["error"] = message;
    json["exit_code"] = exit_code;
    if (!print_output(json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"))
      return kFailure;
  }
  return exit_code;
}

void add_common_options(CLI::App& app, CommonOptions& options) {
  app.add_flag("--json", options.json, "Print one JSON object instead of tables")->group("General");
  app.add_option("--threads", options.threads, "Threads to use (default: all cores)")
      ->check(CLI::Range(1, 4096))
      ->type_name("N")
      ->group("General");
  app.add_flag("-q,--quiet", options.quiet, "No progress bar and no notes on stderr")
      ->group("General");
}

std::vector<std::string> names_of(const std::vector<Command>& commands) {
  std::vector<std::string> names{"help"};
  for (const Command& command : commands) names.push_back(command.app->get_name());
  return names;
}

std::string unknown_command(const std::string& word, const std::vector<Command>& commands) {
  const std::string hint = closest_to(word, names_of(commands));
  return fmt::format("expected a command (see lode --help), got '{}'{}", word,
                     hint.empty() ? "" : fmt::format("; did you mean '{}'?", hint));
}

/// Whether an option is called as a command is, such as --tiles.
bool command_called(const std::string& option, const CLI::App& app) {
  constexpr std::size_t kDashes = 2;
  const auto is_called = [&](const CLI::App* one) {
    return one->get_name() == option.substr(kDashes);
  };
  return !app.get_parent()->get_subcommands(is_called).empty();
}

/// The first argument that looks like an option but is none of this command's, with a hint.
std::string unknown_option(const std::vector<std::string>& arguments, const CLI::App& app) {
  std::vector<std::string> known;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  for (const std::string& argument : arguments) {
    const std::string name = argument.substr(0, argument.find('='));
    if (!name.starts_with("--") || name == "--" || std::ranges::count(known, name) > 0) continue;
    const std::string hint =
        command_called(name, app) ? "lode " + name.substr(2) : closest_to(name, known);
    return fmt::format("{}: expected one of the options in lode {} --help, got '{}'{}",
                       app.get_name(), app.get_name(), name,
                       hint.empty() ? "" : fmt::format("; did you mean '{}'?", hint));
  }
  return {};
}

/// The first option with an empty value, which elsewhere says that there is none.
std::string empty_option(const std::vector<std::string>& arguments, const CLI::App& app) {
  const auto describe = [](std::string_view name) {
    return fmt::format("{}: expected a value, got ''", name);
  };
  // CLI11 gives --name= the next argument, or a flag's default.
  for (const std::string& argument : arguments) {
    if (argument == "--") break;
    if (argument.starts_with("--") && argument.find('=') == argument.size() - 1)
      return describe(std::string_view(argument).substr(0, argument.size() - 1));
  }
  for (const CLI::Option* option : app.get_options())
    if (!option->get_lnames().empty() && std::ranges::count(option->results(), "") > 0)
      return describe("--" + option->get_lnames().front());
  return {};
}

/// The first value that a flag may have with =, and was given without.
std::string detached_value(const std::vector<std::string>& arguments, const CLI::App& app) {
  for (std::size_t i = 0; i + 1 < arguments.size(); ++i) {
    const CLI::Option* const option = app.get_option_no_throw(arguments[i]);
    const bool has_optional = option != nullptr && !option->get_positional() &&
                              option->get_expected_max() == 0 &&
                              option->get_name(false, true).find('{') != std::string::npos;
    if (has_optional && !arguments[i + 1].starts_with('-'))
      return fmt::format("{0}: expected its value as {0}={1}, got '{0} {1}'", arguments[i],
                         arguments[i + 1]);
  }
  return {};
}

/// CLI11's sentences may have several lines; ours have one.
std::string one_line(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0)
    text.pop_back();
  std::ranges::replace(text, '\n', ' ');
  return text;
}

int print_outcome(const Outcome& outcome, bool is_json) {
  const std::string text =
      is_json ? outcome.json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"
              : outcome.text;
  return print_output(text) ? outcome.exit_code : kFailure;
}

int run_command(const Command& command, const CommonOptions& options) {
  if (command.footer)
    if (const auto status = check_options(*command.app); !status)
      return report_error(status.error().message, kUsage, options.json);
  if (const auto status = command.check(); !status)
    return report_error(status.error().message, kUsage, options.json);
  ProgressBar bar(options.quiet ? ProgressDisplay::off : ProgressDisplay::terminal);
  Progress progress([&bar](std::string_view phase, double fraction, std::uint64_t n_bytes) {
    bar.update(phase, fraction, n_bytes);
  });
  const SignalGuard guard(progress);
  Session session(options, progress, bar);
  const auto outcome = command.run(session);
  bar.clear();
  if (outcome) return print_outcome(*outcome, options.json);
  if (SignalGuard::received() != 0)
    return report_error("stopped; " + session.leftover(), kSignalBase + SignalGuard::received(),
                        options.json);
  return report_error(outcome.error().message, kFailure, options.json);
}

/// Of one kind of data alone, where the command has several.
int explain(const Command& command, std::optional<DataKind> kind) {
  if (command.footer) {
    if (kind) show_only(*kind, *command.app);
    command.app->footer(command.footer->text(command.app->get_name(), kind));
  }
  return print_output(command.app->help("lode")) ? 0 : kFailure;
}

/// What `lode help COMMAND KIND` asks for.
struct HelpTopic {
  std::string command;
  std::string kind;
};

int print_help(CLI::App& program, const HelpTopic& asked, const std::vector<Command>& commands) {
  const std::string& topic = asked.command;
  const std::optional<DataKind> kind = find_data_kind(asked.kind);
  if (!asked.kind.empty() && !kind)
    return report_error(
        fmt::format("help: expected volume, mesh or terrain after {}, got '{}'", topic, asked.kind),
        kUsage, false);
  for (const Command& command : commands)
    if (command.app->get_name() == topic) return explain(command, kind);
  if (!topic.empty()) return report_error(unknown_command(topic, commands), kUsage, false);
  program.clear();  // a program that has parsed a subcommand explains only that
  return print_output(program.help()) ? 0 : kFailure;
}

int handle_parse_error(const CLI::ParseError& error, const CLI::App& program,
                       const std::vector<std::string>& arguments,
                       const std::vector<Command>& commands) {
  const bool is_json = std::ranges::count(arguments, "--json") > 0;
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
    const auto command = std::ranges::find_if(
        commands, [&](const Command& one) { return one.app->get_name() == arguments[0]; });
    if (command != commands.end()) return explain(*command, kind_of_input(*command->app));
    std::ostringstream text;  // --help or --version
    const int exit_code = program.exit(error, text, text);
    return print_output(text.str()) ? exit_code : kFailure;
  }
  for (const Command& command : commands) {
    if (arguments.empty() || command.app->get_name() != arguments[0]) continue;
    std::string message = unknown_option(arguments, *command.app);
    if (message.empty()) message = detached_value(arguments, *command.app);
    if (message.empty()) message = empty_option(arguments, *command.app);
    return report_error(message.empty() ? fmt::format("{}: {} (see lode {} --help)", arguments[0],
                                                      one_line(error.what()), arguments[0])
                                        : message,
                        kUsage, is_json);
  }
  return report_error(one_line(error.what()) + " (see lode --help)", kUsage, is_json);
}

int run_program(const std::vector<std::string>& arguments) {
  CLI::App program(
      "Lode: multiresolution scalar fields with proven errors.\n"
      "Builds a hierarchy of a volume, and extracts and draws surfaces within a tolerance.");
  program.name("lode");
  program.set_version_flag("--version", "lode " LODE_VERSION, "Print the version");
  program.require_subcommand(1);
  program.footer("lode COMMAND --help says more, with an example.");
  CommonOptions options;
  std::vector<Command> commands{
      add_info_command(program),     add_build_command(program),      add_attach_command(program),
      add_count_command(program),    add_extract_command(program),    add_probe_command(program),
      add_height_command(program),   add_neighbours_command(program), add_profile_command(program),
      add_contours_command(program), add_features_command(program),   add_sight_command(program),
      add_verify_command(program),   add_render_command(program),     add_tiles_command(program),
      add_compare_command(program),  add_bench_command(program)};
  for (const Command& command : commands) add_common_options(*command.app, options);
  HelpTopic topic;
  CLI::App* help = program.add_subcommand("help", "Explain a command");
  help->add_option("command", topic.command, "Command to explain")->type_name("COMMAND");
  help->add_option("kind", topic.kind, "Only what data of this kind have: volume, mesh or terrain")
      ->type_name("KIND");

  if (arguments.empty()) {
    print_error(program.help());
    return kUsage;
  }
  if (!arguments[0].starts_with('-') && std::ranges::count(names_of(commands), arguments[0]) == 0)
    return report_error(unknown_command(arguments[0], commands), kUsage,
                        std::ranges::count(arguments, "--json") > 0);
  try {
    // CLI11 takes the arguments as a stack.
    program.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::ParseError& error) {
    return handle_parse_error(error, program, arguments, commands);
  }
  if (help->parsed()) return print_help(program, topic, commands);
  const auto chosen =
      std::ranges::find_if(commands, [](const Command& command) { return command.app->parsed(); });
  if (const std::string message = empty_option(arguments, *chosen->app); !message.empty())
    return report_error(message, kUsage, options.json);
  return run_command(*chosen, options);
}

}  // namespace
}  // namespace lode::cli

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + std::min(argc, 1), argv + argc);
  const bool is_json = std::ranges::count(arguments, "--json") > 0;
  try {
    return lode::cli::run_program(arguments);
  } catch (const std::bad_alloc&) {
    return lode::cli::report_error("out of memory", lode::cli::kFailure, is_json);
  } catch (const std::exception& error) {
    return lode::cli::report_error(error.what(), lode::cli::kFailure, is_json);
  }
}

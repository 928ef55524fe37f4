// The results of Borgo, Scopigno, Cignoni, Pascucci, "A Progressive Subdivision Paradigm" (2003),
// section 5 and theorems 4.1 to 4.3, beside ours: docs/models/diamond3d.md. Their times are of a PC
// of 2003. The tables as CSV are what tools/plot_papers draws.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string_view>

#include "bench/papers/cases.h"
#include "bench/papers/growth.h"
#include "bench/papers/tables_1_2.h"

namespace lode::bench {
namespace {

struct Settings {
  std::string only;
  std::string directory;
  std::int32_t largest = 513;
};

bool is_wanted(const Settings& settings, std::string_view part) {
  return settings.only.empty() || settings.only == part;
}

Result<void> run_tables_1_2(const Settings& settings) {
  const bool with_builds = is_wanted(settings, "build");
  const bool with_extractions = is_wanted(settings, "extraction");
  Tables12 tables;
  for (const PaperCase& paper_case : paper_cases()) {
    const auto volume = load(paper_case);
    if (!volume) {
      fmt::print("{}: {}\n\n", paper_case.name, volume.error().message);
      continue;
    }
    if (with_builds) tables.add_build(paper_case, *volume);
    if (with_extractions) LODE_CHECK(tables.add_extractions(paper_case, *volume));
  }
  if (with_builds) LODE_CHECK(publish(tables.preprocessing(), settings.directory));
  if (!with_extractions) return {};
  LODE_CHECK(publish(tables.counts(), settings.directory));
  return publish(tables.times(), settings.directory);
}

Result<void> run_growth(const Settings& settings) {
  Growth growth;
  for (const oracles::Field field : {oracles::Field::gaussians40, oracles::Field::sphere})
    LODE_CHECK(growth.add_contours(field));
  LODE_CHECK(publish(growth.by_output(), settings.directory));
  for (const oracles::Field field : {oracles::Field::gaussians40, oracles::Field::sphere})
    LODE_CHECK(growth.add_sizes(field, settings.largest));
  return publish(growth.by_data(), settings.directory);
}

Result<void> run(const Settings& settings) {
  std::error_code failure;
  if (!settings.directory.empty()) std::filesystem::create_directories(settings.directory, failure);
  if (failure) return fail("{}: {}", settings.directory, failure.message());
  fmt::print(
      "Medians of seven runs in turns (three of long ones); where nothing else is said, one thread "
      "and "
      "its processor time.\n\n");
  if (settings.only != "growth") LODE_CHECK(run_tables_1_2(settings));
  return is_wanted(settings, "growth") ? run_growth(settings) : Result<void>();
}

}  // namespace
}  // namespace lode::bench

int main(int argc, char** argv) {
  CLI::App app("The papers' results beside ours");
  lode::bench::Settings settings;
  app.add_option("--only", settings.only, "Table 1, table 2, or the theorems")
      ->check(CLI::IsMember({"build", "extraction", "growth"}));
  app.add_option("--out", settings.directory, "Directory for the tables as Markdown and CSV");
  app.add_option("--largest", settings.largest, "Most samples per axis for growth with n");
  CLI11_PARSE(app, argc, argv);
  if (const auto done = lode::bench::run(settings); !done) {
    fmt::print(stderr, "{}\n", done.error().message);
    return 1;
  }
  return 0;
}

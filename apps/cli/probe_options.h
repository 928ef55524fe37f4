#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "command.h"
#include "input.h"
#include "lode/api/probe.h"

namespace lode::cli {

/// The options of `lode probe` as typed.
struct ProbeArguments {
  std::string input;
  std::vector<std::string> points;
  std::string points_file;
  std::string line;
  bool is_integral = false;
  std::string box;
  std::vector<std::string> regions;
  std::string max_error;
  std::string snap;
  std::string memory_limit;
  std::string output;
  ReadingArguments reading;
};

void add_probe_options(CLI::App& app, ProbeArguments& arguments);

enum class ProbeKind { points, line, integral };

/// What is wanted, but for the points of a file, and regions, which the mesh numbers.
struct ProbeJob {
  ProbeKind kind = ProbeKind::points;
  std::vector<Vec3d> points;
  ProbedLine line;
  ProbeOptions options;
  IntegralOptions integral;
};

[[nodiscard]] Result<ProbeJob> to_probe_job(const ProbeArguments& arguments, Threads threads);

/// Points of a text file: three numbers a line, with commas, semicolons, tabs or blanks between
/// them; a first line without a number is a heading, and lines that begin with # are left out.
/// Fails, naming file and line, on anything else.
[[nodiscard]] Result<std::vector<Vec3d>> read_points(const std::string& path);

}  // namespace lode::cli

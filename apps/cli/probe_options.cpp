#include "probe_options.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <utility>

#include "parse.h"
#include "tolerance.h"

namespace lode::cli {
namespace {

Result<Box3d> parse_integral_box(const std::string& text) {
  LODE_TRY(const std::vector<double> n, parse_numbers("--box", text));
  if (n.size() != 6)
    return fail("--box: expected six numbers as X0,X1,Y0,Y1,Z0,Z1, got '{}'", text);
  if (!(n[0] < n[1] && n[2] < n[3] && n[4] < n[5]))
    return fail("--box: expected X0 < X1, Y0 < Y1 and Z0 < Z1, got '{}'", text);
  return Box3d{{{n[0], n[2], n[4]}}, {{n[1], n[3], n[5]}}};
}

Result<ProbedLine> parse_line(const std::string& text) {
  constexpr std::int64_t kMost = 10'000'000;
  const std::size_t first = text.find(':');
  if (first == std::string::npos)
    return fail("--line: expected two points as X,Y,Z:X,Y,Z, and :N for N points, got '{}'", text);
  const std::size_t second = text.find(':', first + 1);
  ProbedLine line;
  LODE_TRY(line.begin, parse_vector("--line", text.substr(0, first)));
  LODE_TRY(line.end, parse_vector("--line", text.substr(first + 1, second - first - 1)));
  if (line.begin == line.end) return fail("--line: expected two different points, got '{}'", text);
  if (second == std::string::npos) return line;
  LODE_TRY(const std::int64_t n, parse_integer("--line", text.substr(second + 1), 2, kMost));
  line.n_points = static_cast<std::uint32_t>(n);
  return line;
}

/// The numbers of a line of text, or none where something else is among them.
std::optional<std::vector<double>> numbers_of(std::string line) {
  std::ranges::replace_if(
      line, [](char c) { return c == ',' || c == ';' || c == '\t' || c == '\r'; }, ' ');
  std::vector<double> numbers;
  for (std::size_t at = line.find_first_not_of(' '); at != std::string::npos;) {
    const std::size_t end = std::min(line.find(' ', at), line.size());
    const auto number = parse_number("", line.substr(at, end - at));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    at = line.find_first_not_of(' ', end);
  }
  return numbers;
}

bool is_blank(const std::string& line) {
  return line.starts_with('#') ||
         std::ranges::all_of(line, [](unsigned char c) { return std::isspace(c) != 0; });
}

/// Whether it names columns: words that do not begin as numbers do.
bool is_heading(const std::string& line) {
  const std::size_t at = line.find_first_not_of(" \t\"");
  return at != std::string::npos && std::isalpha(static_cast<unsigned char>(line[at])) != 0 &&
         !line.substr(at).starts_with("nan") && !line.substr(at).starts_with("inf");
}

Result<ProbeKind> kind_of(const ProbeArguments& arguments) {
  const bool has_points = !arguments.points.empty() || !arguments.points_file.empty();
  const int n =
      (has_points ? 1 : 0) + (arguments.line.empty() ? 0 : 1) + (arguments.is_integral ? 1 : 0);
  if (n != 1)
    return fail("{}: expected --point or --points, --line, or --integral, got {} of these",
                arguments.input, n == 0 ? "none" : "several");
  if (!arguments.is_integral)
    for (const auto& [name, is_set] :
         {std::pair{"--box", !arguments.box.empty()}, {"--region", !arguments.regions.empty()}})
      if (is_set) return fail("{}: expected --integral with it", name);
  return has_points              ? ProbeKind::points
         : arguments.is_integral ? ProbeKind::integral
                                 : ProbeKind::line;
}

}  // namespace

void add_probe_options(CLI::App& app, ProbeArguments& arguments) {
  const auto add = [&](const char* name, auto& value, const char* type, const char* help) {
    app.add_option(name, value, help)->type_name(type)->allow_extra_args(false);
  };
  add("--point", arguments.points, "X,Y,Z", "The value at a point, and bounds; may be repeated");
  add("--points", arguments.points_file, "FILE.csv", "At each point of a file: X,Y,Z a line");
  add("--line", arguments.line, "X,Y,Z:X,Y,Z[:N]",
      "Along a line: where it meets faces of cells, in between which the field is linear; or at N "
      "points at equal distances");
  app.add_flag("--integral", arguments.is_integral,
               "Volume, integral, mean, minimum and maximum over the domain");
  add("--box", arguments.box, "X0,X1,Y0,Y1,Z0,Z1", "With --integral: over what is in a box");
  add("--region", arguments.regions, "NAME",
      "With --integral: over a region (block, material, zone) of a mesh of cells, by its name or "
      "number (info lists them); may be repeated");
  add("--max-error", arguments.max_error, "E",
      "Tolerance in field units, or with % of the range of values: coarser, and with wider bounds "
      "(default: 0, full resolution)");
  add("--snap", arguments.snap, "D",
      "With --point, --points, or N points of a --line: points that are outside, but no farther "
      "from a cell than D, get what its nearest point has (default: 2^-46 of the largest distance "
      "from the origin, which rounds coordinates)");
  add("--memory-limit", arguments.memory_limit, "SIZE",
      "Of a volume's .lode file: bytes that may be taken, as 512M or 4G (default: a quarter of the "
      "memory)");
  add("-o,--output", arguments.output, "OUT.csv", "Write the rows to a file, too");
}

Result<ProbeJob> to_probe_job(const ProbeArguments& arguments, Threads threads) {
  ProbeJob job;
  LODE_TRY(job.kind, kind_of(arguments));
  for (const std::string& text : arguments.points) {
    LODE_TRY(const Vec3d point, parse_vector("--point", text));
    job.points.push_back(point);
  }
  if (!arguments.line.empty()) {
    LODE_TRY(job.line, parse_line(arguments.line));
  }
  if (!arguments.max_error.empty()) {
    LODE_TRY(job.options.max_error, parse_tolerance("--max-error", arguments.max_error));
  }
  if (!arguments.snap.empty()) {
    const bool is_of_points =
        job.kind == ProbeKind::points || (job.kind == ProbeKind::line && job.line.n_points > 0);
    if (!is_of_points) return fail("--snap: expected --point, --points or --line with N with it");
    LODE_TRY(job.options.snap, parse_number("--snap", arguments.snap));
    if (!(job.options.snap >= 0))
      return fail("--snap: expected a distance >= 0, got '{}'", arguments.snap);
  }
  if (!arguments.memory_limit.empty()) {
    LODE_TRY(job.options.memory_limit, parse_bytes("--memory-limit", arguments.memory_limit));
  }
  job.options.threads = threads;
  job.integral = {.max_error = job.options.max_error,
                  .memory_limit = job.options.memory_limit,
                  .threads = threads};
  if (!arguments.box.empty()) {
    LODE_TRY(job.integral.box, parse_integral_box(arguments.box));
  }
  return job;
}

Result<std::vector<Vec3d>> read_points(const std::string& path) {
  std::ifstream file(path);
  if (!file) return fail("{}: expected a file of points that can be read, got none", path);
  std::vector<Vec3d> points;
  std::string line;
  std::size_t n_lines = 0;
  for (bool is_first = true; std::getline(file, line);) {
    ++n_lines;
    if (is_blank(line)) continue;
    const bool may_be_heading = std::exchange(is_first, false);
    const auto numbers = numbers_of(line);
    if (may_be_heading && is_heading(line)) continue;
    if (!numbers || numbers->size() != 3)
      return fail("{}: expected three finite numbers as X,Y,Z in line {}, got '{}'", path, n_lines,
                  line.substr(0, 80));
    points.push_back({{(*numbers)[0], (*numbers)[1], (*numbers)[2]}});
  }
  if (file.bad()) return fail("{}: could not be read to its end", path);
  if (points.empty()) return fail("{}: expected points, got none", path);
  return points;
}

}  // namespace lode::cli

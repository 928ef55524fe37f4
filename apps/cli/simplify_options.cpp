#include "simplify_options.h"

#include <fmt/format.h>

#include "parse.h"

namespace lode::cli {

void add_simplify_options(CLI::App& app, SimplifyArguments& arguments) {
  const char* group = "Simplification";
  app.add_flag("--simplify", arguments.is_wanted,
               "Collapse edges of the surface within --max-distance: proven, still a manifold, "
               "never through itself (without --max-error, of full resolution)")
      ->group(group);
  app.add_option("--max-distance", arguments.max_distance,
                 "How far any point of either surface may be from the other, world units")
      ->type_name("D")
      ->group(group);
}

Result<void> apply_simplify_options(const SimplifyArguments& arguments, ExtractOptions& options) {
  if (!arguments.is_wanted) return {};
  if (arguments.max_distance.empty())
    return fail("--simplify: expected --max-distance with it, which says how far");
  LODE_TRY(const double distance, parse_number("--max-distance", arguments.max_distance));
  if (!(distance > 0))
    return fail("--max-distance: expected a number > 0, got '{}'", arguments.max_distance);
  if (options.border == Border::closed)
    return fail("--simplify: expected no --close-border with it: caps would leave the border");
  options.simplify_distance = distance;
  return {};
}

std::string simplify_comment(const ExtractReport& report) {
  if (!report.simplified) return "";
  return fmt::format(", simplified within distance {}", report.simplified->proven_distance);
}

void add_simplified(Json& json, const ExtractReport& report) {
  if (!report.simplified) return;
  const SimplifyReport& done = *report.simplified;
  Json& simplified = json["simplified"];
  simplified["max_distance"] = done.max_distance;
  simplified["proven_distance"] = done.proven_distance;
  simplified["triangles_before"] = done.triangles_before;
  simplified["triangles"] = done.triangles;
  simplified["collapses"] = done.collapses;
  simplified["collapses_undone"] = done.undone;
  simplified["components_dropped"] = 0;
  simplified["input_crossings"] = done.input_crossings;
  json["seconds"]["simplify"] = report.seconds.simplify;
}

void add_simplified(Table& table, const ExtractReport& report) {
  if (!report.simplified) return;
  const SimplifyReport& done = *report.simplified;
  table.add({"simplified", fmt::format("from {} triangles, {} collapses ({} undone)",
                                       format_count(done.triangles_before),
                                       format_count(done.collapses), format_count(done.undone))});
  table.add(
      {"distance",
       fmt::format("at most {} from the surface before and back (asked for: {}), no piece dropped",
                   format_number(done.proven_distance), format_number(done.max_distance))});
  if (done.input_crossings > 0)
    table.add({"met itself before", format_count(done.input_crossings) + " pairs of triangles"});
  table.add({"simplify", fmt::format("{} (collapse {:.3f}, prove {:.3f}, finish {:.3f})",
                                     format_seconds(report.seconds.simplify), done.seconds.collapse,
                                     done.seconds.check, done.seconds.finish)});
}

}  // namespace lode::cli

#include "simplify_options.h"

#include <fmt/format.h>

#include "parse.h"

namespace lode::cli {

void add_simplify_options(CLI::App& app, SimplifyArguments& arguments) {
  const char* group = "Simplification";
  app.add_flag("--simplify", arguments.simplifies,
               "Collapse edges of the surface within --max-distance: proven, still a manifold, "
               "never through itself (without --max-error, of full resolution)")
      ->group(group);
  app.add_flag("--remove-slivers", arguments.removes_slivers,
               "The same of edges up to --max-distance long alone: triangles beside them change "
               "shape, and slivers without a short edge stay")
      ->group(group);
  app.add_option(
         "--max-distance", arguments.max_distance,
         "How far any point of the surface may be from that of full resolution, and back, "
         "world units: proven; with --simplify or --remove-slivers, from the surface before and "
         "back")
      ->type_name("D")
      ->group(group);
}

namespace {

Result<void> apply_max_distance(double distance, ExtractOptions& options) {
  static constexpr const char* kExpected =
      "--max-distance: expected no {} with it unless --simplify is, {}";
  if (options.style == SurfaceStyle::cubes)
    return fail(kExpected, "--style cubes", "as it is of full resolution already");
  if (options.border == Border::closed)
    return fail(kExpected, "--close-border", "as caps are not proven");
  if (options.clip) return fail(kExpected, "--clip", "whose planes part what lies near");
  if (options.min_component > 1)
    return fail(kExpected, "--min-component", "which would drop parts of the surface");
  options.max_distance = distance;
  return {};
}

}  // namespace

Result<void> apply_simplify_options(const SimplifyArguments& arguments, ExtractOptions& options) {
  if (!arguments.is_wanted() && arguments.max_distance.empty()) return {};
  if (arguments.simplifies && arguments.removes_slivers)
    return fail("--remove-slivers: expected no --simplify with it, which takes longer edges too");
  if (arguments.max_distance.empty())
    return fail("{}: expected --max-distance with it, which says how far", arguments.name());
  LODE_TRY(const double distance, parse_number("--max-distance", arguments.max_distance));
  if (!(distance > 0))
    return fail("--max-distance: expected a number > 0, got '{}'", arguments.max_distance);
  if (!arguments.is_wanted()) return apply_max_distance(distance, options);
  if (options.border == Border::closed)
    return fail("{}: expected no --close-border with it: caps would leave the border",
                arguments.name());
  options.simplify_distance = distance;
  if (arguments.removes_slivers) options.simplify_what = SimplifyWhat::slivers;
  if (!options.max_error) options.max_error = 0;
  return {};
}

std::string simplify_comment(const ExtractReport& report) {
  if (!report.simplified) return "";
  return fmt::format(", simplified within distance {}", report.simplified->proven_distance);
}

std::string distance_comment(const ExtractReport& report) {
  if (!report.distance) return "";
  return fmt::format(", max_distance {}, proven_distance {}", report.distance->max_distance,
                     report.distance->proven_distance);
}

void add_distance(Json& json, const ExtractReport& report) {
  if (!report.distance) return;
  const DistanceReport& kept = *report.distance;
  Json& distance = json["distance"];
  distance["max_distance"] = kept.max_distance;
  distance["proven_distance"] = kept.proven_distance;
  distance["rounds"] = kept.rounds;
  distance["nodes_refined"] = kept.nodes_refined;
  distance["full_triangles"] = kept.full_triangles;
  distance["lost_triangles"] = kept.lost_triangles;
  distance["lost_size"] = kept.lost_size;
  json["seconds"]["distance"] = report.seconds.distance;
}

void add_distance(Table& table, const ExtractReport& report) {
  if (!report.distance) return;
  const DistanceReport& kept = *report.distance;
  table.add({"distance",
             fmt::format("at most {} from full resolution ({} triangles) and back (asked for: {})",
                         format_number(kept.proven_distance), format_count(kept.full_triangles),
                         format_number(kept.max_distance))});
  table.add({"lost",
             kept.lost_triangles == 0
                 ? "nothing"
                 : fmt::format("{} triangles of full resolution, within {}",
                               format_count(kept.lost_triangles), format_number(kept.lost_size))});
  table.add({"refined for it",
             fmt::format("{} nodes in {} rounds, {}", format_count(kept.nodes_refined),
                         format_count(kept.rounds), format_seconds(report.seconds.distance))});
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

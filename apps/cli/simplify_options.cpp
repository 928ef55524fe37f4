#include "simplify_options.h"

#include <fmt/format.h>

#include <cmath>

#include "parse.h"

namespace lode::cli {

void add_simplify_options(CLI::App& app, SimplifyArguments& arguments) {
  const char* group = "Simplification";
  app.add_flag(
         "--simplify", arguments.simplifies,
         "Collapse edges of the surface within --max-error of the isovalue, the field's at full "
         "resolution, and within --max-distance of the surface at full resolution (with --style "
         "cubes of the cubes, with --keep-topology=P of what persists): proven, "
         "still a manifold, never through itself; within --max-error alone closed pieces that "
         "hold nothing farther go")
      ->group(group);
  app.add_flag("--remove-slivers", arguments.removes_slivers,
               "The same of edges up to --max-distance long alone: triangles beside them change "
               "shape, and slivers without a short edge stay")
      ->group(group);
  app.add_option(
         "--max-distance", arguments.max_distance,
         "How far any point of the surface may be from that of full resolution, and back, "
         "world units: proven; with --simplify or --remove-slivers and --style cubes, from the "
         "cubes, and with --keep-topology=P from what persists (of a step of the grid or more "
         "--simplify gives a fifth to beginning with cubes, "
         "where these are near; beside --max-error half goes to the surface that it begins with)")
      ->type_name("D")
      ->group(group);
}

namespace {

Result<void> apply_max_distance(double distance, ExtractOptions& options) {
  static constexpr const char* kExpected =
      "--max-distance: expected no {} with it unless --simplify or --remove-slivers is, {}";
  if (options.border == Border::closed)
    return fail("--max-distance: expected no --close-border with it, as caps are not proven");
  if (options.style == SurfaceStyle::cubes)
    return fail(kExpected, "--style cubes",
                "as it is of full resolution already; how far cubes may be from the level set says "
                "--style-distance");
  if (options.clip) return fail(kExpected, "--clip", "whose planes part what lies near");
  if (options.min_component > 1)
    return fail(kExpected, "--min-component", "which would drop parts of the surface");
  options.max_distance = distance;
  return {};
}

}  // namespace

Result<void> check_simplify_range(const ExtractOptions& options, double range_min,
                                  double range_max) {
  if (options.simplify == Simplify::off || options.simplify_distance || range_min < range_max ||
      options.max_error.value_or(0) > 0)
    return {};
  return fail(
      "--simplify: expected --max-distance, or --max-error in the field's unit, with it, as the "
      "field has one value: shares of its range are 0");
}

Result<void> apply_simplify_options(const SimplifyArguments& arguments, ExtractOptions& options) {
  if (!arguments.is_wanted() && arguments.max_distance.empty()) return {};
  if (arguments.simplifies && arguments.removes_slivers)
    return fail("--remove-slivers: expected no --simplify with it, which takes longer edges too");
  if (arguments.removes_slivers && arguments.max_distance.empty())
    return fail("--remove-slivers: expected --max-distance with it, which says how far");
  if (!arguments.max_distance.empty()) {
    LODE_TRY(const double distance, parse_number("--max-distance", arguments.max_distance));
    if (!(distance > 0))
      return fail("--max-distance: expected a number > 0, got '{}'", arguments.max_distance);
    if (!arguments.is_wanted()) return apply_max_distance(distance, options);
    options.simplify_distance = distance;
  }
  if (options.border == Border::closed)
    return fail("{}: expected no --close-border with it: caps would leave the border",
                arguments.name());
  options.simplify = arguments.removes_slivers ? Simplify::slivers : Simplify::edges;
  if (!options.max_error && options.simplify_distance) options.max_error = 0;
  if (options.max_error == 0.0 && !options.simplify_distance)
    return fail("--simplify: expected --max-error > 0 or --max-distance with it, got neither");
  if (options.max_error != 0.0 && options.min_component > 1)
    return fail(
        "{}: expected no --min-component with it within --max-error, which drops pieces by "
        "their distance from the isovalue",
        arguments.name());
  if (options.max_error != 0.0 && options.clip)
    return fail("{}: expected no --clip with it within --max-error, of which a part has no proof",
                arguments.name());
  return {};
}

std::string simplify_comment(const ExtractReport& report) {
  if (!report.simplified) return "";
  const SimplifyReport& done = *report.simplified;
  if (done.max_error == 0)
    return fmt::format(", simplified within distance {}", done.proven_distance);
  if (!std::isfinite(done.max_distance))
    return fmt::format(", simplified within error {}", done.max_error);
  return fmt::format(", simplified within error {} and distance {}", done.max_error,
                     done.proven_distance);
}

std::string distance_comment(const ExtractReport& report) {
  if (!report.distance) return "";
  const DistanceReport& kept = *report.distance;
  return fmt::format(
      ", max_distance {}, proven_distance {}{}", kept.max_distance, kept.proven_distance,
      kept.memory_limit > 0 ? fmt::format(", memory_limit {}", kept.memory_limit) : "");
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
  distance["memory_limit"] = kept.memory_limit > 0 ? Json(kept.memory_limit) : Json(nullptr);
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
  if (kept.memory_limit > 0)
    table.add({"in windows", fmt::format("for a memory limit of {} bytes, which verify is to know",
                                         format_count(kept.memory_limit))});
}

void add_simplified(Json& json, const ExtractReport& report) {
  if (!report.simplified) return;
  const SimplifyReport& done = *report.simplified;
  Json& simplified = json["simplified"];
  const bool has_distance = std::isfinite(done.max_distance);
  simplified["max_distance"] = has_distance ? Json(done.max_distance) : Json(nullptr);
  simplified["proven_distance"] = has_distance ? Json(done.proven_distance) : Json(nullptr);
  simplified["max_error"] = done.max_error > 0 ? Json(done.max_error) : Json(nullptr);
  simplified["proven_error"] = done.max_error > 0 ? Json(done.proven_error) : Json(nullptr);
  simplified["start_distance"] = done.start_distance;
  simplified["triangles_before"] = done.triangles_before;
  simplified["triangles"] = done.triangles;
  simplified["collapses"] = done.collapses;
  simplified["collapses_undone"] = done.undone;
  simplified["components_dropped"] = done.components_dropped;
  simplified["triangles_dropped"] = done.triangles_dropped;
  simplified["input_crossings"] = done.input_crossings;
  simplified["by_pieces"] = done.by_pieces;
  json["seconds"]["simplify"] = report.seconds.simplify;
}

void add_simplified(Table& table, const ExtractReport& report) {
  if (!report.simplified) return;
  const SimplifyReport& done = *report.simplified;
  table.add({"simplified", fmt::format("from {} triangles, {} collapses ({} undone)",
                                       format_count(done.triangles_before),
                                       format_count(done.collapses), format_count(done.undone))});
  if (done.by_pieces)
    table.add({"by pieces", "as the memory limit asks: seams keep triangles that it would not"});
  if (done.start_distance > 0 && done.max_error > 0)
    table.add({"beginning with", fmt::format("a surface within {} of full resolution",
                                             format_number(done.start_distance))});
  else if (done.start_distance > 0)
    table.add({"beginning with", fmt::format("cubes where they are within {} of the tetrahedra",
                                             format_number(done.start_distance))});
  if (done.max_error > 0)
    table.add({"simplified within",
               fmt::format("|F - isovalue| at most {} where edges collapsed (asked for: {})",
                           format_number(done.proven_error), format_number(done.max_error))});
  if (std::isfinite(done.max_distance)) {
    const char* const from = done.max_error > 0 && done.start_distance > 0 ? "full resolution"
                             : report.topology && report.topology->leaves_out_weak
                                 ? "the surface before, of what persists,"
                                 : "the surface before";
    table.add({"distance", fmt::format("at most {} from {} and back (asked for: {})",
                                       format_number(done.proven_distance), from,
                                       format_number(done.max_distance))});
  }
  if (done.max_error > 0)
    table.add({"pieces in the band",
               done.components_dropped == 0
                   ? "none"
                   : fmt::format("{} with {} triangles dropped of the surface that it begins with: "
                                 "all within the max error inside",
                                 format_count(done.components_dropped),
                                 format_count(done.triangles_dropped))});
  if (done.input_crossings > 0)
    table.add({"met itself before", format_count(done.input_crossings) + " pairs of triangles"});
  table.add({"simplify", fmt::format("{} (collapse {:.3f}, prove {:.3f}, finish {:.3f})",
                                     format_seconds(report.seconds.simplify), done.seconds.collapse,
                                     done.seconds.check, done.seconds.finish)});
}

}  // namespace lode::cli

#include "extraction_options.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "parse.h"
#include "text.h"
#include "tolerance.h"

namespace lode::cli {
namespace {

Result<std::vector<double>> parse_isovalues(const std::vector<std::string>& arguments) {
  std::vector<double> isovalues;
  for (const std::string& argument : arguments) {
    LODE_TRY(const std::vector<double> some, parse_numbers("--isovalue", argument));
    for (const double isovalue : some) {
      if (std::ranges::find(isovalues, isovalue) != isovalues.end())
        return fail("--isovalue: expected each value once, got {} twice", isovalue);
      isovalues.push_back(isovalue);
    }
  }
  return isovalues;
}

Result<Box3d> parse_clip(const std::string& text) {
  LODE_TRY(const std::vector<double> n, parse_numbers("--clip", text));
  if (n.size() != 6)
    return fail("--clip: expected six numbers as X0,X1,Y0,Y1,Z0,Z1, got '{}'", text);
  if (n[0] >= n[1] || n[2] >= n[3] || n[4] >= n[5])
    return fail("--clip: expected X0 < X1, Y0 < Y1 and Z0 < Z1, got '{}'", text);
  return Box3d{{{n[0], n[2], n[4]}}, {{n[1], n[3], n[5]}}};
}

}  // namespace

void add_extraction_options(CLI::App& app, ExtractionArguments& arguments) {
  const char* group = "Surface";
  app.add_option("--isovalue", arguments.isovalues,
                 "Value of the surface; may be repeated (default of a picture of a volume: one "
                 "that parts the values best)")
      ->type_name("V")
      ->allow_extra_args(false)
      ->group(group);
  app.add_option(
         "--max-error", arguments.max_error,
         "Tolerance in field units (terrain: of its heights), or with % of the range of values; 0 "
         "is full resolution (default: 0.5%)")
      ->type_name("E")
      ->group(group);
  app.add_option(
         "--style", arguments.style,
         "Vertices of full resolution: tetra, on all edges of the tetrahedra (the exact "
         "level set), or cubes, on the grid's edges alone (a third of the triangles) "
         "wherever that keeps within --max-error; with --max-error 0 everywhere but in "
         "bricks of 32^3 that holes touch. Cubes are of full resolution: an error makes none "
         "of them larger, --simplify does")
      ->type_name("tetra|cubes")
      ->group(group);
  app.add_option("--style-distance", arguments.style_distance,
                 "With --style cubes: tetrahedra stay, too, where cubes are not within D of them, "
                 "or they of cubes, world units")
      ->type_name("D")
      ->group(group);
  app.add_flag("--keep-topology{0}", arguments.keep_topology,
               "Refine where the surface would tear, join, lose or gain a piece: components, "
               "tunnels and voids are those of full resolution; with =P those at least that there "
               "are from P below the isovalue to P above it, without pieces round regions that "
               "nowhere are farther than P from it (P may be with % of the range of values). Not "
               "with --max-distance, unless with --simplify "
               "or --remove-slivers: then the distance is from what is left. Of these P is "
               "--max-error at most, and with both, but of cubes, nothing is left out")
      ->group(group);
  app.add_option("--clip", arguments.clip,
                 "Crop to a box in world units (not --mesh); of terrain the triangles that meet "
                 "X0,X1,Y0,Y1, whole")
      ->type_name("X0,X1,Y0,Y1[,Z0,Z1]")
      ->group(group);
  app.add_flag("--close-border", arguments.close_border,
               "Cap the surface at the domain's border: it then encloses all values from V up")
      ->group(group);
  app.add_option("--min-component", arguments.min_component,
                 "Drop pieces with fewer triangles (lines) than N")
      ->type_name("N")
      ->group(group);
  app.add_flag("--flip", arguments.flip, "Turn triangles and normals to the other side")
      ->group(group);
  app.add_option("--normals", arguments.normals, "on or off (default: on)")
      ->type_name("on|off")
      ->group(group);
}

Result<ExtractOptions> to_extract_options(const ExtractionArguments& arguments) {
  ExtractOptions options;
  LODE_TRY(options.isovalues, parse_isovalues(arguments.isovalues));
  if (!arguments.max_error.empty()) {
    LODE_TRY(options.max_error, parse_tolerance("--max-error", arguments.max_error));
  }
  if (arguments.style != "tetra" && arguments.style != "cubes")
    return fail("--style: expected 'tetra' or 'cubes', got '{}'", arguments.style);
  if (arguments.style == "cubes") options.style = SurfaceStyle::cubes;
  if (!arguments.style_distance.empty()) {
    if (options.style != SurfaceStyle::cubes)
      return fail("--style-distance: expected --style cubes with it");
    LODE_TRY(options.style_distance, parse_number("--style-distance", arguments.style_distance));
    if (!(*options.style_distance > 0))
      return fail("--style-distance: expected a number > 0, got '{}'", arguments.style_distance);
  }
  if (!arguments.clip.empty()) {
    LODE_TRY(options.clip, parse_clip(arguments.clip));
  }
  if (arguments.normals != "on" && arguments.normals != "off")
    return fail("--normals: expected 'on' or 'off', got '{}'", arguments.normals);
  options.normals = arguments.normals == "on" ? Normals::on : Normals::off;
  if (arguments.close_border && options.isovalues.size() > 1)
    return fail("--close-border: expected one --isovalue, got {}: caps would lie in each other",
                options.isovalues.size());
  if (arguments.close_border && options.clip)
    return fail("--close-border: expected no --clip with it, whose cut would stay open");
  options.border = arguments.close_border ? Border::closed : Border::open;
  if (!arguments.keep_topology.empty()) {
    LODE_TRY(options.keep_topology, parse_tolerance("--keep-topology", arguments.keep_topology));
  }
  if (options.keep_topology && options.clip)
    return fail("--keep-topology: expected no --clip with it, whose planes cut pieces elsewhere");
  if (options.keep_topology && !arguments.min_component.empty())
    return fail("--keep-topology: expected no --min-component with it, which drops pieces");
  options.orientation =
      arguments.flip ? Orientation::from_higher_values : Orientation::from_lower_values;
  if (!arguments.min_component.empty()) {
    constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
    LODE_TRY(const auto n, parse_integer("--min-component", arguments.min_component, 0, kMost));
    options.min_component = static_cast<std::uint64_t>(n);
  }
  return options;
}

void add_isovalues(const std::vector<double>& isovalues, Table& table) {
  std::string texts;
  for (const double isovalue : isovalues)
    texts += (texts.empty() ? "" : "; ") + fmt::format("{}", isovalue);
  table.add({isovalues.size() == 1 ? "isovalue" : "isovalues", texts});
}

std::string describe_tolerance(const ExtractOptions& options, double max_error) {
  if (options.max_distance && !options.max_error) return "any, within the distance";
  return format_number(max_error) +
         (options.max_error ? "" : " (default: 0.5 % of the value range)");
}

std::string describe_topology(const ExtractReport& report) {
  const KeptTopology& kept = *report.topology;
  const std::string of_what =
      kept.persistence > 0
          ? fmt::format("what persists by {} of full resolution", format_number(kept.persistence))
          : "of full resolution";
  std::string left_out;
  if (kept.leaves_out_weak)
    left_out = fmt::format(
        "; regions left out that do not persist: {}, beside those that the tolerance loses",
        format_count(kept.weak_regions));
  else if (kept.persistence > 0)
    left_out = "; within the distance nothing is left out";
  if (!kept.is_searched)
    return kept.leaves_out_weak ? of_what + left_out : "of full resolution, which the surface is";
  return fmt::format("{}: {} critical nodes, {} with what comes before them, found in {}{}",
                     of_what, format_count(kept.critical_nodes), format_count(kept.nodes),
                     format_seconds(report.seconds.topology), left_out);
}

std::string topology_comment(const ExtractReport& report) {
  if (!report.topology) return "";
  return fmt::format(", keep_topology {}", report.topology->persistence);
}

void add_extraction(Json& json, const ExtractOptions& options, const ExtractReport& report) {
  json["isovalues"] = options.isovalues;
  json["max_error"] = report.max_error;
  json["max_error_is_default"] = !options.max_error && !options.max_distance;
  json["achieved_error"] = report.achieved_error;
  if (options.style == SurfaceStyle::cubes) {
    json["style"] = "cubes";
    if (options.style_distance) json["max_style_distance"] = *options.style_distance;
    if (options.deviation == Deviation::measured) {
      json["style_error"] = report.style_error;
      json["style_distance"] = report.style_distance;
    }
  }
  if (report.topology) {
    const KeptTopology& kept = *report.topology;
    json["topology"]["persistence"] = kept.persistence;
    json["topology"]["critical_nodes"] = kept.is_searched ? Json(kept.critical_nodes) : Json();
    json["topology"]["nodes"] = kept.is_searched ? Json(kept.nodes) : Json();
    json["topology"]["weak_regions"] = kept.leaves_out_weak ? Json(kept.weak_regions) : Json();
  }
  json["triangles"] = report.triangles;
  json["lines"] = report.lines;
  json["cap_cells"] = report.cap_cells;
  json["vertices"] = report.vertices;
}

void warn_of_cubes(Session& session, const ExtractOptions& options) {
  if (options.style == SurfaceStyle::cubes && options.isovalues.size() > 1)
    session.warn("--style cubes: surfaces of isovalues that are near each other may meet");
}

void warn_of_open(Session& session, const ExtractReport& report) {
  if (report.open_edges > 0)
    session.warn(fmt::format("the surface stays open at holes: along {} edges{}", report.open_edges,
                             report.components_dropped > 0 ? ", before pieces were dropped" : ""));
}

void warn_of_persistence(Session& session, const ExtractReport& report,
                         const ExtractOptions& options, const DatasetInfo& info) {
  if (!report.topology || !report.topology->leaves_out_weak) return;
  const double persistence = report.topology->persistence;
  if (persistence < options.keep_topology)
    session.warn(fmt::format(
        "--keep-topology: what is farther than --max-error from the isovalue keeps its side, so it "
        "is {} in place of {}",
        persistence, *options.keep_topology));
  for (const double isovalue : options.isovalues) {
    const bool is_low = isovalue - persistence < info.range_min;
    if (!is_low && isovalue + persistence <= info.range_max) continue;
    session.warn(fmt::format(
        "--keep-topology: no value is {} {}, so nothing {} the isovalue {} persists by {}: no more "
        "than {} does",
        is_low ? "below" : "above", is_low ? isovalue - persistence : isovalue + persistence,
        is_low ? "below" : "above", isovalue, persistence,
        is_low ? isovalue - info.range_min : info.range_max - isovalue));
  }
}

void add_style(const ExtractOptions& options, const ExtractReport& report, bool has_holes,
               Table& table) {
  if (options.style != SurfaceStyle::cubes) return;
  const char* const when = report.simplified ? ", before it was simplified" : "";
  table.add({"style", report.max_error > 0 ? "cubes within the max error, tetrahedra elsewhere"
                      : options.style_distance
                          ? "cubes within the style distance, tetrahedra elsewhere"
                      : has_holes ? "cubes, tetrahedra in bricks that holes touch"
                                  : "cubes: vertices on grid edges alone"});
  if (options.deviation != Deviation::measured) {
    if (report.max_error == 0)
      table.add({"|F - isovalue|", "of cubes not measured: lode extract measures it"});
    return;
  }
  const double error = std::max(report.style_error, report.achieved_error);
  table.add({"|F - isovalue|", fmt::format("at most {}{}", format_number(error), when)});
  table.add(
      {"cubes",
       fmt::format("their points at most {} from F = isovalue, measured in {}{}",
                   format_number(report.style_distance), format_seconds(report.seconds.measure),
                   report.max_error > 0 ? "" : "; how far that is from them, verify measures")});
}

void add_dropped(const ExtractOptions& options, std::uint64_t components, std::uint64_t cells,
                 bool is_lines, Table& table) {
  if (options.min_component > 0)
    table.add(
        {"pieces dropped", fmt::format("{} with {} {}", format_count(components),
                                       format_count(cells), is_lines ? "lines" : "triangles")});
}

void warn_of_coordinates(Session& session, const RegularGrid& grid) {
  constexpr double kMany = 1.0 / 64;
  const double steps = coordinate_step(grid);
  if (steps > kMany)
    session.warn(fmt::format(
        "coordinates are {:.2g} of a step of the grid apart where the data lie: vertices may be at "
        "one place, and triangles meet",
        steps));
}

namespace {

/// Why there are no cells that a surface could meet; null where there are some.
const char* why_no_cells(const DatasetInfo& info) {
  std::uint64_t n_cells = 1;
  int n_thin = 0;
  for (const std::int32_t n : info.volume.grid.dims.v) {
    n_thin += n == 1 ? 1 : 0;
    n_cells *= static_cast<std::uint64_t>(std::max(1, n - 1));
  }
  if (n_thin > 1) return "data of one sample along two axes have no cells";
  if (info.range_min == info.range_max) return "the field has one value";
  if (info.n_removed_cells >= n_cells) return "each cell has a hole at one of its corners";
  return nullptr;
}

}  // namespace

void warn_of_unmet(Session& session, const ExtractReport& report, const ExtractOptions& options,
                   const DatasetInfo& info) {
  const bool is_cropped = options.clip || options.min_component > 0;
  const bool is_all_holes =
      info.n_holes == static_cast<std::uint64_t>(info.volume.grid.n_samples());
  const bool is_flat =
      std::ranges::find(info.volume.grid.dims.v, 1) != info.volume.grid.dims.v.end();
  const char* const no_cells = why_no_cells(info);
  for (const double isovalue : report.unmet) {
    if (is_all_holes) {
      session.warn(fmt::format("no surface at isovalue {}: the field has no finite sample{}",
                               isovalue, info.volume.nodata ? " but nodata" : ""));
      continue;
    }
    // A sample that is the isovalue counts as above it.
    const bool is_in_range = info.range_min < isovalue && isovalue <= info.range_max;
    const bool is_coarse = options.max_error != 0.0 || options.max_distance.has_value();
    const char* why = isovalue == info.range_min ? "no value is below it" : "it meets nothing";
    const bool is_kept = report.topology.has_value();
    if (is_kept && is_in_range && report.topology->persistence > 0)
      why = "it meets nothing that persists as --keep-topology asks";
    else if (is_in_range && is_cropped)
      why = "nothing of it is left by --clip and --min-component";
    else if (is_in_range && is_coarse && !is_kept && is_flat)
      why = "nothing of it is left within the tolerance: a smaller one keeps it";
    else if (is_in_range && is_coarse && !is_kept)
      why =
          "nothing of it is left within the tolerance: a smaller one, or --keep-topology, keeps it";
    if (no_cells != nullptr) why = no_cells;
    session.warn(fmt::format("no surface at isovalue {}: {} (values run from {} to {})", isovalue,
                             why, info.range_min, info.range_max));
  }
}

}  // namespace lode::cli

#include "query_options.h"

#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "parse.h"
#include "tolerance.h"
#include "warp_options.h"

namespace lode::cli {
namespace {

/// The two halves of A:B.
Result<std::array<std::string, 2>> split_pair(std::string_view option, const std::string& text,
                                              std::string_view form) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos || text.find(':', colon + 1) != std::string::npos)
    return fail("{}: expected {}, got '{}'", option, form, text);
  return std::array{text.substr(0, colon), text.substr(colon + 1)};
}

Result<Box3d> parse_box(const std::string& text) {
  LODE_TRY(const std::vector<double> n, parse_numbers("--box", text));
  if (n.size() != 6)
    return fail("--box: expected six numbers as X0,X1,Y0,Y1,Z0,Z1, got '{}'", text);
  if (n[0] > n[1] || n[2] > n[3] || n[4] > n[5])
    return fail("--box: expected X0 <= X1, Y0 <= Y1 and Z0 <= Z1, got '{}'", text);
  return Box3d{{{n[0], n[2], n[4]}}, {{n[1], n[3], n[5]}}};
}

Result<Ball> parse_ball(const std::string& text) {
  LODE_TRY(const std::vector<double> n, parse_numbers("--ball", text));
  if (n.size() != 4) return fail("--ball: expected four numbers as X,Y,Z,R, got '{}'", text);
  if (n[3] < 0) return fail("--ball: expected a radius >= 0, got '{}'", text);
  return Ball{{{n[0], n[1], n[2]}}, n[3]};
}

Result<SectionPlane> parse_plane_of(const char* option, const std::string& text) {
  LODE_TRY(const auto parts, split_pair(option, text, "a point and a normal as X,Y,Z:NX,NY,NZ"));
  SectionPlane plane;
  LODE_TRY(plane.point, parse_vector(option, parts[0]));
  LODE_TRY(plane.normal, parse_vector(option, parts[1]));
  if (!(length(plane.normal) > 0) || !std::isfinite(length(plane.normal)))
    return fail("{}: expected a normal whose length is a number above 0, got '{}'", option, text);
  return plane;
}

/// A point and a normal as elsewhere, or A,B,C,D: where A x + B y + C z = D.
Result<SectionPlane> parse_section(const std::string& text) {
  if (text.find(':') != std::string::npos) return parse_plane_of("--section", text);
  LODE_TRY(const auto n, parse_numbers("--section", text));
  if (n.size() != 4)
    return fail("--section: expected a plane as A,B,C,D or X,Y,Z:NX,NY,NZ, got '{}'", text);
  SectionPlane plane{{}, {{n[0], n[1], n[2]}}};
  plane.point = plane.normal * (n[3] / dot(plane.normal, plane.normal));
  for (const double number : plane.point.v)
    if (!std::isfinite(number)) return fail("--section: expected a normal, got '{}'", text);
  return plane;
}

Result<Budget> parse_budget(const std::string& text) {
  if (text.empty()) return Budget{};
  LODE_TRY(const std::int64_t n,
           parse_integer("--max-cells", text, 1, static_cast<std::int64_t>(kMaxMeshCells)));
  return Budget{static_cast<std::uint64_t>(n)};
}

Result<std::vector<Range>> parse_field_ranges(const std::vector<std::string>& texts) {
  std::vector<Range> ranges;
  for (const std::string& text : texts) {
    LODE_TRY(const Range range, parse_range("--field-range", text));
    ranges.push_back(range);
  }
  return ranges;
}

/// Boxes, balls, half-spaces and budget, which meshes and surfaces share.
Result<void> add_foci(const QueryArguments& arguments, Query& query) {
  LODE_TRY(query.boxes, parse_boxes(arguments.boxes));
  for (const std::string& text : arguments.balls) {
    LODE_TRY(const Ball ball, parse_ball(text));
    query.balls.push_back(ball);
  }
  for (const std::string& text : arguments.half_spaces) {
    LODE_TRY(const SectionPlane plane, parse_plane_of("--half-space", text));
    query.half_spaces.push_back({plane.point, plane.normal});
  }
  LODE_TRY(query.budget, parse_budget(arguments.max_cells));
  return {};
}

Result<std::optional<double>> parse_limit(const char* option, const std::string& text) {
  if (text.empty()) return std::optional<double>{};
  LODE_TRY(const double limit, parse_number(option, text));
  if (limit < 0) return fail("{}: expected a number >= 0, got '{}'", option, text);
  return std::optional{limit};
}

/// Refuses options of surfaces, which would silently do nothing.
Result<void> check_surface_options(const ExtractionArguments& extraction, const char* answer) {
  for (const auto& [name, is_set] : {std::pair{"--clip", !extraction.clip.empty()},
                                     {"--close-border", extraction.close_border},
                                     {"--flip", extraction.flip},
                                     {"--min-component", !extraction.min_component.empty()},
                                     {"--style", extraction.style != "tetra"},
                                     {"--keep-topology", !extraction.keep_topology.empty()},
                                     {"--normals", extraction.normals != "on"}})
    if (is_set) return fail("{}: expected no {} with it, which has no such option", name, answer);
  return {};
}

}  // namespace

Result<std::vector<Box3d>> parse_boxes(const std::vector<std::string>& texts) {
  std::vector<Box3d> boxes;
  for (const std::string& text : texts) {
    LODE_TRY(const Box3d box, parse_box(text));
    boxes.push_back(box);
  }
  return boxes;
}

Result<Range> parse_range(const char* option, const std::string& text) {
  LODE_TRY(const auto ends, split_pair(option, text, "two numbers as A:B"));
  LODE_TRY(const double low, parse_number(option, ends[0]));
  LODE_TRY(const double high, parse_number(option, ends[1]));
  if (low > high) return fail("{}: expected A <= B, got '{}'", option, text);
  return Range{low, high};
}

void add_focus_options(CLI::App& app, QueryArguments& arguments) {
  const char* group = "Meshes and sections";
  const auto add = [&](const char* name, auto& value, const char* type, const char* help) {
    app.add_option(name, value, help)->type_name(type)->allow_extra_args(false)->group(group);
  };
  add("--threshold", arguments.threshold, "A:B",
      "Of a mesh of cells, in a picture, with --mesh or --boundary: only cells whose values lie "
      "from A to B at all corners; without another focus accurate where the field may be in it");
  add("--region", arguments.regions, "NAME",
      "Only cells of a region (block, material, zone) of a mesh of cells, by its name or number "
      "(info lists them), and accurate in these alone: --max-cells counts the whole mesh, most of "
      "it spent there; may be repeated");
  add("--field-range", arguments.field_ranges, "A:B",
      "Accurate where the field may be from A to B; may be repeated");
  group = "Focus and budget";
  add("--box", arguments.boxes, "X0,X1,Y0,Y1,Z0,Z1",
      "Accurate in a box (of terrain X0,X1,Y0,Y1); may be repeated (crops nothing)");
  add("--ball", arguments.balls, "X,Y,Z,R", "Accurate in a ball; may be repeated");
  add("--half-space", arguments.half_spaces, "X,Y,Z:NX,NY,NZ",
      "Accurate on the side of a plane that its normal points to; may be repeated");
  add("--view", arguments.view, "CAMERA.json",
      "Accurate where a camera sees it (as render --save-camera writes them; of a picture of a "
      "mesh of cells its --camera unless it is deformed)");
  add("--view-size", arguments.view_size, "WxH",
      "Pixels of the view (default: 1920x1080, or the picture's)");
  add("--max-space-error", arguments.max_space_error, "D",
      "Tolerance in space, of a mesh of cells built with --space-errors: how far from its place a "
      "value may be, world units, by an estimate; without --max-error values may be off by any");
  add("--max-error-outside", arguments.max_error_outside, "E",
      "Tolerance outside the focus, in the unit of the other, or of terrain's heights, or with % "
      "of "
      "the range of values; with --opacity of errors as they are, however clear it "
      "is there (default: any)");
  add("--max-cells", arguments.max_cells, "N",
      "At most N simplices, before cells are cut by --clip or where the data end; of a volume's "
      "--mesh N cells as they are written; without --max-error, as accurate as they allow");
  add("--deadline-ms", arguments.deadline_ms, "T",
      "The best answer that is ready T milliseconds after the file is open; of a picture its mesh, "
      "which is drawn after that, of a moving camera each frame's");
}

void add_query_options(CLI::App& app, QueryArguments& arguments) {
  const char* group = "Meshes and sections";
  const auto add = [&](const char* name, auto& value, const char* type, const char* help) {
    app.add_option(name, value, help)->type_name(type)->allow_extra_args(false)->group(group);
  };
  app.add_flag("--mesh", arguments.is_mesh,
               "Write the tetrahedra (triangles of 2D data) with values and errors, as .vtu, .vtk, "
               ".msh (Gmsh) or .e, .exo, .ex2 (Exodus II)")
      ->group(group);
  app.add_flag("--boundary", arguments.is_boundary,
               "Write the outer faces of a mesh of cells: triangles with values and errors")
      ->group(group);
  add("--section", arguments.sections, "X,Y,Z:NX,NY,NZ",
      "Write the plane through a point, by its normal, or A,B,C,D: where A x + B y + C z = D; "
      "triangles with values and errors, or with --isovalue the lines on it; may be repeated of a "
      "mesh of cells. With --mesh: accurate along planes");
  add("--opacity", arguments.opacity, "PRESET|FILE",
      "With --mesh or --boundary of a mesh of cells: accurate as far as render's --opacity shows "
      "it; errors count as much as the extinction is of the largest");
  add_warp_options(app, arguments.warp);
  add("--patch", arguments.patches, "NAME",
      "With --boundary of a mesh of cells: only faces of a patch, by its name or number (info "
      "lists "
      "them); may be repeated");
  add_focus_options(app, arguments);
  group = "Focus and budget";
  add("--max-error-px", arguments.max_error_px, "P",
      "Tolerance in pixels of the view, by an estimate of distances, which meshes of cells have "
      "that are built with --space-errors; of terrain a bound, of vertical errors");
}

Result<View> to_view(const QueryArguments& arguments) {
  View view;
  if (arguments.view_size.empty()) return view;
  LODE_TRY(const auto size, parse_dims("--view-size", arguments.view_size, 16384));
  if (size.size() != 2)
    return fail("--view-size: expected width and height as 1920x1080, got '{}'",
                arguments.view_size);
  view.width = static_cast<int>(size[0]);
  view.height = static_cast<int>(size[1]);
  return view;
}

Result<View> read_view(const QueryArguments& arguments) {
  LODE_TRY(View view, to_view(arguments));
  LODE_TRY(view.camera, read_camera(arguments.view));
  return view;
}

Result<std::optional<double>> to_deadline(const QueryArguments& arguments) {
  LODE_TRY(const auto deadline_ms, parse_limit("--deadline-ms", arguments.deadline_ms));
  return deadline_ms ? std::optional(*deadline_ms / 1000) : std::nullopt;
}

Result<void> add_space_tolerances(const QueryArguments& arguments, Query& query) {
  if (!arguments.max_error_px.empty() && !query.view)
    return fail(
        "--max-error-px: expected --view with it, or of a picture --camera or --camera-path, which "
        "says how large pixels are");
  LODE_TRY(query.max_error_px, parse_limit("--max-error-px", arguments.max_error_px));
  LODE_TRY(query.max_world_error, parse_limit("--max-space-error", arguments.max_space_error));
  const bool is_in_space = !query.max_error && (query.max_error_px || query.max_world_error);
  if (is_in_space && arguments.max_error_outside.ends_with('%'))
    return fail("--max-error-outside: expected a number in the unit of {}, got {}",
                query.max_world_error ? "--max-space-error" : "--max-error-px",
                arguments.max_error_outside);
  return {};
}

Result<void> check_unused(const QueryArguments& arguments, bool is_of_cells) {
  if (arguments.is_boundary && arguments.is_mesh)
    return fail("--boundary: expected no --mesh with it, got both");
  if (arguments.is_boundary && !arguments.sections.empty())
    return fail("--boundary: expected no --section with it, got both");
  if (!arguments.threshold.empty() && !arguments.is_mesh && !arguments.is_boundary)
    return fail("--threshold: expected --mesh or --boundary with it, got neither");
  if (!arguments.opacity.empty() && !arguments.is_mesh && !arguments.is_boundary)
    return fail("--opacity: expected --mesh or --boundary with it, got neither");
  if (!is_of_cells && !arguments.max_space_error.empty())
    return fail(
        "--max-space-error: expected a mesh of cells with it; of a volume's surface --max-distance "
        "is a bound");
  LODE_CHECK(check_view_size(arguments));
  if (arguments.is_wanted()) {
    if (is_of_cells) return {};
    for (const auto& [name, is_set] : {std::pair{"--view", !arguments.view.empty()},
                                       {"--max-error-px", !arguments.max_error_px.empty()},
                                       {"--deadline-ms", !arguments.deadline_ms.empty()}})
      if (is_set) return fail("{}: expected no --mesh or --section with it", name);
    return {};
  }
  if (!arguments.field_ranges.empty())
    return fail("--field-range: expected --mesh or --section with it");
  return {};
}

Result<Query> to_query(const QueryArguments& arguments, const ExtractionArguments& extraction,
                       const char* answer) {
  LODE_CHECK(check_surface_options(extraction, answer));
  LODE_TRY(const ExtractOptions surface, to_extract_options(extraction));
  Query query;
  query.isovalues = surface.isovalues;
  query.max_error = surface.max_error;
  LODE_TRY(query.field_ranges, parse_field_ranges(arguments.field_ranges));
  LODE_CHECK(add_foci(arguments, query));
  if (!arguments.max_error_outside.empty()) {
    LODE_TRY(query.max_error_outside,
             parse_tolerance("--max-error-outside", arguments.max_error_outside));
  }
  return query;
}

Result<void> check_outside(const Query& query) {
  const bool has_values =
      !query.isovalues.empty() || !query.field_ranges.empty() || !query.opacity.empty();
  const bool has_places = !query.boxes.empty() || !query.balls.empty() ||
                          !query.half_spaces.empty() || !query.sections.empty() || query.view;
  if (!query.max_error_outside || has_values || has_places) return {};
  return fail(
      "--max-error-outside: expected a focus with it, such as --isovalue, --field-range, --box, "
      "--ball, --half-space, --section or --view, outside of which it holds");
}

void warn_of_boxes(const std::vector<Box3d>& boxes, const Box3d& bounds, Session& session,
                   const char* when) {
  const auto to_text = [](const Box3d& box) {
    return fmt::format("{},{},{},{},{},{}", box.lower[0], box.upper[0], box.lower[1], box.upper[1],
                       box.lower[2], box.upper[2]);
  };
  for (const Box3d& box : boxes) {
    bool is_beside = false;
    for (std::size_t i = 0; i < 3; ++i)
      is_beside = is_beside || box.upper[i] < bounds.lower[i] || box.lower[i] > bounds.upper[i];
    if (is_beside)
      session.warn(fmt::format("--box {}: none of the data are in it, but in {}{}", to_text(box),
                               to_text(bounds), when));
  }
}

Result<void> check_view_size(const QueryArguments& arguments) {
  if (arguments.view_size.empty() || !arguments.view.empty()) return {};
  return fail("--view-size: expected --view with it");
}

Result<MeshOptions> to_mesh_options(const QueryArguments& arguments,
                                    const ExtractionArguments& extraction) {
  LODE_TRY(Query query, to_query(arguments, extraction, "--mesh"));
  LODE_CHECK(add_section_foci(arguments, query));
  LODE_CHECK(check_outside(query));
  return MeshOptions{query};
}

Result<SectionOptions> to_section_options(const QueryArguments& arguments,
                                          const ExtractionArguments& extraction) {
  LODE_CHECK(check_surface_options(extraction, "--section"));
  // Regions are joined: the plane would be as fine outside them.
  for (const auto& [name, is_set] : {std::pair{"--box", !arguments.boxes.empty()},
                                     {"--ball", !arguments.balls.empty()},
                                     {"--half-space", !arguments.half_spaces.empty()},
                                     {"--max-error-outside", !arguments.max_error_outside.empty()}})
    if (is_set) return fail("{}: expected no --section with it, only --mesh", name);
  LODE_TRY(const ExtractOptions surface, to_extract_options(extraction));
  SectionOptions options;
  LODE_TRY(const std::vector<SectionPlane> planes, to_planes(arguments));
  options.plane = planes.at(0);
  options.isovalues = surface.isovalues;
  options.max_error = surface.max_error;
  LODE_TRY(options.field_ranges, parse_field_ranges(arguments.field_ranges));
  if (!options.isovalues.empty() && !options.field_ranges.empty())
    return fail("--field-range: expected no --isovalue with --section, whose lines need no other");
  LODE_TRY(options.budget, parse_budget(arguments.max_cells));
  return options;
}

Result<void> add_section_foci(const QueryArguments& arguments, Query& query) {
  LODE_TRY(const std::vector<SectionPlane> planes, to_planes(arguments));
  for (const SectionPlane& plane : planes) query.sections.push_back({plane.point, plane.normal});
  return {};
}

Result<std::vector<SectionPlane>> to_planes(const QueryArguments& arguments) {
  std::vector<SectionPlane> planes;
  for (const std::string& text : arguments.sections) {
    LODE_TRY(const SectionPlane plane, parse_section(text));
    planes.push_back(plane);
  }
  return planes;
}

Result<std::optional<Range>> to_threshold(const QueryArguments& arguments) {
  if (arguments.threshold.empty()) return std::optional<Range>{};
  LODE_TRY(const Range range, parse_range("--threshold", arguments.threshold));
  return std::optional{range};
}

Result<FocusedOptions> to_focused_options(const QueryArguments& arguments,
                                          const ExtractionArguments& extraction) {
  LODE_TRY(const ExtractOptions surface, to_extract_options(extraction));
  if (surface.isovalues.size() != 1)
    return fail("--isovalue: expected one with a focus, budget or deadline, got {}",
                surface.isovalues.size());
  if (extraction.close_border)
    return fail("--close-border: expected no focus, budget or deadline with it");
  if (surface.style != SurfaceStyle::tetra)
    return fail("--style cubes: expected no focus, budget or deadline with it");
  if (surface.keep_topology)
    return fail("--keep-topology: expected no focus, budget or deadline with it");
  FocusedOptions options;
  options.clip = surface.clip;
  options.min_component = surface.min_component;
  options.orientation = surface.orientation;
  options.normals = surface.normals;
  Query& query = options.query;
  query.isovalues = surface.isovalues;
  query.max_error = surface.max_error;
  LODE_CHECK(add_foci(arguments, query));
  LODE_TRY(query.max_error_px, parse_limit("--max-error-px", arguments.max_error_px));
  if (!arguments.max_error_outside.empty()) {
    LODE_TRY(query.max_error_outside,
             parse_tolerance("--max-error-outside", arguments.max_error_outside));
    if (!query.max_error && query.max_error_px && is_share(arguments.max_error_outside))
      return fail("--max-error-outside: expected pixels as --max-error-px, got '{}'",
                  arguments.max_error_outside);
  }
  if (query.max_error_px && arguments.view.empty())
    return fail("--max-error-px: expected --view with it, which says how large pixels are");
  if (query.max_error_outside && arguments.view.empty() && query.boxes.empty() &&
      query.balls.empty() && query.half_spaces.empty())
    return fail("--max-error-outside: expected --box, --ball, --half-space or --view with it");
  LODE_TRY(options.deadline_s, to_deadline(arguments));
  return options;
}

}  // namespace lode::cli

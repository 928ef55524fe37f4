#include "query_options.h"

#include <array>
#include <cmath>
#include <utility>

#include "parse.h"

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

Result<Range> parse_field_range(const std::string& text) {
  LODE_TRY(const auto ends, split_pair("--field-range", text, "two numbers as A:B"));
  LODE_TRY(const double low, parse_number("--field-range", ends[0]));
  LODE_TRY(const double high, parse_number("--field-range", ends[1]));
  if (low > high) return fail("--field-range: expected A <= B, got '{}'", text);
  return Range{low, high};
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

Result<SectionPlane> parse_section(const std::string& text) {
  LODE_TRY(const auto parts,
           split_pair("--section", text, "a point and a normal as X,Y,Z:NX,NY,NZ"));
  SectionPlane plane;
  LODE_TRY(plane.point, parse_vector("--section", parts[0]));
  LODE_TRY(plane.normal, parse_vector("--section", parts[1]));
  if (!(length(plane.normal) > 0) || !std::isfinite(length(plane.normal)))
    return fail("--section: expected a normal whose length is a number above 0, got '{}'", text);
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
    LODE_TRY(const Range range, parse_field_range(text));
    ranges.push_back(range);
  }
  return ranges;
}

/// Refuses options of surfaces, which would silently do nothing.
Result<void> check_surface_options(const ExtractionArguments& extraction, const char* answer) {
  for (const auto& [name, is_set] : {std::pair{"--clip", !extraction.clip.empty()},
                                     {"--close-border", extraction.close_border},
                                     {"--flip", extraction.flip},
                                     {"--min-component", !extraction.min_component.empty()},
                                     {"--normals", extraction.normals != "on"}})
    if (is_set) return fail("{}: expected no {} with it, which is no isosurface", name, answer);
  return {};
}

}  // namespace

void add_query_options(CLI::App& app, QueryArguments& arguments) {
  const char* group = "Meshes and sections";
  const auto add = [&](const char* name, auto& value, const char* type, const char* help) {
    app.add_option(name, value, help)->type_name(type)->allow_extra_args(false)->group(group);
  };
  app.add_flag("--mesh", arguments.is_mesh,
               "Write the tetrahedra (triangles of 2D data) with values and errors, as .vtu")
      ->group(group);
  add("--section", arguments.section, "X,Y,Z:NX,NY,NZ",
      "Write the plane through a point, by its normal: triangles with values and errors, or with "
      "--isovalue the lines on it");
  add("--field-range", arguments.field_ranges, "A:B",
      "Accurate where the field may be from A to B; may be repeated");
  add("--box", arguments.boxes, "X0,X1,Y0,Y1,Z0,Z1",
      "Mesh accurate in a box; may be repeated (crops nothing)");
  add("--ball", arguments.balls, "X,Y,Z,R", "Mesh accurate in a ball; may be repeated");
  add("--max-error-outside", arguments.max_error_outside, "E",
      "Tolerance of a mesh outside --isovalue, --field-range, --box and --ball (default: any)");
  add("--max-cells", arguments.max_cells, "N",
      "At most N simplices before clipping; without --max-error, as accurate as they allow");
}

Result<void> check_unused(const QueryArguments& arguments) {
  for (const auto& [name, is_set] : {std::pair{"--field-range", !arguments.field_ranges.empty()},
                                     {"--box", !arguments.boxes.empty()},
                                     {"--ball", !arguments.balls.empty()},
                                     {"--max-error-outside", !arguments.max_error_outside.empty()},
                                     {"--max-cells", !arguments.max_cells.empty()}})
    if (is_set) return fail("{}: expected --mesh or --section with it", name);
  return {};
}

Result<MeshOptions> to_mesh_options(const QueryArguments& arguments,
                                    const ExtractionArguments& extraction) {
  if (!arguments.section.empty()) return fail("--mesh: expected no --section with it");
  LODE_CHECK(check_surface_options(extraction, "--mesh"));
  LODE_TRY(const ExtractOptions surface, to_extract_options(extraction));
  Query query;
  query.isovalues = surface.isovalues;
  query.max_error = surface.max_error;
  LODE_TRY(query.field_ranges, parse_field_ranges(arguments.field_ranges));
  for (const std::string& text : arguments.boxes) {
    LODE_TRY(const Box3d box, parse_box(text));
    query.boxes.push_back(box);
  }
  for (const std::string& text : arguments.balls) {
    LODE_TRY(const Ball ball, parse_ball(text));
    query.balls.push_back(ball);
  }
  LODE_TRY(query.budget, parse_budget(arguments.max_cells));
  if (arguments.max_error_outside.empty()) return MeshOptions{query};
  LODE_TRY(const double outside, parse_number("--max-error-outside", arguments.max_error_outside));
  if (outside < 0)
    return fail("--max-error-outside: expected a number >= 0, got '{}'",
                arguments.max_error_outside);
  if (query.isovalues.empty() && query.field_ranges.empty() && query.boxes.empty() &&
      query.balls.empty())
    return fail("--max-error-outside: expected --isovalue, --field-range, --box or --ball with it");
  query.max_error_outside = outside;
  return MeshOptions{query};
}

Result<SectionOptions> to_section_options(const QueryArguments& arguments,
                                          const ExtractionArguments& extraction) {
  LODE_CHECK(check_surface_options(extraction, "--section"));
  // Regions are joined: the plane would be as fine outside them.
  for (const auto& [name, is_set] : {std::pair{"--box", !arguments.boxes.empty()},
                                     {"--ball", !arguments.balls.empty()},
                                     {"--max-error-outside", !arguments.max_error_outside.empty()}})
    if (is_set) return fail("{}: expected no --section with it, only --mesh", name);
  LODE_TRY(const ExtractOptions surface, to_extract_options(extraction));
  SectionOptions options;
  LODE_TRY(options.plane, parse_section(arguments.section));
  options.isovalues = surface.isovalues;
  options.max_error = surface.max_error;
  LODE_TRY(options.field_ranges, parse_field_ranges(arguments.field_ranges));
  if (!options.isovalues.empty() && !options.field_ranges.empty())
    return fail("--field-range: expected no --isovalue with --section, whose lines need no other");
  LODE_TRY(options.budget, parse_budget(arguments.max_cells));
  return options;
}

}  // namespace lode::cli

#include "warp_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>
#include <utility>

#include "lode/api/warp.h"
#include "parse.h"

namespace lode::cli {
namespace {

Result<double> scale_of(const WarpArguments& arguments) {
  if (arguments.scale.empty()) return 1;
  return parse_number("--scale", arguments.scale);
}

/// The vector's components as they are asked for: three names, or NAME, which may end in :xyz.
Result<std::vector<std::string>> components_of(const WarpArguments& arguments) {
  const std::string& text = arguments.field;
  if (text.find(',') == std::string::npos) {
    const bool is_scalar = text.size() > 2 && text[text.size() - 2] == ':' &&
                           std::string_view("xyz012").find(text.back()) != std::string_view::npos;
    if (is_scalar)
      return fail("--warp: expected a vector, or three scalars as X,Y,Z, got '{}'", text);
    return std::vector<std::string>{text.ends_with(kVectorEnd) ? text
                                                               : text + std::string(kVectorEnd)};
  }
  std::vector<std::string> names;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    names.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  const bool has_empty = std::ranges::any_of(names, &std::string::empty);
  if (names.size() == 3 && !has_empty) return names;
  return fail("--warp: expected a vector, or three scalars as X,Y,Z, got '{}'", text);
}

using Values = std::array<std::span<const double>, 3>;

/// What a vertex goes by, and how far that may be off.
struct Vector {
  Values values;
  double error = 0;
};

/// The vector's values, and its error.
Vector vector_in(const TetraInput& input, const std::vector<Attribute>& attributes,
                 std::span<const double> measured, double largest_error) {
  Vector vector;
  double squares = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t place = input.warp->vector[i];
    double error = largest_error;
    if (place == input.fields.measured) {
      vector.values[i] = measured;
    } else {
      const std::string& name = input.dataset.describe().fields[place].name;
      const auto found = std::ranges::find(attributes, name, &Attribute::name);
      LODE_EXPECTS(found != attributes.end());
      vector.values[i] = found->values;
      error = found->error;
    }
    squares += error * error;
  }
  vector.error = std::sqrt(squares);
  return vector;
}

void drop_hidden(const TetraInput& input, std::vector<Attribute>& attributes) {
  for (const std::size_t place : input.warp->hidden) {
    const std::string& name = input.dataset.describe().fields[place].name;
    std::erase_if(attributes, [&](const Attribute& attribute) { return attribute.name == name; });
  }
}

Error too_far(const WarpArguments& arguments, const char* type) {
  return fail("--warp {}: expected vertices at {} coordinates, got others: a smaller --scale",
              arguments.field, type);
}

}  // namespace

void add_warp_options(CLI::App& app, WarpArguments& arguments) {
  app.add_option(
         "--warp", arguments.field,
         "Deform a mesh of cells by a vector, or by three scalars X,Y,Z; its .lode file must have "
         "been built --with NAME:xyz, or with these. Foci and sections are of the mesh before, "
         "--clip crops what is deformed; how far the deformation itself may be off is told")
      ->type_name("NAME")
      ->group("Meshes of cells");
  app.add_option("--scale", arguments.scale, "With --warp: times this (default: 1)")
      ->type_name("S")
      ->group("Meshes of cells");
}

Result<void> check_warp(const QueryArguments& query) {
  const WarpArguments& arguments = query.warp;
  if (!arguments.scale.empty() && arguments.field.empty())
    return fail("--scale: expected --warp with it, got none");
  if (arguments.is_wanted()) LODE_CHECK(components_of(arguments));
  LODE_CHECK(scale_of(arguments));
  // Where cells are that are deformed the hierarchy does not know, nor how large they appear.
  for (const auto& [name, value] :
       {std::pair{"--view", &query.view}, {"--max-error-px", &query.max_error_px}})
    if (arguments.is_wanted() && !value->empty())
      return fail(
          "{}: expected no --warp with it: what a camera sees of a deformed mesh is not "
          "known before it is extracted",
          name);
  return {};
}

ReadingArguments with_warp(ReadingArguments reading, const WarpArguments& arguments) {
  if (!arguments.is_wanted()) return reading;
  if (auto components = components_of(arguments)) reading.deforming = std::move(*components);
  return reading;
}

std::string Warped::text() const {
  return fmt::format("{}{}{}", field, scale == 1 ? "" : fmt::format(", {} times", scale),
                     error > 0 ? fmt::format("; itself off by up to {} at samples",
                                             format_number(error * std::abs(scale)))
                               : "");
}

Result<std::optional<Warped>> apply_warp(const WarpArguments& arguments, const TetraInput& input,
                                         double largest_error, Threads threads, SimplexMesh& mesh) {
  if (!input.warp) return std::optional<Warped>();
  LODE_TRY(const double scale, scale_of(arguments));
  const Vector vector = vector_in(input, mesh.attributes, mesh.values, largest_error);
  Warped warped{arguments.field, scale, vector.error};
  warped.n_inverted = warp(mesh, vector.values, scale, threads);
  for (const Vec3d& p : mesh.positions)
    if (!std::ranges::all_of(p.v, [](double x) { return std::isfinite(x); }))
      return too_far(arguments, "float64");
  drop_hidden(input, mesh.attributes);
  return std::optional(std::move(warped));
}

Result<std::optional<Warped>> apply_warp(const WarpArguments& arguments, const TetraInput& input,
                                         double largest_error, std::span<const double> isovalues,
                                         Surface& surface) {
  if (!input.warp) return std::optional<Warped>();
  LODE_TRY(const double scale, scale_of(arguments));
  std::vector<double> measured = surface.values;
  if (measured.empty()) measured = surface.isovalues;
  if (measured.empty() && isovalues.size() == 1)
    measured.assign(surface.positions.size(), isovalues.front());
  LODE_EXPECTS(measured.size() == surface.positions.size());
  const Vector vector = vector_in(input, surface.attributes, measured, largest_error);
  warp(surface, vector.values, scale);
  for (const Vec3f& p : surface.positions)
    for (const float x : p.v)
      if (!std::isfinite(x)) return too_far(arguments, "float32");
  drop_hidden(input, surface.attributes);
  return std::optional(Warped{arguments.field, scale, vector.error});
}

void add_warp(const std::optional<Warped>& warped, Table& table, Json& json) {
  if (!warped) return;
  table.add({"deformed by", warped->text()});
  json["warp"] = {{"field", warped->field},
                  {"scale", warped->scale},
                  {"error", warped->error * std::abs(warped->scale)}};
}

std::string warp_comment(const std::optional<Warped>& warped) {
  return warped ? "; deformed by " + warped->text() : std::string();
}

std::string inverted_warning(std::uint64_t n_inverted) {
  return n_inverted == 0 ? std::string()
                         : fmt::format("--warp: {} cells are flat or turned round", n_inverted);
}

void warn_of_inverted(Session& session, std::uint64_t n_inverted) {
  if (n_inverted > 0) session.warn(inverted_warning(n_inverted));
}

}  // namespace lode::cli

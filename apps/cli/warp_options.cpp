#include "warp_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "parse.h"

namespace lode::cli {
namespace {

std::string component_of(const WarpArguments& arguments, std::size_t axis) {
  return arguments.field + ":" + std::to_string(axis);
}

Result<double> scale_of(const WarpArguments& arguments) {
  if (arguments.scale.empty()) return 1;
  return parse_number("--scale", arguments.scale);
}

/// The vector's values, where they are.
Result<std::array<std::span<const double>, 3>> vector_in(const WarpArguments& arguments,
                                                         const std::vector<Attribute>& attributes,
                                                         const std::string& first,
                                                         std::span<const double> values) {
  std::array<std::span<const double>, 3> vector;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string name = component_of(arguments, i);
    const auto found = std::ranges::find(attributes, name, &Attribute::name);
    if (found != attributes.end())
      vector[i] = found->values;
    else if (name == first)
      vector[i] = values;
    else
      return fail("--warp: expected the field {}, got none", name);
  }
  return vector;
}

/// Those that nobody has asked for.
void drop_unwanted(const WarpArguments& arguments, const ReadingArguments& reading,
                   std::vector<Attribute>& attributes) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string name = component_of(arguments, i);
    const std::string by_letter = arguments.field + ":" + "xyz"[i];
    const std::string whole = arguments.field + ":xyz";
    const auto is_named = [&](const std::string& word) {
      return std::ranges::find(reading.with, word) != reading.with.end();
    };
    if (is_named(name) || is_named(by_letter) || is_named(whole)) continue;
    std::erase_if(attributes, [&](const Attribute& attribute) { return attribute.name == name; });
  }
}

}  // namespace

void add_warp_options(CLI::App& app, WarpArguments& arguments) {
  app.add_option(
         "--warp", arguments.field,
         "Deform a mesh of cells by a vector; its .lode file must have been built --with "
         "NAME:x, NAME:y and NAME:z, or --with NAME:xyz. Sections are cut before, --clip crops "
         "what is deformed; how far the deformation itself may be off, --with NAME:xyz tells")
      ->type_name("NAME")
      ->group("Meshes of cells");
  app.add_option("--scale", arguments.scale, "With --warp: times this (default: 1)")
      ->type_name("S")
      ->group("Meshes of cells");
}

Result<void> check_warp(const WarpArguments& arguments) {
  if (!arguments.scale.empty() && arguments.field.empty())
    return fail("--scale: expected --warp with it, got none");
  LODE_CHECK(scale_of(arguments));
  return {};
}

ReadingArguments with_warp(ReadingArguments reading, const WarpArguments& arguments) {
  for (std::size_t i = 0; i < 3 && arguments.is_wanted(); ++i)
    reading.with.push_back(component_of(arguments, i));
  return reading;
}

Result<std::uint64_t> apply_warp(const WarpArguments& arguments, const ReadingArguments& reading,
                                 Threads threads, SimplexMesh& mesh) {
  if (!arguments.is_wanted()) return std::uint64_t{0};
  LODE_TRY(const double scale, scale_of(arguments));
  LODE_TRY(const auto vector, vector_in(arguments, mesh.attributes, reading.field, mesh.values));
  const std::uint64_t n_inverted = warp(mesh, vector, scale, threads);
  drop_unwanted(arguments, reading, mesh.attributes);
  return n_inverted;
}

std::string inverted_warning(std::uint64_t n_inverted) {
  return n_inverted == 0 ? std::string()
                         : fmt::format("--warp: {} cells are flat or turned round", n_inverted);
}

void warn_of_inverted(Session& session, std::uint64_t n_inverted) {
  if (n_inverted > 0) session.warn(inverted_warning(n_inverted));
}

Result<void> apply_warp(const WarpArguments& arguments, const ReadingArguments& reading,
                        Surface& surface) {
  if (!arguments.is_wanted()) return {};
  LODE_TRY(const double scale, scale_of(arguments));
  LODE_TRY(const auto vector,
           vector_in(arguments, surface.attributes, reading.field, surface.values));
  warp(surface, vector, scale);
  drop_unwanted(arguments, reading, surface.attributes);
  return {};
}

}  // namespace lode::cli

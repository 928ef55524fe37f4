#include "input.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <limits>
#include <system_error>
#include <utility>

#include "describe.h"
#include "parse.h"
#include "salvage.h"
#include "stopwatch.h"
#include "terrain_arguments.h"
#include "vtk_import.h"

namespace lode::cli {
namespace {

constexpr std::int64_t kMaxInt = std::numeric_limits<std::int32_t>::max();

Result<RawLayout> to_raw_layout(const ReadingArguments& arguments) {
  if (arguments.dims.empty() || arguments.type.empty())
    return fail("expected both --dims and --type for a file of bare samples, got {}",
                !arguments.dims.empty()   ? "only --dims"
                : !arguments.type.empty() ? "only --type"
                                          : "only --spacing, --origin or --byte-order");
  RawLayout raw;
  LODE_TRY(const auto dims, parse_dims("--dims", arguments.dims, kMaxInt));
  if (dims.size() != 2 && dims.size() != 3)
    return fail("--dims: expected two or three numbers as 256x256x128, got '{}'", arguments.dims);
  for (std::size_t i = 0; i < 3; ++i)
    raw.dims[i] = i < dims.size() ? static_cast<std::int32_t>(dims[i]) : 1;
  const auto type = scalar_type_from_name(arguments.type);
  if (!type)
    return fail("--type: expected uint8, int16, float32 or the like, got '{}'", arguments.type);
  raw.type = *type;
  if (!arguments.spacing.empty()) {
    LODE_TRY(raw.spacing, parse_vector("--spacing", arguments.spacing));
  }
  if (!arguments.origin.empty()) {
    LODE_TRY(raw.origin, parse_vector("--origin", arguments.origin));
  }
  if (arguments.byte_order == "big") {
    raw.byte_order = ByteOrder::big;
  } else if (!arguments.byte_order.empty() && arguments.byte_order != "little") {
    return fail("--byte-order: expected 'little' or 'big', got '{}'", arguments.byte_order);
  }
  return raw;
}

Result<Dataset> build_in_memory(Session& session, const std::string& path,
                                const ReadOptions& options, const AcceptVolume& accept) {
  LODE_TRY(const auto source, open_foreign_volume(path, options));
  if (accept) LODE_CHECK(accept(source->info()));
  session.note(fmt::format("{}: not a .lode file; building its hierarchy in memory", path));
  return build_opened(path, *source, {.threads = session.threads()}, session.progress());
}

/// One spelling for each existing place, so that links and relative paths compare equal.
std::string canonical_path(const std::string& path) {
  std::error_code status;
  const auto canonical = std::filesystem::weakly_canonical(path, status);
  return status ? path : canonical.string();
}

bool is_same_file(const std::string& a, const std::string& b) {
  std::error_code status;
  return std::filesystem::equivalent(a, b, status) || canonical_path(a) == canonical_path(b);
}

}  // namespace

Result<void> check_is_volume(const std::string& path, const ReadingArguments& reading) {
  if (is_lode_path(path)) return check_lode_opens(path);
  if (is_volume_path(path) || !reading.dims.empty()) return {};
  return fail(
      "{}: expected a volume and --isovalue, a mesh of cells (.vtu, ...), {}, or a .lode file, "
      "got another file",
      path, kTerrainFiles);
}

Error no_isovalue(const std::string& path, const ReadingArguments& reading) {
  if (const auto volume = check_is_volume(path, reading); !volume) return volume.error();
  if (std::error_code status; !std::filesystem::exists(path, status))
    return fail("{}: cannot be opened: No such file or directory", path);
  return fail(
      "--isovalue: expected at least one value, got none: lode info {} shows the range of values, "
      "lode count what surfaces they give, and lode render draws one that it chooses",
      path);
}

Result<void> expect_no_mesh(const std::string& path) {
  if (is_cells_path(path) || (is_lode_path(path) && holds_tetrahedra(path)))
    return fail(
        "{}: expected a regular volume, got a mesh of cells, which this command does not take",
        path);
  return {};
}

Result<std::unique_ptr<VolumeSource>> open_foreign_volume(const std::string& path,
                                                          const ReadOptions& options) {
  LODE_CHECK(expect_no_mesh(path));
  return open_volume(path, options);
}

std::string ReadingArguments::given() const {
  const std::array<std::pair<const char*, bool>, 21> options = {
      {{"--field", !field.empty()},
       {"--with", !with.empty()},
       {"--component", !component.empty()},
       {"--time", !time.empty()},
       {"--nodata", !nodata.empty()},
       {"--dims", !dims.empty()},
       {"--type", !type.empty()},
       {"--spacing", !spacing.empty()},
       {"--origin", !origin.empty()},
       {"--byte-order", !byte_order.empty()},
       {"--length-unit", !length_unit.empty()},
       {"--value-unit", !value_unit.empty()},
       {"--weld", !weld.empty()},
       {"--weld-values", !weld_values.empty()},
       {"--linearise", !linearise.empty()},
       {"--region-field", !region_field.empty()},
       {"--only-region", !only_regions.empty()},
       {"--solution", !solution.empty()},
       {"--placement", !placement.empty()},
       {"--order", !order.empty()},
       {"--fast", is_fast}}};
  std::string names;
  for (const auto& [name, is_given] : options)
    if (is_given) names += fmt::format("{}{}", names.empty() ? "" : ", ", name);
  return names;
}

std::string ReadingArguments::component_number() const {
  if (component == "x") return "0";
  if (component == "y") return "1";
  return component == "z" ? "2" : component;
}

void add_reading_options(CLI::App& app, ReadingArguments& arguments) {
  const auto add = [&app](const char* name, std::string& value, const char* type,
                          const char* help) {
    app.add_option(name, value, help)->type_name(type)->group("Reading other formats");
  };
  add("--field", arguments.field, "NAME",
      "Array to read, where a file holds several; NAME:xyz of a mesh of cells: all three scalars "
      "of a vector");
  app.add_option(
         "--with", arguments.with,
         "Of a mesh of cells: a further field, which the answer has, too; NAME:x, y or z is "
         "a scalar of a vector, NAME:xyz all three, all: every other field of the points, and "
         "measured ones of cells (of a .lode file all it has); may be repeated")
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->group("Reading other formats");
  add("--component", arguments.component, "N|x|y|z|magnitude|mises",
      "Which scalar of a vector, or channel, from 0 (default of meshes of cells: magnitude, which "
      "is of all components as they come); mises: von Mises' of a tensor of six, xx, yy and zz "
      "first, or nine");
  add("--time", arguments.time, "N",
      "Time step, from 0; of a .lode file in order of time, for all fields alike (default: the "
      "first; of what lode-vtk-import reads, and of Gmsh's fields at several times: the last)");
  add("--nodata", arguments.nodata, "V", "Samples with this value are holes");
  add("--dims", arguments.dims, "XxYxZ", "Samples per axis of a raw file");
  add("--type", arguments.type, "TYPE", "uint8, int16, float32, ... of a raw file");
  add("--spacing", arguments.spacing, "X,Y,Z", "Distance of samples in a raw file");
  add("--origin", arguments.origin, "X,Y,Z", "Position of the first sample of a raw file");
  add("--byte-order", arguments.byte_order, "ORDER", "little (default) or big, of a raw file");
  add("--length-unit", arguments.length_unit, "UNIT",
      "Of positions and distances of a volume, in place of what its file says: mm. Reports and "
      "files name it; nothing is converted");
  add("--value-unit", arguments.value_unit, "UNIT", "Of its values, likewise: HU");
  add("--weld", arguments.weld, "DISTANCE",
      "Of a mesh of cells: points that are so close become one (0: those at one place)");
  add("--weld-values", arguments.weld_values, "V",
      "... where all fields differ by no more than this (default: 0); others stay apart");
  add("--linearise", arguments.linearise, "corners",
      "Of a mesh of cells: those of higher order become the linear ones of their corners; else "
      "quadratic ones are split between all of their nodes, as eight tetrahedra of one");
  add("--region-field", arguments.region_field, "NAME",
      "Of a mesh of cells: the field of its cells whose whole numbers are regions (default: the "
      "first of Material, MaterialId, RegionId, BlockId and the like); RegionId: the blocks, with "
      "their names, that lode-vtk-import reads");
  app.add_option("--only-region", arguments.only_regions,
                 "Of a mesh of cells: only the cells of a region, by its number or name, as if the "
                 "file had no others; may be repeated")
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->group("Reading other formats");
  add("--solution", arguments.solution, "FILE",
      "Of a MEDIT mesh: .sol or .solb with values at its vertices (default: that of its name)");
  add("--placement", arguments.placement, "half-edge|midpoint",
      "Of a mesh of cells that is built: where edges collapse to (default: one of their ends)");
  add("--order", arguments.order, "error|space|quadric",
      "Of a mesh of cells that is built: which edges collapse first, those that add least to "
      "errors "
      "(default), to how far from its place a value is, or to a quadric");
  app.add_flag(
         "--fast", arguments.is_fast,
         "Of a mesh of cells that is built: the same as --order quadric, for a preview; errors "
         "are as true, and larger for as many cells")
      ->group("Reading other formats");
}

Result<ReadOptions> to_read_options(const ReadingArguments& arguments, Threads threads) {
  if (!arguments.weld.empty() || !arguments.weld_values.empty() || !arguments.linearise.empty() ||
      !arguments.region_field.empty() || !arguments.only_regions.empty() ||
      !arguments.with.empty() || !arguments.placement.empty() || !arguments.order.empty() ||
      arguments.is_fast || !arguments.solution.empty())
    return fail(
        "--with, --weld, --weld-values, --linearise, --region-field, --only-region, --solution, "
        "--placement, "
        "--order and --fast: "
        "expected a mesh of cells with them");
  ReadOptions options;
  options.threads = threads;
  options.units = {.length = arguments.length_unit, .value = arguments.value_unit};
  if (!arguments.field.empty()) options.field = arguments.field;
  if (arguments.component == "magnitude") {
    options.component = Magnitude{};
  } else if (!arguments.component.empty()) {
    LODE_TRY(const auto n, parse_integer("--component", arguments.component_number(), 0, kMaxInt));
    options.component = static_cast<int>(n);
  }
  if (!arguments.time.empty()) {
    LODE_TRY(const auto step, parse_integer("--time", arguments.time, 0, kMaxInt));
    options.time = static_cast<int>(step);
  }
  if (!arguments.nodata.empty()) {
    LODE_TRY(options.nodata, parse_number("--nodata", arguments.nodata));
  }
  const bool is_raw = !arguments.dims.empty() || !arguments.type.empty() ||
                      !arguments.spacing.empty() || !arguments.origin.empty() ||
                      !arguments.byte_order.empty();
  if (is_raw) {
    LODE_TRY(options.raw, to_raw_layout(arguments));
  }
  return options;
}

Result<void> check_reading_options(const ReadingArguments& arguments, const std::string& path) {
  if (arguments.salvage && !is_lode_path(path))
    return fail("--salvage: expected a .lode file, got {}", path);
  if (is_lode_path(path) && !arguments.is_empty())
    return fail("{}: expected no options of reading with a .lode file, got {}", path,
                arguments.given());
  if (auto options = to_read_options(arguments, {}); !options) return options.error();
  return {};
}

Result<Input> open_input(Session& session, const std::string& path,
                         const ReadingArguments& arguments, const AcceptVolume& accept) {
  const Stopwatch watch;
  LODE_TRY(const ReadOptions options, to_read_options(arguments, session.threads()));
  const bool is_foreign = !is_lode_path(path);
  if (!is_foreign) LODE_CHECK(expect_no_mesh(path));
  auto dataset = is_foreign          ? build_in_memory(session, path, options, accept)
                 : arguments.salvage ? Dataset::salvage(path, session.threads(), session.progress())
                                     : Dataset::open(path, session.threads());
  if (!dataset) return dataset.error();
  if (const auto* const salvaged = dataset->salvaged()) warn_of_damage(session, path, *salvaged);
  DatasetInfo info = dataset->describe();
  if (accept) LODE_CHECK(accept(info.volume));
  return Input{std::move(dataset).value(), std::move(info), watch.seconds(), is_foreign};
}

Result<Input> load_input(Session& session, const std::string& path,
                         const ReadingArguments& arguments, const AcceptVolume& accept) {
  LODE_TRY(Input input, open_input(session, path, arguments, accept));
  const Stopwatch watch;
  LODE_CHECK(input.dataset.load(session.progress()));
  input.open_seconds += watch.seconds();
  return input;
}

Json extract_head(const std::string& input_path, const Input& input,
                  const std::vector<std::string>& outputs) {
  Json json;
  json["command"] = "extract";
  json["input"] = input_path;
  json["outputs"] = outputs;
  json["model"] = input.info.model;
  json["built_in_memory"] = input.was_built;
  add_units(json, input.info.volume.units);
  return json;
}

void warn_of_limit(Session& session, const std::string& memory_limit, const Input& input) {
  if (memory_limit.empty() || !input.was_built) return;
  session.warn(
      "--memory-limit is of queries to a .lode file, which lode build makes within it: the "
      "hierarchy of this file was built in memory");
}

std::string units_comment(const Input& input) {
  const Units& units = input.info.volume.units;
  return units.is_empty() ? "" : ", " + describe_units(units);
}

Result<void> check_paths_differ(const std::vector<std::string>& inputs,
                                const std::vector<std::string>& outputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    for (const std::string& input : inputs)
      if (is_same_file(outputs[i], input))
        return fail("{}: expected an output that is not an input, got the file that is read",
                    outputs[i]);
    for (std::size_t j = 0; j < i; ++j)
      if (is_same_file(outputs[i], outputs[j]))
        return fail("{}: expected outputs that differ, got the same file twice", outputs[i]);
  }
  return {};
}

}  // namespace lode::cli

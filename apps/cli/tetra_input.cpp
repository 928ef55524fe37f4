#include "tetra_input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

#include "lode/api/mesh_picture.h"
#include "parse.h"
#include "stopwatch.h"
#include "tetra_record.h"
#include "tolerance.h"
#include "vtk_import.h"

namespace lode::cli {
namespace {

constexpr std::int64_t kMaxStep = 1'000'000'000;

Result<double> parse_weld(const char* name, const std::string& text) {
  LODE_TRY(const double number, parse_number(name, text));
  if (number >= 0 && std::isfinite(number)) return number;
  return fail("{}: expected a number >= 0, got {}", name, text);
}

Result<void> add_welding(const ReadingArguments& reading, TetraOptions& options) {
  if (!reading.weld.empty()) {
    LODE_TRY(options.weld_distance, parse_weld("--weld", reading.weld));
  }
  if (reading.weld_values.empty()) return {};
  if (reading.weld.empty()) return fail("--weld-values: expected --weld with it, got none");
  LODE_TRY(options.weld_values, parse_weld("--weld-values", reading.weld_values));
  return {};
}

Result<CollapseOrder> to_order(const ReadingArguments& reading) {
  const std::string& order = reading.order;
  if (reading.is_fast && !order.empty() && order != "quadric")
    return fail("--order: expected 'quadric' with --fast, got '{}'", order);
  if (reading.is_fast || order == "quadric") return CollapseOrder::quadric;
  if (order == "space") return CollapseOrder::space_error;
  if (order.empty() || order == "error") return CollapseOrder::squared_error;
  return fail("--order: expected error, space or quadric, got '{}'", order);
}

}  // namespace

Result<TetraOptions> to_tetra_options(const ReadingArguments& reading, const IsField& is_field) {
  TetraOptions options;
  LODE_CHECK(add_welding(reading, options));
  if (!reading.linearise.empty() && reading.linearise != "corners")
    return fail("--linearise: expected 'corners', got '{}'", reading.linearise);
  if (!reading.linearise.empty()) options.quadratic = QuadraticCells::corners;
  if (!reading.region_field.empty()) options.region_field = reading.region_field;
  options.only_regions = reading.only_regions;
  for (const auto& [name, is_given] : {std::pair{"--component", !reading.component.empty()},
                                       std::pair{"--with", !reading.with.empty()},
                                       std::pair{"--warp", !reading.deforming.empty()}})
    if (reading.field.empty() && is_given)
      return fail("{}: expected --field with it, got none", name);
  if (reading.field.empty()) return options;
  options.fields = scalars_of(reading.field, is_field);
  if (!reading.component.empty() && options.fields.size() > 1)
    return fail("--component: expected none with --field {}, got {}", reading.field,
                reading.component);
  if (!reading.component.empty() && reading.component != "magnitude")
    options.fields[0] += ":" + reading.component_number();
  std::vector<std::string> more = scalars_of_with(reading, is_field);
  for (const std::string& component : reading.deforming)
    for (std::string& name : scalars_of(component, is_field)) more.push_back(std::move(name));
  for (std::string& name : more)
    if (std::ranges::find(options.fields, name) == options.fields.end())
      options.fields.push_back(std::move(name));
  options.has_all = wants_all(reading);
  return options;
}

Result<TetraBuildOptions> to_build_options(const ReadingArguments& reading, Threads threads) {
  TetraBuildOptions options{.has_world_errors = reading.has_space_errors, .threads = threads};
  LODE_TRY(options.order, to_order(reading));
  if (reading.placement == "midpoint")
    options.placement = Placement::midpoint;
  else if (!reading.placement.empty() && reading.placement != "half-edge")
    return fail("--placement: expected half-edge or midpoint, got '{}'", reading.placement);
  return options;
}

const char* name_of(Placement placement) {
  return placement == Placement::midpoint ? "midpoint" : "half-edge";
}

const char* name_of(ErrorPlace place) {
  return place == ErrorPlace::everywhere ? "everywhere" : "at samples";
}

bool is_medit_path(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::ranges::transform(extension, extension.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return extension == ".mesh" || extension == ".meshb";
}

Result<void> check_tetra_reading(const ReadingArguments& reading, const std::string& path) {
  ReadingArguments others = reading;
  others.field.clear();
  others.with.clear();
  if (is_lode_path(path)) {
    if (!others.time.empty()) LODE_CHECK(parse_integer("--time", others.time, 0, kMaxStep));
    others.time.clear();
    if (!others.is_empty())
      return fail("{}: expected no options of reading but --field, --with and --time, got {}", path,
                  others.given());
    return check_reading_options(others, path);
  }
  LODE_CHECK(to_tetra_options(reading));
  LODE_CHECK(to_build_options(reading, {}));
  others.placement.clear();
  others.order.clear();
  others.is_fast = false;
  others.component.clear();
  others.weld.clear();
  others.weld_values.clear();
  others.linearise.clear();
  others.region_field.clear();
  others.only_regions.clear();
  if (is_medit_path(path)) others.solution.clear();
  if (!others.solution.empty())
    return fail("--solution: expected a MEDIT mesh (.mesh or .meshb) with it, got {}", path);
  if (may_have_steps(path) && !others.time.empty()) {
    LODE_CHECK(parse_integer("--time", others.time, 0, kMaxStep));
    others.time.clear();
  }
  std::string got = others.given();
  if (others.salvage) got += got.empty() ? "--salvage" : ", --salvage";
  if (!got.empty())
    return fail(
        "{}: expected no options of reading but --field, --with, --component, --weld, "
        "--weld-values, --linearise, --region-field, --only-region{}{}, --placement, --order and "
        "--fast, got {}",
        path, may_have_steps(path) ? ", --time" : "", is_medit_path(path) ? ", --solution" : "",
        got);
  return {};
}

Result<QueryArguments> without_share(const QueryArguments& arguments) {
  QueryArguments made = arguments;
  if (!made.max_error_outside.ends_with('%')) return made;
  LODE_CHECK(parse_tolerance("--max-error-outside", made.max_error_outside));
  made.max_error_outside = "0";
  return made;
}

Result<void> check_opacity(const std::string& preset_or_path) {
  if (preset_or_path.empty() || is_transfer_preset(preset_or_path)) return {};
  const auto file = read_transfer_function(preset_or_path);
  std::error_code ignored;
  if (file) return {};
  if (std::filesystem::exists(preset_or_path, ignored))
    return fail("--opacity: {}", file.error().message);
  return fail("--opacity: {}; nor is there a file of that name",
              transfer_preset(preset_or_path, {}).error().message);
}

namespace {

/// What is at other times or places says so itself.
std::string why_skipped(const std::string& skipped, const std::string& field) {
  const std::string_view more = std::string_view(skipped).substr(field.size());
  if (more.starts_with(" (at other times ") || more.starts_with(" at ")) return {};
  return ", as it has no number at each point or cell";
}

/// What else there is to say where a field is not found.
std::string why_missing(const CellMesh& cells, const std::string& field) {
  for (const std::string& skipped : cells.skipped_arrays)
    if (!field.empty() && (skipped == field || skipped.starts_with(field + " ")))
      return fmt::format("; {} is left out{}", skipped, why_skipped(skipped, field));
  if (is_medit_path(cells.path) && cells.point_fields.empty())
    return "; MEDIT's meshes hold no fields but references, and no .sol or .solb of the same name "
           "lies beside it that has values at vertices: --solution names another";
  return {};
}

bool has_field(const CellMesh& cells, const std::string& name) {
  return std::ranges::find(cells.point_fields, name, &MeshField::name) !=
             cells.point_fields.end() ||
         std::ranges::find(cells.cell_fields, name, &MeshField::name) != cells.cell_fields.end();
}

/// NAME:xyz is all of a vector, and one deforms.
Result<void> check_vectors(const CellMesh& cells, const ReadingArguments& reading) {
  std::vector<std::pair<std::string, const char*>> names{{reading.field, ""}};
  for (const std::string& name : reading.with) names.emplace_back(name, "");
  for (const std::string& name : reading.deforming) names.emplace_back(name, "--warp: ");
  for (const auto& [name, option] : names) {
    if (!name.ends_with(kVectorEnd) || has_field(cells, name)) continue;
    const std::string vector = name.substr(0, name.size() - kVectorEnd.size());
    for (const auto* fields : {&cells.point_fields, &cells.cell_fields}) {
      const auto field = std::ranges::find(*fields, vector, &MeshField::name);
      if (field == fields->end()) continue;
      if (field->n_components == 3) break;
      return fail("{}: {}{}: expected a field of three components, {} has {}", cells.path, option,
                  name, vector, field->n_components);
    }
  }
  return {};
}

/// The first of them.
std::string list_ids(const std::vector<std::int64_t>& ids) {
  constexpr std::ptrdiff_t kMost = 10;
  const auto n = std::min(kMost, std::ssize(ids));
  return fmt::format("{}{}", fmt::join(ids.begin(), ids.begin() + n, ", "),
                     n < std::ssize(ids) ? ", ..." : "");
}

/// Where values are lacking in some regions alone.
std::string advice_on_regions(const AveragedField& field) {
  if (field.nonfinite_regions.empty()) return {};
  return fmt::format(
      ", all of them in the region{} {}: the regions {} may be read alone, each by an "
      "--only-region (info lists them)",
      field.nonfinite_regions.size() > 1 ? "s" : "", list_ids(field.nonfinite_regions),
      list_ids(field.finite_regions));
}

}  // namespace

Result<TetrahedraOutcome> read_tetra_mesh(const std::string& path, const ReadingArguments& reading,
                                          Session& session) {
  LODE_TRY(CellMesh cells, read_cells(path, reading, session));
  LODE_TRY(TetraOptions options, to_tetra_options(reading, [&](const std::string& name) {
             return has_field(cells, name);
           }));
  if (!reading.time.empty() && !needs_vtk_import(path) && cells.times.empty())
    return fail("{}: expected no --time, as it has no field at several times, got {}", path,
                reading.time);
  LODE_CHECK(check_vectors(cells, reading));
  const std::string why = why_missing(cells, reading.field);
  std::string names;
  for (const auto* fields : {&cells.point_fields, &cells.cell_fields})
    for (const MeshField& field : *fields) names += (names.empty() ? "" : ", ") + field.name;
  auto made = to_tetrahedra(std::move(cells), options);
  if (!made) return fail("{}{}", made.error().message, why);
  if (!made->report.nonfinite.empty()) {
    const NonfiniteField& field = made->report.nonfinite.front();
    for (const AveragedField& of_cells : made->report.averaged)
      if (of_cells.name == field.name && of_cells.n_nonfinite_cells > 0)
        return fail(
            "{}: field {}: expected finite values, got {} that {} not, the first at cell {} "
            "(from 0{}){}",
            path, field.name, of_cells.n_nonfinite_cells,
            of_cells.n_nonfinite_cells > 1 ? "are" : "is", of_cells.first_nonfinite,
            made->report.n_other_regions > 0 ? ", of those that are kept" : "",
            advice_on_regions(of_cells));
    return fail(
        "{}: field {}: expected finite values, got {} that {} not, the first at point {} "
        "(from 0)",
        path, field.name, field.n_values, field.n_values > 1 ? "are" : "is", field.first);
  }
  if (!reading.field.empty() || made->mesh.fields.size() == 1) return made;
  return fail("{}: expected --field to name one of its fields ({}), got none{}", path,
              names.empty() ? "there are none" : names, why);
}

Result<TetraInput> open_tetra_input(const std::string& path, const ReadingArguments& reading,
                                    Session& session) {
  const Stopwatch watch;
  if (is_lode_path(path)) {
    LODE_TRY(TetraDataset dataset, TetraDataset::open(path));
    auto fields = fields_of(dataset.describe(), reading);
    if (!fields) return fail("{}: {}", path, fields.error().message);
    return TetraInput{std::move(dataset), std::nullopt, watch.seconds(), std::move(fields->use),
                      std::move(fields->warp)};
  }
  session.note(fmt::format("{}: not a .lode file; building its hierarchy in memory", path));
  LODE_TRY(TetrahedraOutcome made, read_tetra_mesh(path, reading, session));
  TetraReport report = made.report;
  LODE_TRY(TetraBuildOptions options, to_build_options(reading, session.threads()));
  options.time = report.time;
  auto built = TetraDataset::build(made.mesh, options, session.progress());
  if (!built) {
    if (session.progress().is_cancelled()) return built.error();
    return fail("{}: {}", path, built.error().message);
  }
  LODE_TRY(ReadFields fields, fields_of_built(built->describe(), reading));
  return TetraInput{std::move(*built), std::move(report), watch.seconds(), std::move(fields.use),
                    std::move(fields.warp)};
}

std::optional<double> TetraInput::time() const {
  const std::vector<TetraFieldInfo>& all = dataset.describe().fields;
  if (field().time) return field().time;
  for (const std::size_t at : fields.along)
    if (all[at].time) return all[at].time;
  return std::nullopt;
}

std::uint64_t TetraInput::n_inverted() const {
  return report ? report->n_inverted : kept_inverted(dataset.describe().record);
}

void add_reading(const TetraInput& input, Table& table, Json& json) {
  const std::optional<double> time = input.time();
  json["time"] = time ? Json(*time) : Json(nullptr);
  if (time) table.add({"time", fmt::format("{}", *time)});
  json["built_in_memory"] = input.was_built();
  if (input.report) return add_cell_counts(*input.report, table, json["reading"]);
  const TetraReads reads = input.dataset.reads();
  json["bytes_read"] = reads.n_bytes;
  json["file_bytes"] = reads.file_size;
  table.add({"read",
             fmt::format("{} of {}", format_bytes(reads.n_bytes), format_bytes(reads.file_size))});
}

}  // namespace lode::cli

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
std::string numbered_component(const std::string& name) {
  if (name.size() < 3 || name[name.size() - 2] != ':') return name;
  const std::size_t axis = std::string_view("xyz").find(name.back());
  if (axis == std::string_view::npos) return name;
  return name.substr(0, name.size() - 1) + std::to_string(axis);
}

namespace {

constexpr std::int64_t kMaxStep = 1'000'000'000;
constexpr std::string_view kVector = ":xyz";

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

/// Of NAME:xyz, all three.
std::vector<std::string> components_of(const std::string& name) {
  const std::string vector = name.substr(0, name.size() - kVector.size());
  return {vector + ":0", vector + ":1", vector + ":2"};
}

/// With --with: all others.
constexpr std::string_view kAllFields = "all";

bool wants_all(const ReadingArguments& reading) {
  return std::ranges::find(reading.with, kAllFields) != reading.with.end();
}

/// The fields of --with that are named; NAME:xyz is three.
std::vector<std::string> names_of_with(const ReadingArguments& reading) {
  std::vector<std::string> names;
  for (const std::string& name : reading.with)
    if (name == kAllFields)
      continue;
    else if (name.ends_with(kVector))
      for (std::string& component : components_of(name)) names.push_back(std::move(component));
    else
      names.push_back(numbered_component(name));
  return names;
}

/// A field that is asked for, perhaps with its time behind it as lists of fields have it.
struct NamedField {
  std::string name;
  std::optional<double> time{};
  std::vector<std::size_t> steps{};  ///< Places, in order of time; what has none comes first.
};

Result<NamedField> to_named_field(const TetraInfo& info, const std::string& text) {
  const auto named = [&](std::string name, std::optional<double> time) {
    NamedField field{std::move(name), time};
    for (std::size_t i = 0; i < info.fields.size(); ++i)
      if (info.fields[i].name == field.name) field.steps.push_back(i);
    std::ranges::stable_sort(field.steps, {}, [&](std::size_t i) { return info.fields[i].time; });
    return field;
  };
  NamedField field = named(text.empty() ? info.fields[0].name : numbered_component(text), {});
  if (!field.steps.empty()) return field;
  constexpr std::string_view kAt = " at ";
  if (const std::size_t at = text.rfind(kAt); at != std::string::npos)
    if (const auto time = parse_number("", text.substr(at + kAt.size())); time)
      field = named(numbered_component(text.substr(0, at)), *time);
  if (!field.steps.empty()) return field;
  LODE_CHECK(find_field(info, text));  // Names those that there are.
  return field;
}

bool has_times(const TetraInfo& info, const NamedField& field) {
  return info.fields[field.steps.back()].time.has_value();
}

std::string text_of(const std::optional<double>& time) {
  return time ? fmt::format("at {}", *time) : "without a time";
}

/// The place of a field that has steps at a time, or among those without one.
Result<std::size_t> step_at(const TetraInfo& info, const NamedField& field,
                            const std::optional<double>& time) {
  constexpr std::size_t kMostNamed = 20;
  std::string times;
  for (std::size_t i = 0; i < field.steps.size(); ++i) {
    const std::optional<double>& other = info.fields[field.steps[i]].time;
    if (other == time && (!field.time || field.time == time)) return field.steps[i];
    if (i < kMostNamed) times += (i > 0 ? ", " : "") + text_of(other);
  }
  if (field.steps.size() > kMostNamed) times += ", ...";
  return fail("field {}: expected a step {}, as all fields of an answer are of one time, got {}",
              field.name, text_of(time),
              field.time && field.time != time ? "one " + text_of(field.time) : times);
}

/// The time of the first field, by its name or as the step of a number.
Result<std::optional<double>> time_of(const TetraInfo& info, const NamedField& field,
                                      const std::string& step) {
  if (field.time && !step.empty())
    return fail("--time: expected none with the field {} {}, got {}", field.name,
                text_of(field.time), step);
  if (field.time) return field.time;
  if (step.empty()) return info.fields[field.steps.front()].time;
  LODE_TRY(const std::int64_t n,
           parse_integer("--time", step, 0, static_cast<std::int64_t>(field.steps.size()) - 1));
  return info.fields[field.steps[static_cast<std::size_t>(n)]].time;
}

}  // namespace

Result<std::vector<std::size_t>> named_fields(const TetraInfo& info,
                                              const std::vector<std::string>& names,
                                              const std::string& step) {
  std::vector<NamedField> fields;
  for (const std::string& name : names) {
    LODE_TRY(NamedField field, to_named_field(info, name));
    fields.push_back(std::move(field));
  }
  const auto first =
      std::ranges::find_if(fields, [&](const NamedField& field) { return has_times(info, field); });
  if (first == fields.end() && !step.empty())
    return fail("--time: expected none, as the field {} has no steps, got {}", fields[0].name,
                step);
  std::optional<double> time;
  if (first != fields.end()) {
    LODE_TRY(time, time_of(info, *first, step));
  }
  std::vector<std::size_t> places;
  for (const NamedField& field : fields) {
    const bool is_of_all_times = !has_times(info, field) && !field.time;
    LODE_TRY(const std::size_t at, is_of_all_times ? Result<std::size_t>(field.steps.front())
                                                   : step_at(info, field, time));
    places.push_back(at);
  }
  return places;
}

namespace {

Result<TetraFieldUse> fields_of(const TetraInfo& info, const ReadingArguments& reading) {
  const bool is_vector =
      reading.field.ends_with(kVector) &&
      std::ranges::find(info.fields, reading.field, &TetraFieldInfo::name) == info.fields.end();
  std::vector<std::string> names =
      is_vector ? components_of(reading.field) : std::vector{reading.field};
  for (std::string& name : names_of_with(reading)) names.push_back(std::move(name));
  if (wants_all(reading))
    for (const TetraFieldInfo& field : info.fields)
      if (std::ranges::find(names, field.name) == names.end()) names.push_back(field.name);
  LODE_TRY(const std::vector<std::size_t> places, named_fields(info, names, reading.time));
  TetraFieldUse use{.measured = places[0]};
  for (const std::size_t at : places)
    if (at != use.measured && std::ranges::find(use.along, at) == use.along.end())
      use.along.push_back(at);
  return use;
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

Result<TetraOptions> to_tetra_options(const ReadingArguments& reading) {
  TetraOptions options;
  LODE_CHECK(add_welding(reading, options));
  if (!reading.linearise.empty() && reading.linearise != "corners")
    return fail("--linearise: expected 'corners', got '{}'", reading.linearise);
  if (!reading.linearise.empty()) options.quadratic = QuadraticCells::corners;
  if (!reading.region_field.empty()) options.region_field = reading.region_field;
  options.only_regions = reading.only_regions;
  if (reading.field.empty() && !reading.component.empty())
    return fail("--component: expected --field with it, got none");
  if (reading.field.empty() && !reading.with.empty())
    return fail("--with: expected --field with it, got none");
  if (reading.field.empty()) return options;
  if (reading.field.ends_with(kVector)) {
    if (!reading.component.empty())
      return fail("--component: expected none with --field {}, got {}", reading.field,
                  reading.component);
    options.fields = components_of(reading.field);
  } else {
    std::string field = numbered_component(reading.field);
    if (!reading.component.empty() && reading.component != "magnitude")
      field += ":" + reading.component_number();
    options.fields = {std::move(field)};
  }
  for (std::string& name : names_of_with(reading))
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

/// NAME:xyz is all of a vector.
Result<void> check_vectors(const CellMesh& cells, const ReadingArguments& reading) {
  std::vector<std::string> names{reading.field};
  names.insert(names.end(), reading.with.begin(), reading.with.end());
  for (const std::string& name : names) {
    if (!name.ends_with(kVector) || has_field(cells, name)) continue;
    const std::string vector = name.substr(0, name.size() - kVector.size());
    for (const auto* fields : {&cells.point_fields, &cells.cell_fields}) {
      const auto field = std::ranges::find(*fields, vector, &MeshField::name);
      if (field == fields->end()) continue;
      if (field->n_components == 3) break;
      return fail("{}: expected a field of three components, {} has {}", name, vector,
                  field->n_components);
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
  LODE_TRY(TetraOptions options, to_tetra_options(reading));
  LODE_TRY(CellMesh cells, read_cells(path, reading, session));
  if (!reading.time.empty() && !needs_vtk_import(path) && cells.times.empty())
    return fail("{}: expected no --time, as it has no field at several times, got {}", path,
                reading.time);
  if (reading.field.ends_with(kVector) && has_field(cells, reading.field)) {  // it is one's name
    options.fields.erase(options.fields.begin() + 1, options.fields.begin() + 3);
    options.fields[0] = reading.field;
  }
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
    return TetraInput{std::move(dataset), std::nullopt, watch.seconds(), std::move(*fields)};
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
  TetraFieldUse fields;
  for (std::size_t i = 1; i < made.mesh.fields.size(); ++i) fields.along.push_back(i);
  return TetraInput{std::move(*built), std::move(report), watch.seconds(), std::move(fields)};
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

#include "build_tetra.h"

#include <cmath>
#include <limits>

#include "cell_mesh_facts.h"
#include "outputs.h"
#include "parse.h"
#include "stopwatch.h"
#include "tetra_input.h"
#include "tetra_record.h"
#include "text.h"
#include "vtk_import.h"

namespace lode::cli {
namespace {

/// None: as many as TetraBuildOptions has.
Result<std::optional<std::uint64_t>> parse_base_cells(const std::string& text) {
  if (text.empty()) return std::optional<std::uint64_t>();
  LODE_TRY(const std::int64_t n,
           parse_integer("--base-cells", text, 0, std::numeric_limits<std::int64_t>::max()));
  return std::optional(static_cast<std::uint64_t>(n));
}

Result<double> parse_boundary_tolerance(const std::string& text) {
  if (text.empty()) return 0;
  LODE_TRY(const double distance, parse_number("--boundary-tolerance", text));
  if (!(distance >= 0) || !std::isfinite(distance))
    return fail("--boundary-tolerance: expected a distance >= 0, got {}", text);
  return distance;
}

/// Of the fields; none where none is told. `report`: what the file says.
Result<std::optional<double>> build_time(const TetraBuildJob& job, const TetraReport& report) {
  if (job.at.empty()) return std::optional<double>();
  if (job.at != "file") {
    LODE_TRY(const double time, parse_number("--at", job.at));
    return std::optional(time);
  }
  if (report.time) return report.time;
  return fail("--at: expected the time of the fields, as {} does not say its own, got 'file'",
              job.input);
}

Json field_json(const TetraFieldInfo& field) {
  Json json{{"name", field.name},
            {"type", name_of(field.type)},
            {"range", {field.range_min, field.range_max}},
            {"base_error", field.base_error},
            {"error_kind", name_of(field.error_place)}};
  if (field.time) json["time"] = *field.time;
  if (field.base_world_error) json["base_space_error"] = *field.base_world_error;
  return json;
}

/// The number of a field's step, in order of time; none where it has but one.
std::optional<std::size_t> step_of(const TetraInfo& info, const TetraFieldInfo& field) {
  std::size_t n_before = 0;
  std::size_t n = 0;
  for (const TetraFieldInfo& other : info.fields) {
    if (other.name != field.name) continue;
    ++n;
    n_before += other.time < field.time ? 1 : 0;
  }
  return n > 1 ? std::optional(n_before) : std::nullopt;
}

constexpr std::size_t kMostPatchRows = 50;

void add_patches(const std::vector<BoundaryPatch>& patches, Table& table, Json& json) {
  Json list = Json::array();
  for (const BoundaryPatch& patch : patches) {
    list.push_back({{"id", patch.id}, {"name", patch.name}});
    if (list.size() > kMostPatchRows) continue;
    table.add({"patch", patch.name.empty() ? std::to_string(patch.id)
                                           : fmt::format("{} ({})", patch.name, patch.id)});
  }
  if (list.size() > kMostPatchRows)
    table.add({"patches", fmt::format("{} more", format_count(list.size() - kMostPatchRows))});
  json["patches"] = std::move(list);
}

/// Regions with names have a row each, as patches; others one between them.
void add_regions(const std::vector<MeshRegion>& regions, Table& table, Json& json) {
  Json ids = Json::array();
  Json names = Json::array();
  std::string unnamed;
  std::size_t n_shown = 0;
  for (const MeshRegion& region : regions) {
    ids.push_back(region.id);
    names.push_back(region.name);
    if (n_shown++ >= kMostPatchRows) continue;
    if (region.name.empty())
      unnamed += fmt::format("{}{}", unnamed.empty() ? "" : ", ", region.id);
    else
      table.add({"region", fmt::format("{} ({})", region.name, region.id)});
  }
  const std::string more =
      n_shown <= kMostPatchRows ? "" : format_count(n_shown - kMostPatchRows) + " more";
  if (!more.empty()) unnamed += unnamed.empty() ? more : " and " + more;
  if (regions.size() > 1 && !unnamed.empty()) table.add({"regions", std::move(unnamed)});
  json["regions"] = std::move(ids);
  json["region_names"] = std::move(names);
}

/// Of a mesh that is no model yet.
std::vector<MeshRegion> regions_of_mesh(const TetraMesh& mesh) {
  std::vector<MeshRegion> regions;
  for (std::size_t i = 0; i < mesh.region_ids.size(); ++i)
    regions.push_back(
        {mesh.region_ids[i], mesh.region_names.empty() ? std::string() : mesh.region_names[i]});
  return regions;
}

void add_info(const TetraInfo& info, Table& table, Json& json) {
  json["model"] = "tetra_mt";
  json["placement"] = name_of(info.placement);
  json["cells"] = info.n_cells;
  json["vertices"] = info.n_vertices;
  json["nodes"] = info.n_nodes;
  json["base_cells"] = info.n_base_cells;
  add_regions(info.regions, table, json);
  add_patches(info.patches, table, json);
  json["boundary_deviation"] = info.boundary_deviation;
  json["lean"] = info.is_lean;
  json["bounds"] = {info.bounds.lower.v, info.bounds.upper.v};
  table.add({"model", "tetra_mt"});
  table.add({"placement", name_of(info.placement)});
  add_fields(info, table, json);
  table.add({"reference", fmt::format("{} cells, {} vertices", format_count(info.n_cells),
                                      format_count(info.n_vertices))});
  table.add({"base", format_count(info.n_base_cells) + " cells"});
  if (info.is_lean) table.add({"lean", "without gradients and the mesh's numbers of vertices"});
  table.add({"nodes", format_count(info.n_nodes)});
  const auto corner = [](const Vec3d& p) {
    return fmt::format("({}, {}, {})", format_number(p[0]), format_number(p[1]),
                       format_number(p[2]));
  };
  table.add({"bounds", corner(info.bounds.lower) + " to " + corner(info.bounds.upper)});
}

Result<std::uint64_t> parse_memory_limit(const std::string& text) {
  if (text.empty()) return physical_memory();
  return parse_bytes("--memory-limit", text);
}

/// Cells as the file has them, before they are split.
Result<Outcome> foreign_info(const std::string& path, const ReadingArguments& reading,
                             Session& session) {
  LODE_TRY(CellMesh cells, read_cells(path, reading, session));
  Outcome outcome;
  Json& json = outcome.json;
  json["command"] = "info";
  json["input"] = path;
  json["points"] = cells.points.size();
  json["cells"] = cells.n_cells();
  Table table;
  table.add({"file", path});
  table.add({"points", format_count(cells.points.size())});
  table.add({"cells", format_count(cells.n_cells())});
  json["times"] = cells.times;
  if (!cells.times.empty())
    table.add({"time steps",
               fmt::format("{}, at {} to {}", cells.times.size(),
                           format_number(cells.times.front()), format_number(cells.times.back()))});
  add_cell_mesh(cells, table, json);
  LODE_TRY(const TetraOptions options, to_tetra_options(reading));
  LODE_TRY(const TetrahedraOutcome made, to_tetrahedra(std::move(cells), options));
  if (made.report.time) {
    json["time"] = *made.report.time;
    table.add({"time", format_number(*made.report.time)});
  }
  json["tetrahedra"] = made.mesh.tetrahedra.size();
  table.add({"as tetrahedra", format_count(made.mesh.tetrahedra.size())});
  add_patches(made.mesh.patches, table, json);
  add_regions(regions_of_mesh(made.mesh), table, json);
  add_cell_counts(made.report, table, json["reading"]);
  outcome.text = table.to_string();
  return outcome;
}

/// Points that were welded where faces do not match.
template <typename Refusals>
void warn_of_seams(const TetraReport& report, const Refusals& refusals, Session& session) {
  if (report.n_welded_points == 0) return;
  for (const auto& [rule, n] : refusals)
    if (rule == "non-manifold" && n > 0)
      session.warn(fmt::format(
          "--weld: {} of the base {} as non-manifold; where the faces on both sides of a seam are "
          "cut differently, welding its points joins no cells: compare a build without it",
          n == 1 ? "1 vertex" : format_count(n) + " vertices", n == 1 ? "stays" : "stay"));
}

}  // namespace

void add_fields(const TetraInfo& info, Table& table, Json& json) {
  const TetraFieldInfo& first = info.fields[0];
  json["field"] = first.name;
  json["sample_type"] = name_of(first.type);
  json["range"] = {first.range_min, first.range_max};
  json["base_error"] = first.base_error;
  json["error_kind"] = name_of(first.error_place);
  json["fields"] = Json::array();
  for (const TetraFieldInfo& field : info.fields) {
    json["fields"].push_back(field_json(field));
    const std::optional<std::size_t> step = step_of(info, field);
    if (step) json["fields"].back()["step"] = *step;
    table.add(
        {"field",
         fmt::format("{}{}{}, {}, {}, error of the base {} {}{}", field.name,
                     field.time ? fmt::format(" at {}", *field.time) : "",
                     step ? fmt::format(" (--time {})", *step) : "", name_of(field.type),
                     format_range(field.range_min, field.range_max),
                     format_number(field.base_error), name_of(field.error_place),
                     field.base_world_error ? fmt::format(", in space {} by an estimate",
                                                          format_number(*field.base_world_error))
                                            : "")});
  }
}

Result<void> check_tetra_build(const TetraBuildJob& job) {
  if (!is_lode_path(job.output))
    return fail("{}: expected an output that ends in .lode", job.output);
  LODE_CHECK(parse_base_cells(job.base_cells));
  LODE_CHECK(parse_memory_limit(job.memory_limit));
  LODE_TRY(const TetraBuildOptions options, to_build_options(job.reading, {}));
  LODE_TRY(const double tolerance, parse_boundary_tolerance(job.boundary_tolerance));
  if (options.placement == Placement::midpoint && job.is_everywhere)
    return fail(
        "--placement midpoint: expected no --everywhere with it, which follows half edges alone: "
        "errors of midpoints hold at the mesh's vertices");
  if (options.placement == Placement::midpoint && job.is_lean)
    return fail("--placement midpoint: expected no --lean with it: they have no more than that");
  if (options.placement == Placement::midpoint && job.keeps_extrema)
    return fail("--placement midpoint: expected no --keep-extrema with it, which moves vertices");
  if (job.is_everywhere && tolerance > 0)
    return fail("--everywhere: expected no --boundary-tolerance with it, got {}", tolerance);
  if (!job.at.empty() && job.at != "file") LODE_CHECK(parse_number("--at", job.at));
  LODE_CHECK(check_tetra_reading(job.reading, job.input));
  return check_paths_differ({job.input}, {job.output});
}

Result<Outcome> run_tetra_build(const TetraBuildJob& job, Session& session) {
  const Stopwatch watch;
  LODE_CHECK(check_writable(job.output));
  LODE_TRY(const auto base_cells, parse_base_cells(job.base_cells));
  LODE_TRY(const TetrahedraOutcome made, read_tetra_mesh(job.input, job.reading, session));
  const double read_seconds = watch.seconds();
  LODE_TRY(TetraBuildOptions options, to_build_options(job.reading, session.threads()));
  LODE_TRY(options.boundary_tolerance, parse_boundary_tolerance(job.boundary_tolerance));
  options.has_world_errors = job.has_space_errors;
  options.is_lean = job.is_lean;
  options.keeps_extrema = job.keeps_extrema;
  LODE_TRY(options.time, build_time(job, made.report));
  if (job.is_everywhere) options.error_place = ErrorPlace::everywhere;
  LODE_TRY(options.memory_limit, parse_memory_limit(job.memory_limit));
  if (base_cells && !made.mesh.tetrahedra.empty())
    options.base_share =
        static_cast<double>(*base_cells) / static_cast<double>(made.mesh.tetrahedra.size());
  keep_reading(made.report, options);
  auto built = TetraDataset::build_file(made.mesh, job.output, options, session.progress());
  if (!built) {
    if (session.progress().is_cancelled() || built.error().message.starts_with(job.output))
      return built.error();
    return fail("{}: {}", job.input, built.error().message);
  }
  warn_of_seams(made.report, built->info.record.refusals, session);
  Outcome outcome;
  Json& json = outcome.json;
  json["command"] = "build";
  json["input"] = job.input;
  json["output"] = job.output;
  Table table;
  add_info(built->info, table, json);
  add_record(built->info.record, table, json);
  add_cell_counts(made.report, table, json["reading"]);
  const double n = static_cast<double>(std::max<std::uint64_t>(built->info.n_vertices, 1));
  table.add({"boundary moved", format_number(built->info.boundary_deviation) + " at most"});
  json["file_bytes"] = built->file_bytes;
  json["seconds"] = {{"total", watch.seconds()},
                     {"read", read_seconds},
                     {"build", built->build_seconds},
                     {"write", built->write_seconds}};
  json["warnings"] = session.warnings();
  table.add({"file size", fmt::format("{} ({:.1f} bytes a vertex)", format_bytes(built->file_bytes),
                                      static_cast<double>(built->file_bytes) / n)});
  table.add({"time", fmt::format("{} to read, {} to build, {} to write",
                                 format_seconds(read_seconds), format_seconds(built->build_seconds),
                                 format_seconds(built->write_seconds))});
  table.add({"output", job.output});
  outcome.text = table.to_string();
  return outcome;
}

Result<Outcome> tetra_info(const std::string& path, const ReadingArguments& reading,
                           Session& session) {
  LODE_CHECK(check_tetra_reading(reading, path));
  if (!is_lode_path(path)) return foreign_info(path, reading, session);
  LODE_TRY(const TetraInput input, open_tetra_input(path, reading, session));
  Outcome outcome;
  outcome.json["command"] = "info";
  outcome.json["input"] = path;
  Table table;
  table.add({"file", path});
  add_info(input.dataset.describe(), table, outcome.json);
  add_record(input.dataset.describe().record, table, outcome.json);
  add_kept_reading(input.dataset.describe().record, table, outcome.json);
  table.add(
      {"boundary moved", format_number(input.dataset.describe().boundary_deviation) + " at most"});
  outcome.json["file_bytes"] = input.dataset.reads().file_size;
  table.add({"file size", format_bytes(input.dataset.reads().file_size)});
  outcome.text = table.to_string();
  return outcome;
}

}  // namespace lode::cli

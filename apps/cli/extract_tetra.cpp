#include "extract_tetra.h"

#include <algorithm>
#include <cmath>

#include "lode/api/finishing.h"
#include "lode/api/mesh_picture.h"
#include "lode/api/warp.h"
#include "outputs.h"
#include "parse.h"
#include "stopwatch.h"
#include "tetra_input.h"
#include "tetra_query_options.h"
#include "tetra_record.h"
#include "text.h"
#include "tolerance.h"
#include "warp_options.h"

namespace lode::cli {
namespace {

/// What meshes and surfaces report alike.
struct TetraAnswer {
  double max_error = 0;
  bool is_default = false;  ///< The tolerance.
  double achieved_error = 0;
  std::optional<double> space_error{};  ///< Achieved,
  std::optional<double> pixels{};       ///< likewise.
  bool budget_met = true;
  bool is_settled = true;
  double seconds = 0;
  double write_seconds = 0;
  std::vector<Attribute> attributes{};  ///< Without their values.
  std::vector<std::string> outputs{};
  std::vector<double> isovalues{};  ///< Of surfaces.
  std::optional<Warped> warped{};
};

template <typename Report>
TetraAnswer to_answer(const Report& report, bool is_default) {
  return {report.max_error,   is_default,        report.achieved_error, report.achieved_world_error,
          report.achieved_px, report.budget_met, report.is_settled,     report.seconds};
}

/// Where errors of a further field hold.
ErrorPlace place_of(const TetraInput& input, const Attribute& attribute) {
  const std::vector<TetraFieldInfo>& fields = input.dataset.describe().fields;
  for (const std::size_t place : input.fields.along)
    if (fields[place].name == attribute.name) return fields[place].error_place;
  return ErrorPlace::at_samples;
}

/// What is told of further fields.
std::vector<Attribute> without_values(const std::vector<Attribute>& attributes) {
  std::vector<Attribute> told;
  told.reserve(attributes.size());
  for (const Attribute& from : attributes)
    told.push_back({from.name, from.is_narrow, {}, from.error});
  return told;
}

std::string tetra_comment(const std::string& kind, const TetraInput& input, const TetraAnswer& made,
                          const std::string& opacity) {
  const std::string tolerance =
      std::isfinite(made.max_error) ? fmt::format("{}", made.max_error) : "any";
  std::string text =
      fmt::format("Lode {}: {}, max_error {}, achieved_error {} {}", LODE_VERSION, kind, tolerance,
                  made.achieved_error, name_of(input.field().error_place));
  if (made.space_error) text += fmt::format(", space_error {} by an estimate", *made.space_error);
  if (!opacity.empty()) text += fmt::format(", as the opacity of {} weighs it", opacity);
  if (const auto time = input.time()) text += fmt::format("; time {}", *time);
  for (const Attribute& more : made.attributes)
    text += fmt::format("; {}: error {} {}", more.name, more.error, name_of(place_of(input, more)));
  return text + warp_comment(made.warped);
}

/// `counts`: of the answer.
Json answer_json(const MeshJob& job, const TetraInput& input, const TetraAnswer& made,
                 const Json& counts) {
  const TetraInfo& info = input.dataset.describe();
  const TetraFieldInfo& field = input.field();
  Json json;
  json["command"] = "extract";
  json["input"] = job.input;
  json["outputs"] = made.outputs;
  json["model"] = "tetra_mt";
  json["placement"] = name_of(info.placement);
  json["order"] = name_of(input.dataset.describe().record.order);
  json["field"] = field.name;
  json["with"] = Json::array();
  for (const Attribute& more : made.attributes)
    json["with"].push_back({{"field", more.name},
                            {"largest_error", more.error},
                            {"error_kind", name_of(place_of(input, more))}});
  if (!made.isovalues.empty()) json["isovalues"] = made.isovalues;
  json["max_error"] = max_error_json(made.max_error);
  json["max_error_is_default"] = made.is_default;
  json["achieved_error"] = made.achieved_error;
  if (!job.query.opacity.empty()) json["opacity"] = job.query.opacity;
  json["error_kind"] = name_of(field.error_place);
  json["boundary_deviation"] = info.boundary_deviation;
  json.update(counts);
  json["reference_cells"] = info.n_cells;
  json["reference_vertices"] = info.n_vertices;
  json["base_cells"] = info.n_base_cells;
  json["budget_met"] = made.budget_met;
  json["is_settled"] = made.is_settled;
  json["seconds"] = {
      {"total", made.seconds}, {"open", input.seconds}, {"write", made.write_seconds}};
  return json;
}

/// Counts as people know them.
std::string name_of_count(const std::string& key) {
  if (key == "largest_error") return "error anywhere";
  if (key == "cut_cells") return "cells of the cut";
  if (key == "left_out") return "cells left out";
  if (key == "components_dropped") return "pieces dropped";
  return key == "inverted_cells" ? "cells turned round" : key;
}

Outcome tetra_outcome(const MeshJob& job, const TetraInput& input, const TetraAnswer& made,
                      const Json& counts, const Session& session) {
  const TetraInfo& info = input.dataset.describe();
  const TetraFieldInfo& field = input.field();
  const std::string place = name_of(field.error_place);
  Outcome outcome;
  outcome.json = answer_json(job, input, made, counts);
  Table table;
  table.add(
      {"field", fmt::format("{}, {}", field.name, format_range(field.range_min, field.range_max))});
  table.add({"reference", fmt::format("{} cells, {} vertices", format_count(info.n_cells),
                                      format_count(info.n_vertices))});
  add_reading(input, table, outcome.json);
  if (info.placement != Placement::half_edge || !job.reading.placement.empty())
    table.add({"placement", name_of(info.placement)});
  if (input.was_built()) table.add({"order", name_of(input.dataset.describe().record.order)});
  table.add({"base", fmt::format("{} cells, error {} {}", format_count(info.n_base_cells),
                                 format_number(field.base_error), place)});
  table.add(
      {"max error",
       describe_max_error(made.max_error) +
           (made.is_default && made.max_error > 0 ? " (default: 0.5 % of the value range)" : "")});
  table.add({"achieved error", format_number(made.achieved_error) + ' ' + place +
                                   (job.query.opacity.empty() ? "" : kWhereShown)});
  add_space_error(job.query, {made.space_error, made.pixels}, table, outcome.json);
  if (info.boundary_deviation > 0)
    table.add({"boundary", fmt::format("off by up to {}", format_number(info.boundary_deviation))});
  add_deadline(made.is_settled, table);
  add_warp(made.warped, table, outcome.json);
  for (const auto& [name, value] : counts.items())
    table.add({name_of_count(name), value.is_number_float()
                                        ? format_number(value.get<double>()) + ' ' + place
                                        : format_count(value.get<std::uint64_t>())});
  for (const Attribute& more : made.attributes)
    table.add({"with", fmt::format("{}, error {} {}", more.name, format_number(more.error),
                                   name_of(place_of(input, more)))});
  table.add({"extract", format_seconds(made.seconds)});
  table.add({input.was_built() ? "read and build" : "open", format_seconds(input.seconds)});
  table.add({"write", format_seconds(made.write_seconds)});
  for (const std::string& path : made.outputs) table.add({"output", path});
  outcome.text = table.to_string();
  outcome.json["warnings"] = session.warnings();
  return outcome;
}

constexpr const char* kMeshOfCells = "mesh of cells";

/// What is done to a surface when it is there is none of a query's business.
ExtractionArguments without_edits(ExtractionArguments extraction) {
  extraction.clip.clear();
  extraction.min_component.clear();
  extraction.flip = false;
  return extraction;
}

/// Crops a surface, drops small pieces of it and turns it round, as was asked for; what goes.
Result<Dropped> edit_surface(const MeshJob& job, Threads threads, Surface& surface) {
  LODE_TRY(ExtractOptions edits, to_extract_options(job.extraction));
  edits.threads = threads;
  if (!edits.clip && edits.min_component < 2 && !job.extraction.flip) return Dropped{};
  return finish_edits(edits, surface);
}

/// What is wanted of a mesh of cells, when its arguments have been looked at.
struct TetraJob {
  TetraMeshOptions mesh;         ///< With --mesh and --boundary,
  TetraSectionOptions sections;  ///< with --section,
  TetraSurfaceOptions surface;   ///< with neither.
  bool is_default = false;       ///< The tolerance.
};

Result<TetraJob> section_job(const MeshJob& job) {
  LODE_TRY(const SectionOptions one, to_section_options(job.query, without_edits(job.extraction)));
  TetraJob made;
  LODE_TRY(made.sections.planes, to_planes(job.query));
  made.sections.isovalues = one.isovalues;
  made.sections.field_ranges = one.field_ranges;
  made.sections.max_error = one.max_error;
  Query tolerances;
  LODE_CHECK(add_space_tolerances(job.query, tolerances));
  made.sections.max_world_error = tolerances.max_world_error;
  made.sections.budget = one.budget;
  LODE_TRY(made.sections.deadline_s, to_deadline(job.query));
  made.is_default = !one.max_error && !made.sections.max_world_error;
  return made;
}

Result<TetraJob> to_tetra_job(const MeshJob& job, Threads threads) {
  if (!job.query.patches.empty() && !job.query.is_boundary)
    return fail("--patch: expected --boundary with it, whose faces it chooses");
  const bool is_section = job.query.is_section();
  if (is_section && !job.query.view.empty())
    return fail("--view: expected no --section with it, which is fine along its plane");
  if (is_section) return section_job(job);
  const char* const answer = job.query.is_mesh       ? "--mesh"
                             : job.query.is_boundary ? "--boundary"
                                                     : kMeshOfCells;
  ExtractionArguments extraction =
      job.query.is_mesh ? job.extraction : without_edits(job.extraction);
  // Only isosurfaces have normals.
  if (!job.query.is_wanted()) extraction.normals = "on";
  TetraJob made;
  LODE_TRY(made.mesh, to_tetra_query(job.query, extraction, answer));
  LODE_CHECK(add_section_foci(job.query, made.mesh.query));
  // What a transfer function shows is known when the field is.
  if (job.query.opacity.empty()) LODE_CHECK(check_outside(made.mesh.query));
  made.mesh.threads = threads;
  LODE_TRY(const ExtractOptions surface, to_extract_options(job.extraction));
  made.surface = {.query = made.mesh.query,
                  .deadline_s = made.mesh.deadline_s,
                  .normals = surface.normals,
                  .threads = threads};
  const Query& query = made.mesh.query;
  made.is_default = !query.max_error && !query.max_error_px && !query.max_world_error;
  return made;
}

/// What a transfer function shows; its presets go by the field's range.
Result<void> add_opacity(const MeshJob& job, const TetraInput& input, Query& query) {
  if (job.query.opacity.empty()) return {};
  MeshPictureOptions shown;
  LODE_TRY(shown.opacity, to_transfer_function(job.query.opacity, input.dataset.describe().bounds,
                                               {input.field().range_min, input.field().range_max}));
  query.opacity = query_of(shown).opacity;
  return {};
}

void warn_of_empty(Session& session, const MeshJob& job, bool is_empty) {
  if (!is_empty) return;
  const bool has_threshold = !job.query.threshold.empty();
  if (!job.query.patches.empty())
    session.warn(has_threshold
                     ? "the answer is empty: no face of the patches is one of a cell that "
                       "lies in the threshold"
                     : "the answer is empty: the cut has no face of the patches");
  else
    session.warn(has_threshold ? "the answer is empty: no cell of the cut lies in the threshold"
                               : "the answer is empty: the mesh has no cell");
}

Result<Outcome> run_tetra_mesh(const MeshJob& job, const TetraJob& wanted, Session& session) {
  LODE_TRY(const TetraInput input,
           open_tetra_input(job.input, reading_for(job.reading, job.query), session));
  LODE_CHECK(check_space_errors(job.input, input.field(), job.query));
  const TetraFieldInfo& field = input.field();
  TetraMeshOptions options = wanted.mesh;
  LODE_TRY(options.regions, wanted_regions(job.input, input.dataset.describe(), job.query));
  set_shares(job.extraction, job.query, field, options.query);
  LODE_CHECK(add_opacity(job, input, options.query));
  options.fields = input.fields;
  SimplexMesh mesh;
  LODE_TRY(const MeshReport report, input.dataset.extract_mesh(options, mesh, session.progress()));
  LODE_TRY(const std::optional<Warped> warped,
           apply_warp(job.query.warp, input, report.largest_error, session.threads(), mesh));
  if (warped) warn_of_inverted(session, warped->n_inverted);
  warn_of_budget(session, report);
  warn_of_boxes(options.query.boxes, input.dataset.describe().bounds, session,
                warped ? kBeforeWarp : "");
  warn_of_empty(session, job, mesh.is_empty());
  TetraAnswer made = to_answer(report, wanted.is_default);
  made.warped = warped;
  made.attributes = without_values(mesh.attributes);
  made.outputs = {job.output};
  const Stopwatch watch;
  LODE_CHECK(write_mesh(job.output, mesh,
                        {.comment = tetra_comment("mesh", input, made, job.query.opacity),
                         .value_name = field.name,
                         .time = input.time(),
                         .threads = session.threads()},
                        session.progress()));
  made.write_seconds = watch.seconds();
  Json counts;
  counts["largest_error"] = report.largest_error;
  if (warped) counts["inverted_cells"] = warped->n_inverted;
  counts["cells"] = report.n_cells;
  counts["vertices"] = report.n_vertices;
  if (wanted.mesh.threshold || !job.query.regions.empty()) counts["left_out"] = report.n_left_out;
  return tetra_outcome(job, input, made, counts, session);
}

/// What --warp does to the cells of the cut that a surface is made of.
Result<void> look_at_warped_cells(const TetraInput& input, const MeshJob& job,
                                  const TetraJob& wanted, Session& session,
                                  std::optional<Warped>& warped) {
  if (!input.warp) return {};
  TetraMeshOptions options = wanted.mesh;
  if (job.query.is_section()) {
    options.query = query_of(wanted.sections);
    options.regions = wanted.sections.regions;
    options.threads = session.threads();
  }
  set_shares(job.extraction, job.query, input.field(), options.query);
  LODE_CHECK(add_opacity(job, input, options.query));
  options.fields = input.fields;
  SimplexMesh mesh;
  LODE_CHECK(input.dataset.extract_mesh(options, mesh, session.progress()));
  const bool is_section = job.query.is_section();
  const std::vector<double>& isovalues =
      is_section ? wanted.sections.isovalues : wanted.surface.query.isovalues;
  if (job.query.is_boundary) keep_marked_cells(mesh, cells_at_boundary(mesh));
  if (is_section) keep_marked_cells(mesh, cells_at_planes(mesh, wanted.sections.planes));
  if (!job.query.is_boundary && !isovalues.empty())
    keep_marked_cells(mesh, cells_with_values(mesh, isovalues));
  const double error = mesh.errors.empty() ? 0 : static_cast<double>(std::ranges::max(mesh.errors));
  LODE_TRY(warped, apply_warp(job.query.warp, input, error, session.threads(), mesh));
  return {};
}

Result<TetraSurfaceReport> make_surface(const TetraInput& input, const MeshJob& job,
                                        TetraJob wanted, Surface& surface, Progress& progress) {
  wanted.mesh.fields = wanted.sections.fields = wanted.surface.fields = input.fields;
  const TetraFieldInfo& field = input.field();
  set_shares(job.extraction, job.query, field, wanted.mesh.query);
  LODE_CHECK(add_opacity(job, input, wanted.mesh.query));
  set_shares(job.extraction, job.query, field, wanted.surface.query);
  set_field_share(job.extraction.max_error, field, wanted.sections.max_error);
  if (job.query.is_boundary) return input.dataset.extract_boundary(wanted.mesh, surface, progress);
  if (job.query.is_section())
    return input.dataset.extract_section(wanted.sections, surface, progress);
  return input.dataset.extract_surface(wanted.surface, surface, progress);
}

void warn_of_surface(Session& session, const MeshJob& job, const Surface& surface,
                     const TetraSurfaceReport& report) {
  const bool is_section = job.query.is_section();
  if (job.query.is_boundary) warn_of_empty(session, job, surface.is_empty());
  if (job.query.warp.is_wanted() && !job.query.is_wanted() && job.extraction.normals == "on")
    session.warn("--warp: normals are left out, as those of isosurfaces are of the mesh before it");
  for (const double isovalue : report.unmet)
    session.warn(is_section ? fmt::format("no line at isovalue {}: it meets nothing on the section",
                                          isovalue)
                            : fmt::format("no surface at isovalue {}: it meets no cell", isovalue));
  if (is_section && surface.is_empty() && report.unmet.empty())
    session.warn("the section is empty: its plane meets no cell of the data");
  if (job.query.is_wanted() && !can_hold_values(job.output))
    session.warn(fmt::format("{}: values and errors are left out, which only .vtp and .ply hold",
                             job.output));
}

/// Isosurfaces share a file where that tells them apart; other surfaces have one.
std::vector<std::string> surface_paths(const MeshJob& job, const TetraJob& wanted) {
  if (job.query.is_wanted()) return {job.output};
  return paths_for_isovalues(job.output, wanted.surface.query.isovalues);
}

/// What a surface is: of isosurfaces their values.
std::string kind_of_surface(const MeshJob& job, const std::vector<double>& isovalues) {
  if (job.query.is_boundary) return "boundary";
  if (job.query.is_section()) return "section";
  return fmt::format("{} {}", isovalues.size() == 1 ? "isovalue" : "isovalues",
                     fmt::join(isovalues, " "));
}

/// Of more than one path each has an isovalue of its own. All are there in the end, or none.
Result<void> write_surfaces(const MeshJob& job, const TetraInput& input, const Surface& surface,
                            const TetraAnswer& made, Session& session) {
  const auto note = [&](const std::vector<double>& isovalues) {
    return SurfaceWriteOptions{
        .comment = tetra_comment(kind_of_surface(job, isovalues), input, made, job.query.opacity),
        .value_name = input.field().name,
        .time = input.time(),
        .threads = session.threads()};
  };
  Progress& progress = session.progress();
  OutputSet outputs(made.outputs);
  for (const std::string& path : made.outputs) outputs.add(path);
  if (made.outputs.size() == 1) {
    LODE_CHECK(write_surface(made.outputs.front(), surface, note(made.isovalues), progress));
  } else {
    const auto note_of_one = [&](double isovalue) { return note({isovalue}); };
    LODE_CHECK(write_isovalue_files(surface, made.isovalues, made.outputs, note_of_one, progress));
  }
  outputs.keep();
  return {};
}

Result<Outcome> run_tetra_surface(const MeshJob& job, TetraJob wanted, Session& session) {
  LODE_TRY(const TetraInput input,
           open_tetra_input(job.input, reading_for(job.reading, job.query), session));
  LODE_CHECK(check_space_errors(job.input, input.field(), job.query));
  LODE_TRY(wanted.mesh.regions, wanted_regions(job.input, input.dataset.describe(), job.query));
  wanted.surface.regions = wanted.sections.regions = wanted.mesh.regions;
  Surface surface;
  const auto made_surface = make_surface(input, job, wanted, surface, session.progress());
  if (!made_surface && made_surface.error().message.starts_with("patches: "))
    return naming_option("--patch", job.input, made_surface.error());
  LODE_TRY(const TetraSurfaceReport report, made_surface);
  if (job.query.is_boundary && !wanted.mesh.query.isovalues.empty())
    session.note("--isovalue: with --boundary no surface, but where the boundary is accurate");
  LODE_TRY(std::optional<Warped> warped,
           apply_warp(
               job.query.warp, input, report.achieved_error,
               job.query.is_section() ? wanted.sections.isovalues : wanted.surface.query.isovalues,
               surface));
  const bool is_empty = surface.is_empty();
  LODE_TRY(const Dropped dropped, edit_surface(job, session.threads(), surface));
  if (surface.is_empty() && !is_empty)
    session.warn(job.extraction.clip.empty()
                     ? "the surface is empty: all of its pieces are below --min-component"
                     : "the surface is empty: no large enough piece of it is in --clip");
  LODE_CHECK(look_at_warped_cells(input, job, wanted, session, warped));
  if (warped) warn_of_inverted(session, warped->n_inverted);
  warn_of_budget(session, report);
  warn_of_boxes(wanted.mesh.query.boxes, input.dataset.describe().bounds, session,
                warped ? kBeforeWarp : "");
  warn_of_surface(session, job, surface, report);
  TetraAnswer made = to_answer(report, wanted.is_default);
  made.warped = std::move(warped);
  made.attributes = without_values(surface.attributes);
  made.outputs = surface_paths(job, wanted);
  made.isovalues =
      job.query.is_wanted() ? wanted.sections.isovalues : wanted.surface.query.isovalues;
  const Stopwatch watch;
  LODE_CHECK(write_surfaces(job, input, surface, made, session));
  made.write_seconds = watch.seconds();
  Json counts;
  counts["triangles"] = surface.triangles.size();
  if (job.query.is_section()) counts["lines"] = surface.lines.size();
  counts["vertices"] = surface.positions.size();
  if (!job.extraction.min_component.empty()) counts["components_dropped"] = dropped.components;
  counts["cut_cells"] = report.n_cut_cells;
  if (made.warped) counts["inverted_cells"] = made.warped->n_inverted;
  if (wanted.mesh.threshold || !job.query.regions.empty()) counts["left_out"] = report.n_left_out;
  return tetra_outcome(job, input, made, counts, session);
}

/// What the output can hold of what is wanted.
Result<void> check_tetra_output(const MeshJob& job, const TetraJob& wanted) {
  if (job.query.is_mesh) return check_mesh_path(job.output);
  if (!job.reading.with.empty() && !check_extension(job.output, ".vtp") &&
      !check_extension(job.output, ".ply"))
    return fail(
        "--with: expected an output that ends in .vtp or .ply, which hold further fields, got '{}'",
        job.output);
  LODE_CHECK(check_surface_extension(job.output));
  if (!wanted.sections.isovalues.empty() && !can_hold_lines(job.output))
    return fail(
        "{}: expected a format that holds the isolines of a section: .vtp, .ply, .obj or .glb",
        job.output);
  if (job.query.is_wanted()) return {};
  const std::vector<double>& isovalues = wanted.surface.query.isovalues;
  if (isovalues.empty())
    return fail("{}: expected --isovalue or --mesh, --section or --boundary, got none of them",
                job.input);
  return check_isovalues_of(job.output, isovalues);
}

}  // namespace

Result<void> check_tetra_job(const MeshJob& job) {
  LODE_CHECK(check_warp(job.query));
  LODE_TRY(const TetraJob wanted, to_tetra_job(job, {}));
  LODE_CHECK(check_tetra_output(job, wanted));
  LODE_CHECK(check_tetra_reading(job.reading, job.input));
  if (!job.memory_limit.empty())
    return fail("--memory-limit: expected none with a mesh of cells, which is built in memory");
  LODE_CHECK(check_opacity(job.query.opacity));
  std::vector<std::string> inputs = files_of(job.query);
  inputs.push_back(job.input);
  return check_paths_differ(inputs, surface_paths(job, wanted));
}

Result<Outcome> run_tetra_job(const MeshJob& job, Session& session) {
  LODE_TRY(const TetraJob wanted, to_tetra_job(job, session.threads()));
  for (const std::string& path : surface_paths(job, wanted)) LODE_CHECK(check_writable(path));
  return job.query.is_mesh ? run_tetra_mesh(job, wanted, session)
                           : run_tetra_surface(job, wanted, session);
}

}  // namespace lode::cli

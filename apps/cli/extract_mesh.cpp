#include "extract_mesh.h"

#include <algorithm>

#include "outputs.h"
#include "parse.h"
#include "salvage.h"
#include "stopwatch.h"
#include "text.h"
#include "tolerance.h"

namespace lode::cli {
namespace {

/// What both kinds of answer report.
struct Made {
  double max_error = 0;
  bool is_default = false;  ///< The tolerance.
  double achieved_error = 0;
  std::uint64_t n_vertices = 0;
  std::uint64_t n_cut_cells = 0;
  std::uint64_t n_counted = 0;  ///< Of what --max-cells counts.
  std::uint64_t n_left_out = 0;
  bool budget_met = true;
  bool memory_met = true;
  double seconds = 0;
  double write_seconds = 0;
};

template <typename Report>
Made to_made(const Report& report, bool is_default, std::uint64_t n_counted) {
  return {report.max_error,
          is_default,
          report.achieved_error,
          report.n_vertices,
          report.n_cut_cells,
          n_counted,
          report.n_left_out,
          report.budget_met,
          report.memory_met,
          report.seconds,
          0};
}

/// Bytes; 0 where none is given.
Result<std::uint64_t> memory_limit_of(const MeshJob& job) {
  if (job.memory_limit.empty()) return std::uint64_t{0};
  return parse_bytes("--memory-limit", job.memory_limit);
}

void warn_of_shortcomings(Session& session, const Made& made) {
  if (!made.memory_met)
    session.warn(
        fmt::format("the memory limit is too small for the tolerance everywhere: raise it, or "
                    "narrow the focus (achieved error {})",
                    format_number(made.achieved_error)));
  if (made.n_left_out > 0)
    session.warn(
        fmt::format("{} simplices are left out: holes remove a part of each, and nothing refined "
                    "them; a wider focus or a larger budget does",
                    made.n_left_out));
  if (!made.budget_met)
    session.warn(
        fmt::format("--max-cells is not met: the coarsest mesh has {} cells", made.n_counted));
}

std::string comment_of(const char* kind, const Input& input, const Made& made) {
  return fmt::format("Lode {}: {}, max_error {}, achieved_error {}{}{}", LODE_VERSION, kind,
                     made.max_error, made.achieved_error, units_comment(input),
                     salvage_comment(input.dataset.salvaged()));
}

/// Keys of the answer, between those that all commands have.
Json outcome_json(const MeshJob& job, const Input& input, const Made& made, const Json& counts) {
  Json json = extract_head(job.input, input, {job.output});
  json["max_error"] = made.max_error;
  json["max_error_is_default"] = made.is_default;
  json["achieved_error"] = made.achieved_error;
  json.update(counts);
  json["vertices"] = made.n_vertices;
  json["cut_cells"] = made.n_cut_cells;
  json["left_out"] = made.n_left_out;
  json["budget_met"] = made.budget_met;
  json["memory_met"] = made.memory_met;
  Json& seconds = json["seconds"];
  seconds["total"] = made.seconds;
  seconds["open"] = input.open_seconds;
  seconds["write"] = made.write_seconds;
  return json;
}

Outcome report_outcome(const MeshJob& job, const Input& input, const Made& made, const Json& counts,
                       const Session& session) {
  Outcome outcome;
  outcome.json = outcome_json(job, input, made, counts);
  add_salvage(outcome.json, input.dataset.salvaged(), made.achieved_error);
  outcome.json["warnings"] = session.warnings();
  Table table;
  table.add(
      {"max error",
       format_number(made.max_error) +
           (made.is_default && made.max_error > 0 ? " (default: 0.5 % of the value range)" : "")});
  table.add({"achieved error", format_number(made.achieved_error)});
  add_units(table, input.info.volume.units);
  add_salvage(table, input.dataset.salvaged(), made.achieved_error);
  for (const auto& [name, value] : counts.items())
    table.add({name == "largest_error" ? "error anywhere" : name,
               value.is_number_float() ? format_number(value.get<double>())
                                       : format_count(value.get<std::uint64_t>())});
  table.add({"vertices", format_count(made.n_vertices)});
  table.add({"cells of the cut", format_count(made.n_cut_cells)});
  table.add({"extract", format_seconds(made.seconds)});
  table.add({input.was_built ? "read and build" : "open", format_seconds(input.open_seconds)});
  table.add({"write", format_seconds(made.write_seconds)});
  table.add({"output", job.output});
  outcome.text = table.to_string();
  return outcome;
}

Result<Outcome> run_mesh(const MeshJob& job, Session& session) {
  LODE_TRY(MeshOptions options, to_mesh_options(job.query, job.extraction));
  LODE_TRY(options.memory_limit, memory_limit_of(job));
  LODE_TRY(const Input input, open_input(session, job.input, job.reading));
  warn_of_limit(session, job.memory_limit, input);
  set_share(job.extraction.max_error, input.info.range_min, input.info.range_max,
            options.query.max_error);
  set_share(job.query.max_error_outside, input.info.range_min, input.info.range_max,
            options.query.max_error_outside);
  SimplexMesh mesh;
  LODE_TRY(const MeshReport report, input.dataset.extract_mesh(options, mesh, session.progress()));
  Made made = to_made(report, !options.query.max_error, report.n_cells);
  warn_of_boxes(options.query.boxes, input.info.volume.grid.world_bounds(), session);
  warn_of_shortcomings(session, made);
  if (mesh.is_empty()) session.warn("the mesh is empty: the data has no cell without a hole");
  const Stopwatch watch;
  LODE_CHECK(write_mesh(job.output, mesh,
                        {.comment = comment_of("mesh", input, made),
                         .frame = input.info.volume.grid.frame,
                         .value_name = input.info.volume.field_name,
                         .threads = session.threads()},
                        session.progress()));
  made.write_seconds = watch.seconds();
  Json counts;
  counts["largest_error"] = report.largest_error;
  counts["cells"] = report.n_cells;
  return report_outcome(job, input, made, counts, session);
}

void warn_of_section(Session& session, const MeshJob& job, const SectionOptions& options,
                     const Surface& section, const SectionReport& report) {
  if (options.isovalues.empty() && section.is_empty())
    session.warn("the section is empty: its plane meets no cell of the data");
  for (const double isovalue : report.unmet)
    session.warn(fmt::format("no line at isovalue {}: it meets nothing on the section", isovalue));
  if (!can_hold_values(job.output))
    session.warn(fmt::format("{}: values and errors are left out, which only .vtp and .ply hold",
                             job.output));
}

/// What a planar section cannot be made of, before a hierarchy is built.
Result<void> check_is_volume(const VolumeInfo& volume) {
  const Index3& dims = volume.grid.dims;
  if (dims[0] > 1 && dims[1] > 1 && dims[2] > 1) return {};
  return fail("--section: expected 3D data, got {} x {} x {} samples", dims[0], dims[1], dims[2]);
}

Result<Outcome> run_section(const MeshJob& job, Session& session) {
  LODE_TRY(SectionOptions options, to_section_options(job.query, job.extraction));
  LODE_TRY(options.memory_limit, memory_limit_of(job));
  LODE_TRY(const Input input, open_input(session, job.input, job.reading, check_is_volume));
  LODE_CHECK(check_is_volume(input.info.volume));
  warn_of_limit(session, job.memory_limit, input);
  set_share(job.extraction.max_error, input.info.range_min, input.info.range_max,
            options.max_error);
  Surface section;
  LODE_TRY(const SectionReport report,
           input.dataset.extract_section(options, section, session.progress()));
  Made made = to_made(report, !options.max_error, report.n_cut_cells);
  warn_of_shortcomings(session, made);
  warn_of_section(session, job, options, section, report);
  const Stopwatch watch;
  LODE_CHECK(write_surface(job.output, section,
                           {.comment = comment_of("section", input, made),
                            .frame = input.info.volume.grid.frame,
                            .value_name = input.info.volume.field_name,
                            .threads = session.threads()},
                           session.progress()));
  made.write_seconds = watch.seconds();
  Json counts;
  counts["triangles"] = report.n_triangles;
  counts["lines"] = report.n_lines;
  return report_outcome(job, input, made, counts, session);
}

}  // namespace

Result<void> check_mesh_job(const MeshJob& job) {
  if (job.query.is_boundary) return fail("--boundary: expected a mesh of cells, got {}", job.input);
  if (!job.query.opacity.empty())
    return fail("--opacity: expected a mesh of cells, got {}", job.input);
  if (!job.query.threshold.empty())
    return fail("--threshold: expected a mesh of cells, got {}", job.input);
  if (job.query.is_section() && job.query.sections.size() > 1)
    return fail("--section: expected one of a volume, got {}", job.query.sections.size());
  if (job.query.is_mesh) {
    LODE_CHECK(to_mesh_options(job.query, job.extraction));
    LODE_CHECK(check_mesh_path(job.output));
  } else {
    LODE_TRY(const SectionOptions options, to_section_options(job.query, job.extraction));
    LODE_CHECK(check_surface_extension(job.output));
    if (!options.isovalues.empty() && !can_hold_lines(job.output))
      return fail(
          "{}: expected a format that holds the isolines of a section: .vtp, .ply, .obj or "
          ".glb",
          job.output);
  }
  LODE_CHECK(check_reading_options(job.reading, job.input));
  return check_paths_differ({job.input}, {job.output});
}

Result<Outcome> run_mesh_job(const MeshJob& job, Session& session) {
  LODE_CHECK(check_writable(job.output));
  return job.query.is_mesh ? run_mesh(job, session) : run_section(job, session);
}

}  // namespace lode::cli

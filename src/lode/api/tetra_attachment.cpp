#include "lode/api/tetra_attachment.h"

#include <fmt/format.h>

#include <new>
#include <utility>
#include <vector>

#include "lode/api/tetra_info.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/models/tetra_mt/field_appender.h"
#include "lode/models/tetra_mt/measured_fields.h"
#include "lode/models/tetra_mt/midpoint/field_appender.h"
#include "lode/models/tetra_mt/midpoint/measured_fields.h"
#include "lode/models/tetra_mt/midpoint/persist.h"
#include "lode/models/tetra_mt/midpoint/reference_mesh.h"
#include "lode/models/tetra_mt/persist.h"

namespace lode {
namespace {

namespace midpoint = tetra_mt::midpoint;

/// `Head`: HierarchyHead, or ForestHead.
template <typename Head>
Result<void> check_new(const Head& head, const TetraStep& step) {
  if (step.mesh.fields.empty()) return fail("expected a field, got none");
  for (const MeshField& field : step.mesh.fields)
    for (const auto& old : head.fields)
      if (old.name == field.name && old.time == step.time)
        return fail("expected a field that the model has not got, or another time, got {}{}",
                    field.name, step.time ? fmt::format(" at {}", *step.time) : "");
  return {};
}

Result<void> attach_step(const tetra_mt::OpenedHierarchy& opened,
                         const std::vector<std::uint32_t>& mesh_vertices, const TetraStep& step,
                         Threads threads, tetra_mt::FieldAppender& appender, Progress& progress) {
  LODE_CHECK(check_same_mesh(opened.hierarchy, mesh_vertices, step.mesh, progress));
  LODE_CHECK(check_new(appender.head(), step));
  LODE_TRY(auto fields, measure_fields(opened.hierarchy, mesh_vertices, step.mesh, progress));
  for (std::size_t f = 0; f < fields.size(); ++f) {
    fields[f].time = step.time;
    LODE_CHECK(
        appender.append(fields[f], gradient_codes(step.mesh, f, mesh_vertices, threads), threads));
  }
  return {};
}

Result<void> attach_step(const midpoint::Forest& forest, const midpoint::ReferenceMesh& reference,
                         const TetraStep& step, Threads threads, midpoint::FieldAppender& appender,
                         Progress& progress) {
  LODE_TRY(const std::vector<std::uint32_t> mesh_vertices, reference.match(step.mesh));
  LODE_CHECK(check_new(appender.head(), step));
  LODE_TRY(auto fields, measure_fields(forest, mesh_vertices, step.mesh, threads, progress));
  for (midpoint::FieldRecords& field : fields) {
    field.head.time = step.time;
    LODE_CHECK(appender.append(std::move(field), threads, progress));
  }
  return {};
}

/// All steps, and then writes the file. `attach(step)`: one.
template <typename Appender, typename Attach>
Result<TetraAttachReport> attach_all(const NextTetraStep& next, Appender& appender,
                                     const Attach& attach, const Progress& progress) {
  TetraAttachReport report;
  while (true) {
    LODE_TRY(const std::optional<TetraStep> step, next());
    if (!step) break;
    const Result<void> attached = attach(*step);
    if (!attached && progress.is_cancelled()) return attached.error();
    if (!attached) return fail("{}: {}", step->source, attached.error().message);
    report.n_attached += step->mesh.fields.size();
    appender.add_notes(step->notes);
  }
  report.info = info_of(appender.head());
  LODE_TRY(report.file_bytes, appender.finish(progress));
  return report;
}

Result<TetraAttachReport> attach_to_half_edges(const std::string& model, const std::string& output,
                                               const NextTetraStep& next, Threads threads,
                                               Progress& progress) {
  LODE_TRY(const auto opened, tetra_mt::open(model));
  if (!opened.mesh_vertices)
    return fail(
        "{}: expected a file with the mesh's numbers of its vertices, which a lean one is without: "
        "build it again",
        model);
  LODE_TRY(const auto vertices, opened.mesh_vertices());
  LODE_TRY(auto appender,
           tetra_mt::FieldAppender::create(model, opened.hierarchy, output, progress));
  const auto attach = [&](const TetraStep& step) {
    return attach_step(opened, vertices, step, threads, appender, progress);
  };
  return attach_all(next, appender, attach, progress);
}

Result<TetraAttachReport> attach_to_midpoints(const std::string& model, const std::string& output,
                                              const NextTetraStep& next, Threads threads,
                                              Progress& progress) {
  LODE_TRY(const auto opened, midpoint::open(model));
  LODE_TRY(const auto coincident, opened.coincident_leaves());
  const auto reference = midpoint::ReferenceMesh::of(opened.forest, coincident, progress);
  LODE_CHECK(opened.forest.check());
  if (!reference && progress.is_cancelled()) return reference.error();
  if (!reference) return fail("{}: {}", model, reference.error().message);
  LODE_TRY(auto appender, midpoint::FieldAppender::create(model, opened.forest, output, progress));
  const auto attach = [&](const TetraStep& step) {
    return attach_step(opened.forest, *reference, step, threads, appender, progress);
  };
  return attach_all(next, appender, attach, progress);
}

}  // namespace

Result<TetraAttachReport> attach_fields(const std::string& model, const std::string& output,
                                        const NextTetraStep& next, Threads threads,
                                        Progress& progress) try {
  const Stopwatch watch;
  const bool is_of_midpoints = midpoint::is_model_of(model);
  auto report = is_of_midpoints ? attach_to_midpoints(model, output, next, threads, progress)
                                : attach_to_half_edges(model, output, next, threads, progress);
  if (report) report->seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("attach the fields");
}

}  // namespace lode

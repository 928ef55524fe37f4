#include "lode/api/tetra_attachment.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <vector>

#include "lode/api/tetra_info.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/models/tetra_mt/field_appender.h"
#include "lode/models/tetra_mt/measured_fields.h"
#include "lode/models/tetra_mt/midpoint/persist.h"
#include "lode/models/tetra_mt/persist.h"

namespace lode {
namespace {

Result<void> check_new(const tetra_mt::HierarchyHead& head, const TetraStep& step) {
  if (step.mesh.fields.empty()) return fail("expected a field, got none");
  for (const MeshField& field : step.mesh.fields)
    for (const tetra_mt::HierarchyHead::Field& old : head.fields)
      if (old.name == field.name && old.time == step.time)
        return fail("expected a field that the model has not got, or another time, got {}{}",
                    field.name, step.time ? fmt::format(" at {}", *step.time) : "");
  return {};
}

Result<void> attach_step(const tetra_mt::OpenedHierarchy& opened,
                         const std::vector<std::uint32_t>& mesh_vertices, const TetraStep& step,
                         Threads threads, tetra_mt::FieldAppender& appender, Progress& progress) {
  LODE_CHECK(check_new(appender.head(), step));
  LODE_CHECK(check_same_mesh(opened.hierarchy, mesh_vertices, step.mesh, progress));
  LODE_TRY(auto fields, measure_fields(opened.hierarchy, mesh_vertices, step.mesh, progress));
  for (std::size_t f = 0; f < fields.size(); ++f) {
    fields[f].time = step.time;
    LODE_CHECK(
        appender.append(fields[f], gradient_codes(step.mesh, f, mesh_vertices, threads), threads));
  }
  return {};
}

}  // namespace

Result<TetraAttachReport> attach_fields(const std::string& model, const std::string& output,
                                        const NextTetraStep& next, Threads threads,
                                        Progress& progress) try {
  const Stopwatch watch;
  if (tetra_mt::midpoint::is_model_of(model))
    return fail(
        "{}: expected half edges, whose vertices are the mesh's, so that other fields have values "
        "there, got midpoints",
        model);
  LODE_TRY(const auto opened, tetra_mt::open(model));
  auto vertices = opened.mesh_vertices();
  if (!vertices) return vertices.error();
  LODE_TRY(auto appender,
           tetra_mt::FieldAppender::create(model, opened.hierarchy, output, progress));
  TetraAttachReport report;
  while (true) {
    LODE_TRY(const std::optional<TetraStep> step, next());
    if (!step) break;
    auto attached = attach_step(opened, *vertices, *step, threads, appender, progress);
    if (!attached && progress.is_cancelled()) return attached.error();
    if (!attached) return fail("{}: {}", step->source, attached.error().message);
    report.n_attached += step->mesh.fields.size();
  }
  report.info = info_of(appender.head());
  LODE_TRY(report.file_bytes, appender.finish(progress));
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("attach the fields");
}

}  // namespace lode

#include "lode/api/tetra_build.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "lode/api/tetra_info.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/models/tetra_mt/everywhere_errors.h"
#include "lode/models/tetra_mt/file_layout.h"
#include "lode/models/tetra_mt/midpoint/edge_collapses.h"
#include "lode/models/tetra_mt/midpoint/persist.h"
#include "lode/models/tetra_mt/persist.h"

namespace lode {
namespace {

/// Of collapses of either kind.
template <typename Collapses>
tetra_mt::BuildRecord record_of(const TetraBuildOptions& options, const Collapses& collapses) {
  return {.order = options.order,
          .keeps_extrema = options.keeps_extrema,
          .boundary_tolerance = options.boundary_tolerance,
          .volume_change = collapses.volume_change,
          .refusals = named(collapses.refusals),
          .reading = options.reading,
          .notes = options.notes};
}

std::uint64_t base_cells_of(const TetraMesh& mesh, const TetraBuildOptions& options) {
  return static_cast<std::uint64_t>(std::clamp(options.base_share, 0.0, 1.0) *
                                    static_cast<double>(mesh.tetrahedra.size()));
}

Result<void> check_n_fields(const TetraMesh& mesh) {
  if (!mesh.fields.empty() && mesh.fields.size() <= tetra_mt::kMaxFields) return {};
  return fail("expected 1 to {} fields, got {}", tetra_mt::kMaxFields, mesh.fields.size());
}

Result<void> check_time(const TetraBuildOptions& options) {
  if (!options.time || std::isfinite(*options.time)) return {};
  return fail("time: expected a finite number, got {}", *options.time);
}

Result<void> check_memory(const TetraMesh& mesh, const TetraBuildOptions& options) {
  const std::uint64_t n_bytes = memory_to_build(mesh, options);
  if (options.memory_limit == 0 || n_bytes <= options.memory_limit) return {};
  return fail("expected {} MiB of memory to build a mesh of {} cells, got a limit of {:.4g} MiB",
              (n_bytes >> 20) + 1, mesh.tetrahedra.size(),
              static_cast<double>(options.memory_limit) / (1 << 20));
}

}  // namespace

std::uint64_t memory_to_build(const TetraMesh& mesh, const TetraBuildOptions& options) {
  constexpr std::uint64_t kFixed = 16U << 20;
  constexpr std::uint64_t kCell = 200;
  constexpr std::uint64_t kOverlay = 40;
  constexpr std::uint64_t kValue = 80;
  constexpr std::uint64_t kQuadric = 120;
  constexpr std::uint64_t kMidpoint = 50;
  constexpr std::uint64_t kWorldError = 16;
  const bool is_everywhere = options.error_place == ErrorPlace::everywhere;
  const std::uint64_t n_more = std::max<std::size_t>(mesh.fields.size(), 1) - 1;
  const std::uint64_t each = kValue + (options.order == CollapseOrder::quadric ? kQuadric : 0) +
                             (options.placement == Placement::midpoint ? kMidpoint : 0);
  return kFixed + mesh.tetrahedra.size() * (kCell + (is_everywhere ? kOverlay : 0)) +
         mesh.positions.size() *
             (n_more * each + (options.has_world_errors ? (n_more + 1) * kWorldError : 0));
}

Result<tetra_mt::HalfEdgeCollapses> collapse_mesh(const TetraMesh& mesh,
                                                  const TetraBuildOptions& options,
                                                  Progress& progress) {
  LODE_CHECK(check_n_fields(mesh));
  LODE_CHECK(check_time(options));
  LODE_CHECK(check_memory(mesh, options));
  const bool is_everywhere = options.error_place == ErrorPlace::everywhere;
  if (is_everywhere && options.boundary_tolerance > 0)
    return fail(
        "boundary tolerance: expected 0 where errors hold everywhere, as nothing is known of what "
        "is outside, got {}",
        options.boundary_tolerance);
  LODE_TRY(auto collapses, tetra_mt::collapse_half_edges(
                               mesh,
                               {.base_cells = base_cells_of(mesh, options),
                                .rules = {.order = options.order,
                                          .boundary_tolerance = options.boundary_tolerance,
                                          .has_world_errors = options.has_world_errors,
                                          .keeps_extrema = options.keeps_extrema},
                                .threads = options.threads},
                               progress));
  if (is_everywhere)
    LODE_CHECK(make_errors_hold_everywhere(mesh, collapses, options.threads, progress));
  return collapses;
}

Result<tetra_mt::Hierarchy> build_hierarchy(const TetraMesh& mesh, const TetraBuildOptions& options,
                                            Progress& progress) {
  LODE_TRY(const auto collapses, collapse_mesh(mesh, options, progress));
  LODE_TRY(auto hierarchy, tetra_mt::make_hierarchy(mesh, collapses, options.threads));
  hierarchy.time = options.time;
  hierarchy.record = record_of(options, collapses);
  return hierarchy;
}

Result<tetra_mt::midpoint::Hierarchy> build_midpoints(const TetraMesh& mesh,
                                                      const TetraBuildOptions& options,
                                                      Progress& progress) {
  if (options.error_place == ErrorPlace::everywhere)
    return fail("midpoints: expected errors at samples, got errors everywhere");
  if (options.keeps_extrema)
    return fail(
        "midpoints: expected extrema of the mesh as it is to stay, got those of the reference");
  LODE_CHECK(check_n_fields(mesh));
  LODE_CHECK(check_time(options));
  LODE_CHECK(check_memory(mesh, options));
  LODE_TRY(const auto collapses,
           tetra_mt::midpoint::collapse_edges(mesh,
                                              {.base_cells = base_cells_of(mesh, options),
                                               .order = options.order,
                                               .boundary_tolerance = options.boundary_tolerance,
                                               .has_world_errors = options.has_world_errors,
                                               .threads = options.threads},
                                              progress));
  LODE_TRY(auto hierarchy, tetra_mt::midpoint::make_hierarchy(mesh, collapses, options.threads));
  for (tetra_mt::midpoint::ForestField& field : hierarchy.fields) field.time = options.time;
  hierarchy.record = record_of(options, collapses);
  return hierarchy;
}

namespace {

Result<TetraFileReport> build_midpoint_file(const TetraMesh& mesh, const std::string& path,
                                            const TetraBuildOptions& options, Progress& progress) {
  const Stopwatch watch;
  LODE_TRY(const auto made, build_midpoints(mesh, options, progress));
  TetraFileReport report;
  report.build_seconds = watch.seconds();
  report.info = info_of(made);
  const Stopwatch write_watch;
  LODE_TRY(report.file_bytes, tetra_mt::midpoint::save(made, path, options.threads, progress));
  report.write_seconds = write_watch.seconds();
  return report;
}

}  // namespace

Result<TetraFileReport> TetraDataset::build_file(const TetraMesh& mesh, const std::string& path,
                                                 const TetraBuildOptions& options,
                                                 Progress& progress) try {
  if (options.placement == Placement::midpoint && options.is_lean)
    return fail("a lean file: expected half edges, as midpoints have no more than that");
  if (options.placement == Placement::midpoint)
    return build_midpoint_file(mesh, path, options, progress);
  const Stopwatch watch;
  LODE_TRY(const auto hierarchy, build_hierarchy(mesh, options, progress));
  TetraFileReport report;
  report.build_seconds = watch.seconds();
  report.info = info_of(head_of(hierarchy, mesh.tetrahedra.size()));
  report.info.is_lean = options.is_lean;
  const Stopwatch write_watch;
  tetra_mt::GradientsOf gradients;
  if (!options.is_lean)
    gradients = [&](std::size_t field) {
      return gradient_codes(mesh, field, hierarchy.mesh_vertices, options.threads);
    };
  LODE_TRY(report.file_bytes, tetra_mt::save(hierarchy, mesh.tetrahedra.size(), gradients, path,
                                             options.threads, progress));
  report.write_seconds = write_watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("build the hierarchy");
}

}  // namespace lode

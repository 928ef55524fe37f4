#include "lode/api/mesh_extraction.h"

#include <algorithm>
#include <limits>
#include <new>
#include <span>
#include <utility>

#include "lode/api/dataset_impl.h"
#include "lode/api/file_build.h"
#include "lode/api/finishing.h"
#include "lode/api/opened_nodes.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/mappers/surface_edits.h"
#include "lode/models/diamond/cut_mesh.h"
#include "lode/models/diamond/query_cut.h"

namespace lode {
namespace {

/// Whether what is in focus is refined where the data ends.
enum class AtBorder : std::uint8_t { clipped, refined };

/// A query's demand for what is cut out of meshes. Bounds are a little wider than they are, for
/// planes that touch them only.
struct MeshDemand {
  Demand demand;
  AtBorder at_border = AtBorder::clipped;
  double widening = 0;  ///< World units.

  [[nodiscard]] double operator()(const NodeFacts& node) const { return demand(changed(node)); }
  [[nodiscard]] bool touches(const NodeFacts& node) const { return demand.touches(changed(node)); }

 private:
  [[nodiscard]] NodeFacts changed(NodeFacts node) const {
    node.is_at_border = node.is_at_border && at_border == AtBorder::refined;
    node.bounds.radius += widening;
    return node;
  }
};

template <typename Field>
Result<Query> complete_query(const Field& model, Query query) {
  if (query.max_world_error)
    return fail("max world error: expected none of a volume, which has distances of surfaces");
  if (query.view || query.max_error_px)
    return fail("meshes: expected a tolerance in field units and no view, got a view or pixels");
  if (!query.max_error)
    query.max_error = query.budget.is_limited() ? 0 : default_tolerance(model.stats);
  LODE_CHECK(check_query(query));
  return query;
}

bool has_focus(const Query& query) {
  return !(query.isovalues.empty() && query.field_ranges.empty() && query.opacity.empty() &&
           query.boxes.empty() && query.balls.empty() && query.half_spaces.empty() &&
           query.sections.empty());
}

/// What is known without looking: the whole mesh at full resolution.
template <int D, typename Field>
Result<void> check_full_size(const Field& model, const Query& query) {
  const bool wants_all = *query.max_error == 0 && !has_focus(query);
  const bool wants_all_outside = query.max_error_outside && *query.max_error_outside == 0;
  if (query.budget.is_limited() || !(wants_all || wants_all_outside)) return {};
  double n = D == 3 ? 6 : 2;
  for (const std::int32_t dim : model.shape.dims.v) n *= dim - 1;
  if (n <= static_cast<double>(kMaxMeshCells)) return {};
  return fail(
      "expected a query whose mesh has at most {} cells, but at full resolution this data has "
      "{:.0f}: a larger tolerance, a focus or a budget of cells makes it smaller",
      kMaxMeshCells, n);
}

Demand mesh_demand(Query query) {
  const std::optional<double> outside = std::exchange(query.max_error_outside, std::nullopt);
  Demand demand = to_demand(query);
  if (outside) demand = max_of({std::move(demand), uniform_demand(*outside)});
  return MeshDemand{std::move(demand)};
}

/// Touches what is in focus, whatever holds outside.
Demand mesh_focus(Query query) {
  query.max_error_outside.reset();
  return MeshDemand{to_demand(query)};
}

/// One cut's mesh.
template <int D, typename Nodes>
Result<MeshReport> mesh_of_query(Nodes& opened, const Query& query, std::uint64_t memory_limit,
                                 SimplexMesh& mesh, Progress& progress) {
  MeshReport report{.max_error = *query.max_error};
  LODE_CHECK(diamond::with_cut<D>(
      opened, {mesh_demand(query), query.budget, kMaxMeshCells, memory_limit / 2}, progress,
      [&](const Cut& cut, const diamond::QueryCutReport& found) -> Result<void> {
        LODE_TRY(const auto made,
                 diamond::mesh_of_cut<D>(opened, cut,
                                         {.focus = mesh_focus(query), .n_expected = found.n_cells},
                                         mesh, progress));
        report.achieved_error = made.achieved_error;
        report.largest_error = made.largest_error;
        report.n_left_out = made.n_left_out;
        report.n_cut_cells = found.n_cells;
        report.budget_met = found.budget_met;
        report.memory_met = found.memory_met;
        return {};
      }));
  report.n_cells = mesh.n_cells();
  report.n_vertices = mesh.positions.size();
  return report;
}

/// The engine counts simplices of the cut, of which the border makes more cells, or fewer: where
/// there are too many of these the cut is to be smaller, by as much as they are too many.
template <int D, typename Nodes>
Result<MeshReport> extract_model_mesh(Nodes& opened, const MeshOptions& options, SimplexMesh& mesh,
                                      Progress& progress) {
  LODE_TRY(Query query, complete_query(opened.model(), options.query));
  LODE_CHECK(check_full_size<D>(opened.model(), query));
  const std::uint64_t most = query.budget.max_cells;
  while (true) {
    LODE_TRY(MeshReport report,
             mesh_of_query<D>(opened, query, options.memory_limit, mesh, progress));
    if (report.n_cells <= most || !report.budget_met) {
      report.budget_met = report.n_cells <= most;
      return report;
    }
    const double share = static_cast<double>(most) / static_cast<double>(report.n_cells);
    const auto n = static_cast<std::uint64_t>(share * static_cast<double>(report.n_cut_cells));
    query.budget.max_cells = std::max<std::uint64_t>(1, std::min(n, report.n_cut_cells - 1));
  }
}

Query section_query(const SectionOptions& options) {
  Query query;
  query.isovalues = options.isovalues;
  query.field_ranges = options.field_ranges;
  query.sections = {{options.plane.point, options.plane.normal}};
  query.max_error = options.max_error;
  query.budget = options.budget;
  return query;
}

/// Simplices that come so near a plane.
struct NearPlane {
  Vec3d point;
  Vec3d normal;         ///< Unit length.
  double distance = 0;  ///< World units.

  [[nodiscard]] bool operator()(std::span<const Vec3d> corners) const {
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -lowest;
    for (const Vec3d& p : corners) {
      const double d = dot(normal, p - point);
      lowest = std::min(lowest, d);
      highest = std::max(highest, d);
    }
    return lowest <= distance && highest >= -distance;
  }
};

/// Triangles, or lines on them, from the cells that meet the plane.
void fill_section(const SimplexMesh& mesh, const SectionOptions& options,
                  const SectionRounding& rounding, Surface& section, SectionReport& report) {
  Surface triangles = cut_section(mesh, options.plane, rounding);
  section.clear();
  double largest_error = 0;
  for (const double isovalue : options.isovalues)
    largest_error =
        std::max(largest_error, add_isolines(triangles, isovalue, rounding.margin, section));
  if (options.isovalues.empty()) {
    for (const float error : triangles.errors)
      largest_error = std::max(largest_error, static_cast<double>(error));
    section = std::move(triangles);
  }
  report.achieved_error = std::min(report.achieved_error, largest_error);
  report.n_triangles = section.triangles.size();
  report.n_lines = section.lines.size();
  report.n_vertices = section.positions.size();
}

/// As isosurfaces, isolines are refined where the data ends, and come from cells in focus only: F'
/// may take a value in others that F has not, at corners beyond the data.
template <typename Nodes>
Result<SectionReport> extract_model_section(Nodes& opened, const SectionOptions& options,
                                            Surface& section, Progress& progress) {
  const auto& model = opened.model();
  LODE_TRY(const Query query, complete_query(model, section_query(options)));
  const bool is_lines = !options.isovalues.empty();
  const SectionRounding rounding =
      section_rounding(LatticeFrame::of(model.info.grid), options.plane.normal);
  const Demand demand =
      MeshDemand{to_demand(query), is_lines ? AtBorder::refined : AtBorder::clipped, rounding.snap};
  const diamond::CutMeshOptions mesh_options{
      .focus = demand,
      .only_focus = is_lines,
      .is_near = NearPlane{options.plane.point, normalized(options.plane.normal), rounding.snap}};
  SectionReport report{.max_error = *query.max_error};
  SimplexMesh mesh;
  LODE_CHECK(diamond::with_cut<3>(
      opened, {demand, query.budget, kMaxMeshCells, options.memory_limit / 2}, progress,
      [&](const Cut& cut, const diamond::QueryCutReport& found) -> Result<void> {
        LODE_TRY(const auto made,
                 diamond::mesh_of_cut<3>(opened, cut, mesh_options, mesh, progress));
        report.achieved_error = made.achieved_error;
        report.n_left_out = made.n_left_out;
        report.n_cut_cells = found.n_cells;
        report.budget_met = found.budget_met;
        report.memory_met = found.memory_met;
        return {};
      }));
  fill_section(mesh, options, rounding, section, report);
  if (model.has_holes()) split_pinched_vertices(section);
  report.n_vertices = section.positions.size();
  return report;
}

}  // namespace

Result<MeshReport> Dataset::extract_mesh(const MeshOptions& options, SimplexMesh& mesh,
                                         Progress& progress) const try {
  const Stopwatch watch;
  const bool reads_little = has_focus(options.query) || options.query.budget.is_limited();
  LODE_TRY(MeshReport report, with_nodes(*impl_, options.memory_limit, reads_little, progress,
                                         [&](auto& nodes) -> Result<MeshReport> {
                                           constexpr int kD = decltype(dimension_of(nodes))::value;
                                           return extract_model_mesh<kD>(nodes, options, mesh,
                                                                         progress);
                                         }));
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the mesh");
}

Result<SectionReport> Dataset::extract_section(const SectionOptions& options, Surface& section,
                                               Progress& progress) const try {
  if (impl_->is_flat())
    return fail(
        "a section: expected a volume (diamond3d), got 2D data: its contour lines come "
        "from its isovalues alone");
  const Stopwatch watch;
  LODE_TRY(SectionReport report,
           with_nodes(*impl_, options.memory_limit, true, progress,
                      [&](auto& nodes) -> Result<SectionReport> {
                        if constexpr (decltype(dimension_of(nodes))::value == 3)
                          return extract_model_section(nodes, options, section, progress);
                        else
                          return fail("a section: expected a volume");
                      }));
  report.unmet = unmet_isovalues(section, options.isovalues);
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the section");
}

}  // namespace lode

#include "lode/api/mesh_extraction.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "lode/api/dataset_impl.h"
#include "lode/api/finishing.h"
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

class Clock {
 public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

template <int D>
Result<Query> complete_query(const diamond::Model<D>& model, Query query) {
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
template <int D>
Result<void> check_full_size(const diamond::Model<D>& model, const Query& query) {
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

template <int D>
Result<MeshReport> extract_model_mesh(const diamond::Model<D>& model, const MeshOptions& options,
                                      SimplexMesh& mesh, Progress& progress) {
  LODE_TRY(const Query query, complete_query<D>(model, options.query));
  LODE_CHECK(check_full_size<D>(model, query));
  const diamond::Refinable<D> opened(model);
  MeshReport report{.max_error = *query.max_error};
  LODE_CHECK(diamond::with_cut<D>(
      opened, {mesh_demand(query), query.budget, kMaxMeshCells}, progress,
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
        return {};
      }));
  report.n_cells = mesh.n_cells();
  report.n_vertices = mesh.positions.size();
  return report;
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

/// Triangles, or lines on them, from the cells that meet the plane.
void fill_section(const SimplexMesh& mesh, const SectionOptions& options, const LatticeFrame& frame,
                  Surface& section, SectionReport& report) {
  Surface triangles = cut_section(mesh, options.plane, frame);
  section.clear();
  double largest_error = 0;
  for (const double isovalue : options.isovalues)
    largest_error = std::max(largest_error, add_isolines(triangles, isovalue, frame, section));
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
Result<SectionReport> extract_model_section(const diamond::Model<3>& model,
                                            const SectionOptions& options, Surface& section,
                                            Progress& progress) {
  LODE_TRY(const Query query, complete_query<3>(model, section_query(options)));
  const bool is_lines = !options.isovalues.empty();
  const LatticeFrame frame = LatticeFrame::of(model.info.grid);
  const double snap = snap_distance(frame, options.plane.normal);
  const Demand demand =
      MeshDemand{to_demand(query), is_lines ? AtBorder::refined : AtBorder::clipped, snap};
  const diamond::NearPlane near{options.plane.point, normalized(options.plane.normal), snap};
  const diamond::CutMeshOptions mesh_options{.focus = demand, .only_focus = is_lines, .near = near};
  const diamond::Refinable<3> opened(model);
  SectionReport report{.max_error = *query.max_error};
  SimplexMesh mesh;
  LODE_CHECK(diamond::with_cut<3>(
      opened, {demand, query.budget, kMaxMeshCells}, progress,
      [&](const Cut& cut, const diamond::QueryCutReport& found) -> Result<void> {
        LODE_TRY(const auto made,
                 diamond::mesh_of_cut<3>(opened, cut, mesh_options, mesh, progress));
        report.achieved_error = made.achieved_error;
        report.n_left_out = made.n_left_out;
        report.n_cut_cells = found.n_cells;
        report.budget_met = found.budget_met;
        return {};
      }));
  fill_section(mesh, options, frame, section, report);
  if (model.has_holes()) split_pinched_vertices(section);
  report.n_vertices = section.positions.size();
  return report;
}

}  // namespace

Result<MeshReport> Dataset::extract_mesh(const MeshOptions& options, SimplexMesh& mesh,
                                         Progress& progress) const {
  LODE_TRY(const auto* const held, impl_->model(progress));
  const Clock clock;
  LODE_TRY(MeshReport report, std::visit(
                                  [&]<int D>(const diamond::Model<D>& model) {
                                    return extract_model_mesh<D>(model, options, mesh, progress);
                                  },
                                  *held));
  report.seconds = clock.seconds();
  return report;
}

Result<SectionReport> Dataset::extract_section(const SectionOptions& options, Surface& section,
                                               Progress& progress) const {
  if (impl_->is_flat())
    return fail(
        "a section: expected a volume (diamond3d), got 2D data: its contour lines come "
        "from its isovalues alone");
  LODE_TRY(const auto* const held, impl_->model(progress));
  const Clock clock;
  LODE_TRY(SectionReport report,
           extract_model_section(std::get<diamond::Model<3>>(*held), options, section, progress));
  report.unmet = unmet_isovalues(section, options.isovalues);
  report.seconds = clock.seconds();
  return report;
}

}  // namespace lode

#include "lode/api/tetra_dataset.h"

#include <algorithm>
#include <new>
#include <optional>
#include <utility>

#include "lode/api/finishing.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/mappers/mesh_isosurface.h"
#include "lode/models/tetra_mt/tetra_cut.h"
#include "lode/refine/engine.h"

namespace lode {
namespace {

using tetra_mt::Hierarchy;
using tetra_mt::kNone;
using tetra_mt::TetraCut;

/// As for volumes.
constexpr double kShareOfRange = 0.005;

Result<Query> complete_query(const TetraInfo& info, Query query) {
  if (query.view || query.max_error_px)
    return fail("meshes: expected a tolerance in field units and no view, got a view or pixels");
  if (!query.max_error)
    query.max_error =
        query.budget.is_limited() ? 0 : kShareOfRange * (info.range_max - info.range_min);
  LODE_CHECK(check_query(query));
  return query;
}

Demand demand_of(Query query) {
  const std::optional<double> outside = std::exchange(query.max_error_outside, std::nullopt);
  Demand demand = to_demand(query);
  if (outside) demand = max_of({std::move(demand), uniform_demand(*outside)});
  return demand;
}

double base_error_of(const Hierarchy& hierarchy) {
  double largest = 0;
  for (const std::uint32_t maker : hierarchy.base_makers)
    if (maker != kNone)
      largest = std::max(largest, static_cast<double>(hierarchy.facts[maker].error));
  return largest;
}

/// What positions of surfaces are relative to: nothing, unless the mesh is so far away that float32
/// loses more than a millionth of its size.
Vec3d origin_of(const Hierarchy& hierarchy) {
  if (hierarchy.positions.empty()) return {};
  Vec3d lower = hierarchy.positions[0];
  Vec3d upper = lower;
  for (const Vec3d& p : hierarchy.positions)
    for (std::size_t i = 0; i < 3; ++i) {
      lower[i] = std::min(lower[i], p[i]);
      upper[i] = std::max(upper[i], p[i]);
    }
  constexpr double kFar = 16;
  const bool is_far = length(lower) + length(upper) > kFar * length(upper - lower);
  return is_far ? lower : Vec3d();
}

/// Cells of a cut, their vertices numbered in the order of the hierarchy's.
void fill_mesh(const Hierarchy& hierarchy, const TetraCut& cut, SimplexMesh& mesh) {
  mesh = {};
  std::vector<std::uint32_t> numbers(hierarchy.positions.size(), kNone);
  const std::uint32_t outside = hierarchy.outside();
  for (std::size_t slot = 0; slot < cut.slots().size(); ++slot) {
    const auto& t = cut.slots()[slot];
    if (t[0] == kNone || std::ranges::find(t, outside) != t.end()) continue;
    mesh.tetrahedra.push_back(t);
    const std::uint32_t maker = cut.makers()[slot];
    mesh.errors.push_back(maker == kNone ? 0 : hierarchy.facts[maker].error);
    for (const std::uint32_t v : t) numbers[v] = 0;
  }
  std::uint32_t n = 0;
  for (std::uint32_t v = 0; v < numbers.size(); ++v) {
    if (numbers[v] == kNone) continue;
    numbers[v] = n++;
    mesh.positions.push_back(hierarchy.positions[v]);
    mesh.values.push_back(hierarchy.fields[0].values[v]);
  }
  for (auto& t : mesh.tetrahedra)
    for (std::uint32_t& v : t) v = numbers[v];
  mesh.has_narrow_values = std::ranges::all_of(mesh.values, [](double value) {
    return static_cast<double>(static_cast<float>(value)) == value;
  });
}

}  // namespace

class TetraDataset::Impl {
 public:
  Impl(Hierarchy built, TetraInfo known)
      : hierarchy(std::move(built)), info(std::move(known)), surface_origin(origin_of(hierarchy)) {}

  Hierarchy hierarchy;
  TetraInfo info;
  Vec3d surface_origin;
};

TetraDataset::TetraDataset(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TetraDataset::TetraDataset(TetraDataset&&) noexcept = default;
TetraDataset& TetraDataset::operator=(TetraDataset&&) noexcept = default;
TetraDataset::~TetraDataset() = default;

const TetraInfo& TetraDataset::describe() const { return impl_->info; }

Result<TetraDataset> TetraDataset::build(const TetraMesh& mesh, const TetraBuildOptions& options,
                                         Progress& progress) try {
  if (mesh.fields.size() != 1) return fail("expected one field, got {}", mesh.fields.size());
  const auto base_cells = static_cast<std::uint64_t>(std::clamp(options.base_share, 0.0, 1.0) *
                                                     static_cast<double>(mesh.tetrahedra.size()));
  LODE_TRY(
      const auto collapses,
      tetra_mt::collapse_half_edges(
          mesh, {.base_cells = base_cells, .rules = {}, .threads = options.threads}, progress));
  LODE_TRY(auto hierarchy, tetra_mt::make_hierarchy(mesh, collapses, options.threads));
  const std::vector<double>& values = hierarchy.fields[0].values;
  TetraInfo info{.n_vertices = hierarchy.positions.size(),
                 .n_cells = mesh.tetrahedra.size(),
                 .n_base_cells = hierarchy.n_base_cells,
                 .n_nodes = hierarchy.n_nodes(),
                 .field = hierarchy.fields[0].name,
                 .range_min = values.empty() ? 0 : std::ranges::min(values),
                 .range_max = values.empty() ? 0 : std::ranges::max(values),
                 .base_error = base_error_of(hierarchy)};
  return TetraDataset(std::make_unique<Impl>(std::move(hierarchy), std::move(info)));
} catch (const std::bad_alloc&) {
  return out_of_memory("build the hierarchy");
}

Result<MeshReport> TetraDataset::extract_mesh(const MeshOptions& options, SimplexMesh& mesh,
                                              Progress& progress) const try {
  const Stopwatch watch;
  LODE_TRY(const Query query, complete_query(impl_->info, options.query));
  TetraCut cut(impl_->hierarchy);
  Engine<TetraCut> engine(cut);
  engine.set_query(demand_of(query), query.budget);
  engine.run([&] { return progress.is_cancelled(); });
  if (progress.is_cancelled()) return cancelled_error();
  const Standing standing = engine.standing();
  fill_mesh(impl_->hierarchy, cut, mesh);
  MeshReport report{
      .max_error = *query.max_error,
      .achieved_error = engine.largest([](const NodeFacts& facts) { return facts.error; }),
      .n_cells = mesh.n_cells(),
      .n_cut_cells = standing.n_cells,
      .n_vertices = mesh.positions.size(),
      .budget_met = standing.budget_met};
  for (const float error : mesh.errors)
    report.largest_error = std::max(report.largest_error, static_cast<double>(error));
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the mesh");
}

Result<TetraSurfaceReport> TetraDataset::extract_surface(const MeshOptions& options,
                                                         Surface& surface, Progress& progress) const
    try {
  const Stopwatch watch;
  const std::vector<double>& isovalues = options.query.isovalues;
  if (isovalues.empty()) return fail("isosurfaces: expected isovalues, got none");
  SimplexMesh mesh;
  LODE_TRY(const MeshReport made, extract_mesh(options, mesh, progress));
  surface.clear();
  surface.origin = impl_->surface_origin;
  const double margin = rounding_margin(mesh, surface.origin);
  TetraSurfaceReport report{
      .max_error = made.max_error, .n_cut_cells = made.n_cut_cells, .budget_met = made.budget_met};
  for (const double isovalue : isovalues)
    report.achieved_error =
        std::max(report.achieved_error, add_isosurface(mesh, isovalue, margin, surface));
  report.n_triangles = surface.triangles.size();
  report.n_vertices = surface.positions.size();
  report.unmet = unmet_isovalues(surface, isovalues);
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the surface");
}

}  // namespace lode

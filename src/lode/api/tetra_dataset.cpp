#include "lode/api/tetra_dataset.h"

#include <algorithm>
#include <new>
#include <optional>
#include <utility>

#include "lode/api/finishing.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/mappers/mesh_isosurface.h"
#include "lode/models/tetra_mt/persist.h"
#include "lode/models/tetra_mt/tetra_cut.h"
#include "lode/refine/engine.h"

namespace lode {
namespace {

using tetra_mt::Hierarchy;
using tetra_mt::HierarchyHead;
using tetra_mt::kNone;
using tetra_mt::PackedHierarchy;
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

/// What positions of surfaces are relative to: nothing, unless the mesh is so far away that float32
/// loses more than a millionth of its size.
Vec3d origin_of(const HierarchyHead& head) {
  constexpr double kFar = 16;
  const bool is_far =
      length(head.lower) + length(head.upper) > kFar * length(head.upper - head.lower);
  return is_far ? head.lower : Vec3d();
}

/// Cells of a cut, their vertices numbered in the order of the hierarchy's.
void fill_mesh(const PackedHierarchy& hierarchy, const TetraCut& cut, SimplexMesh& mesh) {
  mesh = {};
  std::vector<std::uint32_t> numbers(hierarchy.head().n_vertices(), kNone);
  for (const TetraCut::Cell& cell : cut.slots()) {
    if (!cut.is_inside(cell)) continue;
    mesh.tetrahedra.push_back(cell.corners);
    mesh.errors.push_back(cell.maker == kNone ? 0 : hierarchy.facts(cell.maker, 0).error);
    for (const std::uint32_t v : cell.corners) numbers[v] = 0;
  }
  std::uint32_t n = 0;
  for (std::uint32_t v = 0; v < numbers.size(); ++v) {
    if (numbers[v] == kNone) continue;
    numbers[v] = n++;
    mesh.positions.push_back(hierarchy.position(v));
    mesh.values.push_back(hierarchy.value(v, 0));
  }
  for (auto& t : mesh.tetrahedra)
    for (std::uint32_t& v : t) v = numbers[v];
  mesh.has_narrow_values = std::ranges::all_of(mesh.values, [](double value) {
    return static_cast<double>(static_cast<float>(value)) == value;
  });
}

TetraInfo info_of(const HierarchyHead& head) {
  const HierarchyHead::Field& field = head.fields[0];
  return {.n_vertices = head.n_vertices(),
          .n_cells = head.n_cells,
          .n_base_cells = head.n_base_cells,
          .n_nodes = head.shape.n_nodes,
          .field = field.name,
          .type = field.type,
          .range_min = field.scale.knots().front(),
          .range_max = field.scale.knots().back(),
          .base_error = field.base_error,
          .bounds = {head.lower, head.upper}};
}

Result<Hierarchy> make_hierarchy_of(const TetraMesh& mesh, const TetraBuildOptions& options,
                                    Progress& progress) {
  if (mesh.fields.size() != 1) return fail("expected one field, got {}", mesh.fields.size());
  const auto base_cells = static_cast<std::uint64_t>(std::clamp(options.base_share, 0.0, 1.0) *
                                                     static_cast<double>(mesh.tetrahedra.size()));
  LODE_TRY(
      const auto collapses,
      tetra_mt::collapse_half_edges(
          mesh, {.base_cells = base_cells, .rules = {}, .threads = options.threads}, progress));
  return tetra_mt::make_hierarchy(mesh, collapses, options.threads);
}

}  // namespace

class TetraDataset::Impl {
 public:
  explicit Impl(PackedHierarchy packed, std::function<tetra_mt::FileReads()> reads_of = {})
      : hierarchy(std::move(packed)),
        reads(std::move(reads_of)),
        info(info_of(hierarchy.head())),
        surface_origin(origin_of(hierarchy.head())) {}

  PackedHierarchy hierarchy;
  std::function<tetra_mt::FileReads()> reads;  ///< None in memory.
  TetraInfo info;
  Vec3d surface_origin;
};

TetraDataset::TetraDataset(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TetraDataset::TetraDataset(TetraDataset&&) noexcept = default;
TetraDataset& TetraDataset::operator=(TetraDataset&&) noexcept = default;
TetraDataset::~TetraDataset() = default;

const TetraInfo& TetraDataset::describe() const { return impl_->info; }

TetraReads TetraDataset::reads() const {
  if (!impl_->reads) return {};
  const tetra_mt::FileReads reads = impl_->reads();
  return {reads.n_bytes, reads.file_size};
}

Result<TetraDataset> TetraDataset::build(const TetraMesh& mesh, const TetraBuildOptions& options,
                                         Progress& progress) try {
  LODE_TRY(const auto hierarchy, make_hierarchy_of(mesh, options, progress));
  return TetraDataset(std::make_unique<Impl>(
      PackedHierarchy::pack(hierarchy, mesh.tetrahedra.size(), options.threads)));
} catch (const std::bad_alloc&) {
  return out_of_memory("build the hierarchy");
}

Result<TetraFileReport> TetraDataset::build_file(const TetraMesh& mesh, const std::string& path,
                                                 const TetraBuildOptions& options,
                                                 Progress& progress) try {
  Stopwatch watch;
  LODE_TRY(const auto hierarchy, make_hierarchy_of(mesh, options, progress));
  TetraFileReport report;
  report.build_seconds = watch.seconds();
  report.info = info_of(head_of(hierarchy, mesh.tetrahedra.size()));
  const Stopwatch write_watch;
  LODE_TRY(report.file_bytes,
           tetra_mt::save(hierarchy, mesh.tetrahedra.size(), path, options.threads, progress));
  report.write_seconds = write_watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("build the hierarchy");
}

Result<TetraDataset> TetraDataset::open(const std::string& path) try {
  LODE_TRY(auto opened, tetra_mt::open(path));
  return TetraDataset(std::make_unique<Impl>(std::move(opened.hierarchy), std::move(opened.reads)));
} catch (const std::bad_alloc&) {
  return out_of_memory("open the file");
}

Result<MeshReport> TetraDataset::extract_mesh(const MeshOptions& options, SimplexMesh& mesh,
                                              Progress& progress) const try {
  const Stopwatch watch;
  LODE_TRY(const Query query, complete_query(impl_->info, options.query));
  TetraCut cut(impl_->hierarchy);
  Engine<TetraCut> engine(cut);
  engine.set_query(demand_of(query), query.budget);
  engine.run([&] { return progress.is_cancelled() || cut.is_damaged(); });
  if (progress.is_cancelled()) return cancelled_error();
  LODE_CHECK(cut.check());
  const Standing standing = engine.standing();
  fill_mesh(impl_->hierarchy, cut, mesh);
  LODE_CHECK(cut.check());
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
  const double margin = rounding_margin(mesh.positions, surface.origin);
  TetraSurfaceReport report{
      .max_error = made.max_error, .n_cut_cells = made.n_cut_cells, .budget_met = made.budget_met};
  for (const double isovalue : isovalues)
    report.achieved_error = std::max(report.achieved_error,
                                     add_isosurface(mesh, isovalue, {.margin = margin}, surface));
  report.n_triangles = surface.triangles.size();
  report.n_vertices = surface.positions.size();
  report.unmet = unmet_isovalues(surface, isovalues);
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the surface");
}

}  // namespace lode

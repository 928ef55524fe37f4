#include "lode/api/tetra_dataset.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <span>
#include <utility>

#include "lode/api/tetra_probe.h"
#include "lode/api/tetra_verification.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/mappers/mesh_boundary.h"
#include "lode/mappers/mesh_gradients.h"
#include "lode/mappers/mesh_isosurface.h"
#include "lode/models/tetra_mt/everywhere_errors.h"
#include "lode/models/tetra_mt/gradient_codes.h"
#include "lode/models/tetra_mt/persist.h"
#include "lode/models/tetra_mt/tetra_cut.h"
#include "lode/refine/engine.h"
#include "lode/store/reader.h"

namespace lode {
namespace {

using tetra_mt::Hierarchy;
using tetra_mt::HierarchyHead;
using tetra_mt::kNone;
using tetra_mt::PackedHierarchy;
using tetra_mt::TetraCut;

/// As for volumes.
constexpr double kShareOfRange = 0.005;

Result<Query> complete_query(const TetraInfo& info, Query query,
                             const std::optional<double>& deadline_s) {
  if (query.max_error_px)
    return fail("meshes: expected a tolerance in field units, got pixels, of which they know none");
  if (deadline_s && !(*deadline_s >= 0))
    return fail("deadline: expected a number >= 0, got {}", *deadline_s);
  if (!query.max_error)
    query.max_error = query.budget.is_limited() || deadline_s
                          ? 0
                          : kShareOfRange * (info.range_max - info.range_min);
  LODE_CHECK(check_query(query));
  return query;
}

Result<void> check_regions(const TetraInfo& info, std::span<const std::int64_t> regions) {
  for (const std::int64_t region : regions)
    if (std::ranges::find(info.regions, region) == info.regions.end())
      return fail("regions: expected one of {}, got {}",
                  info.regions.empty() ? "none" : fmt::format("{}", fmt::join(info.regions, ", ")),
                  region);
  return {};
}

/// A demand with bounds a little wider than they are: mesh vertices near a section count as in it.
struct WidenedDemand {
  Demand demand;
  double widening = 0;  ///< World units.

  [[nodiscard]] double operator()(const NodeFacts& node) const { return demand(widened(node)); }
  [[nodiscard]] bool touches(const NodeFacts& node) const { return demand.touches(widened(node)); }

 private:
  [[nodiscard]] NodeFacts widened(NodeFacts node) const {
    node.bounds.radius += widening;
    return node;
  }
};

/// What making a surface or mesh of a cut takes at most, so that a deadline is kept: errors of its
/// cells may be on any page that has not been read.
double finishing_seconds(const PackedHierarchy& hierarchy, std::uint64_t n_cells) {
  const std::uint32_t n_unread = hierarchy.head().shape.n_pages() - hierarchy.n_pages_loaded();
  return 1e-3 + 4e-7 * static_cast<double>(n_cells) + 1e-8 * hierarchy.head().n_vertices() +
         2.5e-4 * n_unread;
}

/// `widening`: how much sections are.
Demand demand_of(Query query, double widening) {
  const std::optional<double> outside = std::exchange(query.max_error_outside, std::nullopt);
  Demand demand = to_demand(query);
  if (!query.sections.empty()) demand = WidenedDemand{std::move(demand), widening};
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

/// Slots of the cells of a cut by their last vertex: as vertices are numbered along a curve in
/// space, cells that are near come near, whatever the order in which they were made.
std::vector<std::uint32_t> sorted_cells(const TetraCut& cut, std::uint32_t n_vertices) {
  std::vector<std::uint32_t> begins(std::size_t{n_vertices} + 1, 0);
  for (const TetraCut::Cell& cell : cut.slots())
    if (cut.is_inside(cell)) ++begins[std::ranges::max(cell.corners) + std::size_t{1}];
  for (std::size_t v = 1; v < begins.size(); ++v) begins[v] += begins[v - 1];
  std::vector<std::uint32_t> slots(begins.back());
  for (std::uint32_t slot = 0; slot < cut.slots().size(); ++slot) {
    const TetraCut::Cell& cell = cut.slots()[slot];
    if (cut.is_inside(cell)) slots[begins[std::ranges::max(cell.corners)]++] = slot;
  }
  return slots;
}

/// Cells of a cut, their vertices numbered in the order of the hierarchy's: whose numbers it
/// returns.
std::vector<std::uint32_t> fill_mesh(const PackedHierarchy& hierarchy, const TetraCut& cut,
                                     SimplexMesh& mesh) {
  mesh = {};
  std::vector<std::uint32_t> vertex_ids;
  std::vector<std::uint32_t> numbers(hierarchy.head().n_vertices(), kNone);
  for (const std::uint32_t slot : sorted_cells(cut, hierarchy.head().n_vertices())) {
    const TetraCut::Cell& cell = cut.slots()[slot];
    mesh.tetrahedra.push_back(cell.corners);
    mesh.errors.push_back(cell.maker == kNone ? 0 : hierarchy.facts(cell.maker, 0).error);
    if (hierarchy.head().shape.n_regions > 1)
      mesh.regions.push_back(hierarchy.head().region_ids[cell.region]);
    for (const std::uint32_t v : cell.corners) numbers[v] = 0;
  }
  for (std::uint32_t v = 0; v < numbers.size(); ++v) {
    if (numbers[v] == kNone) continue;
    numbers[v] = static_cast<std::uint32_t>(vertex_ids.size());
    vertex_ids.push_back(v);
    mesh.positions.push_back(hierarchy.position(v));
    mesh.values.push_back(hierarchy.value(v, 0));
  }
  for (auto& t : mesh.tetrahedra)
    for (std::uint32_t& v : t) v = numbers[v];
  mesh.has_narrow_values = std::ranges::all_of(mesh.values, [](double value) {
    return static_cast<double>(static_cast<float>(value)) == value;
  });
  return vertex_ids;
}

/// By vertex of the hierarchy: gradient_code() on the mesh.
std::vector<std::uint32_t> gradient_codes(const TetraMesh& mesh, std::size_t field,
                                          const Hierarchy& hierarchy, Threads threads) {
  SimplexMesh all;
  all.positions = mesh.positions;
  all.values = mesh.fields[field].values;
  all.tetrahedra = mesh.tetrahedra;
  const std::vector<Vec3f> gradients = vertex_gradients(all, threads);
  std::vector<std::uint32_t> codes(hierarchy.mesh_vertices.size());
  parallel_for(codes.size(), threads, tetra_mt::kPageNodes, [&](std::size_t v, int) {
    codes[v] = tetra_mt::gradient_code(gradients[hierarchy.mesh_vertices[v]]);
  });
  return codes;
}

TetraInfo info_of(const HierarchyHead& head) {
  const HierarchyHead::Field& field = head.fields[0];
  return {
      .n_vertices = head.n_vertices(),
      .n_cells = head.n_cells,
      .n_base_cells = head.n_base_cells,
      .n_nodes = head.shape.n_nodes,
      .field = field.name,
      .type = field.type,
      .range_min = field.low,
      .range_max = field.high,
      .error_place = field.has_errors_everywhere ? ErrorPlace::everywhere : ErrorPlace::at_samples,
      .base_error = field.base_error,
      .bounds = {head.lower, head.upper},
      .boundary_deviation = head.boundary_deviation,
      .regions = head.region_ids};
}

Result<tetra_mt::HalfEdgeCollapses> collapse(const TetraMesh& mesh,
                                             const TetraBuildOptions& options, Progress& progress) {
  if (mesh.fields.size() != 1) return fail("expected one field, got {}", mesh.fields.size());
  const auto base_cells = static_cast<std::uint64_t>(std::clamp(options.base_share, 0.0, 1.0) *
                                                     static_cast<double>(mesh.tetrahedra.size()));
  const bool is_everywhere = options.error_place == ErrorPlace::everywhere;
  if (is_everywhere && options.boundary_tolerance > 0)
    return fail(
        "boundary tolerance: expected 0 where errors hold everywhere, as nothing is known of what "
        "is outside, got {}",
        options.boundary_tolerance);
  LODE_TRY(auto collapses, tetra_mt::collapse_half_edges(
                               mesh,
                               {.base_cells = base_cells,
                                .rules = {.boundary_tolerance = options.boundary_tolerance},
                                .threads = options.threads},
                               progress));
  if (is_everywhere)
    LODE_CHECK(make_errors_hold_everywhere(mesh, collapses, options.threads, progress));
  return collapses;
}

Result<Hierarchy> make_hierarchy_of(const TetraMesh& mesh, const TetraBuildOptions& options,
                                    Progress& progress) {
  LODE_TRY(const auto collapses, collapse(mesh, options, progress));
  return tetra_mt::make_hierarchy(mesh, collapses, options.threads);
}

std::vector<std::pair<std::string, std::uint64_t>> named(const tetra_mt::RefusalCounts& counts) {
  constexpr std::array<const char*, tetra_mt::RefusalCounts::kSize> kNames{
      "non-manifold", "extremum", "boundary", "regions", "shape",
      "topology",     "crowded",  "rounding", "limit"};
  std::vector<std::pair<std::string, std::uint64_t>> result;
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (counts.counts[i] > 0) result.emplace_back(kNames[i], counts.counts[i]);
  return result;
}

}  // namespace

class TetraDataset::Impl {
 public:
  using GradientSource =
      std::function<Result<std::vector<std::uint32_t>>(std::size_t field, std::uint32_t page)>;

  Impl(PackedHierarchy packed, GradientSource source,
       std::function<tetra_mt::FileReads()> reads_of = {})
      : hierarchy(std::move(packed)),
        reads(std::move(reads_of)),
        info(info_of(hierarchy.head())),
        surface_origin(origin_of(hierarchy.head())),
        surface_margin(
            rounding_margin(std::array{info.bounds.lower, info.bounds.upper}, surface_origin)),
        source_(std::move(source)) {}

  /// The mesh of a query's cut, without gradients.
  [[nodiscard]] Result<TetraCutMesh> make_mesh(const Query& wanted,
                                               const std::optional<double>& deadline_s,
                                               std::span<const std::int64_t> regions,
                                               Progress& progress) const;
  /// Of vertices of the hierarchy, ascending.
  [[nodiscard]] Result<std::vector<Vec3f>> gradients(std::span<const std::uint32_t> vertices,
                                                     std::size_t field) const;

  PackedHierarchy hierarchy;
  std::function<tetra_mt::FileReads()> reads;  ///< None in memory.
  TetraInfo info;
  Vec3d surface_origin;
  double surface_margin;

 private:
  [[nodiscard]] Result<const std::vector<std::uint32_t>*> load_gradients(std::size_t field,
                                                                         std::uint32_t page) const;

  GradientSource source_;
  mutable std::mutex mutex_;
  /// Codes by field and page, of those looked at so far.
  mutable std::map<std::pair<std::size_t, std::uint32_t>, std::vector<std::uint32_t>> pages_;
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
  std::vector<std::vector<std::uint32_t>> codes;
  for (std::size_t f = 0; f < mesh.fields.size(); ++f)
    codes.push_back(gradient_codes(mesh, f, hierarchy, options.threads));
  auto packed = PackedHierarchy::pack(hierarchy, mesh.tetrahedra.size(), options.threads);
  auto source = [codes = std::move(codes), shape = packed.head().shape](std::size_t field,
                                                                        std::uint32_t page) {
    const tetra_mt::VertexRange range = vertices_of(shape, page);
    const auto begin = codes[field].begin() + static_cast<std::ptrdiff_t>(range.first);
    return Result(std::vector<std::uint32_t>(begin, begin + range.n));
  };
  return TetraDataset(std::make_unique<Impl>(std::move(packed), std::move(source)));
} catch (const std::bad_alloc&) {
  return out_of_memory("build the hierarchy");
}

Result<TetraFileReport> TetraDataset::build_file(const TetraMesh& mesh, const std::string& path,
                                                 const TetraBuildOptions& options,
                                                 Progress& progress) try {
  Stopwatch watch;
  LODE_TRY(auto collapses, collapse(mesh, options, progress));
  TetraFileReport report;
  report.volume_change = collapses.volume_change;
  report.refusals = named(collapses.refusals);
  LODE_TRY(const auto hierarchy, tetra_mt::make_hierarchy(mesh, collapses, options.threads));
  collapses = {};
  report.build_seconds = watch.seconds();
  report.info = info_of(head_of(hierarchy, mesh.tetrahedra.size()));
  const Stopwatch write_watch;
  const auto gradients = [&](std::size_t field) {
    return gradient_codes(mesh, field, hierarchy, options.threads);
  };
  LODE_TRY(report.file_bytes, tetra_mt::save(hierarchy, mesh.tetrahedra.size(), gradients, path,
                                             options.threads, progress));
  report.write_seconds = write_watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("build the hierarchy");
}

bool TetraDataset::is_model_of(const std::string& path) { return tetra_mt::is_model_of(path); }

Result<TetraDataset> TetraDataset::open(const std::string& path) try {
  LODE_TRY(auto opened, tetra_mt::open(path));
  return TetraDataset(std::make_unique<Impl>(std::move(opened.hierarchy),
                                             std::move(opened.gradients), std::move(opened.reads)));
} catch (const std::bad_alloc&) {
  return out_of_memory("open the file");
}

Result<const std::vector<std::uint32_t>*> TetraDataset::Impl::load_gradients(
    std::size_t field, std::uint32_t page) const {
  auto& codes = pages_[{field, page}];
  if (codes.empty()) {
    LODE_TRY(codes, source_(field, page));
  }
  return &codes;
}

Result<std::vector<Vec3f>> TetraDataset::Impl::gradients(std::span<const std::uint32_t> vertices,
                                                         std::size_t field) const {
  const std::lock_guard lock(mutex_);
  const tetra_mt::PageShape& shape = hierarchy.head().shape;
  std::vector<Vec3f> found;
  found.reserve(vertices.size());
  std::uint32_t page = kNone;
  const std::vector<std::uint32_t>* codes = nullptr;
  for (const std::uint32_t v : vertices) {
    if (codes == nullptr || page_of(shape, v) != page) {
      page = page_of(shape, v);
      LODE_TRY(codes, load_gradients(field, page));
    }
    found.push_back(tetra_mt::gradient_of((*codes)[v - vertices_of(shape, page).first]));
  }
  return found;
}

Result<TetraCutMesh> TetraDataset::Impl::make_mesh(const Query& wanted,
                                                   const std::optional<double>& deadline_s,
                                                   std::span<const std::int64_t> regions,
                                                   Progress& progress) const {
  const Stopwatch watch;
  LODE_TRY(const Query query, complete_query(info, wanted, deadline_s));
  LODE_CHECK(check_regions(info, regions));
  TetraCut cut(hierarchy);
  Engine<TetraCut> engine(cut);
  engine.set_query(demand_of(query, 2 * surface_margin), query.budget);
  const auto is_late = [&] {
    return watch.seconds() + finishing_seconds(hierarchy, engine.n_cells()) >= *deadline_s;
  };
  constexpr unsigned kStepsPerLook = 16;
  unsigned n_looks = 0;
  engine.run([&] {
    return progress.is_cancelled() || cut.is_damaged() ||
           (deadline_s && n_looks++ % kStepsPerLook == 0 && is_late());
  });
  if (progress.is_cancelled()) return cancelled_error();
  LODE_CHECK(cut.check());
  const Standing standing = engine.standing();
  TetraCutMesh made{.origin = surface_origin, .margin = surface_margin};
  made.vertex_ids = fill_mesh(hierarchy, cut, made.mesh);
  LODE_CHECK(cut.check());
  made.report.max_error = *query.max_error;
  // What is out of sight remains a candidate.
  const auto view = query.view ? std::optional(to_view_focus(*query.view)) : std::nullopt;
  made.report.achieved_error = engine.largest([&](const NodeFacts& facts) {
    return !view || view->shows(facts.bounds) ? facts.error : 0.0;
  });
  made.report.n_cut_cells = standing.n_cells;
  made.report.budget_met = standing.budget_met;
  made.report.is_settled = standing.is_settled;
  if (!regions.empty() && info.regions.size() > 1)
    made.report.n_left_out = keep_regions(made.mesh, regions, made.vertex_ids);
  return made;
}

Result<MeshReport> TetraDataset::extract_mesh(const TetraMeshOptions& options, SimplexMesh& mesh,
                                              Progress& progress) const try {
  const Stopwatch watch;
  LODE_TRY(TetraCutMesh cut,
           impl_->make_mesh(query_of(options), options.deadline_s, options.regions, progress));
  apply_threshold(options, cut);
  mesh = std::move(cut.mesh);
  cut.report.seconds = watch.seconds();
  return cut.report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the mesh");
}

Result<TetraSurfaceReport> TetraDataset::extract_surface(const TetraSurfaceOptions& options,
                                                         Surface& surface, Progress& progress) const
    try {
  const Stopwatch watch;
  if (options.query.isovalues.empty()) return fail("isosurfaces: expected isovalues, got none");
  LODE_TRY(TetraCutMesh cut,
           impl_->make_mesh(options.query, options.deadline_s, options.regions, progress));
  if (options.normals == Normals::on) {
    LODE_TRY(cut.gradients, impl_->gradients(cut.vertex_ids, 0));
  }
  TetraSurfaceReport report = make_isosurfaces(cut, options, surface);
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the surface");
}

Result<TetraSurfaceReport> TetraDataset::extract_section(const TetraSectionOptions& options,
                                                         Surface& surface, Progress& progress) const
    try {
  const Stopwatch watch;
  LODE_CHECK(check_planes(options.planes));
  LODE_TRY(const TetraCutMesh cut,
           impl_->make_mesh(query_of(options), options.deadline_s, options.regions, progress));
  TetraSurfaceReport report = make_sections(cut, options, surface);
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the section");
}

Result<TetraSurfaceReport> TetraDataset::extract_boundary(const TetraMeshOptions& options,
                                                          Surface& surface,
                                                          Progress& progress) const try {
  const Stopwatch watch;
  LODE_TRY(TetraCutMesh cut,
           impl_->make_mesh(query_of(options), options.deadline_s, options.regions, progress));
  apply_threshold(options, cut);
  TetraSurfaceReport report = make_boundary(cut, options.threads, surface);
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the boundary");
}

Result<ProbeReport> TetraDataset::probe(std::span<const Vec3d> points, const ProbeOptions& options,
                                        std::vector<ProbedPoint>& found, Progress& progress) const
    try {
  const Stopwatch watch;
  LODE_TRY(ProbeReport report, probe_hierarchy(impl_->hierarchy, points, options, found, progress));
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("probe the field");
}

Result<ProbeReport> TetraDataset::probe_line(const ProbedLine& line, const ProbeOptions& options,
                                             std::vector<ProbedLinePoint>& found,
                                             Progress& progress) const try {
  const Stopwatch watch;
  LODE_TRY(ProbeReport report, probe_hierarchy(impl_->hierarchy, line, options, found, progress));
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("probe the field");
}

Result<IntegralReport> TetraDataset::integrate(const IntegralOptions& options,
                                               Progress& progress) const try {
  const Stopwatch watch;
  LODE_CHECK(check_regions(impl_->info, options.regions));
  LODE_TRY(IntegralReport report, integrate_hierarchy(impl_->hierarchy, options, progress));
  report.probe.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("integrate the field");
}

Result<VerifyReport> TetraDataset::verify(const TetraVerifyOptions& options,
                                          Progress& progress) const try {
  return verify_hierarchy(impl_->hierarchy, options, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("check the hierarchy");
}

Result<VerifyReport> TetraDataset::verify_against(const TetraMesh& original,
                                                  Progress& progress) const try {
  return compare_with_original(impl_->hierarchy, original, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("compare the hierarchy with the data");
}

Result<VerifyReport> verify_tetra_file(const std::string& path, Threads threads,
                                       Progress& progress) try {
  LODE_TRY(const auto reader, store::Reader::open(path));
  LODE_CHECK(reader.check_all(threads, progress));
  VerifyReport report;
  report.add("every byte of the file", reader.file_size(), 0,
             fmt::format("{} blocks", reader.blocks().size()));
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("check the file", path);
}

}  // namespace lode

#include "lode/api/tetra_dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <span>
#include <utility>

#include "lode/api/tetra_build.h"
#include "lode/api/tetra_cut_mesh.h"
#include "lode/api/tetra_cut_source.h"
#include "lode/api/tetra_focus.h"
#include "lode/api/tetra_info.h"
#include "lode/api/tetra_probe.h"
#include "lode/api/tetra_query.h"
#include "lode/api/tetra_verification.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/mappers/mesh_boundary.h"
#include "lode/mappers/mesh_gradients.h"
#include "lode/mappers/mesh_isosurface.h"
#include "lode/models/tetra_mt/gradient_codes.h"
#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"
#include "lode/models/tetra_mt/midpoint/persist.h"
#include "lode/models/tetra_mt/persist.h"
#include "lode/models/tetra_mt/tetra_cut.h"
#include "lode/refine/engine.h"
#include "lode/store/reader.h"

namespace lode {
namespace {

using tetra_mt::Hierarchy;
using tetra_mt::kNone;
using Midpoints = tetra_mt::midpoint::Forest;
using tetra_mt::PackedHierarchy;
using tetra_mt::TetraCut;

/// What making a surface or mesh of a cut takes at most, so that a deadline is kept, with the
/// errors of its cells that are at hand: others may be on any page that has not been read. Values
/// of further fields are in as many pages as those of the measured one.
double finishing_seconds(const PackedHierarchy& hierarchy, const TetraFieldUse& fields,
                         std::uint64_t n_cells) {
  std::uint32_t n_unread = 0;
  const std::uint32_t n_pages = hierarchy.n_field_pages_loaded(fields.measured);
  for (const std::size_t field : fields.along)
    n_unread += n_pages - std::min(n_pages, hierarchy.n_field_pages_loaded(field));
  return 1e-3 + 4e-7 * static_cast<double>(n_cells) + 1e-8 * hierarchy.head().n_vertices() +
         4e-4 * n_unread;
}

/// What positions of surfaces are relative to: nothing, unless the mesh is so far away that float32
/// loses more than a millionth of its size.
Vec3d origin_of(const Box3d& box) {
  constexpr double kFar = 16;
  const bool is_far = length(box.lower) + length(box.upper) > kFar * length(box.upper - box.lower);
  return is_far ? box.lower : Vec3d();
}

/// Of midpoints: of what is in the mesh all errors of the measured field are known; those of
/// others, and values, are in as many pages.
double finishing_seconds(const Midpoints& forest, const TetraFieldUse& fields,
                         std::uint64_t n_cells) {
  std::uint32_t n_unread = 0;
  const std::uint32_t n_pages = forest.n_pages_loaded();
  for (const std::size_t field : fields.along)
    n_unread += n_pages - std::min(n_pages, forest.n_pages_loaded(field));
  return 1e-3 + 1e-6 * static_cast<double>(n_cells) * static_cast<double>(1 + fields.along.size()) +
         4e-4 * n_unread;
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
        info(info_of(hierarchy->head())),
        surface_origin(origin_of(info.bounds)),
        surface_margin(
            rounding_margin(std::array{info.bounds.lower, info.bounds.upper}, surface_origin)),
        source_(std::move(source)) {}
  explicit Impl(Midpoints made, std::function<tetra_mt::FileReads()> reads_of = {})
      : midpoints(std::move(made)),
        reads(std::move(reads_of)),
        info(info_of(midpoints->head())),
        surface_origin(origin_of(info.bounds)),
        surface_margin(
            rounding_margin(std::array{info.bounds.lower, info.bounds.upper}, surface_origin)) {}

  [[nodiscard]] ProbedHierarchy probed() const {
    if (hierarchy) return &*hierarchy;
    return &*midpoints;
  }
  [[nodiscard]] std::unique_ptr<const TetraCutSource> source() const {
    return hierarchy ? source_of(*hierarchy) : source_of(*midpoints);
  }
  /// The mesh of a query's cut, without gradients.
  template <typename Options>
  [[nodiscard]] Result<TetraCutMesh> make_mesh(const Query& wanted, const Options& options,
                                               Progress& progress) const;
  /// Of vertices of the hierarchy, ascending.
  [[nodiscard]] Result<std::vector<Vec3f>> gradients(std::span<const std::uint32_t> vertices,
                                                     std::size_t field) const;

  std::optional<PackedHierarchy> hierarchy;    ///< This,
  std::optional<Midpoints> midpoints;          ///< or this.
  std::function<tetra_mt::FileReads()> reads;  ///< None in memory.
  TetraInfo info;
  Vec3d surface_origin;
  double surface_margin;

 private:
  /// Refines an opened model and makes the rest of the answer. `finishing`: seconds that take so
  /// many cells; `fill`: puts cells in the mesh.
  template <typename Model, typename Options, typename Finishing, typename Fill>
  [[nodiscard]] Result<TetraCutMesh> refine(Model& model, const Query& query,
                                            const Options& options, const Finishing& finishing,
                                            const Fill& fill, Progress& progress) const;
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
  if (options.placement == Placement::midpoint) {
    LODE_TRY(auto midpoints, build_midpoints(mesh, options, progress));
    return TetraDataset(std::make_unique<Impl>(Midpoints(std::move(midpoints.hierarchy))));
  }
  LODE_TRY(const auto hierarchy, build_hierarchy(mesh, options, progress));
  std::vector<std::vector<std::uint32_t>> codes;
  for (std::size_t f = 0; f < mesh.fields.size(); ++f)
    codes.push_back(gradient_codes(mesh, f, hierarchy.mesh_vertices, options.threads));
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

bool TetraDataset::is_model_of(const std::string& path) {
  const auto name = store::Reader::model_of(path);
  return name && (*name == tetra_mt::kModelName || *name == tetra_mt::midpoint::kModelName);
}

Result<TetraDataset> TetraDataset::open(const std::string& path) try {
  if (tetra_mt::midpoint::is_model_of(path)) {
    LODE_TRY(auto opened, tetra_mt::midpoint::open(path));
    return TetraDataset(std::make_unique<Impl>(std::move(opened.forest), std::move(opened.reads)));
  }
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
  const tetra_mt::PageShape& shape = hierarchy->head().shape;
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

template <typename Model, typename Options, typename Finishing, typename Fill>
Result<TetraCutMesh> TetraDataset::Impl::refine(Model& model, const Query& query,
                                                const Options& options, const Finishing& finishing,
                                                const Fill& fill, Progress& progress) const {
  const Stopwatch watch;
  Engine<Model> engine(model);
  // Facts of nodes may be in pages that take milliseconds each, so the clock is looked at for each.
  const auto must_stop = [&] {
    return progress.is_cancelled() || model.is_damaged() ||
           (options.deadline_s &&
            watch.seconds() + finishing(engine.n_cells()) >= *options.deadline_s);
  };
  const bool has_candidates = engine.set_query_unless(
      must_stop, in_regions(demand_of(query, 2 * surface_margin), info, options.regions),
      query.budget, FocusChange::changed,
      options.deadline_s ? ApplyOrder::best_first : ApplyOrder::nearest_first);
  if (has_candidates) engine.run(must_stop);
  if (progress.is_cancelled()) return cancelled_error();
  const Standing standing = engine.standing();
  TetraCutMesh made{.origin = surface_origin, .margin = surface_margin};
  LODE_TRY(made.vertex_ids, fill(made.mesh));
  made.report.max_error = query.max_error.value_or(std::numeric_limits<double>::infinity());
  const TetraFocus focus(query, 2 * surface_margin, info, options.regions);
  const auto largest = [&](double (TetraFocus::*measure)(const NodeFacts&) const, double unknown) {
    if (!has_candidates) return unknown;
    return engine.largest([&](const NodeFacts& facts) { return (focus.*measure)(facts); });
  };
  const TetraFieldInfo& field = info.fields[options.fields.measured];
  made.report.achieved_error = largest(&TetraFocus::error, field.base_error);
  if (needs_world_errors(query))
    made.report.achieved_world_error = largest(&TetraFocus::world_error, *field.base_world_error);
  if (query.max_error_px)
    made.report.achieved_px = largest(&TetraFocus::pixels, std::numeric_limits<double>::infinity());
  made.report.n_cut_cells = standing.n_cells;
  made.report.budget_met = standing.budget_met;
  made.report.is_settled = standing.is_settled;
  if (!options.regions.empty() && info.regions.size() > 1)
    made.report.n_left_out = keep_regions(made.mesh, options.regions, made.vertex_ids);
  return made;
}

template <typename Options>
Result<TetraCutMesh> TetraDataset::Impl::make_mesh(const Query& wanted, const Options& options,
                                                   Progress& progress) const {
  LODE_CHECK(check_fields(info, options.fields));
  LODE_TRY(const Query query,
           complete_query(info.fields[options.fields.measured], wanted, options.deadline_s));
  LODE_CHECK(check_regions(info, options.regions));
  using Ids = Result<std::vector<std::uint32_t>>;
  const auto world_errors =
      needs_world_errors(query) ? tetra_mt::WorldErrors::known : tetra_mt::WorldErrors::unknown;
  if (midpoints) {
    tetra_mt::midpoint::MidpointCut cut(*midpoints, options.fields.measured, world_errors);
    const auto finishing = [&](std::uint64_t n) {
      return finishing_seconds(*midpoints, options.fields, n);
    };
    const auto fill = [&](SimplexMesh& mesh) -> Ids {
      LODE_CHECK(cut.check());
      LODE_TRY(std::vector<std::uint32_t> ids, fill_mesh(cut, options.fields, mesh));
      LODE_CHECK(cut.check());
      return ids;
    };
    return refine(cut, query, options, finishing, fill, progress);
  }
  TetraCut cut(*hierarchy, options.fields.measured, world_errors);
  const auto errors = options.deadline_s ? CellErrors::at_hand : CellErrors::own;
  const auto finishing = [&](std::uint64_t n) {
    return finishing_seconds(*hierarchy, options.fields, n);
  };
  const auto fill = [&](SimplexMesh& mesh) -> Ids {
    LODE_CHECK(cut.check());
    std::vector<std::uint32_t> ids = fill_mesh(*hierarchy, options.fields, cut, errors, mesh);
    LODE_CHECK(cut.check());
    return ids;
  };
  return refine(cut, query, options, finishing, fill, progress);
}

Result<MeshReport> TetraDataset::extract_mesh(const TetraMeshOptions& options, SimplexMesh& mesh,
                                              Progress& progress) const try {
  const Stopwatch watch;
  LODE_TRY(TetraCutMesh cut, impl_->make_mesh(query_of(options), options, progress));
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
  LODE_TRY(TetraCutMesh cut, impl_->make_mesh(options.query, options, progress));
  if (options.normals == Normals::on && impl_->midpoints) {
    cut.gradients = vertex_gradients(cut.mesh, options.threads);
  } else if (options.normals == Normals::on) {
    LODE_TRY(cut.gradients, impl_->gradients(cut.vertex_ids, options.fields.measured));
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
  LODE_TRY(const TetraCutMesh cut, impl_->make_mesh(query_of(options), options, progress));
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
  LODE_TRY(const auto patches, find_patches(impl_->info, options.patches));
  LODE_TRY(TetraCutMesh cut, impl_->make_mesh(query_of(options), options, progress));
  apply_threshold(options, cut);
  TetraSurfaceReport report = make_boundary(cut, patches, options.threads, surface);
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the boundary");
}

Result<ProbeReport> TetraDataset::probe(std::span<const Vec3d> points, const ProbeOptions& options,
                                        std::vector<ProbedPoint>& found, Progress& progress) const
    try {
  const Stopwatch watch;
  LODE_TRY(ProbeReport report, probe_hierarchy(impl_->probed(), points, options, found, progress));
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("probe the field");
}

Result<ProbeReport> TetraDataset::probe_line(const ProbedLine& line, const ProbeOptions& options,
                                             std::vector<ProbedLinePoint>& found,
                                             Progress& progress) const try {
  const Stopwatch watch;
  LODE_TRY(ProbeReport report, probe_hierarchy(impl_->probed(), line, options, found, progress));
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("probe the field");
}

Result<IntegralReport> TetraDataset::integrate(const IntegralOptions& options,
                                               Progress& progress) const try {
  const Stopwatch watch;
  LODE_CHECK(check_regions(impl_->info, options.regions));
  LODE_TRY(IntegralReport report, integrate_hierarchy(impl_->probed(), options, progress));
  report.probe.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("integrate the field");
}

Result<VerifyReport> TetraDataset::verify(const TetraVerifyOptions& options,
                                          Progress& progress) const try {
  LODE_CHECK(check_fields(impl_->info, {.along = options.fields}));
  return verify_hierarchy(*impl_->source(), options, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("check the hierarchy");
}

Result<VerifyReport> TetraDataset::verify_against(const TetraMesh& original,
                                                  std::span<const std::size_t> fields,
                                                  Progress& progress) const try {
  LODE_CHECK(check_fields(impl_->info, {.along = {fields.begin(), fields.end()}}));
  return compare_with_original(*impl_->source(), original, fields, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("compare the hierarchy with the data");
}

}  // namespace lode

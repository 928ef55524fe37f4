#include "lode/api/tetra_session.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "lode/api/tetra_cut_mesh.h"
#include "lode/api/tetra_dataset_impl.h"
#include "lode/api/tetra_focus.h"
#include "lode/api/tetra_query.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/mappers/mesh_boundary.h"
#include "lode/mappers/mesh_gradients.h"
#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"
#include "lode/models/tetra_mt/tetra_cut.h"
#include "lode/refine/counted_cut.h"
#include "lode/refine/engine.h"

namespace lode {
namespace {

using tetra_mt::PackedHierarchy;
using tetra_mt::TetraCut;
using tetra_mt::WorldErrors;
using tetra_mt::midpoint::MidpointCut;
using Midpoints = tetra_mt::midpoint::Forest;
using VertexIds = std::vector<std::uint32_t>;

/// What making a surface or mesh of a cut takes at most, so that a deadline is kept, with the
/// errors of its cells that are at hand: others, which are read while there is time, may be on any
/// page that has not been. Values
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

/// What an answer is refined in, and what the last one was of.
template <typename Cut>
struct Refinement {
  CountedCut<Cut> cut;
  Engine<CountedCut<Cut>> engine{cut};
  std::size_t field;
  WorldErrors world_errors;
  std::optional<Query> query{};
  std::vector<std::int64_t> regions{};

  template <typename Model>
  Refinement(const Model& model, std::size_t measured, WorldErrors known)
      : cut(model, measured, known), field(measured), world_errors(known) {}
  Refinement(const Refinement&) = delete;  // the engine refers to the cut
  Refinement& operator=(const Refinement&) = delete;
  ~Refinement() = default;

  [[nodiscard]] bool serves(std::size_t measured, WorldErrors wanted) const {
    return field == measured && !cut.is_damaged() &&
           (wanted == WorldErrors::unknown || world_errors == WorldErrors::known);
  }
  FocusChange take(const Query& next, const std::vector<std::int64_t>& next_regions) {
    const bool is_same =
        query && regions == next_regions && focus_change(*query, next) == FocusChange::same;
    query = next;
    regions = next_regions;
    return is_same ? FocusChange::same : FocusChange::changed;
  }
};

}  // namespace

class TetraSession::State {
 public:
  explicit State(const TetraDataset::Impl& impl) : impl_(impl) {}

  [[nodiscard]] const TetraDataset::Impl& impl() const { return impl_; }
  /// The mesh of a query's cut, without gradients.
  template <typename Options>
  [[nodiscard]] Result<TetraCutMesh> make_mesh(const Query& wanted, const Options& options,
                                               Progress& progress);
  [[nodiscard]] std::uint64_t n_updates() const { return n_before_ + n_now(); }

 private:
  /// `finishing`: seconds that take so many cells; `fill`: puts cells in the mesh, asking whether
  /// there is time to read pages, and told what no cell's error is above.
  template <typename Cut, typename Options, typename Finishing, typename Fill>
  [[nodiscard]] Result<TetraCutMesh> refine(Refinement<Cut>& refinement, const Query& query,
                                            const Options& options, const Finishing& finishing,
                                            const Fill& fill, Progress& progress);
  template <typename Cut>
  void report(const Refinement<Cut>& refinement, bool has_candidates, std::size_t field,
              MeshReport& report) const;
  template <typename Cut, typename Model>
  Refinement<Cut>& refinement_of(std::unique_ptr<Refinement<Cut>>& held, const Model& model,
                                 std::size_t field, WorldErrors world_errors) {
    if (held == nullptr || !held->serves(field, world_errors)) {
      n_before_ = n_updates();
      held = nullptr;  // before there are two
      held = std::make_unique<Refinement<Cut>>(model, field, world_errors);
    }
    return *held;
  }
  [[nodiscard]] std::uint64_t n_now() const {
    if (half_edges_ != nullptr) return half_edges_->cut.n_updates();
    return midpoints_ != nullptr ? midpoints_->cut.n_updates() : 0;
  }

  const TetraDataset::Impl& impl_;
  std::unique_ptr<Refinement<TetraCut>> half_edges_;    ///< This,
  std::unique_ptr<Refinement<MidpointCut>> midpoints_;  ///< or this, once something was asked.
  std::uint64_t n_before_ = 0;                          ///< Updates of those that were replaced.
};

/// What is in focus, of what has not been applied.
template <typename Cut>
void TetraSession::State::report(const Refinement<Cut>& refinement, bool has_candidates,
                                 std::size_t field, MeshReport& report) const {
  const Query& query = *refinement.query;
  const TetraFocus focus(query, 2 * impl_.surface_margin, impl_.info, refinement.regions);
  const auto largest = [&](double (TetraFocus::*measure)(const NodeFacts&) const, double unknown) {
    if (!has_candidates) return unknown;
    return refinement.engine.largest(
        [&](const NodeFacts& facts) { return (focus.*measure)(facts); });
  };
  constexpr double kAny = std::numeric_limits<double>::infinity();
  const TetraFieldInfo& info = impl_.info.fields[field];
  report.max_error = query.max_error.value_or(kAny);
  report.achieved_error = largest(&TetraFocus::error, info.base_error);
  if (needs_world_errors(query))
    report.achieved_world_error = largest(&TetraFocus::world_error, *info.base_world_error);
  if (query.max_error_px) report.achieved_px = largest(&TetraFocus::pixels, kAny);
  const Standing standing = refinement.engine.standing();
  report.n_cut_cells = standing.n_cells;
  report.budget_met = standing.budget_met;
  report.is_settled = standing.is_settled;
}

template <typename Cut, typename Options, typename Finishing, typename Fill>
Result<TetraCutMesh> TetraSession::State::refine(Refinement<Cut>& refinement, const Query& query,
                                                 const Options& options, const Finishing& finishing,
                                                 const Fill& fill, Progress& progress) {
  const Stopwatch watch;
  auto& engine = refinement.engine;
  const auto has_time = [&] {
    return !options.deadline_s ||
           watch.seconds() + finishing(engine.n_cells()) < *options.deadline_s;
  };
  // Facts of nodes may be in pages that take milliseconds each, so the clock is looked at for each.
  const auto must_stop = [&] {
    return progress.is_cancelled() || refinement.cut.is_damaged() || !has_time();
  };
  const FocusChange change = refinement.take(query, options.regions);
  const bool has_candidates = engine.set_query_unless(
      must_stop,
      in_regions(demand_of(query, 2 * impl_.surface_margin), impl_.info, options.regions),
      query.budget, change,
      options.deadline_s ? ApplyOrder::best_first : ApplyOrder::nearest_first);
  if (has_candidates) engine.run(must_stop);
  if (progress.is_cancelled()) return cancelled_error();
  TetraCutMesh made{.origin = impl_.surface_origin, .margin = impl_.surface_margin};
  // What is not applied is below a candidate, whose errors are nested.
  const double bound =
      has_candidates
          ? engine.largest([](const NodeFacts& facts) { return static_cast<double>(facts.error); })
          : impl_.info.fields[options.fields.measured].base_error;
  LODE_TRY(made.vertex_ids, fill(made.mesh, has_time, bound));
  report(refinement, has_candidates, options.fields.measured, made.report);
  if (!options.regions.empty() && impl_.info.regions.size() > 1)
    made.report.n_left_out = keep_regions(made.mesh, options.regions, made.vertex_ids);
  return made;
}

template <typename Options>
Result<TetraCutMesh> TetraSession::State::make_mesh(const Query& wanted, const Options& options,
                                                    Progress& progress) {
  const TetraInfo& info = impl_.info;
  LODE_CHECK(check_fields(info, options.fields));
  const std::size_t field = options.fields.measured;
  LODE_TRY(const Query query, complete_query(info.fields[field], wanted, options.deadline_s));
  LODE_CHECK(check_regions(info, options.regions));
  const auto world_errors = needs_world_errors(query) ? WorldErrors::known : WorldErrors::unknown;
  if (impl_.midpoints) {
    const Midpoints& model = *impl_.midpoints;
    auto& refinement = refinement_of(midpoints_, model, field, world_errors);
    const auto finishing = [&](std::uint64_t n) {
      return finishing_seconds(model, options.fields, n);
    };
    const auto fill = [&](SimplexMesh& mesh, const MayRead& /*may_read*/,
                          double /*bound*/) -> Result<VertexIds> {
      LODE_CHECK(refinement.cut.check());
      LODE_TRY(VertexIds ids, fill_mesh(refinement.cut, options.fields, mesh));
      LODE_CHECK(refinement.cut.check());
      return ids;
    };
    return refine(refinement, query, options, finishing, fill, progress);
  }
  const PackedHierarchy& model = *impl_.hierarchy;
  auto& refinement = refinement_of(half_edges_, model, field, world_errors);
  const auto finishing = [&](std::uint64_t n) {
    return finishing_seconds(model, options.fields, n);
  };
  const auto fill = [&](SimplexMesh& mesh, const MayRead& may_read,
                        double bound) -> Result<VertexIds> {
    LODE_CHECK(refinement.cut.check());
    VertexIds ids = fill_mesh(model, options.fields, refinement.cut, {may_read, bound}, mesh);
    LODE_CHECK(refinement.cut.check());
    return ids;
  };
  return refine(refinement, query, options, finishing, fill, progress);
}

TetraSession::TetraSession(const TetraDataset& dataset)
    : state_(std::make_unique<State>(*dataset.impl_)) {}
TetraSession::TetraSession(TetraSession&&) noexcept = default;
TetraSession& TetraSession::operator=(TetraSession&&) noexcept = default;
TetraSession::~TetraSession() = default;

std::uint64_t TetraSession::n_updates() const { return state_->n_updates(); }

Result<MeshReport> TetraSession::extract_mesh(const TetraMeshOptions& options, SimplexMesh& mesh,
                                              Progress& progress) try {
  const Stopwatch watch;
  LODE_TRY(TetraCutMesh cut, state_->make_mesh(query_of(options), options, progress));
  apply_threshold(options, cut);
  mesh = std::move(cut.mesh);
  cut.report.seconds = watch.seconds();
  return cut.report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the mesh");
}

Result<TetraSurfaceReport> TetraSession::extract_surface(const TetraSurfaceOptions& options,
                                                         Surface& surface, Progress& progress) try {
  const Stopwatch watch;
  if (options.query.isovalues.empty()) return fail("isosurfaces: expected isovalues, got none");
  LODE_TRY(TetraCutMesh cut, state_->make_mesh(options.query, options, progress));
  if (options.normals == Normals::on && !state_->impl().has_gradients()) {
    cut.gradients = vertex_gradients(cut.mesh, options.threads);
  } else if (options.normals == Normals::on) {
    LODE_TRY(cut.gradients, state_->impl().gradients(cut.vertex_ids, options.fields.measured));
  }
  TetraSurfaceReport report = make_isosurfaces(cut, options, surface);
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the surface");
}

Result<TetraSurfaceReport> TetraSession::extract_section(const TetraSectionOptions& options,
                                                         Surface& surface, Progress& progress) try {
  const Stopwatch watch;
  LODE_CHECK(check_planes(options.planes));
  LODE_TRY(const TetraCutMesh cut, state_->make_mesh(query_of(options), options, progress));
  TetraSurfaceReport report = make_sections(cut, options, surface);
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the section");
}

Result<TetraSurfaceReport> TetraSession::extract_boundary(const TetraMeshOptions& options,
                                                          Surface& surface,
                                                          Progress& progress) try {
  const Stopwatch watch;
  LODE_TRY(const auto patches, find_patches(state_->impl().info, options.patches));
  LODE_TRY(TetraCutMesh cut, state_->make_mesh(query_of(options), options, progress));
  apply_threshold(options, cut);
  TetraSurfaceReport report = make_boundary(cut, patches, options.threads, surface);
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the boundary");
}

}  // namespace lode

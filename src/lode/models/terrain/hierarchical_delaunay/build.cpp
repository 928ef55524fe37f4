// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), section 7.3 and figure 17.
#include <algorithm>
#include <optional>
#include <utility>

#include "lode/core/flat_index.h"
#include "lode/models/terrain/hierarchical_delaunay/edge_refinement.h"
#include "lode/models/terrain/hierarchical_delaunay/hierarchical_delaunay.h"
#include "lode/models/terrain/triangle_hierarchy/fine_grid.h"
#include "lode/models/terrain/triangle_hierarchy/hierarchy_builder.h"
#include "lode/models/terrain/triangle_hierarchy/polygon.h"

namespace lode::hierarchical_delaunay {
namespace {

using triangle_hierarchy::Crossings;
using triangle_hierarchy::FirstMesh;
using triangle_hierarchy::HierarchyBuilder;
using triangle_hierarchy::kNone;
using triangle_hierarchy::Outline;
using triangle_hierarchy::Patch;
using triangle_hierarchy::SelectedPatch;

constexpr std::size_t kGrain = 16;

/// An edge beyond the tolerance, of one or two triangles.
struct RefinedEdge {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  Crossings crossings = Crossings::all;
  std::vector<ChainPlace> between{};
  std::vector<std::uint32_t> vertices{};  ///< Of these places.
};

/// A triangle to be refined.
struct Refined {
  std::uint32_t triangle = kNone;
  std::array<std::uint32_t, 3> corner{};
  std::array<bool, 3> is_beyond{};
  std::array<std::uint32_t, 3> edges{kNone, kNone, kNone};
  std::optional<Result<Patch>> patch{};  ///< Between its chains; none where these have changed.
};

/// A patch with samples, ready to become triangles of the hierarchy.
struct Filled {
  SelectedPatch selected;
  std::vector<double> errors;  ///< By triangle, with those of its edges.
};

/// With errors of samples and edges.
Filled with_errors(const ReferenceSurface& surface, SelectedPatch selected) {
  Filled filled;
  const Patch& made = selected.patch;
  filled.errors.reserve(made.triangles.size());
  for (std::size_t t = 0; t < made.triangles.size(); ++t) {
    double error = selected.sample_errors[t];
    for (std::size_t i = 0; i < 3; ++i)
      error = std::max(error, surface
                                  .worst_crossing(made.places[made.triangles[t][i]],
                                                  made.places[made.triangles[t][(i + 1) % 3]])
                                  .error);
    filled.errors.push_back(error);
  }
  filled.selected = std::move(selected);
  return filled;
}

Result<Filled> fill(const ReferenceSurface& surface, Patch patch, double limit, Outline outline,
                    Progress& progress) {
  LODE_TRY(SelectedPatch selected,
           select_samples(surface, std::move(patch), limit, outline, progress));
  return with_errors(surface, std::move(selected));
}

/// Of a patch as it is.
Filled measure(const ReferenceSurface& surface, const Patch& patch) {
  SelectedPatch selected{.patch = patch, .sample_errors = {}};
  selected.sample_errors.reserve(patch.triangles.size());
  for (const auto& [a, b, c] : patch.triangles)
    selected.sample_errors.push_back(
        surface
            .measure_samples({patch.places[a], patch.places[b], patch.places[c]},
                             triangle_hierarchy::kNoEdges)
            .closed);
  return with_errors(surface, std::move(selected));
}

class LevelBuilder {
 public:
  LevelBuilder(HierarchyBuilder& builder, HierarchicalDelaunay& made, double tolerance,
               Threads threads)
      : builder_(builder),
        made_(made),
        limit_(tolerance + builder.surface().slack()),
        threads_(threads) {}

  Result<std::vector<HierarchyBuilder::Made>> refine(Progress& progress) {
    for (const std::uint32_t t : builder_.mesh())
      if (builder_.error(t) > limit_)
        refined_.push_back({.triangle = t, .corner = builder_.corners(t)});
    find_edges();
    parallel_for(edges_.size(), threads_, kGrain,
                 [&](std::size_t e, int) { find_chain(edges_[e]); });
    LODE_CHECK(find_patches(progress));
    for (RefinedEdge& edge : edges_) add_chain(edge);
    return fill_all(progress);
  }

  /// Level 0.
  Result<std::vector<HierarchyBuilder::Made>> start(const FirstMesh* first, Progress& progress) {
    Filled filled;
    if (first != nullptr) {
      filled = measure(builder_.surface(), first->patch);
    } else {
      LODE_TRY(filled, fill(builder_.surface(), base_patch(builder_.surface()), limit_,
                            Outline::open, progress));
    }
    std::vector<HierarchyBuilder::Made> made;
    add(filled, kNone, {}, 0, made);
    return made;
  }

 private:
  [[nodiscard]] ChainPlace chain_place(std::uint32_t vertex) const {
    return {builder_.place(vertex), builder_.n_moves(vertex)};
  }

  void find_edges() {
    parallel_for(refined_.size(), threads_, kGrain, [&](std::size_t r, int) {
      const auto places = builder_.places(refined_[r].corner);
      for (std::size_t i = 0; i < 3; ++i)
        refined_[r].is_beyond[i] =
            builder_.surface().worst_crossing(places[i], places[(i + 1) % 3]).error > limit_;
    });
    FlatIndex numbers;
    for (Refined& refined : refined_)
      for (std::size_t i = 0; i < 3; ++i) {
        if (!refined.is_beyond[i]) continue;
        const auto [low, high] = std::minmax({refined.corner[i], refined.corner[(i + 1) % 3]});
        const std::uint64_t key = (std::uint64_t{low} << 32) | high;
        refined.edges[i] = numbers.find(key);
        if (refined.edges[i] != FlatIndex::kNone) continue;
        refined.edges[i] = static_cast<std::uint32_t>(edges_.size());
        numbers.insert(key, refined.edges[i]);
        edges_.push_back({.from = low, .to = high});
      }
  }

  void find_chain(RefinedEdge& edge) const {
    edge.between = refine_edge(builder_.surface(), chain_place(edge.from), chain_place(edge.to),
                               limit_, edge.crossings);
  }

  [[nodiscard]] bool is_forward(const Refined& refined, std::size_t i) const {
    return refined.corner[i] == edges_[refined.edges[i]].from;
  }

  /// Once round: visit_corner(vertex) and visit_chain(edge, i-th of its chain).
  template <typename VisitCorner, typename VisitChain>
  void walk_round(const Refined& refined, const VisitCorner& visit_corner,
                  const VisitChain& visit_chain) const {
    for (std::size_t i = 0; i < 3; ++i) {
      visit_corner(refined.corner[i]);
      if (refined.edges[i] == kNone) continue;
      const RefinedEdge& edge = edges_[refined.edges[i]];
      const std::size_t n = edge.between.size();
      for (std::size_t k = 0; k < n; ++k) visit_chain(edge, is_forward(refined, i) ? k : n - 1 - k);
    }
  }

  void find_patch(Refined& refined) const {
    std::vector<Place> corners;
    walk_round(
        refined, [&](std::uint32_t vertex) { corners.push_back(builder_.place(vertex)); },
        [&](const RefinedEdge& edge, std::size_t k) { corners.push_back(edge.between[k].place); });
    refined.patch = triangulate_polygon(std::move(corners));
    if (*refined.patch && has_refined_edge(refined, **refined.patch))
      refined.patch = fail("expected no edge inside whose chain is on the border");
  }

  /// Whether an edge that has a chain is inside of the patch, too, as a chain may be moved out of
  /// the triangle. Inserting samples brings no such edge: new edges have a new vertex.
  [[nodiscard]] bool has_refined_edge(const Refined& refined, const Patch& patch) const {
    std::array<std::uint32_t, 4> place{};  // of the corners, and of the first one again
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t edge = refined.edges[i];
      place[i + 1] = place[i] + 1;
      if (edge != kNone) place[i + 1] += static_cast<std::uint32_t>(edges_[edge].between.size());
    }
    const std::uint32_t n_places = std::exchange(place[3], 0);
    LODE_EXPECTS(n_places == patch.places.size());
    for (std::size_t i = 0; i < 3; ++i) {
      if (refined.edges[i] == kNone || edges_[refined.edges[i]].between.empty()) continue;
      for (const auto& corners : patch.triangles)
        if (std::ranges::find(corners, place[i]) != corners.end() &&
            std::ranges::find(corners, place[i + 1]) != corners.end())
          return true;
    }
    return false;
  }

  /// Where chains that were moved onto the lattice cross, or leave an edge inside, only vertices
  /// exactly on their edges are left of them: between such chains there is always a patch.
  Result<void> find_patches(Progress& progress) {
    for (bool is_done = false; !is_done;) {
      if (progress.is_cancelled()) return cancelled_error();
      parallel_for(refined_.size(), threads_, kGrain, [&](std::size_t r, int) {
        if (!refined_[r].patch) find_patch(refined_[r]);
      });
      std::vector<bool> is_changed(edges_.size());
      is_done = true;
      for (const Refined& refined : refined_) {
        if (*refined.patch) continue;
        is_done = false;
        LODE_CHECK(straighten(refined, is_changed));
      }
      for (Refined& refined : refined_)
        for (const std::uint32_t edge : refined.edges)
          if (edge != kNone && is_changed[edge]) refined.patch.reset();
    }
    return {};
  }

  Result<void> straighten(const Refined& refined, std::vector<bool>& is_changed) {
    bool has_any = false;
    for (const std::uint32_t e : refined.edges) {
      if (e == kNone) continue;
      has_any = has_any || is_changed[e];
      if (edges_[e].crossings == Crossings::exact) continue;
      edges_[e].crossings = Crossings::exact;
      find_chain(edges_[e]);
      is_changed[e] = true;
      has_any = true;
      ++made_.n_edges_left;
    }
    if (!has_any) return refined.patch->error();
    return {};
  }

  void add_chain(RefinedEdge& edge) {
    for (const ChainPlace& at : edge.between)
      edge.vertices.push_back(builder_.add_vertex(at.place, at.n_moves));
  }

  Result<std::vector<HierarchyBuilder::Made>> fill_all(Progress& progress) {
    std::vector<std::optional<Result<Filled>>> filled(refined_.size());
    parallel_for(refined_.size(), threads_, kGrain, [&](std::size_t r, int) {
      if (progress.is_cancelled()) return;
      filled[r] = fill(builder_.surface(), *std::move(*refined_[r].patch), limit_, Outline::fixed,
                       progress);
    });
    std::vector<HierarchyBuilder::Made> made;
    for (std::size_t r = 0; r < refined_.size(); ++r) {
      if (!filled[r]) return cancelled_error();
      if (!*filled[r]) return filled[r]->error();
      // Where all that errs was left.
      if ((*filled[r])->errors.size() < 2) continue;
      std::vector<std::uint32_t> vertices;
      std::int32_t n_moves = 0;
      walk_round(
          refined_[r], [&](std::uint32_t vertex) { vertices.push_back(vertex); },
          [&](const RefinedEdge& edge, std::size_t k) { vertices.push_back(edge.vertices[k]); });
      for (const std::uint32_t vertex : vertices)
        n_moves = std::max(n_moves, builder_.n_moves(vertex));
      add(**filled[r], refined_[r].triangle, std::move(vertices), n_moves, made);
      filled[r].reset();
    }
    return made;
  }

  /// vertices: those of the patch's first places.
  void add(const Filled& filled, std::uint32_t triangle, std::vector<std::uint32_t> vertices,
           std::int32_t n_moves, std::vector<HierarchyBuilder::Made>& made) {
    const Patch& patch = filled.selected.patch;
    for (std::size_t i = vertices.size(); i < patch.places.size(); ++i)
      vertices.push_back(builder_.add_vertex(patch.places[i], n_moves));
    for (std::size_t t = 0; t < patch.triangles.size(); ++t) {
      const auto& [a, b, c] = patch.triangles[t];
      made.push_back({.refined = triangle,
                      .corner = {vertices[a], vertices[b], vertices[c]},
                      .sample_error = filled.selected.sample_errors[t],
                      .error = filled.errors[t]});
    }
  }

  HierarchyBuilder& builder_;
  HierarchicalDelaunay& made_;
  double limit_;
  Threads threads_;
  std::vector<Refined> refined_;
  std::vector<RefinedEdge> edges_;
};

}  // namespace

Result<HierarchicalDelaunay> build(const ReferenceSurface& surface,
                                   std::span<const double> tolerances, Threads threads,
                                   Progress& progress, const FirstMesh* first) {
  LODE_CHECK(triangle_hierarchy::check_tolerances(tolerances));
  HierarchicalDelaunay made;
  HierarchyBuilder builder(surface);
  for (std::size_t level = 0; level < tolerances.size(); ++level) {
    progress.report("refining",
                    static_cast<double>(level) / static_cast<double>(tolerances.size()));
    LevelBuilder of_level(builder, made, tolerances[level], threads);
    LODE_TRY(auto triangles,
             level == 0 ? of_level.start(first, progress) : of_level.refine(progress));
    std::ranges::stable_sort(triangles, {}, &HierarchyBuilder::Made::refined);
    LODE_CHECK(builder.add_level(tolerances[level], triangles));
  }
  made.hierarchy = builder.finish();
  if (first != nullptr) made.hierarchy.lines = first->lines;
  return made;
}

Result<HierarchicalDelaunay> build(const HeightGrid& heights, std::span<const double> tolerances,
                                   Threads threads, Progress& progress) {
  LODE_TRY(const auto grid, triangle_hierarchy::FineGrid::make(heights));
  return build(grid, tolerances, threads, progress);
}

}  // namespace lode::hierarchical_delaunay

// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), section 7.2 and figure 16, after L. Scarlatos, T.
// Pavlidis, "Hierarchical triangulation using cartographic coherence", CVGIP 54 (1992).
#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "lode/core/expects.h"
#include "lode/core/flat_index.h"
#include "lode/models/terrain/adaptive_triangulation/adaptive_triangulation.h"
#include "lode/models/terrain/triangle_hierarchy/fine_grid.h"
#include "lode/models/terrain/triangle_hierarchy/hierarchy_builder.h"
#include "lode/models/terrain/triangle_hierarchy/patch.h"

namespace lode::adaptive_triangulation {
namespace {

using triangle_hierarchy::EdgeSplit;
using triangle_hierarchy::FirstMesh;
using triangle_hierarchy::HierarchyBuilder;
using triangle_hierarchy::kNone;
using triangle_hierarchy::Patch;
using triangle_hierarchy::Place;
using triangle_hierarchy::ReferenceSurface;
using triangle_hierarchy::SampleErrors;

/// A triangle of which it is not yet known whether it is split.
struct Candidate {
  std::uint32_t refined = kNone;  ///< What it is part of.
  bool is_whole = false;          ///< It is just that.
  std::array<std::uint32_t, 3> corner{};
  SampleErrors samples{};
  std::array<EdgeSplit, 3> edges{};
  std::array<std::uint32_t, 3> shared{kNone, kNone, kNone};  ///< Of edges beyond the tolerance.
  std::optional<Split> split{};

  /// Samples on edges are among their crossings.
  [[nodiscard]] double error() const {
    return std::max({samples.inner, edges[0].error, edges[1].error, edges[2].error});
  }
};

/// An edge beyond the tolerance, of one or two triangles.
struct SharedEdge {
  EdgeSplit split;
  bool is_left = false;  ///< It cannot be split.
  std::uint32_t vertex = kNone;
};

std::uint64_t key_of(std::uint32_t a, std::uint32_t b) {
  return (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
}

/// Splits triangles until they are within a tolerance: all at once, again and again, which is the
/// same as one after another, as what becomes of each depends on itself and its edges alone.
class LevelRefiner {
 public:
  LevelRefiner(HierarchyBuilder& builder, double tolerance, AdaptiveTriangulation& made)
      : builder_(builder), limit_(tolerance + builder.surface().slack()), report_(made) {}

  Result<std::vector<HierarchyBuilder::Made>> run(std::vector<Candidate> candidates,
                                                  Threads threads, Progress& progress) {
    while (!candidates.empty()) {
      if (progress.is_cancelled()) return cancelled_error();
      constexpr std::size_t kGrain = 64;
      parallel_for(candidates.size(), threads, kGrain,
                   [&](std::size_t i, int) { judge(candidates[i]); });
      for (Candidate& candidate : candidates) share_edges(candidate);
      while (!plan(candidates)) {
      }
      std::vector<Candidate> next;
      for (const Candidate& candidate : candidates) {
        if (candidate.split)
          apply(candidate, next);
        else
          keep(candidate);
      }
      candidates = std::move(next);
    }
    std::ranges::stable_sort(kept_, {}, &HierarchyBuilder::Made::refined);
    return std::move(kept_);
  }

 private:
  void judge(Candidate& candidate) const {
    const auto corners = builder_.places(candidate.corner);
    candidate.samples = builder_.surface().measure_samples(corners, triangle_hierarchy::kNoEdges);
    for (std::size_t i = 0; i < 3; ++i)
      candidate.edges[i] = builder_.surface().worst_crossing(corners[i], corners[(i + 1) % 3]);
  }

  void share_edges(Candidate& candidate) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (candidate.edges[i].error <= limit_) continue;
      const std::uint64_t key = key_of(candidate.corner[i], candidate.corner[(i + 1) % 3]);
      candidate.shared[i] = edge_numbers_.find(key);
      if (candidate.shared[i] != FlatIndex::kNone) continue;
      candidate.shared[i] = static_cast<std::uint32_t>(edges_.size());
      edge_numbers_.insert(key, candidate.shared[i]);
      edges_.push_back({.split = candidate.edges[i]});
    }
  }

  [[nodiscard]] bool is_split(const Candidate& candidate, std::size_t edge) const {
    return candidate.shared[edge] != kNone && !edges_[candidate.shared[edge]].is_left;
  }

  /// Decides on all splits; false: on the way an edge turned out to be none to split, and others
  /// may have counted on it.
  bool plan(std::vector<Candidate>& candidates) {
    bool is_final = true;
    for (Candidate& candidate : candidates) {
      Insertion insertion;
      bool has_any = candidate.samples.inner > limit_;
      if (has_any) insertion.centre = candidate.samples.at;
      for (std::size_t i = 0; i < 3; ++i) {
        insertion.corner[i] = builder_.place(candidate.corner[i]).at;
        if (!is_split(candidate, i)) continue;
        insertion.on_edge[i] = edges_[candidate.shared[i]].split.place.at;
        has_any = true;
      }
      candidate.split = has_any ? split_triangle(insertion) : std::nullopt;
      if (!has_any || candidate.split) continue;
      leave_edge(candidate);
      is_final = false;
    }
    return is_final;
  }

  /// Gives up the place with the smallest error of those not exactly on their edges, for the worst
  /// that is, if it must be: with all places exactly on edges there is a split.
  void leave_edge(const Candidate& candidate) {
    std::size_t least = 3;
    for (std::size_t i = 0; i < 3; ++i) {
      if (!is_split(candidate, i) || edges_[candidate.shared[i]].split.is_exact) continue;
      if (least == 3 || candidate.edges[i].error < candidate.edges[least].error) least = i;
    }
    LODE_EXPECTS(least < 3);
    SharedEdge& edge = edges_[candidate.shared[least]];
    edge.split = builder_.surface().worst_crossing(
        builder_.place(candidate.corner[least]), builder_.place(candidate.corner[(least + 1) % 3]),
        triangle_hierarchy::Crossings::exact);
    edge.is_left = edge.split.error <= limit_;
    if (edge.is_left) ++report_.n_edges_left;
  }

  [[nodiscard]] std::int32_t n_moves(const Candidate& candidate) const {
    return std::max({builder_.n_moves(candidate.corner[0]), builder_.n_moves(candidate.corner[1]),
                     builder_.n_moves(candidate.corner[2])});
  }

  /// The vertex on an edge, made by the first triangle that asks.
  std::uint32_t vertex_on(const Candidate& candidate, std::size_t i) {
    SharedEdge& edge = edges_[candidate.shared[i]];
    if (edge.vertex == kNone)
      edge.vertex = builder_.add_vertex(edge.split.place,
                                        std::max(builder_.n_moves(candidate.corner[i]),
                                                 builder_.n_moves(candidate.corner[(i + 1) % 3])) +
                                            (edge.split.is_exact ? 0 : 1));
    return edge.vertex;
  }

  void apply(const Candidate& candidate, std::vector<Candidate>& next) {
    const Split& split = *candidate.split;
    ++report_.n_splits[static_cast<std::size_t>(split.rule)];
    std::array<std::uint32_t, 7> vertices{};
    for (std::size_t i = 0; i < 3; ++i) {
      vertices[i] = candidate.corner[i];
      if (is_split(candidate, i)) vertices[3 + i] = vertex_on(candidate, i);
    }
    if (split.rule == Rule::centre || split.rule == Rule::edge_and_centre) {
      const LatticePoint at = candidate.samples.at;
      vertices[6] = builder_.add_vertex({at, builder_.surface().height(at)}, n_moves(candidate));
    }
    for (std::size_t t = 0; t < split.n_triangles; ++t) {
      Candidate child{.refined = candidate.refined};
      for (std::size_t i = 0; i < 3; ++i) child.corner[i] = vertices[split.triangles[t][i]];
      next.push_back(child);
    }
  }

  void keep(const Candidate& candidate) {
    if (candidate.is_whole) return;
    kept_.push_back({.refined = candidate.refined,
                     .corner = candidate.corner,
                     .sample_error = candidate.samples.closed,
                     .error = candidate.error()});
  }

  HierarchyBuilder& builder_;
  double limit_;
  AdaptiveTriangulation& report_;
  FlatIndex edge_numbers_;
  std::vector<SharedEdge> edges_;
  std::vector<HierarchyBuilder::Made> kept_;
};

std::vector<Candidate> patch_candidates(HierarchyBuilder& builder, const Patch& patch) {
  for (const Place& place : patch.places) builder.add_vertex(place, 0);
  std::vector<Candidate> candidates;
  candidates.reserve(patch.triangles.size());
  for (const auto& corner : patch.triangles) candidates.push_back({.corner = corner});
  return candidates;
}

/// The Delaunay selector's mesh: its vertices stand for the surface-specific points of the paper.
Result<std::vector<Candidate>> first_candidates(HierarchyBuilder& builder, double limit,
                                                Progress& progress) {
  LODE_TRY(const auto selected, select_samples(builder.surface(), base_patch(builder.surface()),
                                               limit, triangle_hierarchy::Outline::open, progress));
  return patch_candidates(builder, selected.patch);
}

std::vector<Candidate> mesh_candidates(const HierarchyBuilder& builder, double limit) {
  std::vector<Candidate> candidates;
  for (const std::uint32_t t : builder.mesh())
    if (builder.error(t) > limit)
      candidates.push_back({.refined = t, .is_whole = true, .corner = builder.corners(t)});
  return candidates;
}

}  // namespace

Result<AdaptiveTriangulation> build(const ReferenceSurface& surface,
                                    std::span<const double> tolerances, Threads threads,
                                    Progress& progress, const FirstMesh* first) {
  LODE_CHECK(triangle_hierarchy::check_tolerances(tolerances));
  AdaptiveTriangulation made;
  HierarchyBuilder builder(surface);
  for (std::size_t level = 0; level < tolerances.size(); ++level) {
    progress.report("refining",
                    static_cast<double>(level) / static_cast<double>(tolerances.size()));
    const double tolerance = tolerances[level];
    LevelRefiner refiner(builder, tolerance, made);
    std::vector<Candidate> candidates;
    if (level > 0) {
      candidates = mesh_candidates(builder, tolerance + surface.slack());
    } else if (first != nullptr) {
      candidates = patch_candidates(builder, first->patch);
    } else {
      LODE_TRY(candidates, first_candidates(builder, tolerance + surface.slack(), progress));
    }
    LODE_TRY(const auto triangles, refiner.run(std::move(candidates), threads, progress));
    LODE_CHECK(builder.add_level(tolerance, triangles));
  }
  made.hierarchy = builder.finish();
  if (first != nullptr) made.hierarchy.lines = first->lines;
  return made;
}

Result<AdaptiveTriangulation> build(const HeightGrid& heights, std::span<const double> tolerances,
                                    Threads threads, Progress& progress) {
  LODE_TRY(const auto grid, triangle_hierarchy::FineGrid::make(heights));
  return build(grid, tolerances, threads, progress);
}

}  // namespace lode::adaptive_triangulation

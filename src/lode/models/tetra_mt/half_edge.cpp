#include "lode/models/tetra_mt/half_edge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "lode/models/tetra_mt/interfaces.h"
#include "lode/models/tetra_mt/left_mesh.h"
#include "lode/models/tetra_mt/mesh_check.h"
#include "lode/models/tetra_mt/space_blocks.h"

namespace lode::tetra_mt {
namespace {

/// Vertices: what belongs to one fits the second cache.
constexpr std::size_t kBlockSize = 6000;
/// Of what is left, how much is to go in a round, in the order of quadrics more, as nobody asks it
/// to be exact; and at least of what is left to go.
constexpr double kRoundShare = 0.2;
constexpr double kQuadricRoundShare = 0.35;
constexpr double kLastShare = 0.6;
/// Rounds without much effect, in blocks elsewhere each, after which nothing is left to do.
constexpr int kMaxIdle = 4;
constexpr double kMuch = 1e-3;
constexpr std::array<double, 5> kShares{0.5, 0.38, 0.62, 0.44, 0.56};

class Rounds {
 public:
  Rounds(const HalfEdgeOptions& options, BuildState& state)
      : options_(options),
        state_(state),
        places_(static_cast<std::size_t>(n_workers(options.threads)),
                std::vector<std::uint32_t>(state.outside + std::size_t{1})) {}

  Result<void> run(Progress& progress) {
    const auto n_first = static_cast<double>(state_.n_cells);
    const auto n_last = static_cast<double>(options_.base_cells);
    cut(0);
    visit_blocks([](std::size_t, BlockCollapser& block) { block.find_keys(); });
    int n_idle = 0;  // rounds in a row
    for (int round = 0;
         static_cast<double>(state_.n_cells) > kNearBase * n_last && n_idle < kMaxIdle; ++round) {
      if (progress.is_cancelled()) return cancelled_error();
      if (round > 0) cut(round);
      n_idle = collapse_round() > kMuch ? 0 : n_idle + 1;
      progress.report("collapsing edges", (n_first - static_cast<double>(state_.n_cells)) /
                                              std::max(n_first - n_last, 1.0));
    }
    return {};
  }

 private:
  /// Vertices that are there, and by block the tetrahedra that have one of its own.
  void cut(int round) {
    std::vector<std::uint32_t> there;
    for (std::uint32_t v = 0; v < state_.outside; ++v)
      if (state_.is_there[v] != 0) there.push_back(v);
    blocks_ = cut_mesh(state_.mesh.positions, std::move(there), state_.tetrahedra, kBlockSize,
                       kShares[static_cast<std::size_t>(round) % kShares.size()], options_.threads);
  }

  template <typename Visit>
  void visit_blocks(const Visit& visit) {
    parallel_for(blocks_.size(), options_.threads, 1, [&](std::size_t b, int worker) {
      BlockCollapser block(state_, blocks_.vertices.of(b), blocks_.slots[b],
                           places_[static_cast<std::size_t>(worker)], options_.rules);
      visit(b, block);
    });
  }

  [[nodiscard]] double round_share() const {
    return options_.rules.order == CollapseOrder::quadric ? kQuadricRoundShare : kRoundShare;
  }

  /// Returns which share of the cells has gone.
  double collapse_round() {
    const auto before = static_cast<double>(state_.n_cells);
    const double left = before - static_cast<double>(options_.base_cells);
    const double aim =
        left < 0.01 * before ? left : std::min(round_share() * before, kLastShare * left);
    const double share = std::min(0.9, aim / before / gain_);
    const float limit = find_limit(share);
    std::vector<std::vector<Collapse>> collapses(blocks_.size());
    std::vector<std::vector<CollapseFacts>> facts(blocks_.size());
    std::vector<CollapseStars> stars(blocks_.size());
    std::vector<std::uint64_t> n_gone(blocks_.size(), 0);
    visit_blocks([&](std::size_t b, BlockCollapser& block) {
      // No block may take more than its part of what is left to go.
      const double part = static_cast<double>(blocks_.vertices.of(b).size()) /
                          static_cast<double>(blocks_.vertices.points.size());
      block.run(limit, static_cast<std::uint64_t>(std::ceil(part * left)));
      block.write_back();
      n_gone[b] = block.n_cells_gone();
      collapses[b].assign(block.collapses().begin(), block.collapses().end());
      facts[b].assign(block.facts().begin(), block.facts().end());
      stars[b] = block.take_stars();
    });
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      state_.n_cells -= n_gone[b];
      state_.collapses.insert(state_.collapses.end(), collapses[b].begin(), collapses[b].end());
      state_.facts.insert(state_.facts.end(), facts[b].begin(), facts[b].end());
      if (!collapses[b].empty()) state_.stars.push_back(std::move(stars[b]));
    }
    const double gone = (before - static_cast<double>(state_.n_cells)) / before;
    gain_ = std::clamp(gone / share, gain_ / 2, gain_ * 2);
    return gone;
  }

  /// The key that a share of the vertices which may go is below.
  [[nodiscard]] float find_limit(double share) const {
    std::vector<float> keys;
    for (const std::uint32_t v : blocks_.vertices.points)
      if (state_.is_locked[v] == 0 && std::isfinite(state_.keys[v])) keys.push_back(state_.keys[v]);
    if (keys.empty()) return 0;
    const auto at = static_cast<std::size_t>(share * static_cast<double>(keys.size()));
    std::nth_element(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(at), keys.end());
    return std::nextafter(keys[at], std::numeric_limits<float>::infinity());
  }

  HalfEdgeOptions options_;
  BuildState& state_;
  std::vector<std::vector<std::uint32_t>> places_;  ///< By worker.
  double gain_ = 1.5;  ///< What share goes, against that of vertices that a limit lets.
  MeshBlocks blocks_;
};

/// Of all vertices that are left.
RefusalCounts count_refusals(BuildState& state, const HalfEdgeOptions& options) {
  LeftMesh left = left_mesh(state, options.base_cells);
  return BlockCollapser(state, left.vertices, left.slots, left.places, options.rules)
      .count_refusals();
}

}  // namespace

Result<HalfEdgeCollapses> collapse_half_edges(const TetraMesh& mesh, const HalfEdgeOptions& options,
                                              Progress& progress) {
  LODE_CHECK(check_mesh(mesh));
  const double tolerance = options.rules.boundary_tolerance;
  if (!(tolerance >= 0 && std::isfinite(tolerance)))
    return fail("boundary tolerance: expected a distance of at least 0, got {}", tolerance);
  BuildState state(mesh, options.rules.order);
  LODE_CHECK(state.close(options.threads));
  state.set_limits(tolerance);
  if (options.rules.keeps_extrema) state.stays.assign(state.outside, 0);
  const double volume = state.volume();
  std::vector<Tetrahedron> outer(
      state.tetrahedra.begin() + static_cast<std::ptrdiff_t>(mesh.tetrahedra.size()),
      state.tetrahedra.end());
  LODE_CHECK(Rounds(options, state).run(progress));
  HalfEdgeCollapses result;
  result.refusals = count_refusals(state, options);
  for (std::size_t slot = 0; slot < mesh.tetrahedra.size(); ++slot) {
    if (state.tetrahedra[slot][0] == kNone) continue;
    result.base.push_back(state.tetrahedra[slot]);
    result.base_makers.push_back(state.makers[slot]);
    if (!state.labels.empty()) result.base_regions.push_back(state.labels[slot]);
  }
  for (std::size_t i = 0; i < outer.size(); ++i) {
    const std::size_t slot = mesh.tetrahedra.size() + i;
    if (state.tetrahedra[slot][0] == kNone) continue;
    result.outer_base.push_back({state.tetrahedra[slot],
                                 {outer[i][1], outer[i][2], outer[i][3]},
                                 state.makers[slot],
                                 state.labels.empty() ? 0 : patch_mark(state.labels[slot])});
  }
  for (std::size_t slot = 0; slot < state.tetrahedra.size(); ++slot)
    if (state.tetrahedra[slot][0] != kNone)
      result.boundary_deviation =
          std::max(result.boundary_deviation, static_cast<double>(state.deviations[slot]));
  result.volume_change = state.volume() - volume;
  result.collapses = std::move(state.collapses);
  result.facts = std::move(state.facts);
  result.has_world_errors = options.rules.has_world_errors;
  result.stars = std::move(state.stars);
  result.errors = std::move(state.errors);
  return result;
}

}  // namespace lode::tetra_mt

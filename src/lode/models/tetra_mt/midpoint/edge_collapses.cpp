#include "lode/models/tetra_mt/midpoint/edge_collapses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "lode/models/tetra_mt/left_mesh.h"
#include "lode/models/tetra_mt/mesh_check.h"
#include "lode/models/tetra_mt/midpoint/edge_collapser.h"
#include "lode/models/tetra_mt/space_blocks.h"

namespace lode::tetra_mt::midpoint {
namespace {

/// As for half edges (half_edge.cpp): vertices, shares of what is left that go in a round, and
/// rounds without much effect after which nothing is left to do.
constexpr std::size_t kBlockSize = 6000;
constexpr double kRoundShare = 0.2;
constexpr double kLastShare = 0.6;
constexpr int kMaxIdle = 4;
constexpr double kMuch = 1e-3;
constexpr std::array<double, 5> kShares{0.5, 0.38, 0.62, 0.44, 0.56};

class Rounds {
 public:
  Rounds(const EdgeCollapseOptions& options, State& state)
      : options_(options),
        state_(state),
        places_(static_cast<std::size_t>(n_workers(options.threads)),
                std::vector<std::uint32_t>(state.outside + std::size_t{1})) {}

  Result<void> run(Progress& progress) {
    const auto n_first = static_cast<double>(state_.n_cells);
    const auto n_last = static_cast<double>(options_.base_cells);
    find_keys();
    int n_idle = 0;  // rounds in a row
    for (int round = 0;
         static_cast<double>(state_.n_cells) > kNearBase * n_last && n_idle < kMaxIdle; ++round) {
      if (progress.is_cancelled()) return cancelled_error();
      cut(round);
      n_idle = collapse_round() > kMuch ? 0 : n_idle + 1;
      progress.report("collapsing edges", (n_first - static_cast<double>(state_.n_cells)) /
                                              std::max(n_first - n_last, 1.0));
    }
    return {};
  }

 private:
  void cut(int round) {
    std::vector<std::uint32_t> there;
    for (std::uint32_t v = 0; v < state_.outside; ++v)
      if (state_.is_there[v] != 0) there.push_back(v);
    blocks_ = cut_mesh(state_.positions, std::move(there), state_.tetrahedra, kBlockSize,
                       kShares[static_cast<std::size_t>(round) % kShares.size()], options_.threads);
  }

  /// Blocks with what is beside their vertices, as edges there belong to one block each.
  void find_keys() {
    cut(0);
    std::vector<std::vector<std::uint32_t>> stars(state_.outside);
    for (std::uint32_t slot = 0; slot < state_.tetrahedra.size(); ++slot)
      for (const std::uint32_t v : state_.tetrahedra[slot])
        if (v != state_.outside) stars[v].push_back(slot);
    const auto visit = [&](const auto& what) {
      parallel_for(blocks_.size(), options_.threads, 1, [&](std::size_t b, int worker) {
        std::vector<std::uint32_t> vertices(blocks_.vertices.of(b).begin(),
                                            blocks_.vertices.of(b).end());
        const std::size_t n = vertices.size();
        for (const std::uint32_t slot : blocks_.slots[b])
          for (const std::uint32_t v : state_.tetrahedra[slot])
            if (v != state_.outside && blocks_.block_of[v] != b) vertices.push_back(v);
        const auto beside = vertices.begin() + static_cast<std::ptrdiff_t>(n);
        std::sort(beside, vertices.end());
        vertices.erase(std::unique(beside, vertices.end()), vertices.end());
        std::vector<std::uint32_t> slots = blocks_.slots[b];
        for (std::size_t i = n; i < vertices.size(); ++i)
          slots.insert(slots.end(), stars[vertices[i]].begin(), stars[vertices[i]].end());
        std::ranges::sort(slots);
        slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
        EdgeCollapser block(state_, vertices, slots, places_[static_cast<std::size_t>(worker)]);
        what(block, n);
      });
    };
    visit([](EdgeCollapser& block, std::size_t n) { block.find_locked(n); });
    if (options_.order == CollapseOrder::quadric)
      visit([](EdgeCollapser& block, std::size_t n) { block.find_quadrics(n); });
    visit([](EdgeCollapser& block, std::size_t n) { block.find_keys(n); });
  }

  /// Returns which share of the cells has gone.
  double collapse_round() {
    const auto before = static_cast<double>(state_.n_cells);
    const double left = before - static_cast<double>(options_.base_cells);
    const double aim =
        left < 0.01 * before ? left : std::min(kRoundShare * before, kLastShare * left);
    const double share = std::min(0.9, aim / before / gain_);
    const float limit = find_limit(share);
    std::vector<std::vector<EdgeCollapse>> collapses(blocks_.size());
    std::vector<std::vector<EdgeFacts>> facts(blocks_.size());
    std::vector<std::uint64_t> n_gone(blocks_.size(), 0);
    parallel_for(blocks_.size(), options_.threads, 1, [&](std::size_t b, int worker) {
      EdgeCollapser block(state_, blocks_.vertices.of(b), blocks_.slots[b],
                          places_[static_cast<std::size_t>(worker)]);
      // No block may take more than its part of what is left to go.
      const double part = static_cast<double>(blocks_.vertices.of(b).size()) /
                          static_cast<double>(blocks_.vertices.points.size());
      block.run(limit, static_cast<std::uint64_t>(std::ceil(part * left)));
      block.write_back();
      n_gone[b] = block.n_cells_gone();
      collapses[b].assign(block.collapses().begin(), block.collapses().end());
      facts[b].assign(block.facts().begin(), block.facts().end());
    });
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      state_.n_cells -= n_gone[b];
      state_.collapses.insert(state_.collapses.end(), collapses[b].begin(), collapses[b].end());
      state_.facts.insert(state_.facts.end(), facts[b].begin(), facts[b].end());
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

  EdgeCollapseOptions options_;
  State& state_;
  std::vector<std::vector<std::uint32_t>> places_;  ///< By worker.
  double gain_ = 1.5;  ///< What share goes, against that of vertices that a limit lets.
  MeshBlocks blocks_;
};

/// Of all vertices that are left.
RefusalCounts count_refusals(State& state, const EdgeCollapseOptions& options) {
  LeftMesh left = left_mesh(state, options.base_cells);
  return EdgeCollapser(state, left.vertices, left.slots, left.places).count_refusals();
}

}  // namespace

Result<EdgeCollapses> collapse_edges(const TetraMesh& mesh, const EdgeCollapseOptions& options,
                                     Progress& progress) {
  LODE_CHECK(check_mesh(mesh));
  if (mesh.fields.empty()) return fail("midpoints: expected a field, got none");
  const double tolerance = options.boundary_tolerance;
  if (!(tolerance >= 0 && std::isfinite(tolerance)))
    return fail("boundary tolerance: expected a distance of at least 0, got {}", tolerance);
  State state(mesh, options.order, tolerance);
  state.has_world_errors = options.has_world_errors;
  LODE_CHECK(state.close(options.threads));
  const double volume = state.volume();
  LODE_CHECK(Rounds(options, state).run(progress));
  EdgeCollapses result;
  result.n_base_cells = state.n_cells;
  result.refusals = count_refusals(state, options);
  for (std::size_t slot = 0; slot < state.deviations.size(); ++slot)
    if (state.tetrahedra[slot][0] != kNone)
      result.boundary_deviation = std::max(result.boundary_deviation, state.deviations[slot]);
  result.volume_change = state.volume() - volume;
  result.boundary_tolerance = tolerance;
  result.has_world_errors = options.has_world_errors;
  result.collapses = std::move(state.collapses);
  result.facts = std::move(state.facts);
  result.errors = std::move(state.errors);
  return result;
}

}  // namespace lode::tetra_mt::midpoint

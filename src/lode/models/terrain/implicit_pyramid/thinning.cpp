#include "lode/models/terrain/implicit_pyramid/thinning.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lode/models/terrain/implicit_pyramid/thinned_mesh.h"

namespace lode::implicit_pyramid {
namespace {

using delaunay::LatticePoint;

class Thinner {
 public:
  Thinner(delaunay::Tin full, const std::vector<bool>& must_stay)
      : mesh_(std::move(full)), last_level_(must_stay.size(), 0) {
    for (std::uint32_t v = 0; v < must_stay.size(); ++v)
      if (!must_stay[v]) left_.push_back(v);
    n_all_ = left_.size();
  }

  Result<Thinning> run(Progress& progress) {
    Thinning levels;
    std::size_t most_neighbours = kMostNeighbours;
    while (!left_.empty()) {
      if (progress.is_cancelled()) return cancelled_error();
      progress.report("thinning", 1 - static_cast<double>(left_.size()) /
                                          static_cast<double>(std::max<std::size_t>(n_all_, 1)));
      ++level_;
      std::vector<RemovedVertex> removed = remove_level(most_neighbours);
      // Where all that is left has more, more must do.
      most_neighbours = removed.empty() ? 2 * most_neighbours : kMostNeighbours;
      if (!removed.empty()) levels.push_back(std::move(removed));
    }
    return levels;
  }

 private:
  struct Candidate {
    float surprise;
    std::uint32_t vertex;
    bool operator<(const Candidate& other) const {
      return surprise != other.surprise ? surprise < other.surprise : vertex < other.vertex;
    }
  };

  std::vector<RemovedVertex> remove_level(std::size_t most_neighbours) {
    candidates_.clear();
    for (const std::uint32_t v : left_) {
      const auto& ring = mesh_.neighbours(v);
      if (ring.size() <= most_neighbours) candidates_.push_back({surprise_of(v, ring), v});
    }
    std::sort(candidates_.begin(), candidates_.end());
    std::vector<RemovedVertex> removed;
    for (const Candidate& candidate : candidates_) {
      if (last_level_[candidate.vertex] == level_) continue;
      const auto& ring = mesh_.neighbours(candidate.vertex);
      for (const std::uint32_t v : ring) last_level_[v] = level_;
      removed.push_back({candidate.vertex, ring.front()});
      mesh_.remove(candidate.vertex);
      last_level_[candidate.vertex] = kGone;
    }
    std::erase_if(left_, [&](std::uint32_t v) { return last_level_[v] == kGone; });
    std::ranges::sort(removed, {}, &RemovedVertex::vertex);
    return removed;
  }

  /// How far a height is from the mean of its neighbours', the near ones counting more. An
  /// estimate.
  [[nodiscard]] float surprise_of(std::uint32_t v, const std::vector<std::uint32_t>& ring) const {
    const delaunay::Tin& tin = mesh_.tin();
    double sum = 0;
    double weights = 0;
    for (const std::uint32_t u : ring) {
      const double dx = tin.vertices[u].x - tin.vertices[v].x;
      const double dy = tin.vertices[u].y - tin.vertices[v].y;
      const double weight = 1 / (dx * dx + dy * dy);
      sum += weight * tin.heights[u];
      weights += weight;
    }
    return static_cast<float>(std::abs(tin.heights[v] - sum / weights));
  }

  static constexpr std::uint32_t kGone = 0xffffffff;

  ThinnedMesh mesh_;
  std::vector<std::uint32_t> left_;        ///< That may go, ascending.
  std::vector<std::uint32_t> last_level_;  ///< By vertex: the last level that a neighbour went in.
  std::vector<Candidate> candidates_;
  std::uint32_t level_ = 0;
  std::size_t n_all_ = 0;
};

}  // namespace

Result<Thinning> thin(delaunay::Tin full, const std::vector<bool>& must_stay, Progress& progress) {
  return Thinner(std::move(full), must_stay).run(progress);
}

}  // namespace lode::implicit_pyramid

#include "lode/models/diamond/distance_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "lode/core/box.h"
#include "lode/mappers/facet_proof.h"
#include "lode/models/diamond/leaf_facets.h"
#include "lode/models/diamond/leaf_node.h"

namespace lode::diamond {
namespace {

/// Facets that failed, and the largest bound of those that did not.
struct Found {
  double proven = 0;
  std::vector<std::uint32_t> failing;
};

/// prove(i, hint) -> FacetProof for i in 0 .. n, in parallel; failing ones in order. `hint`: a
/// witness of one before it.
template <typename Prove>
Found prove_all(std::size_t n, Threads threads, const Progress& progress, const Prove& prove) {
  constexpr std::size_t kChunk = 1024;
  std::vector<Found> parts((n + kChunk - 1) / kChunk);
  parallel_for(parts.size(), threads, 1, [&](std::size_t chunk, int) {
    if (progress.is_cancelled()) return;
    Found& part = parts[chunk];
    std::uint32_t hint = FacetGrid::kNone;
    for (std::size_t i = chunk * kChunk; i < std::min(n, (chunk + 1) * kChunk); ++i) {
      const FacetProof proof = prove(i, hint);
      if (proof.witness != FacetGrid::kNone) hint = proof.witness;
      if (proof.holds)
        part.proven = std::max(part.proven, proof.bound);
      else
        part.failing.push_back(static_cast<std::uint32_t>(i));
    }
  });
  Found all;
  for (const Found& part : parts) {
    all.proven = std::max(all.proven, part.proven);
    all.failing.insert(all.failing.end(), part.failing.begin(), part.failing.end());
  }
  return all;
}

double largest_coordinate(std::span<const Facet> facets) {
  double largest = 0;
  for (const Facet& facet : facets)
    for (const Vec3f& p : facet.corner)
      for (const float x : p.v) largest = std::max(largest, std::abs(static_cast<double>(x)));
  return largest;
}

class DistanceSearch {
 public:
  DistanceSearch(DistanceWindow& window, double max_distance, Threads threads, Progress& progress)
      : window_(window), threads_(threads), progress_(progress), max_distance_(max_distance) {}

  Result<DistanceCutReport> run() {
    progress_.report("finding the full-resolution surface", window_.share_done());
    full_ = window_.full(progress_);
    if (progress_.is_cancelled()) return cancelled_error();
    report_.n_full_triangles = full_.n_own;
    limit_ = max_distance_ - distance_rounding(largest_coordinate(full_.all));
    if (!(limit_ > 0)) {
      refine_everywhere();
    } else if (full_.n_own > 0) {
      report_.n_nodes += window_.insert_guess();
      LODE_CHECK(search());
    }
    return report_;
  }

 private:
  /// Of a facet of full resolution: not known, or not by a single witness; else the place of its
  /// witness's leaf, or where it fails that of its own, marked.
  static constexpr std::uint64_t kUnknown = ~std::uint64_t{0};
  static constexpr std::uint64_t kFailing = LeafPlace::kFresh;
  static constexpr int kOldest = 63;
  /// Facets of full resolution are small.
  static constexpr int kMostPiecesOfCut = 4096;
  static constexpr int kMostPiecesOfTruth = 256;
  /// What is refined in a round, as a share of what fails, at least.
  static constexpr double kShareAtOnce = 0.5;

  void refine_everywhere() {
    const auto is_above_finest = [](const Simplex<3>& s) {
      const Diamond<3> node = diamond_at<3>(s.bisection_point());
      return node.level > 0 || node.tier < 2;
    };
    for (std::size_t i = 0; i < full_.n_own; ++i)
      if (const auto node =
              leaf_node(window_.shape(), to_point(full_.all[i].place), is_above_finest))
        report_.n_nodes += window_.insert(*node);
  }

  Result<void> search() {
    const FacetGrid truth(full_.all, max_distance_);
    states_.assign(full_.n_own, kUnknown);
    while (true) {
      progress_.report("proving the distance", window_.share_done());
      ++report_.n_rounds;
      const DistanceWindow::Facets facets = window_.cut(progress_);
      prove_cut(facets, truth);
      const FacetGrid cut(facets.all, max_distance_);
      prove_truth(cut);
      while (next_turn() < turn_) {
        turn_ = next_turn();
        prove_truth(cut);
      }
      if (progress_.is_cancelled()) return cancelled_error();
      if (!refine_failing()) {
        list_lost();
        return {};
      }
    }
  }

  /// From what is new of the cut's surface to the true one, which does not change.
  void prove_cut(const DistanceWindow::Facets& facets, const FacetGrid& truth) {
    const Found found =
        prove_all(facets.n_own, threads_, progress_, [&](std::size_t i, std::uint32_t hint) {
          if ((facets.all[i].place & LeafPlace::kFresh) == 0) return FacetProof{true, 0};
          return prove_near(facets.all[i], truth, {limit_, kMostPiecesOfCut, hint});
        });
    report_.proven = std::max(report_.proven, found.proven);
    for (const std::uint32_t f : found.failing)
      failing_leaves_.push_back(facets.all[f].place & ~LeafPlace::kFresh);
  }

  /// And back: from what has no proof, or one by a leaf that is no more. What has failed in a leaf
  /// that is there still waits for its turn.
  void prove_truth(const FacetGrid& cut) {
    const Found found =
        prove_all(full_.n_own, threads_, progress_, [&](std::size_t i, std::uint32_t hint) {
          std::uint64_t& state = states_[i];
          if (is_settled(state)) return FacetProof{true, 0};
          const FacetProof proof =
              prove_near(full_.all[i], cut, {limit_, kMostPiecesOfTruth, hint});
          if (!proof.holds) {
            state = leaf_round(full_.all[i]);
            // There both surfaces are the same.
            if (state == LeafPlace::kFinest) return FacetProof{true, 0};
            state |= kFailing;
          } else {
            state = proof.witness == FacetGrid::kNone
                        ? kUnknown
                        : cut.facets()[proof.witness].place & ~LeafPlace::kFresh;
          }
          return proof;
        });
    report_.proven = std::max(report_.proven, found.proven);
  }

  /// Whether there is no need to look at a facet of full resolution again.
  [[nodiscard]] bool is_settled(std::uint64_t state) const {
    if (state == kUnknown) return false;
    if (state == LeafPlace::kFinest) return true;
    const Index<3> node = to_point(state & ~kFailing);
    if (window_.contains(node)) return false;
    return (state & kFailing) == 0 || age_of(node) < turn_;
  }

  /// Coarser nodes first.
  [[nodiscard]] static int age_of(const Index<3>& centre) {
    const Diamond<3> node = diamond_at<3>(centre);
    return 3 * node.level - node.tier + 2;
  }

  /// The nodes that bisect leaves in which something fails, each once.
  [[nodiscard]] std::vector<std::uint64_t> failing() const {
    std::vector<std::uint64_t> leaves;
    for (const std::uint64_t leaf : failing_leaves_)
      if (!window_.contains(to_point(leaf))) leaves.push_back(leaf);
    for (const std::uint64_t state : states_)
      if (state != kUnknown && (state & kFailing) != 0) leaves.push_back(state & ~kFailing);
    std::sort(leaves.begin(), leaves.end());
    leaves.erase(std::unique(leaves.begin(), leaves.end()), leaves.end());
    return leaves;
  }

  /// The age from which on nodes are refined next.
  [[nodiscard]] int next_turn() const {
    const std::vector<std::uint64_t> leaves = failing();
    std::array<std::size_t, kOldest + 1> n_of_age{};
    for (const std::uint64_t leaf : leaves) ++n_of_age[as_size(age_of(to_point(leaf)))];
    std::size_t n = 0;
    for (int age = kOldest; age > 0; --age) {
      n += n_of_age[as_size(age)];
      if (static_cast<double>(n) > kShareAtOnce * static_cast<double>(leaves.size())) return age;
    }
    return 0;
  }

  /// Refines the coarsest of what fails; false if nothing is left to refine. Much of what fails in
  /// finer leaves no longer does then.
  bool refine_failing() {
    window_.forget_new();
    const std::uint64_t n_before = report_.n_nodes;
    turn_ = next_turn();
    for (const std::uint64_t leaf : failing())
      if (age_of(to_point(leaf)) >= turn_) report_.n_nodes += window_.insert(to_point(leaf));
    return report_.n_nodes > n_before;
  }

  /// What still fails. The proof in docs/models/diamond3d.md says that there is none: in a finest
  /// leaf both surfaces are the same.
  void list_lost() {
    std::optional<Box3d> box;
    for (std::size_t i = 0; i < full_.n_own; ++i) {
      if (states_[i] == kUnknown || (states_[i] & kFailing) == 0) continue;
      ++report_.n_lost;
      for (const Vec3d& p : corners_of(full_.all[i])) {
        if (!box) box = Box3d{p, p};
        for (std::size_t k = 0; k < 3; ++k) {
          box->lower[k] = std::min(box->lower[k], p[k]);
          box->upper[k] = std::max(box->upper[k], p[k]);
        }
      }
    }
    if (box) report_.lost_size = length(box->upper - box->lower);
  }

  /// The place of the leaf that a facet of full resolution lies in.
  [[nodiscard]] std::uint64_t leaf_round(const Facet& facet) const {
    const auto node = leaf_node(window_.shape(), to_point(facet.place),
                                [this](const Simplex<3>& s) { return window_.is_refined(s); });
    return node ? to_key(*node) : LeafPlace::kFinest;
  }

  DistanceWindow& window_;
  Threads threads_;
  Progress& progress_;
  double max_distance_;
  double limit_ = 0;
  DistanceWindow::Facets full_;
  std::vector<std::uint64_t> states_;          ///< By own facet of full resolution.
  std::vector<std::uint64_t> failing_leaves_;  ///< With facets that are far from full resolution.
  int turn_ = 0;                               ///< Failing leaves as old are looked at again.
  DistanceCutReport report_;
};

}  // namespace

Result<DistanceCutReport> search_distance(DistanceWindow& window, double max_distance,
                                          Threads threads, Progress& progress) {
  return DistanceSearch(window, max_distance, threads, progress).run();
}

}  // namespace lode::diamond

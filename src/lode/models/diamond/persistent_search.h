#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "lode/models/diamond/due_bricks.h"
#include "lode/models/diamond/refinable.h"
#include "lode/models/diamond/relaxed_field.h"
#include "lode/models/diamond/weak_search.h"

namespace lode::diamond {

/// The rounds of find_persistent_nodes(). `Field`: as RelaxedField's.
template <typename Field>
class PersistentSearch {
 public:
  PersistentSearch(const Field& field, const CriticalQuery& query, Progress& progress)
      : query_(query),
        progress_(progress),
        relaxed_(field, query),
        found_{NodeSet<3>(field.shape)},
        brick_dims_(brick_counts<3>(field.shape)),
        wants_(n_points<3>(brick_dims_)),
        turned_(n_points<3>(brick_dims_)),
        n_critical_(wants_.size() + 1, 0),
        due_(brick_dims_, [&](const Index<3>& brick) { return relaxed_.is_met(brick); }),
        weak_(relaxed_, field, query, progress) {}

  /// Whether bricks' nodes are needed, beside their samples.
  [[nodiscard]] bool has_tolerance() const { return relaxed_.has_tolerance(); }

  /// What is kept takes no more memory than the query lets it.
  [[nodiscard]] Result<void> check_size() const;

  /// visit(bricks, see): calls see(SeenBricks) with some of the bricks at a time, until all were
  /// seen.
  template <typename Visit>
  Result<CriticalNodes> run(const Visit& visit) {
    if (!relaxed_.is_full()) LODE_CHECK(find_nodes(visit));
    for (const std::uint64_t n : n_critical_) found_.n_critical += n;
    if (query_.with_weak) {
      LODE_TRY(found_.weak, weak_.run(due_, visit));
      LODE_CHECK(check_size());
    }
    return std::move(found_);
  }

 private:
  enum class Wants : std::uint8_t { coarse, all };
  static_assert(power(as_size(kBrickSamples<3>), 3) <= 1U << 16U);
  static constexpr std::int32_t kReach = RelaxedField<Field>::kReach;
  /// A round takes in at least one in so many of what is missing then, and all that is coarse. With
  /// 64 there are up to twice as many rounds, and as many triangles in the end; with 2 there are 5
  /// to 7 % more triangles (bonsai at 40.5).
  static constexpr std::uint64_t kRounds = 8;

  template <typename Visit>
  Result<void> find_nodes(const Visit& visit);
  void relax_coarse();
  template <typename Part>
  void relax_bricks(const Part& part);
  template <typename Part>
  void relax_brick(const Part& part, const Index<3>& brick, RelaxedBox& box);
  template <typename Part>
  void find_refined(const Part& part, const Index<3>& brick, const Refinable<3>& nodes,
                    const RelaxedBox& box);
  std::uint64_t hold_turned();
  [[nodiscard]] std::uint64_t forget_refined(std::vector<Index<3>>& critical) const;
  std::uint64_t add_coarsest(Wants wants);
  /// The bricks that are done but depend on this node: as far as simplices of those below it reach.
  void mark_due(const Index<3>& centre) {
    due_.mark(centre, (std::int32_t{3} << common_exponent<3>(centre)) + kReach, DueBricks::done);
  }

  CriticalQuery query_;
  Progress& progress_;
  RelaxedField<Field> relaxed_;
  CriticalNodes found_;
  Index<3> brick_dims_;
  /// Those that are critical, and not refined yet: coarse ones; and by brick, as their places among
  /// its samples.
  std::vector<Index<3>> coarse_wants_;
  std::vector<std::vector<std::uint16_t>> wants_;
  std::vector<std::vector<Index<3>>> turned_;  ///< By brick, though they are refined.
  std::vector<std::uint64_t> n_critical_;      ///< By brick, and coarse ones.
  DueBricks due_;
  WeakSearch<Field> weak_;
};

template <typename Field>
template <typename Visit>
Result<void> PersistentSearch<Field>::find_nodes(const Visit& visit) {
  if (has_tolerance()) {
    relaxed_.add_coarse_beyond_tolerance();
    LODE_CHECK(visit(due_.list_due(),
                     [&](const auto& part) { relaxed_.add_beyond_tolerance(part, progress_); }));
  }
  for (std::uint64_t n_added = 1; n_added > 0;) {
    if (progress_.is_cancelled()) return cancelled_error();
    relax_coarse();
    n_added = add_coarsest(Wants::coarse);
    if (n_added > 0) continue;
    LODE_CHECK(visit(due_.list_due(), [&](const auto& part) { relax_bricks(part); }));
    if (progress_.is_cancelled()) return cancelled_error();
    LODE_CHECK(check_size());
    n_added = hold_turned();
    n_added += add_coarsest(Wants::all);
  }
  return {};
}

template <typename Field>
void PersistentSearch<Field>::relax_coarse() {
  constexpr std::int32_t kStep = RelaxedField<Field>::kStep;
  const RelaxedBox& coarse = relaxed_.relax_coarse();
  const LatticeBox<3> all = coarse.sides().box();
  coarse_wants_.clear();
  for (int level = 0; level < relaxed_.n_coarse_levels(); ++level)
    coarse.sides().find(level, all, coarse_wants_);
  for (Index<3>& centre : coarse_wants_) centre = centre * kStep;
  n_critical_.back() = forget_refined(coarse_wants_);
  // Where the samples are all on one side, the relaxed field may not be.
  for (const Index<3>& centre : coarse.turned())
    due_.mark(centre * kStep, kStep + kReach, DueBricks::unmet);
}

template <typename Field>
template <typename Part>
void PersistentSearch<Field>::relax_bricks(const Part& part) {
  std::optional<Refinable<3>> nodes;
  if (has_tolerance()) nodes.emplace(part.model);
  std::vector<std::unique_ptr<RelaxedBox>> workers(as_size(n_workers(query_.threads)));
  parallel_for(part.bricks.size(), query_.threads, 1, [&](std::size_t i, int number) {
    if (progress_.is_cancelled()) return;
    auto& box = workers[as_size(number)];
    if (!box) box = std::make_unique<RelaxedBox>(query_.isovalue, query_.persistence, true);
    relax_brick(part, part.bricks[i], *box);
    if (nodes) find_refined(part, part.bricks[i], *nodes, *box);
  });
}

template <typename Field>
template <typename Part>
void PersistentSearch<Field>::relax_brick(const Part& part, const Index<3>& brick,
                                          RelaxedBox& box) {
  relaxed_.relax(part, brick, box);
  const LatticeBox<3> own = own_centres(brick, part.samples.shape.dims);
  const Index<3> number = part.in_field(brick);
  const std::size_t at = linear_index<3>(brick_dims_, number);
  std::vector<Index<3>> found;
  for (int level = 0; level < relaxed_.n_fine_levels(); ++level)
    box.sides().find(level, own, found);
  for (Index<3>& p : found) p = p + part.origin;
  n_critical_[at] = forget_refined(found);
  wants_[at].clear();
  for (const Index<3>& p : found)
    wants_[at].push_back(static_cast<std::uint16_t>(
        linear_index<3>(all_equal<3>(kBrickSamples<3>), p - number * kBrickEdge<3>)));
  due_.finish(number);
}

/// Leaves those that are not refined yet. How many there are with those that were found before.
template <typename Field>
std::uint64_t PersistentSearch<Field>::forget_refined(std::vector<Index<3>>& critical) const {
  const auto n_found =
      std::ranges::count_if(critical, [&](const Index<3>& p) { return found_.nodes.contains(p); });
  std::erase_if(critical, [&](const Index<3>& p) { return relaxed_.refined().contains(p); });
  return static_cast<std::uint64_t>(n_found) + critical.size();
}

/// Of those that were turned, which the tolerance refines.
template <typename Field>
template <typename Part>
void PersistentSearch<Field>::find_refined(const Part& part, const Index<3>& brick,
                                           const Refinable<3>& nodes, const RelaxedBox& box) {
  const LatticeBox<3> own = own_centres(brick, part.samples.shape.dims);
  std::vector<Index<3>>& turned = turned_[linear_index<3>(brick_dims_, part.in_field(brick))];
  turned.clear();
  for (const Index<3>& p : box.turned()) {
    bool is_own = true;
    for (std::size_t a = 0; a < 3; ++a)
      is_own = is_own && p[a] >= own.lower[a] && p[a] < own.upper[a];
    if (is_own && nodes.facts_at(diamond_at<3>(p)).error > decode_error(relaxed_.tolerance()))
      turned.push_back(p + part.origin);
  }
}

/// They are to keep their samples. How many.
template <typename Field>
std::uint64_t PersistentSearch<Field>::hold_turned() {
  std::uint64_t n_held = 0;
  for (std::vector<Index<3>>& turned : turned_) {
    for (const Index<3>& centre : turned)
      relaxed_.refined().insert(centre, [&](const Index<3>& p) {
        mark_due(p);
        ++n_held;
      });
    turned.clear();
  }
  return n_held;
}

/// Of what is wanted and not refined yet, with its ancestors, the coarsest: once those are refined,
/// some of what is finer is not wanted any more. How many.
template <typename Field>
std::uint64_t PersistentSearch<Field>::add_coarsest(Wants wants) {
  std::vector<std::vector<Index<3>>> missing(3 * as_size(relaxed_.shape().n_levels));
  std::uint64_t n_missing = 0;
  const auto want = [&](const Index<3>& centre) {
    relaxed_.refined().insert(centre, [&](const Index<3>& p) {
      const Diamond<3> node = diamond_at<3>(p);
      missing[3 * as_size(node.level) + 2 - as_size(node.tier)].push_back(p);
      ++n_missing;
    });
  };
  for (const Index<3>& centre : coarse_wants_) want(centre);
  for (std::size_t i = 0; wants == Wants::all && i < wants_.size(); ++i)
    for (const std::uint16_t at : wants_[i])
      want(point_of<3>(brick_dims_, i) * kBrickEdge<3> +
           point_of<3>(all_equal<3>(kBrickSamples<3>), at));
  if (n_missing > 0)
    progress_.report("finding critical nodes", static_cast<double>(found_.n_nodes) /
                                                   static_cast<double>(found_.n_nodes + n_missing));
  std::uint64_t n_added = 0;
  for (std::size_t rank = missing.size(); rank-- > 0;) {
    const bool is_later = rank < 3 * kKeptLevel && n_added > n_missing / kRounds;
    for (const Index<3>& centre : missing[rank]) {
      if (is_later) {
        relaxed_.refined().reset(centre);
        continue;
      }
      found_.nodes.insert(centre, [&](const Index<3>&) { ++found_.n_nodes; });
      mark_due(centre);
      ++n_added;
    }
  }
  return n_added;
}

template <typename Field>
Result<void> PersistentSearch<Field>::check_size() const {
  std::uint64_t n_bytes = relaxed_.refined().n_bytes() + found_.nodes.n_bytes() + weak_.n_bytes();
  if (found_.weak.samples) n_bytes += found_.weak.samples->n_bytes();
  for (const auto& list : wants_) n_bytes += list.capacity() * sizeof(list[0]);
  for (const auto& list : turned_) n_bytes += list.capacity() * sizeof(list[0]);
  if (n_bytes <= query_.max_bytes) return {};
  return fail(
      "keeping the topology: expected at most {} MB for the nodes that it takes, got {} MB: a "
      "higher memory limit, or a larger persistence or tolerance, leaves room for them",
      query_.max_bytes / 1'000'000, n_bytes / 1'000'000 + 1);
}

}  // namespace lode::diamond

#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lode/models/diamond/brick_work.h"
#include "lode/models/diamond/critical_nodes.h"
#include "lode/models/diamond/due_bricks.h"
#include "lode/models/diamond/kept_nodes.h"
#include "lode/models/diamond/refinable.h"
#include "lode/models/diamond/relaxed_box.h"
#include "lode/models/diamond/selection.h"

namespace lode::diamond {

/// Bricks with the samples round them.
template <typename Samples>
struct SeenBricks {
  const Samples& samples;
  const Model<3>& model;             ///< With their nodes, if a tolerance can refine any.
  std::span<const Index<3>> bricks;  ///< Of the model's.
  Index<3> origin;                   ///< Of the model's lattice in the field's.
};

/// The rounds of find_persistent_nodes(). `Field`: has the nodes of levels kKeptLevel and coarser,
/// and their samples.
template <typename Field>
class PersistentSearch {
 public:
  PersistentSearch(const Field& field, const CriticalQuery& query, Progress& progress)
      : field_(field),
        query_(query),
        progress_(progress),
        selection_(field, query.isovalue, query.tolerance),
        refined_(query.refined != nullptr ? *query.refined : NodeSet<3>(field.shape)),
        found_{NodeSet<3>(field.shape)},
        brick_dims_(brick_counts<3>(field.shape)),
        wants_(n_points<3>(brick_dims_)),
        turned_(n_points<3>(brick_dims_)),
        n_critical_(wants_.size() + 1, 0),
        coarse_(query.isovalue, query.persistence, false),
        due_(brick_dims_, [&](const Index<3>& brick) { return is_met(brick); }),
        has_tolerance_(can_refine(field, query.tolerance)) {}

  /// Whether the tolerance can refine any node, so that the bricks' nodes are needed.
  [[nodiscard]] bool has_tolerance() const { return has_tolerance_; }

  /// What is kept of nodes takes no more memory than the query lets it.
  [[nodiscard]] Result<void> check_size() const;

  /// visit(bricks, see): calls see(SeenBricks) with some of the bricks at a time, until all were
  /// seen.
  template <typename Visit>
  Result<CriticalNodes> run(const Visit& visit) {
    open_coarse();
    if (has_tolerance_) {
      add_coarse_beyond_tolerance();
      LODE_CHECK(visit(due_.list(), [&](const auto& part) { add_beyond_tolerance(part); }));
    }
    for (std::uint64_t n_added = 1; n_added > 0;) {
      if (progress_.is_cancelled()) return cancelled_error();
      relax_coarse();
      n_added = add_coarsest(Wants::coarse);
      if (n_added > 0) continue;
      LODE_CHECK(visit(due_.list(), [&](const auto& part) { relax_bricks(part); }));
      if (progress_.is_cancelled()) return cancelled_error();
      LODE_CHECK(check_size());
      n_added = hold_turned();
      n_added += add_coarsest(Wants::all);
    }
    for (const std::uint64_t n : n_critical_) found_.n_critical += n;
    return std::move(found_);
  }

 private:
  static constexpr std::int32_t kStep = 1 << kKeptLevel;
  /// Of the stars of finer nodes.
  static constexpr std::int32_t kReach = kStep / 2;
  static_assert(kReach <= FilePart<3>::kMargin);
  enum class Wants : std::uint8_t { coarse, all };
  static_assert(power(as_size(kBrickSamples<3>), 3) <= 1U << 16U);
  /// A round takes in at least one in so many of what is missing then, and all that is coarse. With
  /// 64 there are up to twice as many rounds, and as many triangles in the end; with 2 there are 5
  /// to 7 % more triangles (bonsai at 40.5).
  static constexpr std::uint64_t kRounds = 8;

  [[nodiscard]] static bool can_refine(const Field& field, double tolerance) {
    const double most = field.stats.max - field.stats.min + rounding_slack<3>(field);
    constexpr double kLargest = std::numeric_limits<float>::max() / 4;  // of errors
    return field.has_holes() || tolerance < 2 * most || !(most < kLargest);
  }
  [[nodiscard]] int n_fine_levels() const { return std::min(field_.shape.n_levels, kKeptLevel); }
  [[nodiscard]] int n_coarse_levels() const { return field_.shape.n_levels - n_fine_levels(); }
  /// Whether finer nodes with a centre in a brick may be critical.
  [[nodiscard]] bool is_met(const Index<3>& brick) const {
    if (field_.shape.n_levels <= kKeptLevel) return true;
    return any_kept_node<3>(field_.shape, brick, [&](const Index<3>&, std::size_t at) {
      return selection_.is_active(kKeptLevel, at);
    });
  }
  [[nodiscard]] bool is_known_refined(const Index<3>& centre) const {
    return refined_.contains(centre) ||
           field_.shape.reaches_across(centre, common_exponent<3>(centre));
  }
  /// Of a brick of a part, in the field.
  [[nodiscard]] static Index<3> in_field(Index<3> brick, const Index<3>& origin) {
    for (std::size_t a = 0; a < 3; ++a) brick[a] += origin[a] / kBrickEdge<3>;
    return brick;
  }

  void open_coarse();
  void add_coarse_beyond_tolerance();
  template <typename Part>
  void add_beyond_tolerance(const Part& part);
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

  const Field& field_;
  CriticalQuery query_;
  Progress& progress_;
  Selection<3, Field> selection_;
  NodeSet<3> refined_;  ///< All that the cut is known to refine, but for the border's.
  CriticalNodes found_;
  Index<3> brick_dims_;
  /// Those that are critical, and not refined yet: coarse ones; and by brick, as their places among
  /// its samples.
  std::vector<Index<3>> coarse_wants_;
  std::vector<std::vector<std::uint16_t>> wants_;
  std::vector<std::vector<Index<3>>> turned_;  ///< By brick, though they are refined.
  std::vector<std::uint64_t> n_critical_;      ///< By brick, and coarse ones.
  RelaxedBox coarse_;                          ///< Every kStep-th sample.
  DueBricks due_;
  bool has_tolerance_;
};

template <typename Field>
void PersistentSearch<Field>::open_coarse() {
  LatticeBox<3> all{{}, {}};
  for (std::size_t i = 0; i < 3; ++i) all.upper[i] = ((field_.shape.dims[i] - 1) >> kKeptLevel) + 1;
  coarse_.open(all.upper, all);
}

template <typename Field>
void PersistentSearch<Field>::add_coarse_beyond_tolerance() {
  for (int level = kKeptLevel; level < field_.shape.n_levels; ++level) {
    const Index<3> dims = field_.shape.grid_dims(level);
    for (std::size_t at = 0; at < n_points<3>(dims); ++at) {
      const Index<3> centre = point_of<3>(dims, at) * (std::int32_t{1} << level);
      if (field_.shape.is_sample(centre) && common_exponent<3>(centre) == level &&
          selection_.exceeds_tolerance(selection_.error(level, at)) &&
          selection_.is_active(level, at))
        refined_.set(centre);
    }
  }
}

/// Those that have stored attributes; their ancestors have larger errors, and are among them.
/// Others are asked for where they turn.
template <typename Field>
template <typename Part>
void PersistentSearch<Field>::add_beyond_tolerance(const Part& part) {
  const Selection<3> selection(part.model, query_.isovalue, query_.tolerance);
  for (const Index<3>& brick : part.bricks) {
    if (progress_.is_cancelled()) return;
    const LatticeBox<3> own = own_centres(brick, part.model.shape.dims);
    for (int level = 0; level < n_fine_levels(); ++level) {
      const std::int32_t step = std::int32_t{1} << std::max(level, 1);
      const std::int32_t first = level == 0 ? 1 : 0;  // of level 0 only cubes have any
      for (std::int32_t z = own.lower[2] + first; z < own.upper[2]; z += step)
        for (std::int32_t y = own.lower[1] + first; y < own.upper[1]; y += step)
          for (std::int32_t x = own.lower[0] + first; x < own.upper[0]; x += step) {
            const Index<3> centre{{x, y, z}};
            if (common_exponent<3>(centre) != level) continue;
            const std::size_t at = selection.index_of(diamond_at<3>(centre));
            if (selection.exceeds_tolerance(selection.error(level, at)) &&
                selection.is_active(level, at))
              refined_.set(centre + part.origin);
          }
    }
  }
}

template <typename Field>
void PersistentSearch<Field>::relax_coarse() {
  parallel_for(coarse_.n_rows(), query_.threads, 64,
               [&](std::size_t row, int) { coarse_.fill_row(field_, row, kStep); });
  coarse_.relax(
      std::max(n_coarse_levels(), 0), [&](const Index<3>& p) { return coarse_.value(p); },
      [&](const Index<3>& p) { return is_known_refined(p * kStep); });
  const LatticeBox<3> all = coarse_.sides().box();
  coarse_wants_.clear();
  for (int level = 0; level < n_coarse_levels(); ++level)
    coarse_.sides().find(level, all, coarse_wants_);
  for (Index<3>& centre : coarse_wants_) centre = centre * kStep;
  n_critical_.back() = forget_refined(coarse_wants_);
  // Where the samples are all on one side, the relaxed field may not be.
  for (const Index<3>& centre : coarse_.turned())
    due_.mark(centre * kStep, kStep + kReach, DueBricks::unmet);
}

template <typename Field>
template <typename Part>
void PersistentSearch<Field>::relax_bricks(const Part& part) {
  std::optional<Refinable<3>> nodes;
  if (has_tolerance_) nodes.emplace(part.model);
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
  const Index<3>& dims = part.samples.shape.dims;
  const LatticeBox<3> own = own_centres(brick, dims);
  LatticeBox<3> round;
  for (std::size_t a = 0; a < 3; ++a) {
    round.lower[a] = std::max(own.lower[a] - kReach, 0);
    round.upper[a] = std::min(own.lower[a] + kBrickEdge<3> + kReach + 1, dims[a]);
  }
  box.open(dims, round);
  for (std::size_t row = 0; row < box.n_rows(); ++row) box.fill_row(part.samples, row, 1);
  box.relax(
      n_fine_levels(),
      [&](const Index<3>& p) {
        if (field_.shape.n_levels < kKeptLevel)
          return box.value(p);  // corners of all that there is
        Index<3> coarse = p + part.origin;
        for (std::int32_t& x : coarse.v) x >>= kKeptLevel;
        return coarse_.value(coarse);
      },
      [&](const Index<3>& p) { return is_known_refined(p + part.origin); });
  const Index<3> number = in_field(brick, part.origin);
  const std::size_t at = linear_index<3>(brick_dims_, number);
  std::vector<Index<3>> found;
  for (int level = 0; level < n_fine_levels(); ++level) box.sides().find(level, own, found);
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
  std::erase_if(critical, [&](const Index<3>& p) { return refined_.contains(p); });
  return static_cast<std::uint64_t>(n_found) + critical.size();
}

/// Of those that were turned, which the tolerance refines.
template <typename Field>
template <typename Part>
void PersistentSearch<Field>::find_refined(const Part& part, const Index<3>& brick,
                                           const Refinable<3>& nodes, const RelaxedBox& box) {
  const LatticeBox<3> own = own_centres(brick, part.samples.shape.dims);
  std::vector<Index<3>>& turned =
      turned_[linear_index<3>(brick_dims_, in_field(brick, part.origin))];
  turned.clear();
  for (const Index<3>& p : box.turned()) {
    bool is_own = true;
    for (std::size_t a = 0; a < 3; ++a)
      is_own = is_own && p[a] >= own.lower[a] && p[a] < own.upper[a];
    if (is_own && nodes.facts_at(diamond_at<3>(p)).error > decode_error(selection_.tolerance()))
      turned.push_back(p + part.origin);
  }
}

/// They are to keep their samples. How many.
template <typename Field>
std::uint64_t PersistentSearch<Field>::hold_turned() {
  std::uint64_t n_held = 0;
  for (std::vector<Index<3>>& turned : turned_) {
    for (const Index<3>& centre : turned)
      refined_.insert(centre, [&](const Index<3>& p) {
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
  std::vector<std::vector<Index<3>>> missing(3 * as_size(field_.shape.n_levels));
  std::uint64_t n_missing = 0;
  const auto want = [&](const Index<3>& centre) {
    refined_.insert(centre, [&](const Index<3>& p) {
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
        refined_.reset(centre);
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
  std::uint64_t n_bytes = refined_.n_bytes() + found_.nodes.n_bytes();
  for (const auto& list : wants_) n_bytes += list.capacity() * sizeof(list[0]);
  for (const auto& list : turned_) n_bytes += list.capacity() * sizeof(list[0]);
  if (n_bytes <= query_.max_bytes) return {};
  return fail(
      "keeping the topology: expected at most {} MB for the nodes that it takes, got {} MB: a "
      "higher memory limit, or a larger persistence or tolerance, leaves room for them",
      query_.max_bytes / 1'000'000, n_bytes / 1'000'000 + 1);
}

}  // namespace lode::diamond

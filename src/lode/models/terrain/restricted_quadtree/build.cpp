// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), section 6 and figure 12: the restricted quadtree.
#include <bit>
#include <deque>
#include <optional>

#include "lode/models/terrain/restricted_quadtree/restricted_quadtree.h"

namespace lode::restricted_quadtree {
namespace {

using squares::Share;

enum class State : std::uint8_t { absent, leaf, split };

/// Sides by number: lower, right, upper, left.
constexpr std::array<std::array<std::int32_t, 2>, 4> kAcross{{{0, -1}, {1, 0}, {0, 1}, {-1, 0}}};
/// The children of a square that lie along a side, by number.
constexpr std::array<std::array<int, 2>, 4> kAlong{{{0, 1}, {1, 3}, {2, 3}, {0, 2}}};

constexpr int opposite(int side) { return (side + 2) % 4; }

class Builder {
 public:
  Builder(const SquareDomain& domain, double tolerance) : domain_(domain), tolerance_(tolerance) {
    for (std::int32_t level = 0; level < domain.n_levels(); ++level)
      nodes_.emplace_back(domain.n_squares(level));
  }

  Result<std::vector<Leaf>> run(Progress& progress) {
    add_leaf(domain_.root());
    // As in the paper, it begins with four quadrants.
    if (domain_.root().level > 0) split(domain_.root());
    for (std::uint64_t n = 0; !queue_.empty(); ++n) {
      constexpr std::uint64_t kPerReport = 1 << 12;
      if (n % kPerReport == 0 && progress.is_cancelled()) return cancelled_error();
      const Square square = queue_.front();
      queue_.pop_front();
      node(square).is_queued = false;
      if (node(square).state == State::leaf) update(square);
    }
    return leaves();
  }

 private:
  struct Node {
    State state = State::absent;
    bool is_queued = false;
    SideMask midpoints = 0;
  };
  /// What neighbours ask of a square's sides.
  struct Sides {
    SideMask required = 0;
    SideMask free = 0;  ///< May have midpoints, or not.
    bool must_split = false;
  };

  Node& node(const Square& q) {
    return nodes_[static_cast<std::size_t>(q.level)][domain_.index(q)];
  }
  [[nodiscard]] const Node& node(const Square& q) const {
    return nodes_[static_cast<std::size_t>(q.level)][domain_.index(q)];
  }
  [[nodiscard]] State state(const Square& q) const {
    return domain_.has(q) ? node(q).state : State::absent;
  }
  [[nodiscard]] static Square across(const Square& q, int side) {
    const auto& [columns, rows] = kAcross[static_cast<std::size_t>(side)];
    return {q.level, q.column + columns, q.row + rows};
  }

  void enqueue(const Square& q) {
    if (node(q).is_queued) return;
    node(q).is_queued = true;
    queue_.push_back(q);
  }
  void add_leaf(const Square& q) {
    node(q).state = State::leaf;
    enqueue(q);
  }

  [[nodiscard]] Sides look_around(const Square& q) const {
    Sides sides;
    for (int side = 0; side < 4; ++side) {
      const auto bit = static_cast<SideMask>(1 << side);
      const Square other = across(q, side);
      switch (state(other)) {
        case State::split:
          sides.required |= bit;
          for (const int i : kAlong[static_cast<std::size_t>(opposite(side))])
            if (other.level > 0 && state(other.child(i)) == State::split) sides.must_split = true;
          break;
        case State::leaf:
          if ((node(other).midpoints >> opposite(side) & 1) != 0)
            sides.required |= bit;
          else
            sides.free |= bit;
          break;
        case State::absent:
          // Nothing is there, or a larger leaf, whose corner a midpoint would miss.
          if (domain_.share(other) == Share::none) sides.free |= bit;
          break;
      }
    }
    return sides;
  }

  /// Whether all samples to be kept in a square are corners, its centre or midpoints.
  [[nodiscard]] bool keeps_all(const Square& q, SideMask midpoints) const {
    std::uint32_t n = domain_.kept_in(q).all;
    if (n == 0) return true;
    const std::int32_t half = q.side() / 2;
    const LatticePoint centre{q.x() + half, q.y() + half};
    n -= domain_.is_kept(centre) ? 1U : 0U;
    for (std::size_t side = 0; side < 4; ++side) {
      const auto& [columns, rows] = kAcross[side];
      const bool is_vertex = (midpoints >> side & 1) != 0;
      if (is_vertex && domain_.is_kept({centre.x + columns * half, centre.y + rows * half})) --n;
    }
    return n == 0;
  }

  /// The fewest midpoints, those required among them, within the tolerance and with all that is
  /// kept.
  [[nodiscard]] std::optional<SideMask> choose(const Square& q, const Sides& sides) const {
    std::optional<SideMask> best;
    for (unsigned added = 0; added < 16; ++added) {
      if ((added & ~static_cast<unsigned>(sides.free)) != 0) continue;
      if (best && std::popcount(added) >= std::popcount(unsigned{*best} & sides.free)) continue;
      const auto mask = static_cast<SideMask>(sides.required | added);
      if (keeps_all(q, mask) && pattern_error(domain_, q, mask) <= tolerance_) best = mask;
      if (best && added == 0) break;
    }
    return best;
  }

  void update(const Square& q) {
    if (q.level == 0) return;
    const Sides sides = look_around(q);
    std::optional<SideMask> mask;
    if (domain_.share(q) == Share::all && !sides.must_split) mask = choose(q, sides);
    if (!mask) {
      split(q);
      return;
    }
    const auto added = static_cast<SideMask>(*mask & ~sides.required);
    node(q).midpoints = *mask;
    for (int side = 0; side < 4; ++side)
      if ((added >> side & 1) != 0 && state(across(q, side)) == State::leaf)
        enqueue(across(q, side));
  }

  void split(const Square& q) {
    node(q).state = State::split;
    for (int i = 0; i < 4; ++i)
      if (domain_.share(q.child(i)) != Share::none) add_leaf(q.child(i));
    for (int side = 0; side < 4; ++side) {
      const Square other = across(q, side);
      if (!domain_.has(other)) continue;
      if (state(other) == State::leaf) enqueue(other);
      if (state(other) != State::absent || other.level + 1 >= domain_.n_levels()) continue;
      // A larger leaf, which would have neighbours two levels below it.
      const Square larger{other.level + 1, other.column / 2, other.row / 2};
      if (state(larger) == State::leaf) enqueue(larger);
    }
  }

  [[nodiscard]] std::vector<Leaf> leaves() const {
    std::vector<Leaf> leaves;
    for (std::int32_t level = domain_.n_levels() - 1; level >= 0; --level)
      for (std::int32_t row = 0; row < domain_.n_rows(level); ++row)
        for (std::int32_t column = 0; column < domain_.n_columns(level); ++column) {
          const Square q{level, column, row};
          if (node(q).state != State::leaf) continue;
          const SideMask midpoints = node(q).midpoints;
          leaves.push_back({q, midpoints, level == 0 ? 0 : pattern_error(domain_, q, midpoints)});
        }
    return leaves;
  }

  const SquareDomain& domain_;
  double tolerance_;
  std::vector<std::vector<Node>> nodes_;  ///< By level.
  std::deque<Square> queue_;
};

}  // namespace

Result<std::vector<Leaf>> build(const SquareDomain& domain, double tolerance, Progress& progress) {
  return Builder(domain, tolerance).run(progress);
}

}  // namespace lode::restricted_quadtree

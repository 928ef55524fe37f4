#pragma once

#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

#include "lode/core/progress.h"

namespace lode::diamond {

/// Regions of either side of an isovalue, in pieces, and which ones are beside each other: what can
/// be turned over so that fewer are left. A region without a fixed sample is turned to the other
/// side, the smallest first (then the one whose first sample comes first): so it is one with all
/// that are beside it, and that goes on until each has a fixed sample or is alone. The result does
/// not depend on the order in which pieces are given.
class RegionGraph {
 public:
  using Id = std::uint32_t;

  /// A piece of one: n samples, of which `first` comes first. Their numbers go up from 0.
  Id add(bool is_fixed, std::uint64_t n, std::uint64_t first);
  /// Pieces of one region.
  void join(Id a, Id b);
  /// Pieces of regions on different sides.
  void touch(Id a, Id b) { touching_.emplace_back(a, b); }
  [[nodiscard]] std::size_t size() const { return pieces_.size(); }
  /// With what turning takes for a while.
  [[nodiscard]] std::uint64_t n_bytes() const {
    constexpr std::uint64_t kTurnedPiece = 3 * sizeof(Id) + sizeof(std::uint64_t) + 1;
    constexpr std::uint64_t kFreePiece = 48;  // a place in a queue that may grow
    return pieces_.size() * (sizeof(Piece) + kTurnedPiece) + n_free_ * kFreePiece +
           touching_.size() * (sizeof(touching_[0]) + 2 * sizeof(Id));
  }

  struct Turned {
    std::vector<bool> is_turned;  ///< By piece.
    std::uint64_t n_fewer = 0;    ///< Regions that have become one with others.
  };
  /// All of it is used up. Ends early when cancelled.
  [[nodiscard]] Turned turn(const Progress& progress);

 private:
  struct Piece {
    std::uint64_t n = 0;
    std::uint64_t first = 0;
    Id parent = 0;
    bool is_fixed = false;
  };
  class Turning;

  [[nodiscard]] Id root_of(Id id);

  // Which grow without being moved.
  std::deque<Piece> pieces_;
  std::uint64_t n_free_ = 0;  ///< Pieces without a fixed sample.
  std::deque<std::pair<Id, Id>> touching_;
};

}  // namespace lode::diamond

#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/models/tetra_mt/live_tetrahedra.h"
#include "lode/models/tetra_mt/star.h"

namespace lode::tetra_mt {

/// A sample that lies in a face, an edge or a vertex is covered by one of the tetrahedra there, but
/// all of them hold it: what is stated of them must be true of it. One still holds what is so far
/// outside, as a share of its height, besides what that may be off: more than verification allows.
inline constexpr double kHeld = 2e-9;

/// Between which corners of its tetrahedron a sample lies, a bit each: in a face, an edge or a
/// vertex, or, with all of them, inside, where no other holds it. None where it is covered from
/// outside, as the smallest weight says: it may lie anywhere.
using CornerBits = std::uint8_t;
inline constexpr CornerBits kAllCorners = 15;

[[nodiscard]] inline CornerBits corners_round(const std::array<double, 4>& weights, double least) {
  constexpr double kNear = 1e-4;  // far more than kHeld: beside thin ones are thick ones
  if (least < -kNear) return 0;
  unsigned corners = 0;
  for (std::size_t k = 0; k < 4; ++k) corners |= weights[k] > kNear ? 1U << k : 0;
  return static_cast<CornerBits>(corners);
}

/// Those of the samples that a tetrahedron covers which others may hold.
class CornerSets {
 public:
  void add(CornerBits corners) {
    if (corners != kAllCorners) sets_ = static_cast<std::uint16_t>(sets_ | 1U << corners);
  }
  [[nodiscard]] bool is_empty() const { return sets_ == 0; }
  /// Whether one may lie between these corners.
  [[nodiscard]] bool has_within(unsigned corners) const {
    for (unsigned left = sets_; left != 0; left &= left - 1)
      if ((static_cast<unsigned>(std::countr_zero(left)) & ~corners) == 0) return true;
    return false;
  }

 private:
  std::uint16_t sets_ = 0;  ///< A bit for each set of corners, which is a number of four bits.
};

/// By the corners of a lane's tetrahedron, as they are before the collapse.
[[nodiscard]] inline std::array<double, 4> weights_of_corners(
    const Tetrahedron& corners, const Star& star, std::size_t lane,
    const std::array<double, 3>& weights) {
  std::array<double, 4> all{};
  all.fill(1 - (weights[0] + weights[1] + weights[2]));
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t k = 0; k < weights.size(); ++k)
      if (corners[i] == star.link[star.triangles[lane][k]]) all[i] = weights[k];
  return all;
}

/// Makes a collapse's facts of a field true of a sample, too.
template <typename Facts>
void widen_by(double value, double error, Facts& facts) {
  facts.error = std::max(facts.error, std::abs(error));
  facts.low = std::min(facts.low, value);
  facts.high = std::max(facts.high, value);
}

/// Finds the tetrahedra beside a star which cover samples that those of the star may hold. Has a
/// mark for each vertex.
class TetrahedraBeside {
 public:
  explicit TetrahedraBeside(const LiveTetrahedra& mesh)
      : mesh_(mesh), marks_(std::size_t{mesh.outside()} + 1, Mark::elsewhere) {}

  /// Calls visit(slot, others) for each that has none of the `ends`, but some of the `link` round
  /// these, and samples between such corners: those whose CornerBits have none of the `others`. All
  /// vertices are own ones, but the one outside. `sets_of(slot)`: its CornerSets.
  template <typename SetsOf, typename Visit>
  void visit(std::span<const std::uint32_t> ends, std::span<const std::uint32_t> link,
             const SetsOf& sets_of, const Visit& visit) {
    for (const std::uint32_t v : link) marks_[v] = Mark::link;
    for (const std::uint32_t v : ends) marks_[v] = Mark::end;
    for (const std::uint32_t v : link) {
      if (v == mesh_.outside() || marks_[v] == Mark::end) continue;
      for (const std::uint32_t slot : mesh_.star(v))
        if (const CornerSets sets = sets_of(slot); !sets.is_empty())
          if (const unsigned common = common_corners(mesh_.corners(slot), v);
              common != 0 && sets.has_within(common))
            visit(slot, kAllCorners & ~common);
    }
    for (const std::uint32_t v : link) marks_[v] = Mark::elsewhere;
    for (const std::uint32_t v : ends) marks_[v] = Mark::elsewhere;
  }

 private:
  enum class Mark : std::uint8_t { elsewhere, link, end };

  /// Those in the link, a bit each; none where `from` is not the first of them, so that each
  /// tetrahedron comes once, or one is an end.
  [[nodiscard]] unsigned common_corners(const Tetrahedron& corners, std::uint32_t from) const {
    unsigned common = 0;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Mark mark = marks_[corners[k]];
      if (mark == Mark::end || (mark == Mark::link && common == 0 && corners[k] != from)) return 0;
      common |= mark == Mark::link ? 1U << k : 0;
    }
    return common;
  }

  const LiveTetrahedra& mesh_;
  std::vector<Mark> marks_;  ///< By vertex.
};

}  // namespace lode::tetra_mt

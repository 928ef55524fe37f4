#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"
#include "lode/delaunay/window.h"
#include "lode/models/terrain/squares/square_domain.h"

namespace lode::quaternary_triangulation {

using squares::Square;
using squares::SquareDomain;

/// Half of a square, cut from its lower left to its upper right corner (x to the right, y up).
struct HalfSquare {
  Square square;
  bool is_upper = false;  ///< The half with the upper left corner.

  friend bool operator==(const HalfSquare&, const HalfSquare&) = default;
  /// Of the four that the midpoints of its sides cut it into.
  [[nodiscard]] HalfSquare child(int i) const;
};

/// A bound of |z - z'| of the samples in a triangle that is wholly in the domain, z' linear: the
/// largest, and SquareDomain::rounding_in() more.
[[nodiscard]] double linear_error(const SquareDomain& domain, const HalfSquare& triangle);

/// The quaternary triangulation (D. Gomez, A. Guzman, "Digital model for three-dimensional surface
/// representation", 1979; L. De Floriani, P. Marzano, E. Puppo 1996, section 6): right triangles,
/// each split in four by the midpoints of its sides where a sample errs by more than the tolerance.
/// Begins with the two halves of a square. Triangles that are partly outside the domain are split.
/// Surfaces do not meet where triangles of different sizes do. Errors of all triangles are kept, so
/// any tolerance has its tree.
class QuaternaryTriangulation {
 public:
  /// O(N log N) for N samples; two floats for each square larger than a cell.
  [[nodiscard]] static Result<QuaternaryTriangulation> build(const HeightGrid& grid,
                                                             Threads threads, Progress& progress);

  /// Of errors that are known, as errors() has them; fails where these cannot be of the domain.
  [[nodiscard]] static Result<QuaternaryTriangulation> of(
      SquareDomain domain, std::vector<std::vector<std::array<float, 2>>> errors);

  [[nodiscard]] const SquareDomain& domain() const { return domain_; }
  /// See SquareDomain::keep(): triangles are split until these are corners.
  void keep(std::vector<LatticePoint> nodes) { domain_.keep(std::move(nodes)); }
  /// By level and SquareDomain::index().
  [[nodiscard]] const std::vector<std::vector<std::array<float, 2>>>& errors() const {
    return errors_;
  }
  /// Rounded up; infinite where it is not wholly in the domain.
  [[nodiscard]] float error(const HalfSquare& triangle) const {
    return errors_[static_cast<std::size_t>(triangle.square.level)][domain_.index(triangle.square)]
                  [triangle.is_upper ? 1 : 0];
  }
  /// The leaves within a tolerance, in depth-first order.
  [[nodiscard]] std::vector<HalfSquare> leaves(double tolerance) const;
  /// The same where a triangle that is wholly in the domain is split if split(triangle) says so.
  [[nodiscard]] std::vector<HalfSquare> leaves(
      const std::function<bool(const HalfSquare&)>& split) const;
  /// How many there are within a tolerance, or most + 1 where there are more.
  [[nodiscard]] std::uint64_t count_leaves(double tolerance, std::uint64_t most) const;
  [[nodiscard]] std::uint64_t n_bytes() const;

  /// Whether it is in the domain and stays whole: split(triangle) as of leaves().
  template <typename Split>
  [[nodiscard]] bool is_leaf(const HalfSquare& triangle, const Split& split) const {
    if (std::isinf(error(triangle))) return false;
    if (triangle.square.level == 0) return true;
    const squares::KeptCounts kept = domain_.kept_in(triangle.square);
    return (triangle.is_upper ? kept.upper : kept.lower) == 0 && !split(triangle);
  }

 private:
  /// Cells are in the domain or not; larger triangles where all children are, by their errors.
  [[nodiscard]] bool is_whole(const HalfSquare& triangle) const;
  explicit QuaternaryTriangulation(SquareDomain domain) : domain_(std::move(domain)) {}

  SquareDomain domain_;
  std::vector<std::vector<std::array<float, 2>>> errors_;  ///< By level; lower and upper half.
};

/// The leaf within a tolerance that holds a sample, found from above in O(number of levels); of
/// several that do one. Nothing outside of the domain.
[[nodiscard]] std::optional<HalfSquare> find_leaf(const QuaternaryTriangulation& tree,
                                                  double tolerance, LatticePoint p);

/// How many leaves within a tolerance meet a window, found from above: O(number of levels) and what
/// is counted.
[[nodiscard]] std::uint64_t count_in_window(const QuaternaryTriangulation& tree, double tolerance,
                                            const delaunay::Window& window);

[[nodiscard]] delaunay::Tin to_tin(const QuaternaryTriangulation& tree,
                                   const std::vector<HalfSquare>& leaves);

}  // namespace lode::quaternary_triangulation

#pragma once

#include <array>
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

namespace lode::surface_quadtree {

using squares::Square;
using squares::SquareDomain;

/// A bound of |z - z'| of the samples in a square that is wholly in the domain, z' bilinear between
/// its corners: the largest, and SquareDomain::rounding_in() more.
[[nodiscard]] double bilinear_error(const SquareDomain& domain, const Square& square);

/// The surface quadtree (L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for
/// topographic surface description", The Visual Computer 12, 1996, section 6 and figure 8; Z.-T.
/// Chen, W. Tobler, "Quadtree representations of digital terrain", 1986): squares, bilinear between
/// their corners, split in four where a sample errs by more than the tolerance. Squares that are
/// partly outside the domain are split, too. Surfaces of different squares do not meet where one is
/// larger. Errors of all squares are kept, so any tolerance has its tree, built bottom-up: the
/// highest squares that keep it, not those whose children all do, which is another tree (an error
/// may be larger in a part).
class SurfaceQuadtree {
 public:
  /// O(N log N) for N samples; a float for each square larger than a cell.
  [[nodiscard]] static Result<SurfaceQuadtree> build(const HeightGrid& grid, Threads threads,
                                                     Progress& progress);

  /// Of errors that are known, as errors() has them; fails where these cannot be of the domain.
  [[nodiscard]] static Result<SurfaceQuadtree> of(SquareDomain domain,
                                                  std::vector<std::vector<float>> errors);

  [[nodiscard]] const SquareDomain& domain() const { return domain_; }
  /// See SquareDomain::keep(): squares are split until these are corners.
  void keep(std::vector<LatticePoint> nodes) { domain_.keep(std::move(nodes)); }
  /// By level and SquareDomain::index().
  [[nodiscard]] const std::vector<std::vector<float>>& errors() const { return errors_; }
  /// Of a square in the raster, rounded up; infinite where it is not wholly in the domain.
  [[nodiscard]] float error(const Square& square) const {
    return errors_[static_cast<std::size_t>(square.level)][domain_.index(square)];
  }
  /// The leaves within a tolerance, in depth-first order.
  [[nodiscard]] std::vector<Square> leaves(double tolerance) const;
  /// The same where a square that is wholly in the domain is split if split(square) says so.
  [[nodiscard]] std::vector<Square> leaves(const std::function<bool(const Square&)>& split) const;
  /// How many there are within a tolerance, or most + 1 where there are more.
  [[nodiscard]] std::uint64_t count_leaves(double tolerance, std::uint64_t most) const;
  [[nodiscard]] std::uint64_t n_bytes() const;

 private:
  explicit SurfaceQuadtree(SquareDomain domain) : domain_(std::move(domain)) {}

  SquareDomain domain_;
  std::vector<std::vector<float>> errors_;  ///< By level.
};

/// Top-down, as in figure 8: the same leaves, without errors that are kept.
[[nodiscard]] std::vector<Square> leaves_top_down(const SquareDomain& domain, double tolerance);

/// The leaf within a tolerance that holds a sample, found from above in O(number of levels); of
/// several that do one. Nothing outside of the domain.
[[nodiscard]] std::optional<Square> find_leaf(const SurfaceQuadtree& tree, double tolerance,
                                              LatticePoint p);

/// How many triangles of to_tin() of the leaves within a tolerance meet a window, found from above:
/// O(number of levels) and what is counted.
[[nodiscard]] std::uint64_t count_in_window(const SurfaceQuadtree& tree, double tolerance,
                                            const delaunay::Window& window);

/// Two triangles a square, cut along the diagonal whose ends differ less in height, as bilinear
/// surfaces are no triangles: their error is another. Errors are those of the squares.
[[nodiscard]] delaunay::Tin to_tin(const SurfaceQuadtree& tree, const std::vector<Square>& leaves);

}  // namespace lode::surface_quadtree

#pragma once

#include <bit>
#include <cmath>
#include <limits>

#include "lode/core/progress.h"
#include "lode/models/diamond/sample_scale.h"
#include "lode/models/diamond/world_block.h"

namespace lode::diamond {

/// The world error of a node that is not refined, an estimate: how far the surface may lie from the
/// true one. The node's own error over the smallest gradient of F' on its simplices, but at most
/// their longest edge. The axes are taken as orthogonal. As a share of the longest edge of the
/// node's level; operation by operation as WorldBlock, whose C is the same.
template <int D, typename C>
class WorldErrorRule {
 public:
  explicit WorldErrorRule(const WorldScale<D, C>& scale) : scale_(scale) {}

  /// `own_error` in field units; value(p) is the sample at a lattice point, NaN where there is
  /// none.
  template <typename Value>
  [[nodiscard]] C operator()(const Diamond<D>& d, C own_error, const Value& value) const {
    if (!(own_error > 0)) return 0;
    auto ends = axis_ends<D>(d);
    const std::size_t first = as_size(std::countr_zero(d.odd));
    if (ends[0][first] > ends[1][first]) std::swap(ends[0], ends[1]);
    const C start = static_cast<C>(value(ends[0]));
    const C middle = C(0.5) * (start + static_cast<C>(value(ends[1])));
    const C squared = along_face(ends[0], ends[1], d.odd, start, value) +
                      outward(d, d.centre, ~d.odd & kAllAxes, middle, value);
    const C longest = scale_.longest[d.odd];
    // Infinite where holes leave no simplex whole.
    if (!(squared > 0) || !std::isfinite(squared)) return longest;
    return std::min(longest, own_error / std::sqrt(squared));
  }

 private:
  static constexpr std::uint32_t kAllAxes = (1U << D) - 1;
  static constexpr C kEndless = std::numeric_limits<C>::infinity();

  /// The smallest squared gradient within the bisected face: its Kuhn simplices go from one end of
  /// the axis to the other along the lattice, so each step is one component.
  template <typename Value>
  [[nodiscard]] C along_face(const Index<D>& p, const Index<D>& end, std::uint32_t axes, C f,
                             const Value& value) const {
    if (axes == 0) return 0;
    C smallest = kEndless;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      if ((axes >> i & 1U) == 0) continue;
      Index<D> q = p;
      q[i] = end[i];
      const C g = static_cast<C>(value(q));
      const C sum =
          (g - f) * (g - f) * scale_.face[i] + along_face(q, end, axes & ~(1U << i), g, value);
      if (sum < smallest) smallest = sum;
    }
    return smallest;
  }

  /// And across it, from the node's centre over the centres of larger faces to that of a cube.
  template <typename Value>
  [[nodiscard]] C outward(const Diamond<D>& d, const Index<D>& p, std::uint32_t axes, C f,
                          const Value& value) const {
    if (axes == 0) return 0;
    C smallest = kEndless;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      if ((axes >> i & 1U) == 0) continue;
      for (const std::int32_t step : {-d.h(), d.h()}) {
        Index<D> q = p;
        q[i] += step;
        const C g = static_cast<C>(value(q));
        const C sum =
            (g - f) * (g - f) * scale_.outward[i] + outward(d, q, axes & ~(1U << i), g, value);
        if (sum < smallest) smallest = sum;
      }
    }
    return smallest;
  }

  const WorldScale<D, C>& scale_;
};

/// Finds the world errors of all stored nodes of a model from its samples.
template <int D>
[[nodiscard]] Result<WorldErrors> compute_world_errors(const Model<D>& model, Threads threads,
                                                       Progress& progress);

/// The share of a node of level 0, not nested. `scales`: the field's.
template <int D, typename Field>
[[nodiscard]] double finest_own_world(const Field& field, const Diamond<D>& node,
                                      const WorldScales<D>& scales);

/// The nested world error of a node of level 0, from the samples round it.
template <int D, typename Field>
[[nodiscard]] WorldCode finest_world_error(const Field& field, const Diamond<D>& node,
                                           const WorldScales<D>& scales);

}  // namespace lode::diamond

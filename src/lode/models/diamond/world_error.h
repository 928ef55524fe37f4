#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "lode/core/progress.h"
#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// The world error of a node that is not refined, an estimate: how far the surface may lie from the
/// true one. The node's own error over the smallest gradient of F' on its simplices, but at most
/// their longest edge. The axes are taken as orthogonal.
template <int D>
class WorldErrorRule {
 public:
  explicit WorldErrorRule(const Model<D>& model) {
    for (std::size_t i = 0; i < as_size(D); ++i)
      spacing_[i] = model.info.grid.spacing[as_size(model.axes.axis[i])];
  }

  /// `own_error` in field units; value(p) is the sample at a lattice point, NaN where there is
  /// none.
  template <typename Value>
  [[nodiscard]] double operator()(const Diamond<D>& d, double own_error, const Value& value) const {
    if (!(own_error > 0)) return 0;
    const auto ends = axis_ends<D>(d);
    const double first = value(ends[0]);
    const double middle = 0.5 * (first + value(ends[1]));
    const double squared = along_face(d, ends[0], ends[1], d.odd, first, value) +
                           outward(d, d.centre, ~d.odd & kAllAxes, middle, value);
    const double longest = longest_edge(d);
    // Not a number or infinite where holes leave no simplex whole.
    if (!(squared > 0) || !std::isfinite(squared)) return longest;
    return std::min(longest, own_error / std::sqrt(squared));
  }

 private:
  static constexpr std::uint32_t kAllAxes = (1U << D) - 1;

  [[nodiscard]] double longest_edge(const Diamond<D>& d) const {
    double axis = 0;
    double all = 0;
    for (int i = 0; i < D; ++i) {
      const double squared = spacing_[as_size(i)] * spacing_[as_size(i)];
      all += squared;
      if (d.is_odd(i)) axis += 4 * squared;
    }
    return d.h() * std::sqrt(std::max(axis, all));
  }

  /// The smallest squared gradient within the bisected face: its Kuhn simplices go from one end of
  /// the axis to the other along the lattice, so each step is one component.
  template <typename Value>
  [[nodiscard]] double along_face(const Diamond<D>& d, const Index<D>& p, const Index<D>& end,
                                  std::uint32_t axes, double f, const Value& value) const {
    if (axes == 0) return 0;
    double smallest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < D; ++i) {
      if (((axes >> i) & 1U) == 0) continue;
      Index<D> q = p;
      q[as_size(i)] = end[as_size(i)];
      const double g = value(q);
      const double slope = (g - f) / (2 * d.h() * spacing_[as_size(i)]);
      const double sum = slope * slope + along_face(d, q, end, axes & ~(1U << i), g, value);
      if (sum < smallest) smallest = sum;
    }
    return smallest;
  }

  /// And across it, from the node's centre over the centres of larger faces to that of a cube.
  template <typename Value>
  [[nodiscard]] double outward(const Diamond<D>& d, const Index<D>& p, std::uint32_t axes, double f,
                               const Value& value) const {
    if (axes == 0) return 0;
    double smallest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < D; ++i) {
      if (((axes >> i) & 1U) == 0) continue;
      for (const std::int32_t step : {-d.h(), d.h()}) {
        Index<D> q = p;
        q[as_size(i)] += step;
        const double g = value(q);
        const double slope = (g - f) / (d.h() * spacing_[as_size(i)]);
        const double sum = slope * slope + outward(d, q, axes & ~(1U << i), g, value);
        if (sum < smallest) smallest = sum;
      }
    }
    return smallest;
  }

  Vec<double, as_size(D)> spacing_;
};

/// The nested world errors of all stored nodes, laid out as Model::levels and rounded up: by at
/// most (1 + 1/128)^2, as own errors are ErrorCodes too. An entry of level 0 also covers the finer
/// nodes in its cube.
using WorldErrors = std::vector<std::vector<ErrorCode>>;

/// Finds them from the samples, as one more build does; nothing of it is in the file. Fails when
/// cancelled.
template <int D>
[[nodiscard]] Result<WorldErrors> compute_world_errors(const Model<D>& model, Threads threads,
                                                       Progress& progress);

/// The nested world error of a node of level 0 and tier above 0, which has no entry.
template <int D>
[[nodiscard]] double finest_world_error(const Model<D>& model, const Diamond<D>& node);

}  // namespace lode::diamond

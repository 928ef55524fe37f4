#include "lode/api/probe_focus.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "lode/api/probe.h"
#include "lode/locate/line_profile.h"

namespace lode {
namespace {

bool boxes_meet(const Box3d& a, const Box3d& b) {
  bool is = true;
  for (std::size_t i = 0; i < 3; ++i)
    is = is && a.lower[i] <= b.upper[i] && b.lower[i] <= a.upper[i];
  return is;
}

/// Points in halves, again and again, each with the box of its points.
class PointTree {
 public:
  explicit PointTree(std::span<const Vec3d> points) : points_(points.begin(), points.end()) {
    if (!points_.empty()) divide(0, points_.size());
  }

  [[nodiscard]] bool has_any_in(const Box3d& box) const {
    return !points_.empty() && has_any(box, 0, 0, points_.size());
  }

 private:
  static constexpr std::size_t kLeaf = 8;

  struct Node {
    Box3d box;
    std::size_t upper_half = 0;  ///< The lower one follows.
  };

  void divide(std::size_t first, std::size_t last) {
    Box3d box{points_[first], points_[first]};
    for (std::size_t k = first; k < last; ++k)
      for (std::size_t i = 0; i < 3; ++i) {
        box.lower[i] = std::min(box.lower[i], points_[k][i]);
        box.upper[i] = std::max(box.upper[i], points_[k][i]);
      }
    const std::size_t place = nodes_.size();
    nodes_.push_back({box});
    if (last - first <= kLeaf) return;
    std::size_t axis = 0;
    for (std::size_t i = 1; i < 3; ++i)
      if (box.upper[i] - box.lower[i] > box.upper[axis] - box.lower[axis]) axis = i;
    const std::size_t middle = (first + last) / 2;
    std::nth_element(at(first), at(middle), at(last),
                     [axis](const Vec3d& p, const Vec3d& q) { return p[axis] < q[axis]; });
    divide(first, middle);
    nodes_[place].upper_half = nodes_.size();
    divide(middle, last);
  }
  [[nodiscard]] bool has_any(const Box3d& box, std::size_t place, std::size_t first,
                             std::size_t last) const {
    if (!boxes_meet(nodes_[place].box, box)) return false;
    if (last - first <= kLeaf)
      return std::any_of(at(first), at(last), [&](const Vec3d& p) {
        return boxes_meet({p, p}, box);
      });
    const std::size_t middle = (first + last) / 2;
    return has_any(box, place + 1, first, middle) ||
           has_any(box, nodes_[place].upper_half, middle, last);
  }
  [[nodiscard]] std::vector<Vec3d>::iterator at(std::size_t k) {
    return points_.begin() + static_cast<std::ptrdiff_t>(k);
  }
  [[nodiscard]] std::vector<Vec3d>::const_iterator at(std::size_t k) const {
    return points_.begin() + static_cast<std::ptrdiff_t>(k);
  }

  std::vector<Vec3d> points_;
  std::vector<Node> nodes_;
};

/// What a query demands of nodes whose bounds are where it looks.
struct ProbeRule {
  MeetsBox where;
  double max_error = 0;
  double slack = 0;

  [[nodiscard]] Evaluation evaluate(const NodeFacts& node) const {
    if (!where(box_of(node.bounds, slack))) return {0, false};
    constexpr double kLast = 1e-30;  // wanted without an error, too
    return {max_error == 0 ? std::max(node.error, kLast) : std::max(0.0, node.error - max_error),
            true};
  }
  [[nodiscard]] double operator()(const NodeFacts& node) const { return evaluate(node).demand; }
  [[nodiscard]] bool touches(const NodeFacts& node) const { return evaluate(node).touches; }
};

}  // namespace

MeetsBox meets_points(std::span<const Vec3d> points) {
  return [tree = std::make_shared<const PointTree>(points)](const Box3d& box) {
    return tree->has_any_in(box);
  };
}

MeetsBox meets_segment(const Vec3d& a, const Vec3d& b) {
  return [a, b](const Box3d& box) { return meets_line(box, a, b); };
}

MeetsBox meets_box(const Box3d& where) {
  return [where](const Box3d& box) { return boxes_meet(where, box); };
}

MeetsBox meets_all() {
  return [](const Box3d&) { return true; };
}

MeetsBox widened(MeetsBox where, double reach) {
  const Vec3d off{{reach, reach, reach}};
  return [where = std::move(where), off](const Box3d& box) {
    return where({box.lower - off, box.upper + off});
  };
}

double farthest_corner(const Box3d& domain) {
  Vec3d farthest;
  for (std::size_t i = 0; i < 3; ++i)
    farthest[i] = std::max(std::abs(domain.lower[i]), std::abs(domain.upper[i]));
  return length(farthest);
}

double distance_rounding(const Box3d& domain) {
  return ProbeOptions::kSnapRounding / 4 * farthest_corner(domain);
}

Box3d box_of(const Bounds& bounds, double slack) {
  Box3d box;
  for (std::size_t i = 0; i < 3; ++i) {
    const double reach = bounds.half[i] + bounds.radius + slack;
    box.lower[i] = bounds.centre[i] - reach;
    box.upper[i] = bounds.centre[i] + reach;
  }
  return box;
}

double bounds_slack(const Box3d& domain) {
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i)
    largest = std::max({largest, std::abs(domain.lower[i]), std::abs(domain.upper[i])});
  return 0x1p-46 * largest;
}

Demand probe_demand(MeetsBox where, double max_error, double slack) {
  return ProbeRule{std::move(where), max_error, slack};
}

}  // namespace lode

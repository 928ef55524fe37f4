// What the nodes of a hierarchy of splits are worth: errors, ranges and bounds, own ones first,
// then joined with those of the nodes below in the forest.

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "tests/contract/split_hierarchy.h"

namespace lode::test {
namespace {

float rounded_up(double x) {
  const float f = static_cast<float>(x);
  return f < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

float rounded_down(double x) { return -rounded_up(-x); }

/// What a triangle's linear function is at a point in it; points on edges are in both triangles.
std::optional<double> value_in(const SplitHierarchy& hierarchy, const Triangle& triangle,
                               const Vec3d& point) {
  double twice_area = 0;
  double value = 0;
  std::array<double, 3> weights{};
  for (std::size_t i = 0; i < 3; ++i) {
    const SplitVertex& v = hierarchy.vertices[triangle.corners[(i + 1) % 3]];
    const SplitVertex& w = hierarchy.vertices[triangle.corners[(i + 2) % 3]];
    weights[i] = cross(v.position - point, w.position - point)[2];
    twice_area += weights[i];
    value += weights[i] * hierarchy.vertices[triangle.corners[i]].value;
  }
  if (*std::min_element(weights.begin(), weights.end()) < -1e-9 * twice_area) return {};
  return value / twice_area;
}

double own_error(const SplitHierarchy& hierarchy, const Split& split) {
  double error = 0;
  for (std::size_t i = 0; i < hierarchy.n_samples; ++i)
    for (const Triangle& triangle : split.before) {
      const SplitVertex& sample = hierarchy.vertices[i];
      if (const auto value = value_in(hierarchy, triangle, sample.position))
        error = std::max(error, std::abs(*value - sample.value));
    }
  return error;
}

struct Rectangle {
  Range x{1, 0};
  Range y{1, 0};

  [[nodiscard]] bool meets(const Rectangle& other) const {
    return x.meets(other.x) && y.meets(other.y);
  }
};

void join(Range& range, double x) {
  range = range.is_empty() ? Range{x, x} : Range{std::min(range.low, x), std::max(range.high, x)};
}

void join(const SplitHierarchy& hierarchy, Rectangle& rectangle, const Triangle& triangle) {
  for (const Label v : triangle.corners) {
    join(rectangle.x, hierarchy.vertices[v].position[0]);
    join(rectangle.y, hierarchy.vertices[v].position[1]);
  }
}

/// Of the star's vertices, and of all reference triangles that may overlap the star: samples in it
/// alone would miss what the field does near its outline.
Range own_range(const SplitHierarchy& hierarchy, const Split& split) {
  Range range{1, 0};
  Rectangle domain;
  const auto join_values = [&](const Triangle& triangle) {
    for (const Label v : triangle.corners) join(range, hierarchy.vertices[v].value);
  };
  for (const Triangle& triangle : split.before) {
    join_values(triangle);
    join(hierarchy, domain, triangle);
  }
  for (const Triangle& triangle : hierarchy.reference) {
    Rectangle part;
    join(hierarchy, part, triangle);
    if (part.meets(domain)) join_values(triangle);
  }
  return range;
}

/// Around the vertex that is split.
Bounds own_bounds(const SplitHierarchy& hierarchy, Label v) {
  Bounds ball{hierarchy.vertices[v].position, 0};
  for (const Triangle& triangle : hierarchy.split(v).before)
    for (const Label w : triangle.corners)
      ball.radius = std::max(ball.radius, length(hierarchy.vertices[w].position - ball.centre));
  return ball;
}

}  // namespace

void find_split_facts(SplitHierarchy& hierarchy) {
  // Rounding must not let a child's ball out.
  constexpr double kSlack = 1 + 1e-9;
  // Children have lower labels: they are ready.
  for (std::size_t i = 0; i < hierarchy.splits.size(); ++i) {
    const Split& split = hierarchy.splits[i];
    const Range range = own_range(hierarchy, split);
    Bounds bounds = own_bounds(hierarchy, hierarchy.label(i));
    StoredFacts facts;
    facts.error = rounded_up(own_error(hierarchy, split));
    facts.low = rounded_down(range.low);
    facts.high = rounded_up(range.high);
    for (const Label child : split.children) {
      if (!hierarchy.is_node(child)) continue;
      const StoredFacts& below = hierarchy.facts[hierarchy.place(child)];
      facts.error = std::max(facts.error, below.error);
      facts.low = std::min(facts.low, below.low);
      facts.high = std::max(facts.high, below.high);
      const Bounds& inner = hierarchy.bounds[hierarchy.place(child)];
      bounds.radius = std::max(bounds.radius, length(inner.centre - bounds.centre) + inner.radius);
    }
    bounds.radius *= kSlack;
    facts.world_error = rounded_up(2 * bounds.radius);
    hierarchy.facts.push_back(facts);
    hierarchy.bounds.push_back(bounds);
  }
}

}  // namespace lode::test

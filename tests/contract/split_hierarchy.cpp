#include "tests/contract/split_hierarchy.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <random>
#include <set>
#include <tuple>

namespace lode::test {
namespace {

/// What a collapse makes of an edge.
struct Collapse {
  SplitVertex vertex;
  Split split;
};

/// Collapses the cheapest edge that can be, again and again.
class EdgeCollapser {
 public:
  explicit EdgeCollapser(SplitHierarchy& hierarchy)
      : hierarchy_(hierarchy), mesh_(2 * hierarchy.vertices.size(), hierarchy.reference) {}

  void run() {
    while (collapse_cheapest()) {
    }
    hierarchy_.base = mesh_.triangles();
  }

 private:
  /// Slivers would make barycentric coordinates, and so errors, inexact.
  static constexpr double kMinArea = 0.02;
  static constexpr std::size_t kMaxNeighbours = 12;

  struct Edge {
    double cost = 0;
    std::array<Label, 2> ends{};
    friend bool operator<(const Edge& a, const Edge& b) {
      return std::tie(a.cost, a.ends) < std::tie(b.cost, b.ends);
    }
  };

  bool collapse_cheapest() {
    for (const Edge& edge : edges()) {
      const auto collapse = try_collapse(edge.ends);
      if (!collapse) continue;
      const Label made = next_label();
      hierarchy_.vertices.push_back(collapse->vertex);
      hierarchy_.forest_parents.push_back(kNoLabel);
      for (const Label child : edge.ends) hierarchy_.forest_parents[child] = made;
      mesh_.replace(collapse->split.after, collapse->split.before);
      hierarchy_.splits.push_back(collapse->split);
      return true;
    }
    return false;
  }

  [[nodiscard]] Label next_label() const { return static_cast<Label>(hierarchy_.vertices.size()); }

  /// By ascending cost. Long edges cost more, so that the forest does not become a list.
  [[nodiscard]] std::set<Edge> edges() const {
    std::set<Edge> result;
    for (const Triangle& triangle : mesh_.triangles())
      for (std::size_t i = 0; i < 3; ++i) {
        const auto [a, b] = std::minmax(triangle.corners[i], triangle.corners[(i + 1) % 3]);
        const SplitVertex& v = hierarchy_.vertices[a];
        const SplitVertex& w = hierarchy_.vertices[b];
        const double cost = length(w.position - v.position) * (10 + std::abs(w.value - v.value));
        result.insert({cost, {a, b}});
      }
    return result;
  }

  /// Of two vertices the one on more sides stays where it is: the rectangle never changes.
  [[nodiscard]] std::optional<SplitVertex> merged(const SplitVertex& a,
                                                  const SplitVertex& b) const {
    if (a.sides == b.sides)
      return SplitVertex{0.5 * (a.position + b.position), (a.value + b.value) / 2, a.sides};
    if ((a.sides & b.sides) == b.sides) return a;
    if ((a.sides & b.sides) == a.sides) return b;
    return {};
  }

  /// The link condition: only the triangles at the edge vanish, nothing is glued. An edge inside
  /// that joins two sides does not get here: merged() refuses it.
  [[nodiscard]] bool keeps_topology(const std::array<Label, 2>& ends) const {
    const auto a = mesh_.neighbours(ends[0]);
    const auto b = mesh_.neighbours(ends[1]);
    std::vector<Label> common;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
    const auto& star = mesh_.star(ends[0]);
    const auto n_vanishing =
        std::count_if(star.begin(), star.end(), [&](const Triangle& t) { return t.has(ends[1]); });
    return static_cast<std::size_t>(n_vanishing) == common.size() &&
           a.size() + b.size() - common.size() - 2 <= kMaxNeighbours;
  }

  [[nodiscard]] std::optional<Collapse> try_collapse(const std::array<Label, 2>& ends) {
    const auto vertex = merged(hierarchy_.vertices[ends[0]], hierarchy_.vertices[ends[1]]);
    if (!vertex || !keeps_topology(ends)) return {};
    std::set<Triangle> after = mesh_.star(ends[0]);
    after.insert(mesh_.star(ends[1]).begin(), mesh_.star(ends[1]).end());
    Collapse result{*vertex, {ends, {}, {after.begin(), after.end()}}};
    for (const Triangle& old : after) {
      if (old.has(ends[0]) && old.has(ends[1])) continue;
      auto corners = old.corners;
      for (Label& corner : corners)
        if (corner == ends[0] || corner == ends[1]) corner = next_label();
      result.split.before.push_back(Triangle::of(corners[0], corners[1], corners[2]));
    }
    if (!is_flat(result)) return {};
    return result;
  }

  /// Whether no triangle is turned over.
  [[nodiscard]] bool is_flat(const Collapse& collapse) {
    hierarchy_.vertices.push_back(collapse.vertex);
    const auto& before = collapse.split.before;
    const bool result = std::all_of(before.begin(), before.end(), [&](const Triangle& triangle) {
      return hierarchy_.signed_area(triangle) > kMinArea;
    });
    hierarchy_.vertices.pop_back();
    return result;
  }

  SplitHierarchy& hierarchy_;
  SplitMesh mesh_;
};

/// The samples, without collapses.
SplitHierarchy make_reference(std::uint32_t seed) {
  constexpr Label kColumns = 12;
  constexpr Label kRows = 9;
  std::mt19937 random(seed);
  const auto uniform = [&] { return static_cast<double>(random() % 1024) / 1024; };
  SplitHierarchy result;
  for (Label y = 0; y < kRows; ++y)
    for (Label x = 0; x < kColumns; ++x) {
      SplitVertex v;
      v.sides = static_cast<std::uint8_t>((x == 0 ? 1 : 0) | (x == kColumns - 1 ? 2 : 0) |
                                          (y == 0 ? 4 : 0) | (y == kRows - 1 ? 8 : 0));
      const double jitter = v.sides == 0 ? 0.4 : 0;
      v.position = {{x + jitter * (uniform() - 0.5), y + jitter * (uniform() - 0.5), 0}};
      v.value = 45 + 35 * std::sin(0.7 * x) * std::cos(0.6 * y) + 40 * uniform();
      result.vertices.push_back(v);
    }
  for (Label y = 0; y + 1 < kRows; ++y)
    for (Label x = 0; x + 1 < kColumns; ++x) {
      const Label at = y * kColumns + x;
      result.reference.push_back(Triangle::of(at, at + 1, at + kColumns + 1));
      result.reference.push_back(Triangle::of(at, at + kColumns + 1, at + kColumns));
    }
  result.n_samples = result.vertices.size();
  result.forest_parents.assign(result.n_samples, kNoLabel);
  return result;
}

}  // namespace

double SplitHierarchy::signed_area(const Triangle& triangle) const {
  const Vec3d a = vertices[triangle.corners[0]].position;
  const Vec3d b = vertices[triangle.corners[1]].position;
  const Vec3d c = vertices[triangle.corners[2]].position;
  return 0.5 * cross(b - a, c - a)[2];
}

SplitHierarchy build_split_hierarchy(std::uint32_t seed) {
  SplitHierarchy result = make_reference(seed);
  EdgeCollapser(result).run();
  find_split_facts(result);
  return result;
}

}  // namespace lode::test

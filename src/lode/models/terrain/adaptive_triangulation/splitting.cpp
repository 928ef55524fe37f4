#include "lode/models/terrain/adaptive_triangulation/splitting.h"

#include <algorithm>
#include <initializer_list>

namespace lode::adaptive_triangulation {
namespace {

using Numbers = std::array<std::uint8_t, 3>;

constexpr std::uint8_t kCentre = 6;

std::uint8_t corner_of(std::size_t i) { return static_cast<std::uint8_t>(i % 3); }
std::uint8_t place_on(std::size_t edge) { return static_cast<std::uint8_t>(3 + edge % 3); }

class Splitter {
 public:
  explicit Splitter(const Insertion& insertion) : insertion_(insertion) {
    for (std::size_t i = 0; i < 3; ++i) {
      places_[i] = insertion.corner[i];
      if (!insertion.on_edge[i]) continue;
      places_[3 + i] = *insertion.on_edge[i];
      ++n_edges_;
    }
    if (insertion.centre) places_[kCentre] = *insertion.centre;
  }

  std::optional<Split> run() {
    switch (n_edges_) {
      case 0: return by_centre();
      case 1: return by_one_edge();
      case 2: return by_two_edges();
      default: return by_three_edges();
    }
  }

 private:
  [[nodiscard]] bool has(std::size_t edge) const { return insertion_.on_edge[edge].has_value(); }

  [[nodiscard]] std::optional<Split> made(Rule rule,
                                          std::initializer_list<Numbers> triangles) const {
    Split split{.rule = rule, .n_triangles = triangles.size()};
    std::ranges::copy(triangles, split.triangles.begin());
    for (const Numbers& t : triangles)
      if (delaunay::doubled_area(places_[t[0]], places_[t[1]], places_[t[2]]) <= 0) return {};
    return split;
  }

  [[nodiscard]] std::optional<Split> by_centre() const {
    return made(Rule::centre, {{0, 1, kCentre}, {1, 2, kCentre}, {2, 0, kCentre}});
  }

  [[nodiscard]] std::optional<Split> by_one_edge() const {
    const std::size_t edge = has(0) ? 0 : has(1) ? 1 : 2;
    const std::uint8_t a = corner_of(edge);
    const std::uint8_t b = corner_of(edge + 1);
    const std::uint8_t c = corner_of(edge + 2);
    const std::uint8_t p = place_on(edge);
    if (insertion_.centre)
      if (const auto split =
              made(Rule::edge_and_centre,
                   {{a, p, kCentre}, {p, b, kCentre}, {b, c, kCentre}, {c, a, kCentre}}))
        return split;
    return made(Rule::edge, {{a, p, c}, {p, b, c}});
  }

  [[nodiscard]] std::optional<Split> by_two_edges() const {
    // That of the two edges after which the other one comes.
    const std::size_t edge = has(0) && has(1) ? 0 : has(1) ? 1 : 2;
    const std::uint8_t a = corner_of(edge);
    const std::uint8_t b = corner_of(edge + 1);
    const std::uint8_t c = corner_of(edge + 2);
    const std::uint8_t p = place_on(edge);
    const std::uint8_t q = place_on(edge + 1);
    const auto from_p = made(Rule::two_edges, {{p, b, q}, {a, p, c}, {p, q, c}});
    const auto from_q = made(Rule::two_edges, {{p, b, q}, {a, p, q}, {a, q, c}});
    if (!from_p || !from_q) return from_p ? from_p : from_q;
    return squared_length(p, c) <= squared_length(q, a) ? from_p : from_q;
  }

  [[nodiscard]] std::optional<Split> by_three_edges() const {
    return made(Rule::three_edges, {{0, 3, 5}, {3, 1, 4}, {4, 2, 5}, {3, 4, 5}});
  }

  [[nodiscard]] std::int64_t squared_length(std::uint8_t from, std::uint8_t to) const {
    const std::int64_t dx = places_[to].x - places_[from].x;
    const std::int64_t dy = places_[to].y - places_[from].y;
    return dx * dx + dy * dy;
  }

  const Insertion& insertion_;
  std::array<LatticePoint, 7> places_{};
  int n_edges_ = 0;
};

}  // namespace

std::optional<Split> split_triangle(const Insertion& insertion) {
  return Splitter(insertion).run();
}

}  // namespace lode::adaptive_triangulation

#include "lode/delaunay/triangulation.h"

#include <algorithm>
#include <deque>
#include <numeric>

#include "lode/core/expects.h"

namespace lode::delaunay {
namespace {

constexpr unsigned next(unsigned i) { return (i + 1) % 3; }
constexpr unsigned previous(unsigned i) { return (i + 2) % 3; }

}  // namespace

unsigned Triangulation::index_of(std::uint32_t triangle, std::uint32_t corner) const {
  const auto& corners = triangles_[triangle].corner;
  return corners[0] == corner ? 0 : corners[1] == corner ? 1 : 2;
}

Triangulation::Place Triangulation::mirror(const Place& place) const {
  const std::uint32_t other = triangles_[place.triangle].neighbour[place.edge];
  if (other == kNone) return {};
  // Its corner that the two do not share follows the end of the edge.
  const std::uint32_t start = triangles_[place.triangle].corner[next(place.edge)];
  return {other, next(index_of(other, start))};
}

void Triangulation::link(const Place& a, const Place& b) {
  if (a.triangle != kNone) triangles_[a.triangle].neighbour[a.edge] = b.triangle;
  if (b.triangle != kNone) triangles_[b.triangle].neighbour[b.edge] = a.triangle;
}

/// Turns the edge in the quadrilateral of its two triangles, which keep their numbers. Afterwards
/// each has the new edge opposite its corner 0.
void Triangulation::flip(const Place& place) {
  const Place mirrored = mirror(place);
  const Triangle t = triangles_[place.triangle];
  const Triangle u = triangles_[mirrored.triangle];
  const std::uint32_t start = t.corner[next(place.edge)];
  const std::uint32_t end = t.corner[previous(place.edge)];
  const std::uint32_t left = t.corner[place.edge];
  const std::uint32_t right = u.corner[mirrored.edge];
  // Outer edges: of t, end -> left and left -> start; of u, start -> right and right -> end.
  const std::array<Place, 4> outer{mirror({place.triangle, next(place.edge)}),
                                   mirror({place.triangle, previous(place.edge)}),
                                   mirror({mirrored.triangle, next(mirrored.edge)}),
                                   mirror({mirrored.triangle, previous(mirrored.edge)})};
  const std::array<bool, 4> fixed{t.is_fixed[next(place.edge)], t.is_fixed[previous(place.edge)],
                                  u.is_fixed[next(mirrored.edge)],
                                  u.is_fixed[previous(mirrored.edge)]};
  triangles_[place.triangle] = {
      {start, right, left}, {kNone, kNone, kNone}, {false, fixed[1], fixed[2]}};
  triangles_[mirrored.triangle] = {
      {end, left, right}, {kNone, kNone, kNone}, {false, fixed[3], fixed[0]}};
  link({place.triangle, 0}, {mirrored.triangle, 0});
  link({place.triangle, 1}, outer[1]);
  link({place.triangle, 2}, outer[2]);
  link({mirrored.triangle, 1}, outer[3]);
  link({mirrored.triangle, 2}, outer[0]);
  triangle_of_[start] = triangle_of_[left] = place.triangle;
  triangle_of_[end] = triangle_of_[right] = mirrored.triangle;
}

bool Triangulation::is_illegal(const Place& place) const {
  const Triangle& t = triangles_[place.triangle];
  if (t.is_fixed[place.edge] || t.neighbour[place.edge] == kNone) return false;
  const Place mirrored = mirror(place);
  const std::uint32_t across = triangles_[mirrored.triangle].corner[mirrored.edge];
  return side_of_circle(points_[t.corner[0]], points_[t.corner[1]], points_[t.corner[2]],
                        points_[across]) > 0;
}

/// Lawson's flips, starting from some edges.
void Triangulation::make_delaunay(std::vector<Place>& suspects) {
  while (!suspects.empty()) {
    const Place place = suspects.back();
    suspects.pop_back();
    if (!is_illegal(place)) continue;
    const std::uint32_t other = mirror(place).triangle;
    flip(place);
    for (const std::uint32_t triangle : {place.triangle, other})
      for (const unsigned edge : {1U, 2U}) suspects.push_back({triangle, edge});
  }
}

template <typename Visit>
void Triangulation::visit_round(std::uint32_t point, const Visit& visit) const {
  const std::uint32_t first = triangle_of_[point];
  if (first == kNone) return;
  std::uint32_t t = first;
  do {
    if (visit(t)) return;
    t = triangles_[t].neighbour[next(index_of(t, point))];
  } while (t != kNone && t != first);
  if (t == first) return;
  // The hull is in the way: on from the first in the other direction.
  t = first;
  while ((t = triangles_[t].neighbour[previous(index_of(t, point))]) != kNone)
    if (visit(t)) return;
}

Triangulation::Place Triangulation::find_edge(std::uint32_t a, std::uint32_t b) const {
  Place found;
  visit_round(a, [&](std::uint32_t t) {
    const unsigned i = index_of(t, a);
    if (triangles_[t].corner[next(i)] == b) found = {t, previous(i)};
    return found.triangle != kNone;
  });
  return found;
}

/// Adds points in lexicographic order: each lies outside the hull of those before it.
class Triangulation::Sweep {
 public:
  explicit Sweep(Triangulation& result)
      : result_(result), next_(result.points_.size(), kNone), previous_(next_) {}

  Result<void> run() {
    LODE_TRY(const std::vector<std::uint32_t> order, sorted());
    result_.triangle_of_.assign(order.size(), kNone);
    std::size_t n = 2;
    while (n < order.size() && result_.turn(order[0], order[1], order[n]) == 0) ++n;
    if (n >= order.size()) return {};
    start(std::span(order).first(n), order[n]);
    for (std::size_t i = n + 1; i < order.size(); ++i) add(order[i], order[i - 1]);
    return {};
  }

 private:
  Result<std::vector<std::uint32_t>> sorted() const {
    const auto& points = result_.points_;
    std::vector<std::uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return points[a].v < points[b].v; });
    for (std::size_t i = 1; i < order.size(); ++i)
      if (points[order[i]] == points[order[i - 1]])
        return fail("expected distinct points, got points {} and {} both at ({}, {})", order[i - 1],
                    order[i], points[order[i]][0], points[order[i]][1]);
    return order;
  }

  /// A fan from the first point that is not on one line with those before it.
  void start(std::span<const std::uint32_t> line, std::uint32_t apex) {
    const bool is_left = result_.turn(line[0], line[1], apex) > 0;
    std::vector<Place> suspects;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const std::uint32_t from = is_left ? line[i] : line[i + 1];
      const std::uint32_t to = is_left ? line[i + 1] : line[i];
      const std::uint32_t t = append(from, to, apex);
      set_hull(from, to);
      if (t == 0) continue;
      result_.link({t - 1, is_left ? 0U : 1U}, {t, is_left ? 1U : 0U});
      suspects.push_back({t, is_left ? 1U : 0U});
    }
    set_hull(is_left ? line.back() : line.front(), apex);
    set_hull(apex, is_left ? line.front() : line.back());
    result_.make_delaunay(suspects);
  }

  /// Joins a point to the part of the hull that it sees: the last one, to its left, is part of it.
  void add(std::uint32_t point, std::uint32_t rightmost) {
    std::uint32_t first = rightmost;
    std::uint32_t last = rightmost;
    while (result_.turn(previous_[first], first, point) < 0) first = previous_[first];
    while (result_.turn(last, next_[last], point) < 0) last = next_[last];
    std::vector<Place> suspects;
    std::uint32_t before = kNone;
    for (std::uint32_t a = first; a != last; a = next_[a]) {
      const Place behind = result_.find_edge(a, next_[a]);
      const std::uint32_t t = append(next_[a], a, point);
      result_.link({t, 2}, behind);
      result_.link({t, 0}, {before, 1});
      suspects.push_back({t, 2});
      before = t;
    }
    set_hull(first, point);
    set_hull(point, last);
    result_.make_delaunay(suspects);
  }

  std::uint32_t append(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const auto t = static_cast<std::uint32_t>(result_.triangles_.size());
    result_.triangles_.push_back({{a, b, c}});
    for (const std::uint32_t corner : {a, b, c}) result_.triangle_of_[corner] = t;
    return t;
  }

  void set_hull(std::uint32_t from, std::uint32_t to) {
    next_[from] = to;
    previous_[to] = from;
  }

  Triangulation& result_;
  std::vector<std::uint32_t> next_, previous_;  ///< Along the hull, counter-clockwise.
};

Result<Triangulation> Triangulation::of(std::vector<Point> points) {
  Triangulation result(std::move(points));
  LODE_CHECK(Sweep(result).run());
  return result;
}

/// Whether the open segments a-b and c-d meet in one point.
bool Triangulation::crosses(std::uint32_t a, std::uint32_t b, std::uint32_t c,
                            std::uint32_t d) const {
  return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
}

Triangulation::Course Triangulation::start_course(std::uint32_t a, std::uint32_t b,
                                                  Place& first) const {
  Course course{.end = kNone};
  visit_round(a, [&](std::uint32_t t) {
    const unsigned i = index_of(t, a);
    const std::uint32_t c = triangles_[t].corner[next(i)];
    const std::uint32_t d = triangles_[t].corner[previous(i)];
    if (turn(a, b, c) < 0 && turn(a, b, d) > 0 && turn(c, d, b) <= 0) first = {t, i};
    for (const std::uint32_t corner : {c, d}) {
      const Point ahead = points_[b] - points_[a];
      if (turn(a, b, corner) == 0 && dot(points_[corner] - points_[a], ahead) > 0)
        course.end = corner;
    }
    return first.triangle != kNone || course.end != kNone;
  });
  return course;
}

Result<Triangulation::Course> Triangulation::find_course(std::uint32_t a, std::uint32_t b) const {
  Place place;
  Course course = start_course(a, b, place);
  if (course.end != kNone) return course;
  if (place.triangle == kNone) return fail("edge {}-{} has no place in the triangulation", a, b);
  while (true) {
    const Triangle& t = triangles_[place.triangle];
    const std::uint32_t right = t.corner[next(place.edge)];
    const std::uint32_t left = t.corner[previous(place.edge)];
    if (t.is_fixed[place.edge]) return fail("edges {}-{} and {}-{} cross", a, b, right, left);
    course.crossed.push_back({right, left});
    const Place across = mirror(place);
    LODE_EXPECTS(across.triangle != kNone);
    const std::uint32_t apex = triangles_[across.triangle].corner[across.edge];
    const int side = turn(a, b, apex);
    if (side == 0) {
      course.end = apex;
      return course;
    }
    // Seen from there the edge runs left -> right: on to the edge at the end that stays.
    place = {across.triangle, side > 0 ? next(across.edge) : previous(across.edge)};
  }
}

void Triangulation::flip_crossed(std::uint32_t a, std::uint32_t b, std::vector<Ends> crossed) {
  std::deque<Ends> open(crossed.begin(), crossed.end());
  std::vector<Ends> made;
  while (!open.empty()) {
    const Ends edge = open.front();
    open.pop_front();
    const Place place = find_edge(edge[0], edge[1]);
    const Place across = mirror(place);
    const std::uint32_t c = triangles_[place.triangle].corner[place.edge];
    const std::uint32_t d = triangles_[across.triangle].corner[across.edge];
    if (!crosses(c, d, edge[0], edge[1])) {  // not convex: later
      open.push_back(edge);
      continue;
    }
    flip(place);
    (crosses(a, b, c, d) ? open.emplace_back(Ends{c, d}) : made.emplace_back(Ends{c, d}));
  }
  const Place fixed = find_edge(a, b);
  triangles_[fixed.triangle].is_fixed[fixed.edge] = true;
  const Place other = mirror(fixed);
  if (other.triangle != kNone) triangles_[other.triangle].is_fixed[other.edge] = true;
  std::vector<Place> suspects;
  for (const Ends& edge : made)
    if (const Place place = find_edge(edge[0], edge[1]); place.triangle != kNone)
      suspects.push_back(place);
  make_delaunay(suspects);
}

Result<void> Triangulation::fix_edge(std::uint32_t a, std::uint32_t b) {
  if (a == b) return fail("expected an edge between two points, got {}-{}", a, b);
  LODE_TRY(Course course, find_course(a, b));
  if (course.end != b) return fail("edge {}-{} runs through point {}", a, b, course.end);
  fix_course(a, std::move(course));
  return {};
}

std::vector<std::uint32_t> Triangulation::fix_path(std::uint32_t a, std::uint32_t b) {
  std::vector<std::uint32_t> path{a};
  while (path.back() != b) {
    const std::uint32_t from = path.back();
    Result<Course> course = find_course(from, b);
    if (!course) break;
    path.push_back(course->end);
    fix_course(from, *std::move(course));
  }
  return path;
}

void Triangulation::fix_course(std::uint32_t a, Course course) {
  const std::uint32_t b = course.end;
  const bool is_forward = !course.crossed.empty() || find_edge(a, b).triangle != kNone;
  flip_crossed(is_forward ? a : b, is_forward ? b : a, std::move(course.crossed));
}

/// Floods from the left side of every edge; the right sides must stay dry.
Result<std::vector<bool>> Triangulation::left_of(std::span<const Ends> edges) const {
  std::vector<bool> is_inside(triangles_.size(), false);
  std::vector<std::uint32_t> open;
  const auto enter = [&](std::uint32_t t) {
    if (t == kNone || is_inside[t]) return;
    is_inside[t] = true;
    open.push_back(t);
  };
  for (const Ends& edge : edges) {
    const Place left = find_edge(edge[0], edge[1]);
    if (left.triangle == kNone) return fail("edge {}-{} has nothing on its left", edge[0], edge[1]);
    enter(left.triangle);
  }
  while (!open.empty()) {
    const Triangle& t = triangles_[open.back()];
    open.pop_back();
    for (unsigned edge = 0; edge < 3; ++edge)
      if (!t.is_fixed[edge]) {
        if (t.neighbour[edge] == kNone)
          return fail("the region left of the edges is not closed at {}-{}", t.corner[next(edge)],
                      t.corner[previous(edge)]);
        enter(t.neighbour[edge]);
      }
  }
  for (const Ends& edge : edges) {
    const Place right = find_edge(edge[1], edge[0]);
    if (right.triangle != kNone && is_inside[right.triangle])
      return fail("both sides of edge {}-{} are inside", edge[0], edge[1]);
  }
  return is_inside;
}

Result<std::vector<std::array<std::uint32_t, 3>>> triangulate_region(
    std::vector<Point> points, std::span<const std::array<std::uint32_t, 2>> edges) {
  LODE_TRY(Triangulation triangulation, Triangulation::of(std::move(points)));
  for (const auto& edge : edges) LODE_CHECK(triangulation.fix_edge(edge[0], edge[1]));
  LODE_TRY(const std::vector<bool> is_inside, triangulation.left_of(edges));
  return triangulation.corners(is_inside);
}

/// Those with nothing inside on either side, beside an outline that is not convex or that points
/// are off by rounding.
void Triangulation::leave_out_edges(const std::vector<bool>& is_inside, FixedRegion& region) const {
  const auto has_inside = [&](std::uint32_t a, std::uint32_t b) {
    const Place place = find_edge(a, b);
    return place.triangle != kNone && is_inside[place.triangle];
  };
  std::size_t n = 0;
  for (std::size_t i = 0; i < region.edges.size(); ++i) {
    const auto [a, b] = region.edges[i];
    if (has_inside(a, b) || has_inside(b, a)) {
      region.edges[n] = region.edges[i];
      region.line_of[n++] = region.line_of[i];
    } else {
      region.crossing.push_back(region.line_of[i]);
    }
  }
  region.edges.resize(n);
  region.line_of.resize(n);
  std::ranges::sort(region.crossing);
  region.crossing.erase(std::unique(region.crossing.begin(), region.crossing.end()),
                        region.crossing.end());
}

Result<FixedRegion> triangulate_region(std::vector<Point> points,
                                       std::span<const std::array<std::uint32_t, 2>> outline,
                                       std::span<const std::array<std::uint32_t, 2>> lines,
                                       Progress& progress) {
  LODE_TRY(Triangulation triangulation, Triangulation::of(std::move(points)));
  using Edges = std::vector<std::array<std::uint32_t, 2>>;
  /// Whether all of the way is fixed.
  const auto fix = [&](const std::array<std::uint32_t, 2>& edge, Edges& made) {
    const std::vector<std::uint32_t> path = triangulation.fix_path(edge[0], edge[1]);
    for (std::size_t i = 1; i < path.size(); ++i) made.push_back({path[i - 1], path[i]});
    return path.back() == edge[1];
  };
  Edges closed;
  for (const auto& edge : outline)
    if (!fix(edge, closed))
      return fail("expected an outline that does not cross itself, got edge {}-{}", edge[0],
                  edge[1]);
  LODE_TRY(const std::vector<bool> is_inside, triangulation.left_of(closed));
  // What is flipped from here on is on one side of the outline, and stays there.
  FixedRegion region;
  constexpr std::uint32_t kPerReport = 1024;
  for (std::uint32_t i = 0; i < lines.size(); ++i) {
    if (i % kPerReport == 0 && progress.is_cancelled()) return cancelled_error();
    if (!fix(lines[i], region.edges)) {
      region.crossing.push_back(i);
      fix({lines[i][1], lines[i][0]}, region.edges);
    }
    region.line_of.resize(region.edges.size(), i);
  }
  triangulation.leave_out_edges(is_inside, region);
  region.triangles = triangulation.corners(is_inside);
  return region;
}

std::vector<std::array<std::uint32_t, 3>> Triangulation::corners(
    const std::vector<bool>& is_kept) const {
  std::vector<std::array<std::uint32_t, 3>> result;
  for (std::size_t t = 0; t < is_kept.size(); ++t)
    if (is_kept[t]) result.push_back(triangles_[t].corner);
  return result;
}

}  // namespace lode::delaunay

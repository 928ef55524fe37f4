#include "lode/mappers/self_intersections.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>
#include <utility>
#include <vector>

#include "lode/mappers/box_pairs.h"
#include "lode/mappers/coincident_vertices.h"
#include "lode/mappers/triangle_intersection.h"

namespace lode {
namespace {

template <std::size_t N>
using Simplex = std::array<std::uint32_t, N>;

/// Reorders both so that their common corners come first, in the same order; returns how many.
template <std::size_t N>
std::size_t align_common_corners(Simplex<N>& s, Simplex<N>& t) {
  std::size_t n_common = 0;
  for (std::size_t i = 0; i < N; ++i)
    for (std::size_t j = n_common; j < N; ++j) {
      if (s[i] != t[j]) continue;
      std::swap(s[i], s[n_common]);
      std::swap(t[j], t[n_common]);
      ++n_common;
      break;
    }
  return n_common;
}

template <std::size_t N>
std::array<Vec3f, N> corners_of(const std::vector<Vec3f>& positions, const Simplex<N>& s) {
  std::array<Vec3f, N> corners;
  for (std::size_t i = 0; i < N; ++i) corners[i] = positions[s[i]];
  return corners;
}

bool meet_wrongly(const std::vector<Vec3f>& positions, Simplex<3> s, Simplex<3> t) {
  const std::size_t n_common = align_common_corners(s, t);
  if (n_common == 3) return true;
  const TriangleCorners a = corners_of(positions, s);
  const TriangleCorners b = corners_of(positions, t);
  if (n_common == 2) return triangles_meet_beyond_edge(a, b);
  return n_common == 1 ? triangles_meet_beyond_corner(a, b) : triangles_meet(a, b);
}

bool meet_wrongly(const std::vector<Vec3f>& positions, Simplex<2> s, Simplex<2> t) {
  const std::size_t n_common = align_common_corners(s, t);
  if (n_common == 2) return true;
  const LineEnds a = corners_of(positions, s);
  const LineEnds b = corners_of(positions, t);
  return n_common == 1 ? lines_meet_beyond_end(a, b) : lines_meet(a, b);
}

bool is_degenerate(const std::vector<Vec3f>& positions, const Simplex<3>& t) {
  return has_zero_area(positions[t[0]], positions[t[1]], positions[t[2]]);
}

bool is_degenerate(const std::vector<Vec3f>& positions, const Simplex<2>& line) {
  return positions[line[0]] == positions[line[1]];
}

/// The axis along which the plane of the points is best seen: that of the normal's largest
/// component; z where they lie on one line along x or y.
std::size_t viewing_axis(const std::vector<Vec3f>& positions) {
  if (positions.empty()) return 2;
  const Vec3d base = widened(positions[0]);
  Vec3d along;
  for (const Vec3f& p : positions)
    if (const Vec3d d = widened(p) - base; dot(d, d) > dot(along, along)) along = d;
  Vec3d normal;
  for (const Vec3f& p : positions)
    if (const Vec3d n = cross(along, widened(p) - base); dot(n, n) > dot(normal, normal))
      normal = n;
  // On one line no normal stands out: then look along the axis in which the line is shortest.
  const bool is_line = dot(normal, normal) <= 1e-10 * dot(along, along) * dot(along, along);
  std::size_t axis = 2;
  for (const std::size_t i : {std::size_t{1}, std::size_t{0}}) {
    const bool is_better = is_line ? std::abs(along[i]) < std::abs(along[axis])
                                   : std::abs(normal[i]) > std::abs(normal[axis]);
    if (is_better) axis = i;
  }
  return axis;
}

/// Lines as seen along that axis: it becomes the third coordinate, which is set to zero.
std::vector<Vec3f> flattened(const std::vector<Vec3f>& positions) {
  const std::size_t axis = viewing_axis(positions);
  std::vector<Vec3f> flat(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i)
    flat[i] = {{positions[i][(axis + 1) % 3], positions[i][(axis + 2) % 3], 0.0F}};
  return flat;
}

template <std::size_t N>
Box3f box_of(const std::vector<Vec3f>& positions, const Simplex<N>& s) {
  Box3f box{positions[s[0]], positions[s[0]]};
  for (const std::uint32_t vertex : s)
    for (std::size_t i = 0; i < 3; ++i) {
      box.lower[i] = std::min(box.lower[i], positions[vertex][i]);
      box.upper[i] = std::max(box.upper[i], positions[vertex][i]);
    }
  return box;
}

/// What one worker found; `first` counts only where n_intersections > 0.
struct WorkerReport {
  std::uint64_t n_candidates = 0;
  std::uint64_t n_intersections = 0;
  IndexPair first{{0, 0}};

  void add(const IndexPair& pair) {
    if (n_intersections++ == 0 || pair < first) first = pair;
  }
};

template <std::size_t N>
Result<SelfIntersectionReport> check_simplices(const std::vector<Vec3f>& positions,
                                               const std::vector<Simplex<N>>& simplices,
                                               Threads threads, Progress& progress) {
  const std::vector<std::uint32_t> lowest = find_coincident_vertices(positions);
  std::vector<std::uint32_t> numbers;
  std::vector<Box3f> boxes;
  boxes.reserve(simplices.size());
  numbers.reserve(simplices.size());
  for (std::size_t i = 0; i < simplices.size(); ++i) {
    if (is_degenerate(positions, simplices[i])) continue;
    numbers.push_back(static_cast<std::uint32_t>(i));
    boxes.push_back(box_of(positions, simplices[i]));
  }
  const auto merged = [&](std::uint32_t number) {
    Simplex<N> s = simplices[numbers[number]];
    for (std::uint32_t& vertex : s) vertex = lowest[vertex];
    return s;
  };
  std::vector<WorkerReport> workers(static_cast<std::size_t>(n_workers(threads)));
  LODE_CHECK(visit_box_pairs(boxes, threads, progress, [&](auto pairs, int worker) {
    WorkerReport& own = workers[static_cast<std::size_t>(worker)];
    own.n_candidates += pairs.size();
    for (const auto& [i, j] : pairs)
      if (meet_wrongly(positions, merged(i), merged(j))) own.add({numbers[i], numbers[j]});
  }));
  SelfIntersectionReport report{.n_simplices = boxes.size()};
  for (const WorkerReport& own : workers) {
    if (own.n_intersections > 0 && (report.n_intersections == 0 || own.first < report.first))
      report.first = own.first;
    report.n_candidates += own.n_candidates;
    report.n_intersections += own.n_intersections;
  }
  return report;
}

}  // namespace

Result<SelfIntersectionReport> check_self_intersections(const Surface& surface, Threads threads,
                                                        Progress& progress) try {
  if (surface.lines.empty())
    return check_simplices(surface.positions, surface.triangles, threads, progress);
  return check_simplices(flattened(surface.positions), surface.lines, threads, progress);
} catch (const std::bad_alloc&) {
  throw;
} catch (const std::exception& error) {
  return fail("self-intersections: an exact predicate failed: {}", error.what());
}

}  // namespace lode

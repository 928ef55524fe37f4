#include "lode/models/terrain/triangle_hierarchy/point_surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include "lode/core/expects.h"

namespace lode::triangle_hierarchy {
namespace {

__extension__ using Int128 = __int128;

constexpr int kMostPointBits = 8;
constexpr int kPointCoordinateBits = 30;
/// Nodes from one point to the next, on average, as rasters have them: finer lattices keep thinner
/// slivers of the adaptive triangulation, and those of the Delaunay hierarchy are much the same
/// (docs/models/hierarchical_triangulations.md).
constexpr double kNodesBetween = 256;

int point_bits(const HeightFrame& frame, std::size_t n_points) {
  const auto last = static_cast<std::uint32_t>(std::max(frame.n_columns, frame.n_rows) - 1);
  const int most =
      std::min(kMostPointBits, kPointCoordinateBits - static_cast<int>(std::bit_width(last)));
  const double of_point =
      static_cast<double>(frame.n_columns) * frame.n_rows / static_cast<double>(n_points);
  int bits = 0;
  while (bits < most && std::ldexp(of_point, 2 * bits) < kNodesBetween * kNodesBetween) ++bits;
  return bits;
}

HeightRange range_of(const std::vector<double>& heights) {
  const auto [lower, upper] = std::ranges::minmax(heights);
  return {lower, upper};
}

/// from + (to - from) part / whole, to the nearest whole number, upwards from the middle; 0 < part
/// < whole < 2^62.
std::int32_t between(std::int32_t from, std::int32_t to, std::int64_t part, std::int64_t whole) {
  const Int128 way = Int128{to - from} * part;
  Int128 quotient = way / whole;
  Int128 rest = way % whole;
  if (rest < 0) {
    rest += whole;
    --quotient;
  }
  return from + static_cast<std::int32_t>(quotient) + static_cast<std::int32_t>(2 * rest >= whole);
}

std::int64_t squared_distance(LatticePoint a, LatticePoint b) {
  const std::int64_t dx = a.x - b.x;
  const std::int64_t dy = a.y - b.y;
  return dx * dx + dy * dy;
}

}  // namespace

PointSurface::PointSurface(const HeightFrame& frame, delaunay::Tin all,
                           std::span<const std::array<LatticePoint, 3>> base)
    : tin_(std::move(all)),
      locator_(tin_),
      walker_(tin_, locator_, point_bits(frame, tin_.vertices.size())),
      tree_(tin_.vertices, point_bits(frame, tin_.vertices.size())) {
  set_frame(frame, point_bits(frame, tin_.vertices.size()));
  set_range(range_of(tin_.heights));
  std::vector<std::array<LatticePoint, 3>> fine_base;
  fine_base.reserve(base.size());
  for (const auto& [a, b, c] : base) fine_base.push_back({fine(a), fine(b), fine(c)});
  set_base(std::move(fine_base));
}

double PointSurface::height_in(std::uint32_t triangle, LatticePoint at) const {
  const auto& corner = tin_.triangles[triangle];
  std::array<LatticePoint, 3> places{};
  std::array<double, 3> z{};
  for (std::size_t i = 0; i < 3; ++i) {
    places[i] = walker_.fine(corner[i]);
    z[i] = tin_.heights[corner[i]];
    if (places[i] == at) return z[i];
  }
  const auto area = static_cast<double>(delaunay::doubled_area(places[0], places[1], places[2]));
  const auto to_b = static_cast<double>(delaunay::doubled_area(places[2], places[0], at));
  const auto to_c = static_cast<double>(delaunay::doubled_area(places[0], places[1], at));
  const double height = z[0] + (to_b * (z[1] - z[0]) + to_c * (z[2] - z[0])) / area;
  return std::clamp(height, std::min({z[0], z[1], z[2]}), std::max({z[0], z[1], z[2]}));
}

double PointSurface::height(LatticePoint at) const {
  const std::uint32_t triangle = walker_.triangle_at(at);
  LODE_EXPECTS(triangle != delaunay::kNoHalfEdge);
  return height_in(triangle, at);
}

PointSurface::Crossing PointSurface::read(const Place& a, const Place& b,
                                          const TinMeeting& meeting) const {
  if (meeting.is_vertex()) {
    const LatticePoint at = walker_.fine(meeting.left);
    // Along columns or rows, whichever it crosses more of.
    const bool is_wide = std::abs(b.at.x - a.at.x) >= std::abs(b.at.y - a.at.y);
    const double gone = is_wide ? at.x - a.at.x : at.y - a.at.y;
    const double way = is_wide ? b.at.x - a.at.x : b.at.y - a.at.y;
    return {tin_.heights[meeting.left], gone / way};
  }
  const LatticePoint right = walker_.fine(meeting.right);
  const LatticePoint left = walker_.fine(meeting.left);
  const std::int64_t to_right = -delaunay::doubled_area(a.at, b.at, right);
  const std::int64_t to_left = delaunay::doubled_area(a.at, b.at, left);
  const std::int64_t from_a = delaunay::doubled_area(right, left, a.at);
  const std::int64_t from_b = -delaunay::doubled_area(right, left, b.at);
  const double along = static_cast<double>(to_right) / static_cast<double>(to_right + to_left);
  const double z = tin_.heights[meeting.right];
  return {z + (tin_.heights[meeting.left] - z) * along,
          static_cast<double>(from_a) / static_cast<double>(from_a + from_b)};
}

EdgeSplit PointSurface::place_of(const Place& a, const Place& b, const TinMeeting& meeting) const {
  const LatticePoint right = walker_.fine(meeting.right);
  if (meeting.is_vertex()) return {.error = 0, .place = {right, 0}, .is_exact = true};
  const LatticePoint left = walker_.fine(meeting.left);
  const std::int64_t part = -delaunay::doubled_area(a.at, b.at, right);
  const std::int64_t whole = part + delaunay::doubled_area(a.at, b.at, left);
  const LatticePoint at{between(right.x, left.x, part, whole),
                        between(right.y, left.y, part, whole)};
  return {.error = 0, .place = {at, 0}, .is_exact = delaunay::doubled_area(a.at, b.at, at) == 0};
}

EdgeSplit PointSurface::worst_crossing(Place a, Place b, Crossings crossings) const {
  if (std::tie(b.at.y, b.at.x) < std::tie(a.at.y, a.at.x)) std::swap(a, b);
  const std::int64_t length = squared_distance(a.at, b.at);
  EdgeSplit worst;
  std::uint32_t triangle = 0;
  walker_.walk(a.at, b.at, [&](const TinMeeting& meeting) {
    const Crossing at = read(a, b, meeting);
    const double error = std::abs(at.height - (a.height + (b.height - a.height) * at.share));
    if (error <= worst.error) return;
    const EdgeSplit split = place_of(a, b, meeting);
    if (!split.is_exact && crossings == Crossings::exact) return;
    if (squared_distance(a.at, split.place.at) >= length ||
        squared_distance(b.at, split.place.at) >= length)
      return;
    worst = {error, split.place, split.is_exact};
    triangle = meeting.triangle;
  });
  if (worst.error == 0) return worst;
  // A node just outside of the domain has the height of the plane that the crossing is in; no mesh
  // ever has it as a vertex.
  const std::uint32_t holding = walker_.triangle_at(worst.place.at);
  worst.place.height =
      height_in(holding == delaunay::kNoHalfEdge ? triangle : holding, worst.place.at);
  return worst;
}

SampleErrors PointSurface::measure_samples(const std::array<Place, 3>& corners,
                                           EdgeSet open) const {
  const std::array<LatticePoint, 3> at{corners[0].at, corners[1].at, corners[2].at};
  const std::int64_t area = delaunay::doubled_area(at[0], at[1], at[2]);
  const double inverse = 1 / static_cast<double>(area);
  const double to_b = corners[1].height - corners[0].height;
  const double to_c = corners[2].height - corners[0].height;
  SampleErrors made;
  std::uint32_t first = 0;
  tree_.visit_near(at, [&](std::uint32_t vertex, LatticePoint p) {
    const std::int64_t ab = delaunay::doubled_area(at[0], at[1], p);
    const std::int64_t ca = delaunay::doubled_area(at[2], at[0], p);
    if (ab < 0 || ca < 0 || area - ab - ca < 0) return;
    const double rise = (static_cast<double>(ca) * to_b + static_cast<double>(ab) * to_c) * inverse;
    const double error = std::abs(tin_.heights[vertex] - (corners[0].height + rise));
    made.closed = std::max(made.closed, error);
    if (error < made.inner || error == 0 || (error == made.inner && vertex > first)) return;
    if (!SampleWeights{{ab, area - ab - ca, ca}}.may_be_inserted(open)) return;
    made.inner = error;
    made.at = p;
    first = vertex;
  });
  return made;
}

bool PointSurface::has_samples_beside(const std::array<LatticePoint, 3>& corners,
                                      std::int32_t reach) const {
  bool has_any = false;
  tree_.visit_near(
      corners,
      [&](std::uint32_t, LatticePoint p) {
        bool is_outside = false;
        bool is_near = true;
        for (std::size_t i = 0; i < 3; ++i) {
          const LatticePoint a = corners[i];
          const LatticePoint b = corners[(i + 1) % 3];
          const std::int64_t side = delaunay::doubled_area(a, b, p);
          // How far one may go to the right of an edge by `reach` in columns and rows.
          const std::int64_t most =
              reach * (std::abs(std::int64_t{b.x} - a.x) + std::abs(std::int64_t{b.y} - a.y));
          is_outside = is_outside || side < 0;
          is_near = is_near && side >= -most;
        }
        has_any = has_any || (is_outside && is_near);
      },
      reach);
  return has_any;
}

std::size_t PointSurface::count_samples(const std::array<LatticePoint, 3>& corners) const {
  std::size_t n = 0;
  tree_.visit_near(corners, [&](std::uint32_t, LatticePoint p) {
    n += static_cast<std::size_t>(delaunay::doubled_area(corners[0], corners[1], p) >= 0 &&
                                  delaunay::doubled_area(corners[1], corners[2], p) >= 0 &&
                                  delaunay::doubled_area(corners[2], corners[0], p) >= 0);
  });
  return n;
}

}  // namespace lode::triangle_hierarchy

#include "lode/locate/tin_profile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <tuple>
#include <utility>

#include "lode/delaunay/lattice_side.h"
#include "lode/locate/tin_height.h"

namespace lode {
namespace {

using delaunay::LatticePoint;
using delaunay::Point;
using delaunay::Tin;

/// What the segment meets: an edge by its ends, the smaller first, a vertex as an edge from it to
/// itself, or an end of the segment. The same whichever triangle it is seen from.
using Event = std::array<std::uint32_t, 2>;
constexpr Event kStart{UINT32_MAX, 0};
constexpr Event kEnd{UINT32_MAX, 1};

/// What a closed triangle has of the segment; never a point alone.
struct TrianglePiece {
  Event begin, end;
  std::uint32_t triangle;
};

bool is_end(const Event& event) { return event[0] == UINT32_MAX; }

/// The segment, and what is exactly known of places beside it.
class Segment {
 public:
  Segment(const Tin& tin, const Point& a, const Point& b) : tin_(tin), a_(a), b_(b) {}

  [[nodiscard]] std::optional<TrianglePiece> piece_in(std::uint32_t triangle) const {
    const auto& corner = tin_.triangles[triangle];
    std::array<Point, 3> at;
    for (std::size_t i = 0; i < 3; ++i) at[i] = delaunay::to_point(tin_.vertices[corner[i]]);
    if (is_beside(at)) return std::nullopt;
    std::array<int, 3> side{};
    for (std::size_t i = 0; i < 3; ++i) side[i] = delaunay::side_of(a_, b_, at[i]);
    TrianglePiece piece{kStart, kEnd, triangle};
    int n_met = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      const int after = side[j];
      const int before = side[(i + 2) % 3];
      // The line of the segment comes in where the boundary, turning left, goes from its left to
      // its right, and leaves where it goes back.
      if (side[i] * after < 0) {
        const bool is_entry = side[i] > 0;
        if (!clip(piece, is_entry, {std::minmax(corner[i], corner[j])}, side_pair(at[i], at[j])))
          return std::nullopt;
        ++n_met;
      } else if (side[i] == 0 && (before != after)) {
        const bool is_entry = before > after;
        if (!clip(piece, is_entry, {std::pair(corner[i], corner[i])}, along_pair(at[i])))
          return std::nullopt;
        ++n_met;
      }
    }
    if (n_met < 2) return std::nullopt;
    return piece;
  }

  [[nodiscard]] double t_of(const Event& event) const {
    if (event == kStart) return 0;
    if (event == kEnd) return 1;
    const Point u = delaunay::to_point(tin_.vertices[event[0]]);
    if (event[0] == event[1]) {
      const std::size_t axis = std::abs(b_[0] - a_[0]) < std::abs(b_[1] - a_[1]) ? 1 : 0;
      return std::clamp((u[axis] - a_[axis]) / (b_[axis] - a_[axis]), 0.0, 1.0);
    }
    const Point v = delaunay::to_point(tin_.vertices[event[1]]);
    const auto area = [&](const Point& p) {
      return (u[0] - p[0]) * (v[1] - p[1]) - (u[1] - p[1]) * (v[0] - p[0]);
    };
    const double from = std::abs(area(a_));
    const double whole = from + std::abs(area(b_));
    return whole > 0 ? from / whole : 0;
  }
  [[nodiscard]] Point place_of(const Event& event, double t) const {
    if (event == kStart) return a_;
    if (event == kEnd) return b_;
    if (event[0] == event[1]) return delaunay::to_point(tin_.vertices[event[0]]);
    return {{a_[0] + t * (b_[0] - a_[0]), a_[1] + t * (b_[1] - a_[1])}};
  }

 private:
  /// On which side of what is met the ends lie: 1 inside of the triangle, 0 there.
  struct Sides {
    int of_start, of_end;
  };

  [[nodiscard]] bool is_beside(const std::array<Point, 3>& at) const {
    for (std::size_t i = 0; i < 2; ++i) {
      const auto [low, high] = std::minmax({at[0][i], at[1][i], at[2][i]});
      if (std::max(a_[i], b_[i]) < low || std::min(a_[i], b_[i]) > high) return true;
    }
    return false;
  }
  [[nodiscard]] Sides side_pair(const Point& from, const Point& to) const {
    return {delaunay::side_of(from, to, a_), delaunay::side_of(from, to, b_)};
  }
  /// Of a vertex on the line, as if all beyond it were inside; clip() turns it for exits.
  [[nodiscard]] Sides along_pair(const Point& v) const {
    const std::size_t axis = a_[0] == b_[0] ? 1 : 0;
    const bool is_up = b_[axis] > a_[axis];
    const auto compare = [&](double x) {
      const int sign = (x > v[axis]) - (x < v[axis]);
      return is_up ? sign : -sign;
    };
    return {compare(a_[axis]), compare(b_[axis])};
  }
  /// False where nothing longer than a point is left.
  static bool clip(TrianglePiece& piece, bool is_entry,
                   std::pair<std::uint32_t, std::uint32_t> ends, Sides sides) {
    const Event event{ends.first, ends.second};
    // For exits at vertices along_pair() counts what is beyond as inside.
    if (!is_entry && ends.first == ends.second) sides = {-sides.of_start, -sides.of_end};
    if (is_entry) {
      if (sides.of_end <= 0) return false;
      if (sides.of_start < 0) piece.begin = event;
    } else {
      if (sides.of_start <= 0) return false;
      if (sides.of_end < 0) piece.end = event;
    }
    return true;
  }

  const Tin& tin_;
  Point a_;
  Point b_;
};

std::vector<TrianglePiece> find_pieces(const Tin& tin, const Segment& segment) {
  std::vector<TrianglePiece> pieces;
  for (std::uint32_t t = 0; t < tin.triangles.size(); ++t)
    if (const auto piece = segment.piece_in(t)) pieces.push_back(*piece);
  // Of two in one edge that with the smaller error is first, and stays.
  const auto key = [&](const TrianglePiece& p) {
    return std::tuple(p.begin, p.end, tin.errors[p.triangle], p.triangle);
  };
  std::ranges::sort(pieces, {}, key);
  const auto is_same = [](const TrianglePiece& p, const TrianglePiece& q) {
    return p.begin == q.begin && p.end == q.end;
  };
  pieces.erase(std::unique(pieces.begin(), pieces.end(), is_same), pieces.end());
  return pieces;
}

/// The first pieces of parts: where none ends. In the order of the segment.
std::vector<const TrianglePiece*> find_starts(const std::vector<TrianglePiece>& pieces,
                                              const Segment& segment) {
  std::vector<Event> ends;
  ends.reserve(pieces.size());
  for (const TrianglePiece& piece : pieces) ends.push_back(piece.end);
  std::ranges::sort(ends);
  std::vector<std::pair<double, const TrianglePiece*>> starts;
  for (const TrianglePiece& piece : pieces)
    if (!std::ranges::binary_search(ends, piece.begin))
      starts.emplace_back(segment.t_of(piece.begin), &piece);
  // Equal but for rounding are only parts that are no longer than that.
  std::ranges::stable_sort(starts, {}, &std::pair<double, const TrianglePiece*>::first);
  std::vector<const TrianglePiece*> sorted;
  sorted.reserve(starts.size());
  for (const auto& [t, piece] : starts) sorted.push_back(piece);
  return sorted;
}

}  // namespace

std::vector<ProfilePoint> tin_profile(const Tin& tin, const Point& a, const Point& b) {
  const Segment segment(tin, a, b);
  const std::vector<TrianglePiece> pieces = find_pieces(tin, segment);
  std::vector<ProfilePoint> points;
  double last = 0;
  const auto add = [&](const Event& event, std::uint32_t triangle) -> ProfilePoint& {
    // Rounding does not turn the order round.
    const double t = last = std::max(last, segment.t_of(event));
    const Point at = segment.place_of(event, t);
    const TinHeight z = height_in(tin, triangle, at);
    return points.emplace_back(ProfilePoint{t, at, z.height, z.rounding});
  };
  for (const TrianglePiece* piece : find_starts(pieces, segment)) {
    add(piece->begin, piece->triangle).starts_part = true;
    for (;;) {
      points.back().error = tin.errors[piece->triangle];
      add(piece->end, piece->triangle);
      const auto next = std::ranges::lower_bound(pieces, piece->end, {}, &TrianglePiece::begin);
      if (is_end(piece->end) || next == pieces.end() || next->begin != piece->end) break;
      piece = &*next;
    }
  }
  return points;
}

}  // namespace lode

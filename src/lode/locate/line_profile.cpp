#include "lode/locate/line_profile.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "lode/delaunay/predicates.h"

namespace lode {
namespace {

constexpr double kRounding = 32 * 0x1p-52;

/// Where a line crosses the plane of a face, from doubles: the same for both cells of the face.
struct Crossing {
  double t = 0;
  double rounding = 0;
};

Crossing crossing_of(std::array<Vec3d, 3> face, const Vec3d& a, const Vec3d& b) {
  std::ranges::sort(face);
  const Vec3d u = face[1] - face[0];
  const Vec3d v = face[2] - face[0];
  const Vec3d normal = cross(u, v);
  const double from = dot(normal, a - face[0]);
  const double to = dot(normal, b - face[0]);
  const double size = length(u) * length(v) * (length(a - face[0]) + length(b - face[0]));
  const double whole = std::abs(from) + std::abs(to);
  const double rounding = kRounding * size / whole;
  if (!(rounding < 1)) return {0.5, 1};
  return {std::abs(from) / whole, rounding};
}

/// What the half-space at a face leaves of the line.
class Piece {
 public:
  explicit Piece(std::uint32_t cell) { made_.cell = cell, made_.end = 1; }

  /// `from`, `to`: the sides of a and b, 1 inside. False where nothing is left.
  bool cut(int from, int to, const std::array<Vec3d, 3>& face, const Vec3d& a, const Vec3d& b) {
    if (from < 0 && to < 0) return false;
    if (from >= 0 && to >= 0) return true;
    Crossing at{from < 0 ? 1.0 : 0.0, 0};
    if (from != 0 && to != 0) at = crossing_of(face, a, b);
    if (from < 0 && at.t >= made_.begin) {
      made_.begin = at.t;
      made_.begin_rounding = at.rounding;
    } else if (to < 0 && at.t <= made_.end) {
      made_.end = at.t;
      made_.end_rounding = at.rounding;
    }
    return made_.begin < made_.end;
  }
  [[nodiscard]] const LinePiece& made() const { return made_; }

 private:
  LinePiece made_;
};

std::optional<LinePiece> piece_in(const CellLocator& locator, std::uint32_t cell, const Vec3d& a,
                                  const Vec3d& b) {
  const std::array<Vec3d, 4> c = locator.corners_of(cell);
  const int side = delaunay::orientation(c[0], c[1], c[2], c[3]);
  if (side == 0) return std::nullopt;
  Piece piece(cell);
  for (std::size_t k = 0; k < 4; ++k) {
    auto from = c;
    auto to = c;
    from[k] = a;
    to[k] = b;
    const std::array<Vec3d, 3> face{c[(k + 1) % 4], c[(k + 2) % 4], c[(k + 3) % 4]};
    if (!piece.cut(side * delaunay::orientation(from[0], from[1], from[2], from[3]),
                   side * delaunay::orientation(to[0], to[1], to[2], to[3]), face, a, b))
      return std::nullopt;
  }
  return piece.made();
}

/// Of pieces by where they begin those that go farthest, each from where the last one ends.
std::vector<LinePiece> in_a_row(std::span<const LinePiece> pieces,
                                std::span<const std::uint8_t> preferred) {
  const auto rank = [&](const LinePiece& p) {
    return std::tuple(!preferred.empty() && preferred[p.cell] != 0, p.end);
  };
  std::vector<LinePiece> row;
  double at = 0;
  double rounding = 0;
  bool is_outside = true;
  for (std::size_t next = 0; next < pieces.size();) {
    const auto is_behind = [&](const LinePiece& p) {
      return p.end <= at + rounding + p.end_rounding;
    };
    if (is_behind(pieces[next])) {
      ++next;
      continue;
    }
    const LinePiece* best = nullptr;
    for (std::size_t i = next; i < pieces.size(); ++i) {
      const LinePiece& p = pieces[i];
      if (p.begin > at + rounding + p.begin_rounding) break;
      if (!is_behind(p) && (best == nullptr || rank(p) > rank(*best))) best = &p;
    }
    if (best == nullptr || is_outside) {
      const LinePiece& first = best == nullptr ? pieces[next] : *best;
      at = first.begin;
      rounding = first.begin_rounding;
      is_outside = true;
      if (best == nullptr) continue;
    }
    row.push_back({best->cell, at, best->end, rounding, best->end_rounding, is_outside});
    at = best->end;
    rounding = best->end_rounding;
    is_outside = false;
  }
  return row;
}

}  // namespace

bool meets_line(const Box3d& box, const Vec3d& a, const Vec3d& b) {
  double begin = 0;
  double end = 1;
  for (std::size_t i = 0; i < 3; ++i) {
    const double way = b[i] - a[i];
    const double slack = 0x1p-48 * (std::abs(a[i]) + std::abs(b[i]) + std::abs(box.lower[i]) +
                                    std::abs(box.upper[i]));
    const double low = box.lower[i] - slack - a[i];
    const double high = box.upper[i] + slack - a[i];
    if (way == 0) {
      if (low > 0 || high < 0) return false;
      continue;
    }
    begin = std::max(begin, std::min(low / way, high / way));
    end = std::min(end, std::max(low / way, high / way));
  }
  return begin <= end + 0x1p-40;
}

std::vector<LinePiece> line_profile(const CellLocator& locator, const Vec3d& a, const Vec3d& b,
                                    std::span<const std::uint8_t> preferred) {
  std::vector<LinePiece> pieces;
  locator.visit_where([&](const Box3d& box) { return meets_line(box, a, b); },
                      [&](std::uint32_t cell) {
                        if (const auto piece = piece_in(locator, cell, a, b))
                          pieces.push_back(*piece);
                      });
  std::ranges::sort(pieces, {}, [](const LinePiece& p) { return std::tuple(p.begin, p.cell); });
  return in_a_row(pieces, preferred);
}

}  // namespace lode

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "lode/mappers/collapse_pieces.h"
#include "lode/mappers/shadow_cover.h"

namespace lode::simplification {

inline constexpr double kCellRadius = 0.4;   ///< Of cells, at most, in units of the limit.
inline constexpr std::size_t kMaxCells = 8;  ///< Along an edge.

/// The cells of a triangle in its plane.
class Cells {
 public:
  /// Coordinates will be relative to `lower`.
  void place(const Piece& t, const Vec3d& lower, std::size_t n) {
    const Vec3d u = normalized(t[1] - t[0]);
    const Vec3d w = normalized(cross(u, t[2] - t[0]));
    const Vec3d v = cross(w, u);
    u_ = narrowed(u);
    v_ = narrowed(v);
    w_ = narrowed(w);
    base_ = narrowed(t[0] - lower);
    n_ = n;
    count_ = n * n;
    const auto h = static_cast<float>(1 / static_cast<double>(n));
    const float bx = h * static_cast<float>(length(t[1] - t[0]));
    const float cx = h * static_cast<float>(dot(t[2] - t[0], u));
    const float cy = h * static_cast<float>(dot(t[2] - t[0], v));
    std::size_t cell = 0;
    for (std::size_t row = 0; row < n; ++row)
      for (std::size_t at = 0; at <= 2 * row; ++at, ++cell) {
        // Thirds of the way from t[0]: of an upright cell's corners, or of one upside down.
        const std::size_t column = at / 2;
        const auto c = static_cast<float>(column) + (at % 2 == 0 ? 1.0F : 2.0F) / 3.0F;
        const auto r = static_cast<float>(row) + (at % 2 == 0 ? 2.0F : 1.0F) / 3.0F;
        const float b = r - c;
        x_[cell] = b * bx + c * cx;
        y_[cell] = c * cy;
        is_marked_[cell] = 0;
      }
    radius_ = 1.001F * static_cast<float>(radius_of(cell_of(t, 0, n)));
  }
  /// To be called after place() for what asks where cells are.
  void place_points(const Piece& t, const Vec3d& lower) {
    n_points_ = 0;
    for (std::size_t r = 0; r <= n_; ++r)
      for (std::size_t c = 0; c <= r; ++c, ++n_points_) {
        const double s = static_cast<double>(r - c) / static_cast<double>(n_);
        const double u = static_cast<double>(c) / static_cast<double>(n_);
        const Vec3d p = (t[0] - lower) + (t[1] - t[0]) * s + (t[2] - t[0]) * u;
        for (std::size_t i = 0; i < 3; ++i) points_[i][n_points_] = static_cast<float>(p[i]);
        is_near_any_[n_points_] = 0;
        is_wanted_[n_points_] = 0;
      }
  }
  /// Those that shadows on the plane of t cover.
  void mark(const ShadowCover& shadows, const Piece& t) {
    static_assert(kMaxCells * kMaxCells <= ShadowCover::kMostCells);
    shadows.mark_covered(t, n_, static_cast<double>(radius_), is_marked_);
  }
  void mark(const Vec3f& point, float limit2) {
    const Vec3f q = point - base_;
    const float height = dot(q, w_);
    const float disc = std::sqrt(std::max(0.0F, limit2 - height * height)) - radius_;
    if (!(disc > 0)) return;
    const float px = dot(q, u_);
    const float py = dot(q, v_);
    const float disc2 = disc * disc;
    for (std::size_t i = 0; i < count_; ++i) {
      const float x = x_[i] - px;
      const float y = y_[i] - py;
      is_marked_[i] |= static_cast<std::int32_t>(x * x + y * y <= disc2);
    }
  }
  /// Whether a triangle within this box, widened by the limit, could be near all corners of a cell
  /// that is not marked, or the first to be near one of them; after want_unmarked().
  [[nodiscard]] bool may_use(const Vec3f& low, const Vec3f& high) const {
    std::array<std::int32_t, kMaxPoints> is_in;
    std::int32_t is_first = 0;
    for (std::size_t i = 0; i < n_points_; ++i) {
      const float x = points_[0][i];
      const float y = points_[1][i];
      const float z = points_[2][i];
      is_in[i] = static_cast<std::int32_t>(x >= low[0]) & static_cast<std::int32_t>(x <= high[0]) &
                 static_cast<std::int32_t>(y >= low[1]) & static_cast<std::int32_t>(y <= high[1]) &
                 static_cast<std::int32_t>(z >= low[2]) & static_cast<std::int32_t>(z <= high[2]);
      is_first |= is_in[i] & is_wanted_[i] & (is_near_any_[i] ^ 1);
    }
    if (is_first != 0) return true;
    std::int32_t has_cell = 0;
    for_each_cell([&](std::size_t cell, std::size_t a, std::size_t b, std::size_t c) {
      has_cell |= is_in[a] & is_in[b] & is_in[c] & (is_marked_[cell] ^ 1);
    });
    return has_cell != 0;
  }
  /// Those whose corners are all near one triangle.
  void mark(const std::array<Vec3f, 3>& target, float limit2) {
    std::array<std::int32_t, kMaxPoints> is_near;
    find_near(target, limit2, is_near);
    for (std::size_t i = 0; i < n_points_; ++i) is_near_any_[i] |= is_near[i];
    for_each_cell([&](std::size_t cell, std::size_t a, std::size_t b, std::size_t c) {
      is_marked_[cell] |= is_near[a] & is_near[b] & is_near[c];
    });
  }
  /// Triangles are to be near corners of cells that are not marked.
  void want_unmarked() {
    for_each_unmarked_corner([&](std::size_t point) { is_wanted_[point] = 1; });
  }
  /// That holds all cells that are not marked; after place_points().
  [[nodiscard]] std::pair<Vec3f, Vec3f> unmarked_box() const {
    constexpr float kFar = std::numeric_limits<float>::max();
    std::pair<Vec3f, Vec3f> box{{{kFar, kFar, kFar}}, {{-kFar, -kFar, -kFar}}};
    for_each_unmarked_corner([&](std::size_t point) {
      for (std::size_t i = 0; i < 3; ++i) {
        box.first[i] = std::min(box.first[i], points_[i][point]);
        box.second[i] = std::max(box.second[i], points_[i][point]);
      }
    });
    return box;
  }
  /// Whether a corner of an unmarked cell was near none of the triangles.
  [[nodiscard]] bool is_hopeless() const {
    bool is_far = false;
    for_each_unmarked_corner([&](std::size_t point) { is_far |= is_near_any_[point] == 0; });
    return is_far;
  }
  [[nodiscard]] bool are_all_marked() const {
    std::int32_t all = 1;
    for (std::size_t i = 0; i < count_; ++i) all &= is_marked_[i];
    return all != 0;
  }
  [[nodiscard]] bool is_marked(std::size_t cell) const { return is_marked_[cell] != 0; }

 private:
  static constexpr std::size_t kMaxPoints = (kMaxCells + 1) * (kMaxCells + 2) / 2;

  /// visit(cell, and its three points).
  template <typename Visit>
  void for_each_cell(const Visit& visit) const {
    std::size_t cell = 0;
    std::size_t above = 0;  // the first point of the row before
    for (std::size_t row = 0; row < n_; ++row) {
      const std::size_t below = above + row + 1;
      for (std::size_t c = 0; c <= row; ++c) {
        visit(cell++, above + c, below + c + 1, below + c);
        if (c < row) visit(cell++, above + c, below + c + 1, above + c + 1);
      }
      above = below;
    }
  }
  /// Some of them more than once.
  template <typename Visit>
  void for_each_unmarked_corner(const Visit& visit) const {
    for_each_cell([&](std::size_t cell, std::size_t a, std::size_t b, std::size_t c) {
      if (is_marked_[cell] != 0) return;
      visit(a);
      visit(b);
      visit(c);
    });
  }
  /// Which corners of cells are within the limit of a triangle. In doubles: beside a long sliver
  /// floats would take points beyond its ends for points over it.
  void find_near(const std::array<Vec3f, 3>& t, float limit2,
                 std::array<std::int32_t, kMaxPoints>& is_near) const {
    const Vec3d first = widened(t[0]);
    const Vec3d u = widened(t[1]) - first;
    const Vec3d v = widened(t[2]) - first;
    const Vec3d e = v - u;
    const Vec3d n = cross(u, v);
    const double uu = dot(u, u);
    const double uv = dot(u, v);
    const double vv = dot(v, v);
    const double ee = dot(e, e);
    const double nn = dot(n, n);
    // Of a sliver the edges are enough.
    const bool has_inside = nn > 1e-4 * uu * vv;
    const double tiny = std::numeric_limits<double>::min();
    const double over_uu = 1 / std::max(uu, tiny);
    const double over_vv = 1 / std::max(vv, tiny);
    const double over_ee = 1 / std::max(ee, tiny);
    const double over_nn = has_inside ? 1 / nn : 0;
    const double area = has_inside ? nn : -1;
    for (std::size_t i = 0; i < n_points_; ++i) {
      const double x = static_cast<double>(points_[0][i]) - first[0];
      const double y = static_cast<double>(points_[1][i]) - first[1];
      const double z = static_cast<double>(points_[2][i]) - first[2];
      const double qu = x * u[0] + y * u[1] + z * u[2];
      const double qv = x * v[0] + y * v[1] + z * v[2];
      const double qn = x * n[0] + y * n[1] + z * n[2];
      const double s = vv * qu - uv * qv;
      const double r = uu * qv - uv * qu;
      const auto to_line = [&](const Vec3d& d, double along, double px, double py, double pz) {
        const double clamped = std::min(std::max(along, 0.0), 1.0);
        const double dx = px - clamped * d[0];
        const double dy = py - clamped * d[1];
        const double dz = pz - clamped * d[2];
        return dx * dx + dy * dy + dz * dz;
      };
      const double along = (qv - qu - uv + uu) * over_ee;  // (q - u) . e
      const double edges =
          std::min(std::min(to_line(u, qu * over_uu, x, y, z), to_line(v, qv * over_vv, x, y, z)),
                   to_line(e, along, x - u[0], y - u[1], z - u[2]));
      const bool is_inside = (s >= 0) & (r >= 0) & (s + r <= area);
      const double distance2 = is_inside ? qn * qn * over_nn : edges;
      is_near[i] = static_cast<std::int32_t>(distance2 <= static_cast<double>(limit2));
    }
  }
  static Vec3f narrowed(const Vec3d& p) {
    return {{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}};
  }

  Vec3f u_, v_, w_, base_;
  std::size_t n_ = 0;
  std::size_t n_points_ = 0;
  std::array<std::int32_t, kMaxPoints> is_near_any_{};
  std::array<std::int32_t, kMaxPoints>
      is_wanted_{};  ///< Corners of cells to be marked by triangles.
  std::array<std::array<float, kMaxPoints>, 3> points_{};  ///< Corners of cells, row by row.
  std::size_t count_ = 0;
  float radius_ = 0;
  std::array<float, kMaxCells * kMaxCells> x_{};
  std::array<float, kMaxCells * kMaxCells> y_{};
  std::array<std::int32_t, kMaxCells * kMaxCells> is_marked_{};
};

}  // namespace lode::simplification

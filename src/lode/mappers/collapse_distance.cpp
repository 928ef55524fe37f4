#include "lode/mappers/collapse_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "lode/mappers/point_triangle.h"

namespace lode::simplification {
namespace {

using Piece = std::array<Vec3d, 3>;

constexpr double kUnproven = std::numeric_limits<double>::infinity();
// Corners are floats, and differences, midpoints and squared distances are found in doubles: with
// coordinates up to 2^24 of the limit this covers their rounding many times over.
constexpr double kRounding = 1e-6;

Piece widened_corners(const std::array<Vec3f, 3>& t) {
  return {widened(t[0]), widened(t[1]), widened(t[2])};
}

std::array<Piece, 4> quarters(const Piece& p) {
  const Vec3d a = (p[1] + p[2]) * 0.5;
  const Vec3d b = (p[2] + p[0]) * 0.5;
  const Vec3d c = (p[0] + p[1]) * 0.5;
  return {Piece{p[0], c, b}, Piece{c, p[1], a}, Piece{b, a, p[2]}, Piece{a, b, c}};
}

/// The largest squared distance of the corners from a target; stops where it exceeds `enough`.
template <typename SquaredDistance>
double farthest_corner(const Piece& piece, double enough, const SquaredDistance& squared_distance) {
  double largest = 0;
  for (const Vec3d& corner : piece) {
    largest = std::max(largest, squared_distance(corner));
    if (largest > enough) break;
  }
  return largest;
}

/// The least, over targets, of the distance that no point of the piece exceeds; squared.
double nearest_target(const Piece& piece, std::span<const Piece> targets, double limit2) {
  double least = kUnproven;
  for (const Piece& target : targets) {
    const double here = farthest_corner(piece, std::min(least, limit2), [&](const Vec3d& corner) {
      return squared_distance_to_triangle(corner, target);
    });
    least = std::min(least, here);
  }
  return least;
}

/// Squared bound for a piece that is cut until targets are near enough; infinite if none is.
double bound_pieces(const Piece& piece, std::span<const Piece> targets, double limit2, int depth) {
  const double whole = nearest_target(piece, targets, limit2);
  if (whole <= limit2 || depth == 0) return whole <= limit2 ? whole : kUnproven;
  double largest = 0;
  for (const Piece& part : quarters(piece)) {
    largest = std::max(largest, bound_pieces(part, targets, limit2, depth - 1));
    if (largest > limit2) return kUnproven;
  }
  return largest;
}

double radius_of(const Piece& piece) {
  const Vec3d middle = (piece[0] + piece[1] + piece[2]) * (1.0 / 3);
  double radius2 = 0;
  for (const Vec3d& corner : piece)
    radius2 = std::max(radius2, dot(corner - middle, corner - middle));
  return std::sqrt(radius2);
}

/// Of the n * n congruent cells of a triangle, row by row from its first corner.
Piece cell_of(const Piece& t, std::size_t cell, std::size_t n) {
  std::size_t row = 0;
  while ((row + 1) * (row + 1) <= cell) ++row;
  const std::size_t at = cell - row * row;  // of 2 row + 1, every second one upside down
  const auto point = [&](std::size_t r, std::size_t c) {
    const double s = static_cast<double>(r - c) / static_cast<double>(n);
    const double u = static_cast<double>(c) / static_cast<double>(n);
    return t[0] + (t[1] - t[0]) * s + (t[2] - t[0]) * u;
  };
  const std::size_t c = at / 2;
  if (at % 2 == 0) return {point(row, c), point(row + 1, c), point(row + 1, c + 1)};
  return {point(row, c), point(row + 1, c + 1), point(row, c + 1)};
}

constexpr double kCellRadius = 0.3;   ///< Of cells, at most, in units of the limit.
constexpr std::size_t kMaxCells = 8;  ///< Along an edge.

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
  /// To be called after place() where cells are marked by triangles.
  void place_points(const Piece& t, const Vec3d& lower) {
    n_points_ = 0;
    for (std::size_t r = 0; r <= n_; ++r)
      for (std::size_t c = 0; c <= r; ++c, ++n_points_) {
        const double s = static_cast<double>(r - c) / static_cast<double>(n_);
        const double u = static_cast<double>(c) / static_cast<double>(n_);
        const Vec3d p = (t[0] - lower) + (t[1] - t[0]) * s + (t[2] - t[0]) * u;
        for (std::size_t i = 0; i < 3; ++i) points_[i][n_points_] = static_cast<float>(p[i]);
        is_near_any_[n_points_] = 0;
      }
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
  /// Those whose corners are all near one triangle.
  void mark(const std::array<Vec3f, 3>& target, float limit2) {
    std::array<std::int32_t, kMaxPoints> is_near;
    find_near(target, limit2, is_near);
    for (std::size_t i = 0; i < n_points_; ++i) is_near_any_[i] |= is_near[i];
    std::size_t cell = 0;
    std::size_t above = 0;  // the first point of the row before
    for (std::size_t row = 0; row < n_; ++row) {
      const std::size_t below = above + row + 1;
      for (std::size_t c = 0; c <= row; ++c) {
        const std::int32_t middle = is_near[above + c] & is_near[below + c + 1];
        is_marked_[cell++] |= middle & is_near[below + c];
        if (c < row) is_marked_[cell++] |= middle & is_near[above + c + 1];
      }
      above = below;
    }
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

  /// Some of them more than once.
  template <typename Visit>
  void for_each_unmarked_corner(const Visit& visit) const {
    std::size_t cell = 0;
    std::size_t above = 0;
    for (std::size_t row = 0; row < n_; ++row) {
      const std::size_t below = above + row + 1;
      for (std::size_t at = 0; at <= 2 * row; ++at, ++cell) {
        if (is_marked_[cell] != 0) continue;
        const std::size_t c = at / 2;
        visit(above + c);
        visit(below + c + 1);
        visit(at % 2 == 0 ? below + c : above + c + 1);
      }
      above = below;
    }
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
  std::array<std::array<float, kMaxPoints>, 3> points_{};  ///< Corners of cells, row by row.
  std::size_t count_ = 0;
  float radius_ = 0;
  std::array<float, kMaxCells * kMaxCells> x_{};
  std::array<float, kMaxCells * kMaxCells> y_{};
  std::array<std::int32_t, kMaxCells * kMaxCells> is_marked_{};
};

/// Pieces of a new triangle against original vertices near it, in floats with a margin, and where
/// these are too far apart against original triangles round them.
class Cover {
 public:
  Cover(const Surface& original, const Surroundings& around, double limit, float longest_edge)
      : original_(original),
        around_(around),
        limit_(static_cast<float>(limit)),
        longest_edge_(longest_edge) {}

  /// Empties it, for another triangle.
  void begin(const Piece& triangle) {
    clear();
    lower_ = upper_ = triangle[0];
    for (const Vec3d& corner : triangle)
      for (std::size_t i = 0; i < 3; ++i) {
        lower_[i] = std::min(lower_[i], corner[i]);
        upper_[i] = std::max(upper_[i], corner[i]);
      }
    const double reach = 1.01 * static_cast<double>(limit_);
    for (std::size_t i = 0; i < 3; ++i) {
      lower_[i] -= reach;
      upper_[i] += reach;
    }
  }
  /// What is too far away to be of use is left out; where triangles come in too, less is.
  void add(std::uint32_t vertex) {
    const Vec3f& p = original_.positions[vertex];
    if (around_.first.empty())
      for (std::size_t i = 0; i < 3; ++i)
        if (p[i] < lower_[i] || p[i] > upper_[i]) return;
    push(vertex, local_position(p));
  }
  /// Or gives up: what takes too long counts as not covered.
  [[nodiscard]] bool covers(const Piece& triangle) {
    n_tests_ = 0;
    for (std::size_t i = 0; i < 3; ++i)
      if (upper_[i] - lower_[i] > 2000 * static_cast<double>(limit_)) return false;
    constexpr int kDepth = 10;
    return covers_part(triangle, 0, vertices_.size(), kDepth);
  }

 private:
  void clear() {
    vertices_.clear();
    for (auto& axis : local_) axis.clear();
  }
  [[nodiscard]] Vec3f local_position(const Vec3f& p) const {
    return {{static_cast<float>(p[0] - lower_[0]), static_cast<float>(p[1] - lower_[1]),
             static_cast<float>(p[2] - lower_[2])}};
  }
  void push(std::uint32_t vertex, const Vec3f& at) {
    vertices_.push_back(vertex);
    for (std::size_t i = 0; i < 3; ++i) local_[i].push_back(at[i]);
  }

  /// Squared distances of vertices [begin, end) from a point.
  void find_distances(const Vec3d& point, std::size_t begin, std::size_t end) {
    if (distances_.size() < end) distances_.resize(2 * end);
    const Vec3d at = point - lower_;
    const auto px = static_cast<float>(at[0]);
    const auto py = static_cast<float>(at[1]);
    const auto pz = static_cast<float>(at[2]);
    const float* const xs = local_[0].data();
    const float* const ys = local_[1].data();
    const float* const zs = local_[2].data();
    float* const distances = distances_.data();
    for (std::size_t i = begin; i < end; ++i) {
      const float x = xs[i] - px;
      const float y = ys[i] - py;
      const float z = zs[i] - pz;
      distances[i] = x * x + y * y + z * z;
    }
  }

  /// Vertices [begin, end) of the lists are those that may be near the piece.
  bool covers_part(const Piece& piece, std::size_t begin, std::size_t end, int depth) {
    if (begin == end || depth == 0 || n_tests_ > kMostTests) return false;
    const double cells = std::ceil(radius_of(piece) / (kCellRadius * limit_));
    if (cells > kMaxCells) return covers_quarters(piece, begin, end, depth);
    const auto n = static_cast<std::size_t>(cells);
    cells_.place(piece, lower_, n);
    // Coordinates are below 2000 limits (more fail), so the rounding of floats is below a
    // thousandth of it, by which the limit is made smaller.
    const float limit2 = limit_ * limit_ * 0.996F;
    for (std::size_t i = begin; i < end; ++i) {
      cells_.mark(Vec3f{{local_[0][i], local_[1][i], local_[2][i]}}, limit2);
      ++n_tests_;
      constexpr std::size_t kOften = 8;
      if (i % kOften == 0 && cells_.are_all_marked()) return true;
    }
    if (cells_.are_all_marked()) return true;
    if (!around_.first.empty()) {
      mark_by_triangles(piece, begin, end, limit2);
      if (cells_.is_hopeless()) return false;
    }
    const int deeper = std::min(depth, around_.first.empty() ? 2 : 4);
    const Cells marked = cells_;
    for (std::size_t cell = 0; cell < n * n; ++cell)
      if (!marked.is_marked(cell) && !covers_quarters(cell_of(piece, cell, n), begin, end, deeper))
        return false;
    return true;
  }

  /// By triangles near what is not marked yet.
  void mark_by_triangles(const Piece& piece, std::size_t begin, std::size_t end, float limit2) {
    cells_.place_points(piece, lower_);
    const std::pair<Vec3f, Vec3f> box = cells_.unmarked_box();
    const auto is_near = [&](const Vec3f& low, const Vec3f& high, float reach) {
      for (std::size_t i = 0; i < 3; ++i)
        if (low[i] > box.second[i] + reach || high[i] < box.first[i] - reach) return false;
      return true;
    };
    near_.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3f p{{local_[0][i], local_[1][i], local_[2][i]}};
      if (!is_near(p, p, limit_ + longest_edge_)) continue;
      const auto some = around_.of(vertices_[i]);
      near_.insert(near_.end(), some.begin(), some.end());
    }
    sort_unique(near_);
    for (const std::uint32_t t : near_) {
      std::array<Vec3f, 3> target;
      for (std::size_t k = 0; k < 3; ++k)
        target[k] = local_position(original_.positions[original_.triangles[t][k]]);
      Vec3f low = target[0];
      Vec3f high = target[0];
      for (std::size_t i = 0; i < 3; ++i) {
        low[i] = std::min({target[0][i], target[1][i], target[2][i]});
        high[i] = std::max({target[0][i], target[1][i], target[2][i]});
      }
      // Of a sliver floats know the direction to 6e-6, which along 100 limits is a thousandth.
      const bool is_small =
          std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]}) < 100 * limit_;
      if (is_small && is_near(low, high, limit_)) {
        cells_.mark(target, limit2);
        n_tests_ += kCorners;
      }
    }
  }

  /// Vertices that are too far away left out.
  bool covers_quarters(const Piece& piece, std::size_t begin, std::size_t end, int depth) {
    find_distances((piece[0] + piece[1] + piece[2]) * (1.0 / 3), begin, end);
    const float slack = around_.first.empty() ? 0 : longest_edge_;
    const float reach = 1.01F * (limit_ + static_cast<float>(radius_of(piece))) + slack;
    const std::size_t n = vertices_.size();
    for (std::size_t i = begin; i < end; ++i)
      if (distances_[i] <= reach * reach)
        push(vertices_[i], {{local_[0][i], local_[1][i], local_[2][i]}});
    bool covers = true;
    const std::size_t n_near = vertices_.size();
    for (const Piece& part : quarters(piece))
      covers = covers && covers_part(part, n, n_near, depth - 1);
    vertices_.resize(n);
    for (auto& axis : local_) axis.resize(n);
    return covers;
  }

  /// Cells against a vertex; their corners against a triangle take as long as a few of these. Most
  /// triangles take some hundred.
  static constexpr std::size_t kMostTests = 20'000;
  static constexpr std::size_t kCorners = 4;

  const Surface& original_;
  Surroundings around_;
  std::size_t n_tests_ = 0;
  float limit_;
  float longest_edge_;  ///< About, of original triangles.
  Vec3d lower_;
  Vec3d upper_;
  std::vector<std::uint32_t> vertices_;  ///< Those to look at, then those of pieces being cut.
  std::array<std::vector<float>, 3> local_;
  std::vector<float> distances_;
  Cells cells_;
  std::vector<std::uint32_t> near_;
};

/// bound(triangle, worker), squared, of each in parallel.
template <typename Bound>
DistanceReport collect(std::span<const std::uint32_t> triangles, double limit, Threads threads,
                       const Progress& progress, const Bound& bound) {
  constexpr std::size_t kChunk = 2048;
  std::vector<DistanceReport> parts((triangles.size() + kChunk - 1) / kChunk);
  parallel_for(parts.size(), threads, 1, [&](std::size_t chunk, int worker) {
    DistanceReport& part = parts[chunk];
    for (const std::uint32_t t :
         triangles.subspan(chunk * kChunk, std::min(kChunk, triangles.size() - chunk * kChunk))) {
      if (progress.is_cancelled()) return;
      const double here = std::sqrt(bound(t, worker)) * (1 + kRounding);
      if (here <= limit)
        part.proven = std::max(part.proven, here);
      else
        part.failing.push_back(t);
    }
  });
  DistanceReport report;
  for (const DistanceReport& part : parts) {
    report.proven = std::max(report.proven, part.proven);
    report.failing.insert(report.failing.end(), part.failing.begin(), part.failing.end());
  }
  return report;
}

}  // namespace

DistanceProof::Corners DistanceProof::original_corners(std::uint32_t triangle) const {
  const auto& v = original_.triangles[triangle];
  return {widened(original_.positions[v[0]]), widened(original_.positions[v[1]]),
          widened(original_.positions[v[2]])};
}

double DistanceProof::bound_from(std::uint32_t triangle) const {
  const Piece piece = original_corners(triangle);
  const double limit = limit_ * (1 - 2 * kRounding);
  const double limit2 = limit * limit;
  std::array<std::uint32_t, 3> at{kNone, kNone, kNone};
  std::array<Piece, 3> near;
  std::size_t n = 0;
  for (const std::uint32_t corner : original_.triangles[triangle]) {
    const std::uint32_t t = mesh_.attached_to[corner];
    if (t == at[0] || t == at[1]) continue;
    at[n] = t;
    near[n] = widened_corners(corners(mesh_, t));
    const double here = nearest_target(piece, std::span(near).subspan(n, 1), limit2);
    if (here <= limit2) return here;
    ++n;
  }
  constexpr int kFewCuts = 2;
  if (n > 1) {
    const double pieces = bound_pieces(piece, std::span(near).first(n), limit2, kFewCuts);
    if (pieces <= limit2) return pieces;
  }
  std::vector<std::uint32_t> around;
  for (std::size_t i = 0; i < n; ++i)
    for (const std::uint32_t corner : mesh_.triangles[at[i]].v)
      stars_.for_each_around(corner, [&](std::uint32_t t) { around.push_back(t); });
  sort_unique(around);
  std::vector<Piece> targets;
  targets.reserve(around.size());
  for (const std::uint32_t t : around) targets.push_back(widened_corners(corners(mesh_, t)));
  constexpr int kManyCuts = 4;
  return bound_pieces(piece, targets, limit2, kManyCuts);
}

DistanceReport DistanceProof::from_original(std::span<const std::uint32_t> triangles,
                                            Threads threads) const {
  return collect(triangles, limit_, threads, progress_,
                 [this](std::uint32_t t, int) { return bound_from(t); });
}

/// Original vertices attached to the triangle or one that has a vertex with it.
template <typename Add>
void DistanceProof::for_each_near(std::uint32_t triangle, const Add& add) const {
  const auto& v = mesh_.triangles[triangle].v;
  const auto add_points = [&](std::uint32_t t) {
    for (std::uint32_t p = mesh_.triangles[t].points; p != kNone; p = mesh_.next_point[p]) add(p);
  };
  add_points(triangle);  // first, as they are likely to be enough
  stars_.for_each_around(v[0], [&](std::uint32_t t) {
    if (t != triangle) add_points(t);
  });
  stars_.for_each_around(v[1], [&](std::uint32_t t) {
    const auto& w = mesh_.triangles[t].v;
    if (w[0] != v[0] && w[1] != v[0] && w[2] != v[0]) add_points(t);
  });
  stars_.for_each_around(v[2], [&](std::uint32_t t) {
    const auto& w = mesh_.triangles[t].v;
    for (const std::uint32_t x : w)
      if (x == v[0] || x == v[1]) return;
    add_points(t);
  });
}

DistanceReport DistanceProof::cover(std::span<const std::uint32_t> triangles,
                                    const Surroundings& around, Threads threads) const {
  std::vector<Cover> covers(static_cast<std::size_t>(n_workers(threads)),
                            Cover(original_, around, limit_ * (1 - 2 * kRounding), longest_edge_));
  return collect(triangles, limit_, threads, progress_, [&](std::uint32_t t, int worker) {
    Cover& own = covers[static_cast<std::size_t>(worker)];
    const Piece triangle = widened_corners(corners(mesh_, t));
    own.begin(triangle);
    for_each_near(t, [&](std::uint32_t p) { own.add(p); });
    return own.covers(triangle) ? limit_ * limit_ * (1 - 4 * kRounding) : kUnproven;
  });
}

DistanceReport DistanceProof::to_original(std::span<const std::uint32_t> triangles,
                                          Threads threads) {
  DistanceReport report = cover(triangles, {}, threads);
  if (report.failing.empty()) return report;
  if (first_around_.empty()) find_triangles_around();
  DistanceReport again = cover(report.failing, {first_around_, around_}, threads);
  again.proven = std::max(again.proven, report.proven);
  return again;
}

void DistanceProof::find_triangles_around() {
  first_around_.assign(original_.positions.size() + 1, 0);
  for (const auto& t : original_.triangles)
    for (const std::uint32_t v : t) ++first_around_[v + 1];
  for (std::size_t v = 1; v < first_around_.size(); ++v) first_around_[v] += first_around_[v - 1];
  around_.resize(first_around_.back());
  std::vector<std::uint32_t> at(first_around_.begin(), first_around_.end() - 1);
  for (std::uint32_t t = 0; t < original_.triangles.size(); ++t)
    for (const std::uint32_t v : original_.triangles[t]) around_[at[v]++] = t;
}

}  // namespace lode::simplification

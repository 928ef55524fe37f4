// The dual simplex method on the linear program of four variables: of (x, t) with normal . x + t <=
// offset for all half-spaces the one of largest t. Where a step gains nothing, choices are those of
// Bland, New finite pivoting rules for the simplex method, 1977, so that none comes twice.
#include "lode/io/inner_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

namespace lode::io {
namespace {

constexpr std::size_t kN = 4;
constexpr int kMaxSteps = 1000;
constexpr double kTolerance = 1e-13;  // of numbers of a scale of 1, some roundings

using Row = std::array<double, kN>;
using Rows = std::array<Row, kN>;

/// Gauss with the largest pivots; none where the rows are dependent.
std::optional<Row> solve(Rows rows, Row right) {
  for (std::size_t k = 0; k < kN; ++k) {
    std::size_t best = k;
    for (std::size_t i = k + 1; i < kN; ++i)
      if (std::abs(rows[i][k]) > std::abs(rows[best][k])) best = i;
    if (std::abs(rows[best][k]) < kTolerance) return std::nullopt;
    std::swap(rows[k], rows[best]);
    std::swap(right[k], right[best]);
    for (std::size_t i = k + 1; i < kN; ++i) {
      const double factor = rows[i][k] / rows[k][k];
      for (std::size_t j = k; j < kN; ++j) rows[i][j] -= factor * rows[k][j];
      right[i] -= factor * right[k];
    }
  }
  for (std::size_t k = kN; k-- > 0;) {
    for (std::size_t j = k + 1; j < kN; ++j) right[k] -= rows[k][j] * right[j];
    right[k] /= rows[k][k];
  }
  return right;
}

Rows transposed(const Rows& rows) {
  Rows turned;
  for (std::size_t i = 0; i < kN; ++i)
    for (std::size_t j = 0; j < kN; ++j) turned[j][i] = rows[i][j];
  return turned;
}

/// Half-spaces by number: the given ones, then four far away, of which every point has a nearer
/// one that is given.
class Program {
 public:
  explicit Program(std::span<const HalfSpace> given) : given_(given) {
    for (std::size_t i = 0; i < kN; ++i) basis_[i] = given.size() + i;
  }

  Vec3d solve_steps() {
    for (int step = 0; step < kMaxSteps; ++step) {
      const auto vertex = solve(matrix(), offsets());
      if (!vertex) break;
      const bool has_gained = (*vertex)[3] < vertex_[3] - kTolerance;
      vertex_ = *vertex;
      const std::size_t entering = violated(has_gained);
      if (entering == n_all() || !exchange(entering, has_gained)) break;
    }
    return {{vertex_[0], vertex_[1], vertex_[2]}};
  }

 private:
  [[nodiscard]] std::size_t n_all() const { return given_.size() + kN; }

  [[nodiscard]] Row row(std::size_t i) const {
    const Vec3d n = half_space(i).normal;
    return {n[0], n[1], n[2], 1};
  }
  [[nodiscard]] HalfSpace half_space(std::size_t i) const {
    if (i < given_.size()) return given_[i];
    constexpr double kFar = 8;
    constexpr std::array<std::array<double, 3>, kN> kCorners = {
        {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}};
    return {.normal = normalized(Vec3d{kCorners[i - given_.size()]}), .offset = kFar};
  }
  [[nodiscard]] Rows matrix() const {
    Rows rows;
    for (std::size_t i = 0; i < kN; ++i) rows[i] = row(basis_[i]);
    return rows;
  }
  [[nodiscard]] Row offsets() const {
    Row right;
    for (std::size_t i = 0; i < kN; ++i) right[i] = half_space(basis_[i]).offset;
    return right;
  }

  /// The half-space that the vertex breaks most, or the first one; their number if it breaks none.
  [[nodiscard]] std::size_t violated(bool is_most) const {
    const Vec3d x = {{vertex_[0], vertex_[1], vertex_[2]}};
    std::size_t found = n_all();
    double most = kTolerance;
    for (std::size_t i = 0; i < given_.size(); ++i) {
      const double excess = dot(given_[i].normal, x) + vertex_[3] - given_[i].offset;
      if (excess <= most) continue;
      found = i;
      if (!is_most) break;
      most = excess;
    }
    return found;
  }

  /// Takes a half-space into the basis for the one whose weight falls to 0 first.
  bool exchange(std::size_t entering, bool has_gained) {
    const Rows columns = transposed(matrix());
    const auto weights = solve(columns, {0, 0, 0, 1});
    const auto fall = solve(columns, row(entering));
    if (!weights || !fall) return false;
    std::size_t leaving = kN;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < kN; ++k) {
      if ((*fall)[k] <= kTolerance) continue;
      const double ratio = std::max((*weights)[k], 0.0) / (*fall)[k];
      const bool is_tie = std::abs(ratio - least) <= kTolerance;
      const bool wins_tie =
          is_tie && (has_gained ? (*fall)[k] > (*fall)[leaving] : basis_[k] < basis_[leaving]);
      if (!wins_tie && (is_tie || ratio >= least)) continue;
      least = ratio;
      leaving = k;
    }
    if (leaving == kN) return false;
    basis_[leaving] = entering;
    return true;
  }

  std::span<const HalfSpace> given_;
  std::array<std::size_t, kN> basis_{};
  Row vertex_{0, 0, 0, std::numeric_limits<double>::infinity()};
};

}  // namespace

Vec3d innermost_point(std::span<const HalfSpace> half_spaces) {
  return Program(half_spaces).solve_steps();
}

}  // namespace lode::io

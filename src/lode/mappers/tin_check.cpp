#include "lode/mappers/tin_check.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "lode/mappers/tin_edge_check.h"
#include "lode/mappers/worst_seen.h"

namespace lode {
namespace {

using delaunay::LatticePoint;

/// Cells with four valid corners.
class CheckedDomain {
 public:
  explicit CheckedDomain(const HeightGrid& grid) : grid_(grid) {}

  [[nodiscard]] bool has_cell(std::int32_t x, std::int32_t y) const {
    if (x < 0 || y < 0 || x + 1 >= grid_.n_columns || y + 1 >= grid_.n_rows) return false;
    return grid_.has_height(x, y) && grid_.has_height(x + 1, y) && grid_.has_height(x, y + 1) &&
           grid_.has_height(x + 1, y + 1);
  }
  [[nodiscard]] bool has_node(std::int32_t x, std::int32_t y) const {
    return has_cell(x, y) || has_cell(x - 1, y) || has_cell(x, y - 1) || has_cell(x - 1, y - 1);
  }
  /// Whether every step from a to b has the domain on its left only.
  [[nodiscard]] bool is_outline(LatticePoint a, LatticePoint b) const {
    if ((a.x == b.x) == (a.y == b.y)) return false;
    const std::int32_t dx = (b.x > a.x) - (b.x < a.x);
    const std::int32_t dy = (b.y > a.y) - (b.y < a.y);
    for (LatticePoint p = a; p != b; p = {p.x + dx, p.y + dy}) {
      const LatticePoint low{std::min(p.x, p.x + dx), std::min(p.y, p.y + dy)};
      const bool first = has_cell(low.x, low.y);
      const bool second = dx != 0 ? has_cell(low.x, low.y - 1) : has_cell(low.x - 1, low.y);
      // Along a row the first is above; along a column, on the right.
      const bool is_first_left = dx > 0 || dy < 0;
      if (first == second || first != is_first_left) return false;
    }
    return true;
  }

 private:
  const HeightGrid& grid_;
};

using LatticeCorners = std::array<LatticePoint, 3>;

class TinChecker {
 public:
  TinChecker(const Surface& surface, const HeightGrid& grid, double max_error, Threads threads,
             Progress& progress)
      : surface_(surface),
        grid_(grid),
        domain_(grid),
        max_error_(max_error),
        threads_(threads),
        progress_(progress),
        triangles_(turning_left(surface, grid)) {}

  Result<TinFacts> run() {
    facts_.n_vertices = surface_.positions.size();
    facts_.n_triangles = surface_.triangles.size();
    find_nodes();
    if (facts_.n_off_samples > 0) return facts_;
    check_turns(triangles_, nodes_, facts_);
    if (facts_.n_turned > 0) return facts_;
    check_edges(
        triangles_, nodes_,
        [this](LatticePoint a, LatticePoint b) { return domain_.is_outline(a, b); }, facts_);
    count_domain();
    LODE_CHECK(check_samples());
    return facts_;
  }

 private:
  void find_nodes() {
    constexpr double kOff = 0.05;  // of a step
    for (std::uint32_t v = 0; v < surface_.positions.size(); ++v) {
      const Vec3d world = surface_.world_position(v);
      const Vec<double, 2> at = grid_.lattice(world[0], world[1]);
      const LatticePoint node{to_index(at[0], grid_.n_columns), to_index(at[1], grid_.n_rows)};
      nodes_.push_back(node);
      const bool is_near = std::abs(at[0] - node.x) <= kOff && std::abs(at[1] - node.y) <= kOff;
      if (!is_near || !domain_.has_node(node.x, node.y)) {
        ++facts_.n_off_samples;
        continue;
      }
      const double offset = std::abs(world[2] - grid_.height(node.x, node.y));
      if (offset <= allowed_offset(world[2]))
        facts_.height_offset = std::max(facts_.height_offset, offset);
      else
        ++facts_.n_off_samples;
    }
  }
  /// What floats explain; and no more than the error, where one is allowed.
  [[nodiscard]] double allowed_offset(double z) const {
    const double rounding =
        0x1p-23 * std::abs(z - surface_.origin[2]) + 0x1p-52 * std::abs(z) + 0x1p-149;
    return max_error_ > 0 ? std::min(rounding, max_error_) : rounding;
  }
  [[nodiscard]] static std::int32_t to_index(double value, std::int32_t n) {
    return static_cast<std::int32_t>(std::lround(std::clamp(value, -1.0, static_cast<double>(n))));
  }

  [[nodiscard]] LatticeCorners triangle(std::size_t t) const {
    const auto& corner = triangles_[t];
    return {nodes_[corner[0]], nodes_[corner[1]], nodes_[corner[2]]};
  }

  void count_domain() {
    for (std::int32_t y = 0; y < grid_.n_rows; ++y)
      for (std::int32_t x = 0; x < grid_.n_columns; ++x) {
        facts_.n_cells += static_cast<std::uint64_t>(domain_.has_cell(x, y));
        facts_.n_samples += static_cast<std::uint64_t>(domain_.has_node(x, y));
      }
    facts_.doubled_domain_area = 2 * static_cast<std::int64_t>(facts_.n_cells);
  }

  using Seen = WorstSeen<double>;

  Result<void> check_samples() {
    constexpr std::size_t kPiece = 4096;
    std::vector<std::atomic<std::uint8_t>> is_covered(static_cast<std::size_t>(grid_.n_samples()));
    LODE_TRY(const Seen all, look_at_triangles<double>(surface_.triangles.size(), kPiece, threads_,
                                                       progress_, [&](std::size_t t, Seen& seen) {
                                                         look_at(triangle(t), is_covered, seen);
                                                       }));
    facts_.n_beyond = all.n_beyond;
    facts_.worst_error = all.worst;
    facts_.worst = all.at;
    std::uint64_t n_covered = 0;
    for (const auto& flag : is_covered) n_covered += flag.load(std::memory_order_relaxed);
    facts_.n_uncovered = facts_.n_samples - std::min(n_covered, facts_.n_samples);
    return {};
  }

  void look_at(const LatticeCorners& t, std::vector<std::atomic<std::uint8_t>>& is_covered,
               Seen& seen) const {
    const auto [left, right] = std::minmax({t[0].x, t[1].x, t[2].x});
    const auto [low, high] = std::minmax({t[0].y, t[1].y, t[2].y});
    std::array<long double, 3> z{};
    for (std::size_t i = 0; i < 3; ++i) z[i] = grid_.height(t[i].x, t[i].y);
    const auto area = static_cast<long double>(delaunay::doubled_area(t[0], t[1], t[2]));
    // Rounding of four terms in 64 bits; none with integers.
    const auto limit = static_cast<long double>(max_error_) * area * (1 + 0x1p-52L);
    for (LatticePoint p{left, low}; p.y <= high; ++p.y)
      for (p.x = left; p.x <= right; ++p.x) {
        const std::array<std::int64_t, 3> weight{delaunay::doubled_area(t[1], t[2], p),
                                                 delaunay::doubled_area(t[2], t[0], p),
                                                 delaunay::doubled_area(t[0], t[1], p)};
        if (weight[0] < 0 || weight[1] < 0 || weight[2] < 0) continue;
        const auto at = static_cast<std::size_t>(std::int64_t{p.y} * grid_.n_columns + p.x);
        is_covered[at].store(1, std::memory_order_relaxed);
        const long double plane = static_cast<long double>(weight[0]) * z[0] +
                                  static_cast<long double>(weight[1]) * z[1] +
                                  static_cast<long double>(weight[2]) * z[2];
        const long double error = std::abs(grid_.height(p.x, p.y) * area - plane);
        seen.n_beyond += static_cast<std::uint64_t>(error > limit);
        seen.join({0, static_cast<double>(error / area), p});
      }
  }

  const Surface& surface_;
  const HeightGrid& grid_;
  CheckedDomain domain_;
  double max_error_;
  Threads threads_;
  Progress& progress_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  std::vector<LatticePoint> nodes_;
  TinFacts facts_;
};

}  // namespace

Result<TinFacts> check_tin(const Surface& surface, const HeightGrid& grid, double max_error,
                           Threads threads, Progress& progress) {
  return TinChecker(surface, grid, max_error, threads, progress).run();
}

}  // namespace lode

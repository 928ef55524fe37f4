#include "lode/mappers/tin_check.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "lode/core/placed_surface.h"
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
  /// Whether the way from the sample to the right or above to that is a cell's side.
  [[nodiscard]] bool has_side(std::int32_t x, std::int32_t y, bool is_column) const {
    return has_cell(x, y) || (is_column ? has_cell(x - 1, y) : has_cell(x, y - 1));
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

using delaunay::LatticeCorners;

/// What is to be checked: triangles turn left on a lattice whose every `scale`th node along columns
/// and rows is a sample.
struct CheckedTin {
  std::vector<LatticePoint> nodes;
  std::vector<double> heights;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::int32_t scale = 1;
};

/// Puts the vertices of a surface on samples, whose heights they are to have.
class SurfaceNodes {
 public:
  SurfaceNodes(const PlacedSurfaceView& placed, const HeightGrid& grid, double max_error)
      : placed_(placed), grid_(grid), domain_(grid), max_error_(max_error) {}

  CheckedTin find(TinFacts& facts) const {
    CheckedTin tin;
    tin.triangles = turning_left(placed_.surface, grid_);
    for (std::uint32_t v = 0; v < placed_.surface.positions.size(); ++v) {
      const Vec3d world = placed_.world_position(v);
      const Vec<double, 2> at = grid_.lattice(world[0], world[1]);
      const LatticePoint node{to_index(at[0], grid_.n_columns), to_index(at[1], grid_.n_rows)};
      const bool is_near = std::abs(at[0] - node.x) <= kOff && std::abs(at[1] - node.y) <= kOff;
      tin.nodes.push_back(node);
      tin.heights.push_back(0);
      if (!is_near || !domain_.has_node(node.x, node.y)) {
        ++facts.n_off_samples;
        continue;
      }
      tin.heights.back() = grid_.height(node.x, node.y);
      const double offset = std::abs(world[2] - tin.heights.back());
      if (offset <= allowed_offset(world[2]))
        facts.height_offset = std::max(facts.height_offset, offset);
      else
        ++facts.n_off_samples;
    }
    return tin;
  }

 private:
  static constexpr double kOff = 0.05;  // of a step

  /// What rounding explains, of floats where there are no places; and no more than the error, where
  /// one is allowed.
  [[nodiscard]] double allowed_offset(double z) const {
    const double of_floats =
        placed_.places.empty() ? 0x1p-23 * std::abs(z - placed_.surface.origin[2]) + 0x1p-149 : 0;
    const double rounding = of_floats + 0x1p-52 * std::abs(z);
    return max_error_ > 0 ? std::min(rounding, max_error_) : rounding;
  }
  [[nodiscard]] static std::int32_t to_index(double value, std::int32_t n) {
    return static_cast<std::int32_t>(std::lround(std::clamp(value, -1.0, static_cast<double>(n))));
  }

  PlacedSurfaceView placed_;
  const HeightGrid& grid_;
  CheckedDomain domain_;
  double max_error_;
};

/// How far the height of a node is from that of its sample, or from what is linear between the two
/// that it lies between; nothing where it is no such node of the domain, or off by more than
/// rounding.
std::optional<double> offset_between_samples(LatticePoint node, double height, std::int32_t scale,
                                             const HeightGrid& grid, const CheckedDomain& domain) {
  const std::int32_t x = node.x / scale;
  const std::int32_t y = node.y / scale;
  const bool is_on_column = node.x % scale == 0;
  const bool is_on_row = node.y % scale == 0;
  if (is_on_column && is_on_row)
    return domain.has_node(x, y) && height == grid.height(x, y) ? std::optional(0.0) : std::nullopt;
  if ((!is_on_column && !is_on_row) || !domain.has_side(x, y, is_on_column)) return {};
  const double from = grid.height(x, y);
  const double to = is_on_column ? grid.height(x, y + 1) : grid.height(x + 1, y);
  const double share = static_cast<double>((is_on_column ? node.y : node.x) % scale) / scale;
  const double offset = std::abs(height - ((1 - share) * from + share * to));
  // Of five roundings here, and as many where it was made.
  if (!(offset <= 0x1p-49 * std::max(std::abs(from), std::abs(to)))) return {};
  return offset;
}

class TinChecker {
 public:
  TinChecker(CheckedTin tin, const HeightGrid& grid, const TinCheckOptions& options,
             Progress& progress)
      : tin_(std::move(tin)), grid_(grid), domain_(grid), options_(options), progress_(progress) {}

  /// `facts`: of the vertices.
  Result<TinFacts> run(const TinFacts& facts) {
    facts_ = facts;
    facts_.n_vertices = tin_.nodes.size();
    facts_.n_triangles = tin_.triangles.size();
    if (facts_.n_off_samples > 0) return facts_;
    check_turns(tin_.triangles, tin_.nodes, facts_);
    if (facts_.n_turned > 0) return facts_;
    look_at_edges();
    if (grid_.is_round) match_sides();
    count_domain();
    LODE_CHECK(check_samples());
    return facts_;
  }

 private:
  [[nodiscard]] LatticeCorners triangle(std::size_t t) const {
    const auto& corner = tin_.triangles[t];
    return {tin_.nodes[corner[0]], tin_.nodes[corner[1]], tin_.nodes[corner[2]]};
  }
  [[nodiscard]] std::int32_t sample_below(std::int32_t node) const { return node / tin_.scale; }
  [[nodiscard]] std::int32_t sample_above(std::int32_t node) const {
    return (node + tin_.scale - 1) / tin_.scale;
  }

  void look_at_edges() {
    const auto on_outline = [this](LatticePoint a, LatticePoint b) { return is_outline(a, b); };
    if (options_.seams == TinSeams::none) {
      check_edges(tin_.triangles, tin_.nodes, on_outline, facts_);
      if (facts_.n_not_delaunay == 0) return;
    }
    const UncrossedLines lines(
        tin_.triangles, tin_.nodes,
        {(grid_.n_columns - 1) * tin_.scale, (grid_.n_rows - 1) * tin_.scale});
    const auto is_on_seam = [&](std::uint32_t a, std::uint32_t b) {
      return lines.has(tin_.nodes[a], tin_.nodes[b]);
    };
    TinFacts with_seams = facts_;
    TinFacts& facts = options_.seams == TinSeams::none ? with_seams : facts_;
    check_edges(tin_.triangles, tin_.nodes, on_outline, facts, is_on_seam);
    facts_.n_on_seams = with_seams.n_constrained;
  }

  void match_sides() {
    facts_.is_round = true;
    const LatticePoint last{grid_.n_columns - 1, (grid_.n_rows - 1) * tin_.scale};
    std::vector<std::uint8_t> sides(static_cast<std::size_t>(last.y) + 1, 0);
    for (const LatticePoint& p : tin_.nodes) {
      if (p.x == 0) sides[static_cast<std::size_t>(p.y)] |= 1U;
      if (p.x == last.x * tin_.scale) sides[static_cast<std::size_t>(p.y)] |= 2U;
    }
    for (std::int32_t y = 0; y <= last.y; ++y) {
      const std::uint8_t side = sides[static_cast<std::size_t>(y)];
      facts_.n_side_rows += static_cast<std::uint64_t>(side != 0);
      const bool is_one = side == 1 || side == 2;
      if (is_one && domain_.has_node(side == 1 ? last.x : 0, y / tin_.scale)) ++facts_.n_unmatched;
    }
  }

  /// Steps that it goes over in part count whole.
  [[nodiscard]] bool is_outline(LatticePoint a, LatticePoint b) const {
    const bool is_column = a.x == b.x;
    if ((is_column ? a.x : a.y) % tin_.scale != 0) return false;
    const auto widen = [this](std::int32_t from, std::int32_t to) {
      return from < to ? std::pair(sample_below(from), sample_above(to))
                       : std::pair(sample_above(from), sample_below(to));
    };
    const auto [ax, bx] = widen(a.x, b.x);
    const auto [ay, by] = widen(a.y, b.y);
    return domain_.is_outline({ax, ay}, {bx, by});
  }

  void count_domain() {
    for (std::int32_t y = 0; y < grid_.n_rows; ++y)
      for (std::int32_t x = 0; x < grid_.n_columns; ++x) {
        facts_.n_cells += static_cast<std::uint64_t>(domain_.has_cell(x, y));
        facts_.n_samples += static_cast<std::uint64_t>(domain_.has_node(x, y));
      }
    facts_.doubled_domain_area =
        2 * static_cast<std::int64_t>(facts_.n_cells) * tin_.scale * tin_.scale;
  }

  using Seen = WorstSeen<double>;

  Result<void> check_samples() {
    constexpr std::size_t kPiece = 4096;
    std::vector<std::atomic<std::uint8_t>> is_covered(static_cast<std::size_t>(grid_.n_samples()));
    LODE_TRY(const Seen all, look_at_triangles<double>(
                                 tin_.triangles.size(), kPiece, options_.threads, progress_,
                                 [&](std::size_t t, Seen& seen) { look_at(t, is_covered, seen); }));
    facts_.n_beyond = all.n_beyond;
    facts_.worst_error = all.worst;
    facts_.worst = all.at;
    std::uint64_t n_covered = 0;
    for (const auto& flag : is_covered) n_covered += flag.load(std::memory_order_relaxed);
    facts_.n_uncovered = facts_.n_samples - std::min(n_covered, facts_.n_samples);
    return {};
  }

  void look_at(std::size_t number, std::vector<std::atomic<std::uint8_t>>& is_covered,
               Seen& seen) const {
    const LatticeCorners t = triangle(number);
    const auto [left, right] = std::minmax({t[0].x, t[1].x, t[2].x});
    const auto [low, high] = std::minmax({t[0].y, t[1].y, t[2].y});
    std::array<long double, 3> z{};
    for (std::size_t i = 0; i < 3; ++i) z[i] = tin_.heights[tin_.triangles[number][i]];
    const auto area = static_cast<long double>(delaunay::doubled_area(t[0], t[1], t[2]));
    // Rounding of four terms in 64 bits; none with integers.
    const auto limit = static_cast<long double>(options_.max_error) * area * (1 + 0x1p-52L);
    for (LatticePoint s{0, sample_above(low)}; s.y <= sample_below(high); ++s.y)
      for (s.x = sample_above(left); s.x <= sample_below(right); ++s.x) {
        const LatticePoint p{s.x * tin_.scale, s.y * tin_.scale};
        const std::array<std::int64_t, 3> weight{delaunay::doubled_area(t[1], t[2], p),
                                                 delaunay::doubled_area(t[2], t[0], p),
                                                 delaunay::doubled_area(t[0], t[1], p)};
        if (weight[0] < 0 || weight[1] < 0 || weight[2] < 0) continue;
        const auto at = static_cast<std::size_t>(std::int64_t{s.y} * grid_.n_columns + s.x);
        is_covered[at].store(1, std::memory_order_relaxed);
        // From one of the heights, as differences of near numbers are exact.
        const long double way = static_cast<long double>(weight[1]) * (z[1] - z[0]) +
                                static_cast<long double>(weight[2]) * (z[2] - z[0]);
        const long double error = std::abs((grid_.height(s.x, s.y) - z[0]) * area - way);
        seen.n_beyond += static_cast<std::uint64_t>(error > limit);
        seen.join({0, static_cast<double>(error / area), s});
      }
  }

  CheckedTin tin_;
  const HeightGrid& grid_;
  CheckedDomain domain_;
  TinCheckOptions options_;
  Progress& progress_;
  TinFacts facts_;
};

}  // namespace

Result<TinFacts> check_tin(const Surface& surface, const HeightGrid& grid,
                           const TinCheckOptions& options, Progress& progress) {
  TinFacts facts;
  CheckedTin tin = SurfaceNodes({surface, options.places}, grid, options.max_error).find(facts);
  return TinChecker(std::move(tin), grid, options, progress).run(facts);
}

Result<TinFacts> check_fine_tin(const delaunay::Tin& tin, std::int32_t scale,
                                const HeightGrid& grid, double max_error, Threads threads,
                                Progress& progress) {
  TinFacts facts;
  const CheckedDomain domain(grid);
  for (std::size_t v = 0; v < tin.vertices.size(); ++v) {
    const auto offset =
        offset_between_samples(tin.vertices[v], tin.heights[v], scale, grid, domain);
    if (offset)
      facts.height_offset = std::max(facts.height_offset, *offset);
    else
      ++facts.n_off_samples;
  }
  CheckedTin checked{tin.vertices, tin.heights, tin.triangles, scale};
  return TinChecker(std::move(checked), grid, {.max_error = max_error, .threads = threads},
                    progress)
      .run(facts);
}

}  // namespace lode

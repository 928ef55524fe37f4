#include "lode/models/terrain/terrain_lines/line_laying.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "lode/locate/tin_height.h"

namespace lode::terrain_lines {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Along a column or row exactly on it.
Vec3d between(const Vec3d& a, const Vec3d& b, double t) { return a + (b - a) * t; }

double distance(const Vec3d& a, const Vec3d& b) { return std::hypot(b[0] - a[0], b[1] - a[1]); }

/// Without places twice in a row.
PlaceLine without_repeats(const PlaceLine& line) {
  PlaceLine kept;
  for (const Vec3d& p : line)
    if (kept.empty() || distance(kept.back(), p) > 0) kept.push_back(p);
  return kept;
}

/// Fills heights that are missing between others linearly by length, and at ends with the nearest.
void fill_heights(PlaceLine& line) {
  double length = 0;
  std::vector<double> along;
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < line.size(); ++i) {
    length += i > 0 ? distance(line[i - 1], line[i]) : 0;
    along.push_back(length);
    if (!std::isnan(line[i][2])) known.push_back(i);
  }
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (!std::isnan(line[i][2])) continue;
    const auto after = std::ranges::lower_bound(known, i);
    if (after == known.begin()) {
      line[i][2] = line[known.front()][2];
    } else if (after == known.end()) {
      line[i][2] = line[known.back()][2];
    } else {
      const std::size_t a = *(after - 1);
      const std::size_t b = *after;
      const double t = (along[i] - along[a]) / (along[b] - along[a]);
      line[i][2] = line[a][2] * (1 - t) + line[b][2] * t;
    }
  }
}

class LineLayer {
 public:
  LineLayer(const TinLocator& surface, const LayingOptions& options)
      : surface_(surface), options_(options) {
    for (const LatticePoint p : surface.tin().vertices) {
      lower_ = {{std::min<double>(lower_[0], p.x), std::min<double>(lower_[1], p.y)}};
      upper_ = {{std::max<double>(upper_[0], p.x), std::max<double>(upper_[1], p.y)}};
    }
  }

  void lay(const PlaceLine& given, LaidLines& laid) {
    PlaceLine line = without_repeats(given);
    const bool has_own =
        std::ranges::any_of(line, [](const Vec3d& p) { return !std::isnan(p[2]); });
    const bool is_own = has_own && !options_.is_draped;
    if (is_own) fill_heights(line);
    laid.n_own += static_cast<std::uint64_t>(is_own);
    looks_.clear();
    for (std::size_t i = 0; i + 1 < line.size(); ++i) look_along(line[i], line[i + 1], i == 0);
    const std::size_t n_before = laid.parts.size();
    const bool is_whole = add_parts(is_own, laid.parts);
    laid.n_outside += static_cast<std::uint64_t>(laid.parts.size() == n_before);
    laid.n_cut += static_cast<std::uint64_t>(laid.parts.size() > n_before && !is_whole);
  }

 private:
  struct Look {
    Vec3d at;              ///< With the line's own height, or NaN.
    double height = kNaN;  ///< The surface's; NaN: outside.
    bool is_point = false;
  };

  [[nodiscard]] Look look_at(const Vec3d& at, bool is_point) const {
    const delaunay::Point p{{at[0], at[1]}};
    const std::optional<std::uint32_t> triangle = surface_.find(p);
    return {at, triangle ? height_in(surface_.tin(), *triangle, p).height : kNaN, is_point};
  }
  /// Where the line leaves or enters the domain: the last place inside that halving finds.
  [[nodiscard]] Look edge_between(Look inside, Look outside) const {
    constexpr int kHalvings = 40;
    for (int i = 0; i < kHalvings; ++i) {
      const Look middle = look_at(between(inside.at, outside.at, 0.5), false);
      (std::isnan(middle.height) ? outside : inside) = middle;
    }
    return inside;
  }
  void look_along(const Vec3d& a, const Vec3d& b, bool is_first) {
    if (is_first) looks_.push_back(look_at(a, true));
    const auto [begin, end] = within_rectangle(a, b);
    const double n = std::ceil(distance(a, b) * (end - begin) / options_.step);
    if (begin > 0 && begin < end) add_look(look_at(between(a, b, begin), false));
    for (double k = 1; k <= n; ++k) {
      const double t = begin + (end - begin) * (k / n);
      const Vec3d at = between(a, b, t);
      if (t < 1) add_look(look_at(at, is_near_outline(at)));
    }
    add_look(look_at(b, true));
  }
  /// There may be less outside than a step. With a point on each side of it an edge that crosses
  /// the outline is a short one, and the rest of the line stays.
  [[nodiscard]] bool is_near_outline(const Vec3d& p) const {
    for (const double sign : {-1.0, 1.0})
      for (const std::size_t axis : {0U, 1U}) {
        delaunay::Point q{{p[0], p[1]}};
        q[axis] += sign * options_.step;
        if (!surface_.find(q)) return true;
      }
    return false;
  }
  /// The part of the way from a to b that may meet the surface, and a little more; may be empty.
  [[nodiscard]] std::pair<double, double> within_rectangle(const Vec3d& a, const Vec3d& b) const {
    double begin = 0;
    double end = 1;
    for (std::size_t i = 0; i < 2; ++i) {
      const double way = b[i] - a[i];
      const double low = lower_[i] - 1 - a[i];
      const double high = upper_[i] + 1 - a[i];
      if (way == 0) {
        if (low > 0 || high < 0) return {0, 0};
        continue;
      }
      begin = std::max(begin, std::min(low / way, high / way));
      end = std::min(end, std::max(low / way, high / way));
    }
    return {begin, std::max(begin, end)};
  }
  void add_look(const Look& look) {
    const Look last = looks_.back();
    if (std::isnan(last.height) != std::isnan(look.height)) {
      const bool is_leaving = std::isnan(look.height);
      const Vec3d& from = is_leaving ? last.at : look.at;
      Look end = is_leaving ? edge_between(last, look) : edge_between(look, last);
      const double length = distance(from, end.at);
      if (options_.pull > 0 && length > 0)
        end = look_at(between(end.at, from, std::min(1.0, options_.pull / length)), false);
      end.is_point = true;
      looks_.push_back(end);
    }
    looks_.push_back(look);
  }

  /// False where something is outside.
  bool add_parts(bool is_own, std::vector<LineToNode>& parts) {
    bool is_whole = true;
    for (std::size_t first = 0; first < looks_.size();) {
      if (std::isnan(looks_[first].height)) {
        is_whole = false;
        ++first;
        continue;
      }
      std::size_t end = first;
      while (end < looks_.size() && !std::isnan(looks_[end].height)) ++end;
      PlaceLine part = is_own ? own_part(first, end) : draped_part(first, end);
      if (part.size() > 1) parts.push_back({std::move(part), is_own});
      first = end;
    }
    return is_whole;
  }
  [[nodiscard]] PlaceLine own_part(std::size_t first, std::size_t end) const {
    PlaceLine part;
    for (std::size_t i = first; i < end; ++i)
      if (looks_[i].is_point) part.push_back(looks_[i].at);
    return without_repeats(part);
  }
  /// The points, and of the looks between them those that it takes to stay near the surface: always
  /// the farthest first (D. H. Douglas, T. K. Peucker, 1973).
  [[nodiscard]] PlaceLine draped_part(std::size_t first, std::size_t end) const {
    std::vector<bool> is_kept(end - first, false);
    std::vector<std::pair<std::size_t, std::size_t>> open;
    std::size_t from = first;
    for (std::size_t i = first; i < end; ++i) {
      if (i != first && i + 1 != end && !looks_[i].is_point) continue;
      is_kept[i - first] = true;
      if (i > from) open.emplace_back(from, i);
      from = i;
    }
    while (!open.empty()) {
      const auto [a, b] = open.back();
      open.pop_back();
      const std::size_t worst = farthest(a, b);
      if (worst == a) continue;
      is_kept[worst - first] = true;
      open.emplace_back(a, worst);
      open.emplace_back(worst, b);
    }
    PlaceLine part;
    for (std::size_t i = first; i < end; ++i)
      if (is_kept[i - first])
        part.push_back({{looks_[i].at[0], looks_[i].at[1], looks_[i].height}});
    return without_repeats(part);
  }
  /// From the chord of two looks; the first of them where none is beyond the tolerance.
  [[nodiscard]] std::size_t farthest(std::size_t a, std::size_t b) const {
    const double length = distance(looks_[a].at, looks_[b].at);
    std::size_t worst = a;
    double most = options_.max_error;
    for (std::size_t i = a + 1; i < b; ++i) {
      const double t = length > 0 ? distance(looks_[a].at, looks_[i].at) / length : 0;
      const double chord = looks_[a].height * (1 - t) + looks_[b].height * t;
      const double error = std::abs(looks_[i].height - chord);
      if (error <= most) continue;
      most = error;
      worst = i;
    }
    return worst;
  }

  const TinLocator& surface_;
  LayingOptions options_;
  Vec<double, 2> lower_{{kFar, kFar}};  ///< Of all vertices.
  Vec<double, 2> upper_{{-kFar, -kFar}};
  std::vector<Look> looks_;
};

}  // namespace

Result<LaidLines> lay_lines(std::span<const PlaceLine> lines, const TinLocator& surface,
                            const LayingOptions& options, Progress& progress) {
  LaidLines laid;
  LineLayer layer(surface, options);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (progress.is_cancelled()) return cancelled_error();
    progress.report("laying lines", static_cast<double>(i) / static_cast<double>(lines.size()));
    layer.lay(lines[i], laid);
  }
  return laid;
}

}  // namespace lode::terrain_lines

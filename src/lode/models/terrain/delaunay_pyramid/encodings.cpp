// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), section 8: data structures for Delaunay pyramids.
#include "lode/models/terrain/delaunay_pyramid/encodings.h"

#include <algorithm>

#include "lode/delaunay/lattice_side.h"
#include "lode/delaunay/tin_links.h"
#include "lode/models/terrain/delaunay_pyramid/descent.h"
#include "lode/models/terrain/delaunay_pyramid/extract.h"

namespace lode::delaunay_pyramid {
namespace {

using delaunay::LatticePoint;

/// Whether a closed triangle, which turns left, meets a window: exactly, as convex sets that do not
/// are separated by a side of one of them.
bool meets_window(const LatticeCorners& triangle, const Window& window) {
  const auto [x0, x1] = std::minmax({triangle[0].x, triangle[1].x, triangle[2].x});
  const auto [y0, y1] = std::minmax({triangle[0].y, triangle[1].y, triangle[2].y});
  if (x1 < window.lower.x || x0 > window.upper.x || y1 < window.lower.y || y0 > window.upper.y)
    return false;
  for (std::size_t i = 0; i < 3; ++i) {
    const LatticePoint a = triangle[i];
    const LatticePoint b = triangle[(i + 1) % 3];
    // The corner of the window farthest to the left of the edge.
    const LatticePoint p{b.y > a.y ? window.lower.x : window.upper.x,
                         b.x > a.x ? window.upper.y : window.lower.y};
    if (delaunay::doubled_area(a, b, p) < 0) return false;
  }
  return true;
}

/// By triangle of the mesh at `time`, those of the mesh at `later` whose interiors meet its own.
class Interferences {
 public:
  Interferences(const History& history, EncodingLimit limit)
      : history_(history), descent_(history), limit_(limit) {}

  /// number_of(t): of what is linked.
  template <typename NumberOf>
  Result<void> add(std::uint32_t t, std::uint32_t later, const NumberOf& number_of,
                   LinkLists& links) {
    const LatticeCorners own = corners_of(history_, history_.triangles[t].corner);
    if (links.first.empty()) links.first.push_back(0);
    descent_.restart();
    descent_.run(
        t, later,
        [&](std::uint32_t other) {
          return other == t ||
                 do_interiors_meet(own, corners_of(history_, history_.triangles[other].corner));
        },
        [&](std::uint32_t other) { links.items.push_back(number_of(other)); });
    std::sort(links.items.begin() + static_cast<std::ptrdiff_t>(links.first.back()),
              links.items.end());
    n_bytes_ += (links.items.size() - links.first.back()) * sizeof(std::uint32_t);
    links.first.push_back(links.items.size());
    if (n_bytes_ > limit_.n_bytes)
      return fail(
          "expected interference links of up to {} bytes, got more, {} of them so far: fewer "
          "levels, or the lists without links, take less",
          limit_.n_bytes, n_bytes_ / sizeof(std::uint32_t));
    return {};
  }

 private:
  const History& history_;
  Descent descent_;
  EncodingLimit limit_;
  std::uint64_t n_bytes_ = 0;
};

/// The triangles of the mesh at a time, ascending.
std::vector<std::uint32_t> alive_at(const History& history, std::uint32_t time) {
  std::vector<std::uint32_t> alive;
  for (std::uint32_t t = 0; t < history.first_made[time]; ++t)
    if (history.triangles[t].death >= time) alive.push_back(t);
  return alive;
}

std::uint32_t number_in(const std::vector<std::uint32_t>& ascending, std::uint32_t t) {
  return static_cast<std::uint32_t>(std::ranges::lower_bound(ascending, t) - ascending.begin());
}

}  // namespace

std::vector<std::uint32_t> times_of(const History& history, std::span<const double> levels) {
  std::vector<std::uint32_t> times;
  for (const double level : levels) times.push_back(time_within(history, level));
  return times;
}

Result<CompletePyramid> CompletePyramid::make(const History& history,
                                              std::span<const std::uint32_t> times,
                                              EncodingLimit limit, Progress& progress) {
  CompletePyramid made;
  Interferences interferences(history, limit);
  std::vector<std::uint32_t> alive;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (progress.is_cancelled()) return cancelled_error();
    if (i == 0) alive = alive_at(history, times[0]);
    Level& level = made.levels_.emplace_back();
    for (const std::uint32_t t : alive) level.triangles.push_back(history.triangles[t].corner);
    level.twins = delaunay::find_twins(level.triangles);
    if (i + 1 == times.size()) break;
    const std::vector<std::uint32_t> next = alive_at(history, times[i + 1]);
    for (const std::uint32_t t : alive)
      LODE_CHECK(interferences.add(
          t, times[i + 1], [&](std::uint32_t other) { return number_in(next, other); },
          level.links));
    alive = next;
  }
  return made;
}

std::uint64_t CompletePyramid::n_links() const {
  std::uint64_t n = 0;
  for (const Level& level : levels_) n += level.links.items.size();
  return n;
}

std::uint64_t CompletePyramid::n_bytes() const {
  std::uint64_t n = 0;
  for (const Level& level : levels_)
    n += level.triangles.size() * (sizeof(level.triangles[0]) + sizeof(level.twins[0])) +
         level.links.n_bytes();
  return n;
}

delaunay::Tin CompletePyramid::extract(const History& history, std::size_t level) const {
  delaunay::Tin tin;
  tin.triangles = levels_[level].triangles;
  tin.twins = levels_[level].twins;
  place_vertices(history, tin);
  return tin;
}

std::optional<std::uint32_t> CompletePyramid::locate(const History& history, std::size_t level,
                                                     LatticePoint p) const {
  const auto is_in = [&](std::size_t i, std::uint32_t t) {
    return holds(corners_of(history, levels_[i].triangles[t]), p);
  };
  std::uint32_t at = 0;
  const auto n = static_cast<std::uint32_t>(levels_[0].triangles.size());
  while (at < n && !is_in(0, at)) ++at;
  if (at == n) return {};
  for (std::size_t i = 0; i < level; ++i) {
    const auto links = levels_[i].links.of(at);
    at = *std::ranges::find_if(links, [&](std::uint32_t t) { return is_in(i + 1, t); });
  }
  return at;
}

std::vector<std::uint32_t> CompletePyramid::zoom(const History& history, std::size_t level,
                                                 const Window& window) const {
  const auto is_met = [&](std::size_t i, std::uint32_t t) {
    return meets_window(corners_of(history, levels_[i].triangles[t]), window);
  };
  std::vector<std::uint32_t> found;
  for (std::uint32_t t = 0; t < levels_[0].triangles.size(); ++t)
    if (is_met(0, t)) found.push_back(t);
  for (std::size_t i = 0; i < level; ++i) {
    std::vector<std::uint32_t> below;
    for (const std::uint32_t t : found)
      for (const std::uint32_t link : levels_[i].links.of(t)) below.push_back(link);
    std::ranges::sort(below);
    below.erase(std::ranges::unique(below).begin(), below.end());
    std::erase_if(below, [&](std::uint32_t t) { return !is_met(i + 1, t); });
    found = std::move(below);
  }
  return found;
}

Result<TriangleLists> TriangleLists::make(const History& history,
                                          std::span<const std::uint32_t> times,
                                          Interference interference, EncodingLimit limit,
                                          Progress& progress) {
  TriangleLists made;
  made.first_.push_back(0);
  const auto n_levels = static_cast<std::uint32_t>(times.size());
  std::vector<std::uint32_t> numbers;  // Of the entries, in the history.
  for (std::uint32_t level = 0; level < n_levels; ++level) {
    if (progress.is_cancelled()) return cancelled_error();
    const std::uint32_t begin = level == 0 ? 0 : history.first_made[times[level - 1]];
    for (std::uint32_t t = begin; t < history.first_made[times[level]]; ++t) {
      const Triangle& triangle = history.triangles[t];
      if (triangle.death < times[level]) continue;
      const auto death =
          std::ranges::upper_bound(times.subspan(level), triangle.death) - times.begin();
      numbers.push_back(t);
      made.entries_.push_back({triangle.corner, static_cast<std::uint32_t>(death)});
    }
    made.first_.push_back(static_cast<std::uint32_t>(made.entries_.size()));
  }
  if (interference == Interference::left_out) return made;
  Interferences interferences(history, limit);
  for (std::uint32_t e = 0; e < made.entries_.size(); ++e) {
    const std::uint32_t death = made.entries_[e].death;
    if (death == n_levels) {
      if (made.links_.first.empty()) made.links_.first.push_back(0);
      made.links_.first.push_back(made.links_.items.size());
      continue;
    }
    LODE_CHECK(interferences.add(
        numbers[e], times[death], [&](std::uint32_t t) { return number_in(numbers, t); },
        made.links_));
  }
  return made;
}

std::uint64_t TriangleLists::n_bytes() const {
  return entries_.size() * sizeof(entries_[0]) + first_.size() * sizeof(first_[0]) +
         links_.n_bytes();
}

delaunay::Tin TriangleLists::extract(const History& history, std::size_t level) const {
  delaunay::Tin tin;
  for (std::uint32_t e = 0; e < first_[level + 1]; ++e)
    if (entries_[e].death > level) tin.triangles.push_back(entries_[e].corner);
  place_vertices(history, tin);
  return tin;
}

std::optional<std::uint32_t> TriangleLists::locate(const History& history, std::size_t level,
                                                   LatticePoint p) const {
  LODE_EXPECTS(has_links());
  const auto is_in = [&](std::uint32_t e) {
    return holds(corners_of(history, entries_[e].corner), p);
  };
  std::uint32_t at = 0;
  while (at < first_[1] && !is_in(at)) ++at;
  if (at == first_[1]) return {};
  while (entries_[at].death <= level) at = *std::ranges::find_if(links_.of(at), is_in);
  return at;
}

std::vector<std::uint32_t> TriangleLists::zoom(const History& history, std::size_t level,
                                               const Window& window) const {
  LODE_EXPECTS(has_links());
  const auto is_met = [&](std::uint32_t e) {
    return meets_window(corners_of(history, entries_[e].corner), window);
  };
  std::vector<std::uint32_t> open;
  for (std::uint32_t e = 0; e < first_[1]; ++e)
    if (is_met(e)) open.push_back(e);
  std::vector<bool> is_seen(entries_.size());
  std::vector<std::uint32_t> found;
  while (!open.empty()) {
    const std::uint32_t at = open.back();
    open.pop_back();
    if (entries_[at].death > level) {
      found.push_back(at);
      continue;
    }
    for (const std::uint32_t link : links_.of(at)) {
      if (is_seen[link]) continue;
      is_seen[link] = true;
      if (is_met(link)) open.push_back(link);
    }
  }
  std::ranges::sort(found);
  return found;
}

std::optional<std::uint32_t> locate_at(const History& history, std::uint32_t time,
                                       const delaunay::Point& p) {
  const auto is_left = [&](std::uint32_t a, std::uint32_t b) {
    return delaunay::side_of(history.vertices[a], history.vertices[b], p) >= 0;
  };
  const auto is_in = [&](const std::array<std::uint32_t, 3>& corner) {
    return is_left(corner[0], corner[1]) && is_left(corner[1], corner[2]) &&
           is_left(corner[2], corner[0]);
  };
  std::uint32_t at = 0;
  const std::uint32_t n = history.n_base_triangles();
  while (at < n && !is_in(history.triangles[at].corner)) ++at;
  if (at == n) return {};
  while (history.triangles[at].death < time) {
    const std::uint32_t death = history.triangles[at].death;
    // In the cavity p is in one of the sectors round the new vertex.
    const std::uint32_t end = history.first_made[death + 1];
    at = history.first_made[death];
    for (; at + 1 < end; ++at) {
      const auto& corner = history.triangles[at].corner;
      if (is_left(corner[1], corner[2]) && is_left(corner[2], corner[0])) break;
    }
  }
  return at;
}

std::vector<std::uint32_t> zoom_at(const History& history, std::uint32_t time,
                                   const Window& window) {
  std::vector<std::uint32_t> found;
  Descent descent(history);
  for (std::uint32_t t = 0; t < history.n_base_triangles(); ++t)
    descent.run(
        t, time,
        [&](std::uint32_t other) {
          return meets_window(corners_of(history, history.triangles[other].corner), window);
        },
        [&](std::uint32_t other) { found.push_back(other); });
  std::ranges::sort(found);
  return found;
}

}  // namespace lode::delaunay_pyramid

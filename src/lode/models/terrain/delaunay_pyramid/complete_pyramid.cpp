// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), section 8: data structures for Delaunay pyramids.
#include <algorithm>

#include "lode/delaunay/lattice_side.h"
#include "lode/delaunay/tin_links.h"
#include "lode/models/terrain/delaunay_pyramid/encodings.h"
#include "lode/models/terrain/delaunay_pyramid/interferences.h"
#include "lode/models/terrain/insertions/extract.h"

namespace lode::delaunay_pyramid {
namespace {

using delaunay::LatticePoint;

/// The triangles of the mesh at a time, ascending.
std::vector<std::uint32_t> alive_at(const History& history, std::uint32_t time) {
  std::vector<std::uint32_t> alive;
  for (std::uint32_t t = 0; t < history.first_made[time]; ++t)
    if (history.triangles[t].death >= time) alive.push_back(t);
  return alive;
}

}  // namespace

Result<CompletePyramid> CompletePyramid::make(const History& history,
                                              std::span<const std::uint32_t> times,
                                              EncodingLimit limit, Progress& progress) {
  CompletePyramid made;
  Interferences interferences(history, limit);
  made.levels_.resize(times.size());
  for (std::size_t i = 0; i < times.size(); ++i)
    LODE_CHECK(interferences.begin(alive_at(history, times[i]).size(), made.levels_[i].links));
  std::vector<std::uint32_t> alive = alive_at(history, times[0]);
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (progress.is_cancelled()) return cancelled_error();
    Level& level = made.levels_[i];
    for (const std::uint32_t t : alive) level.triangles.push_back(history.triangles[t].corner);
    level.twins = delaunay::find_twins(level.triangles);
    if (i == 0) made.start_.emplace(history, level.triangles);
    if (i + 1 == times.size()) {
      for (std::size_t k = 0; k < alive.size(); ++k) Interferences::add_none(level.links);
      break;
    }
    const std::vector<std::uint32_t> next = alive_at(history, times[i + 1]);
    for (const std::uint32_t t : alive)
      LODE_CHECK(interferences.add(
          t, times[i + 1], [&](std::uint32_t other) { return number_in(next, other); },
          level.links));
    LODE_CHECK(interferences.end(level.links));
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
  std::uint64_t n = start_ ? start_->n_bytes() : 0;
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
  const auto start = start_->find(delaunay::to_point(p));
  if (!start) return {};
  std::uint32_t at = *start;
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
    below.erase(std::unique(below.begin(), below.end()), below.end());
    std::erase_if(below, [&](std::uint32_t t) { return !is_met(i + 1, t); });
    found = std::move(below);
  }
  return found;
}

}  // namespace lode::delaunay_pyramid

// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), section 8: data structures for Delaunay pyramids.
#include <algorithm>

#include "lode/delaunay/lattice_side.h"
#include "lode/models/terrain/delaunay_pyramid/encodings.h"
#include "lode/models/terrain/delaunay_pyramid/interferences.h"
#include "lode/models/terrain/insertions/extract.h"

namespace lode::delaunay_pyramid {
namespace {

using delaunay::LatticePoint;

/// Of the first list.
std::vector<std::array<std::uint32_t, 3>> first_corners(
    std::span<const TriangleLists::Entry> entries) {
  std::vector<std::array<std::uint32_t, 3>> corners;
  for (const TriangleLists::Entry& entry : entries) corners.push_back(entry.corner);
  return corners;
}

}  // namespace

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
  made.start_.emplace(history, first_corners(made.entries().first(made.first_[1])));
  LODE_CHECK(made.link(history, times, numbers, limit, progress));
  return made;
}

Result<void> TriangleLists::link(const History& history, std::span<const std::uint32_t> times,
                                 const std::vector<std::uint32_t>& numbers, EncodingLimit limit,
                                 Progress& progress) {
  Interferences interferences(history, limit);
  links_.resize(n_levels());
  for (std::size_t level = 0; level < n_levels(); ++level)
    LODE_CHECK(interferences.begin(first_[level + 1] - first_[level], links_[level]));
  for (std::size_t level = 0; level < n_levels(); ++level) {
    if (progress.is_cancelled()) return cancelled_error();
    for (std::uint32_t e = first_[level]; e < first_[level + 1]; ++e) {
      const std::uint32_t death = entries_[e].death;
      if (death == n_levels())
        Interferences::add_none(links_[level]);
      else
        LODE_CHECK(interferences.add(
            numbers[e], times[death], [&](std::uint32_t t) { return number_in(numbers, t); },
            links_[level]));
    }
    LODE_CHECK(interferences.end(links_[level]));
  }
  return {};
}

std::uint64_t TriangleLists::n_links() const {
  std::uint64_t n = 0;
  for (const LinkLists& links : links_) n += links.items.size();
  return n;
}

std::uint64_t TriangleLists::n_bytes() const {
  std::uint64_t n = entries_.size() * sizeof(entries_[0]) + first_.size() * sizeof(first_[0]) +
                    (start_ ? start_->n_bytes() : 0);
  for (const LinkLists& links : links_) n += links.n_bytes();
  return n;
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
  const auto start = start_->find(delaunay::to_point(p));
  if (!start) return {};
  std::uint32_t at = *start;
  while (entries_[at].death <= level) at = *std::ranges::find_if(links_of(at), is_in);
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
    for (const std::uint32_t link : links_of(at)) {
      if (is_seen[link]) continue;
      is_seen[link] = true;
      if (is_met(link)) open.push_back(link);
    }
  }
  std::ranges::sort(found);
  return found;
}

}  // namespace lode::delaunay_pyramid

// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), section 8: data structures for Delaunay pyramids.
#include <utility>

#include "lode/core/expects.h"
#include "lode/models/terrain/delaunay_pyramid/pyramid.h"

namespace lode::delaunay_pyramid {
namespace {

/// error(t) of the triangles of a history that are in the mesh at a time and that were made at
/// `begin` or later, in their order.
std::vector<float> errors_at(const History& history, std::uint32_t begin, std::uint32_t time) {
  std::vector<float> errors;
  for (std::uint32_t t = begin; t < history.first_made[time]; ++t)
    if (history.triangles[t].death >= time) errors.push_back(history.triangles[t].error);
  return errors;
}

std::uint64_t n_at(const History& history, std::uint32_t time) {
  return errors_at(history, 0, time).size();
}

PyramidHead head_of(const History& history, std::span<const double> tolerances, Encoding encoding,
                    std::span<const std::uint32_t> times) {
  PyramidHead head;
  head.source = history;
  head.encoding = encoding;
  head.max_error = history.max_error;
  head.tolerances.assign(tolerances.begin(), tolerances.end());
  head.n_lines = static_cast<std::uint32_t>(history.lines.size());
  for (const std::uint32_t time : times) {
    head.vertices_until.push_back(history.n_base_vertices + time);
    head.n_in_mesh.push_back(static_cast<std::uint32_t>(n_at(history, time)));
  }
  return head;
}

/// Without errors.
std::vector<PyramidLevel> to_levels(CompletePyramid complete) {
  std::vector<PyramidLevel> levels;
  for (CompletePyramid::Level& level : std::move(complete).take_levels()) {
    PyramidLevel& kept = levels.emplace_back();
    kept.triangles = std::move(level.triangles);
    kept.twins = std::move(level.twins);
    kept.links = std::move(level.links);
  }
  return levels;
}

/// The same.
std::vector<PyramidLevel> to_levels(TriangleLists lists) {
  std::vector<PyramidLevel> levels;
  // Moved, as they may be too many to be there twice.
  std::vector<LinkLists> links = lists.take_links();
  for (std::size_t level = 0; level < lists.n_levels(); ++level) {
    PyramidLevel& kept = levels.emplace_back();
    for (std::uint32_t e = lists.first_entry(level); e < lists.first_entry(level + 1); ++e) {
      kept.triangles.push_back(lists.entries()[e].corner);
      kept.deaths.push_back(lists.entries()[e].death);
    }
    if (links.empty()) continue;
    kept.links = std::move(links[level]);
    // What meets it in the mesh of its death was made for that: the rest had been beside it.
    for (std::size_t i = 0; i < kept.deaths.size(); ++i)
      for (std::uint64_t k = kept.links.first[i]; k < kept.links.first[i + 1]; ++k)
        kept.links.items[k] -= lists.first_entry(kept.deaths[i]);
  }
  return levels;
}

}  // namespace

Result<Pyramid> encode(const History& history, std::span<const double> tolerances,
                       Encoding encoding, EncodingLimit limit, Progress& progress) {
  LODE_EXPECTS(!tolerances.empty() && history.is_worst_first());
  const std::vector<std::uint32_t> times = times_of(history, tolerances);
  Pyramid pyramid;
  pyramid.head = head_of(history, tolerances, encoding, times);
  if (encoding == Encoding::complete) {
    LODE_TRY(auto complete, CompletePyramid::make(history, times, limit, progress));
    pyramid.levels = to_levels(std::move(complete));
  } else {
    const auto links = has_links(encoding) ? Interference::linked : Interference::left_out;
    LODE_TRY(auto lists, TriangleLists::make(history, times, links, limit, progress));
    pyramid.levels = to_levels(std::move(lists));
  }
  for (std::size_t level = 0; level < times.size(); ++level) {
    PyramidLevel& kept = pyramid.levels[level];
    const bool makes_some = pyramid.head.is_of_lists() && level > 0;
    kept.errors =
        errors_at(history, makes_some ? history.first_made[times[level - 1]] : 0, times[level]);
    pyramid.head.n_kept.push_back(static_cast<std::uint32_t>(kept.triangles.size()));
    pyramid.head.n_links.push_back(kept.links.items.size());
  }
  const std::uint32_t n = pyramid.head.vertices_until.back();
  pyramid.vertices.assign(history.vertices.begin(), history.vertices.begin() + n);
  pyramid.heights.assign(history.heights.begin(), history.heights.begin() + n);
  pyramid.lines = history.lines;
  for (std::size_t level = 0; level < times.size(); ++level)
    pyramid.head.facts.push_back(facts_of(pyramid, numbered_mesh(pyramid, level)));
  pyramid.head.height_type = terrain_file::narrowest(pyramid.heights);
  return pyramid;
}

}  // namespace lode::delaunay_pyramid

#include "lode/models/terrain/insertions/node_columns.h"

#include <algorithm>
#include <utility>

#include "lode/models/terrain/insertions/box_tree.h"

namespace lode::insertions {
namespace {

/// A page's nodes, each near the one before.
std::vector<std::uint32_t> along_curve(const PageNodes& nodes) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> places;
  places.reserve(nodes.times.size());
  for (std::uint32_t i = 0; i < nodes.times.size(); ++i)
    places.emplace_back(place_along_z(nodes.points[i]), i);
  std::ranges::sort(places);
  std::vector<std::uint32_t> order;
  order.reserve(places.size());
  for (const auto& [place, i] : places) order.push_back(i);
  return order;
}

/// is_there: by time, whether there is a node of it.
Result<void> read_page(const HistoryFile& file, std::uint32_t page, std::vector<bool>& is_there,
                       NodeColumns& columns) {
  LODE_TRY(const PageNodes nodes, file.read_nodes(page));
  const auto first = static_cast<std::uint32_t>(columns.errors.size());
  for (const std::uint32_t i : along_curve(nodes)) {
    const std::uint32_t time = nodes.times[i];
    // Pages have as many nodes as there are, so none is missing if none is there twice.
    if (is_there[time])
      return fail("{}: page {}: expected node {} once, got it again", file.path(), page, time);
    is_there[time] = true;
    columns.points.push_back(nodes.points[i]);
    columns.heights.push_back(nodes.heights[i]);
    columns.times.push_back(time);
    columns.n_made.push_back(nodes.first_made[i + 1] - nodes.first_made[i]);
    columns.first_error.push_back(first + nodes.first_made[i]);
    columns.begins_later.push_back(nodes.begins_later[i] ? 1 : 0);
  }
  LODE_TRY(const std::vector<float> errors, file.read_errors(page));
  columns.errors.insert(columns.errors.end(), errors.begin(), errors.end());
  return {};
}

}  // namespace

Error NodeColumns::not_insertable(const HistoryFile& file, std::uint32_t node) const {
  const delaunay::LatticePoint p = point_of(node);
  return fail(
      "{}: node {}: expected column {}, row {} in a triangle of its time that it can be inserted "
      "into",
      file.path(), times[node], p.x, p.y);
}

Result<NodeColumns> NodeColumns::read(const HistoryFile& file, std::size_t n_bands,
                                      Progress& progress) {
  const auto bands = file.bands().first(n_bands);
  const std::uint32_t n_nodes = bands.empty() ? 0 : bands.back().end;
  NodeColumns columns;
  columns.n_base = file.base().n_base_vertices;
  columns.points = file.base().vertices;
  columns.heights = file.base().heights;
  columns.points.reserve(std::size_t{columns.n_base} + n_nodes);
  columns.heights.reserve(std::size_t{columns.n_base} + n_nodes);
  columns.times.reserve(n_nodes);
  columns.n_made.reserve(n_nodes);
  columns.first_error.reserve(n_nodes);
  columns.begins_later.reserve(n_nodes);
  std::vector<bool> is_there(n_nodes);
  for (const Band& band : bands)
    for (std::uint32_t page = band.first_page; page < band.first_page + band.n_pages; ++page) {
      if (progress.is_cancelled()) return cancelled_error();
      const std::uint32_t n_pages = bands.back().first_page + bands.back().n_pages;
      progress.report("reading", static_cast<double>(page) / static_cast<double>(n_pages));
      LODE_CHECK(read_page(file, page, is_there, columns));
    }
  return columns;
}

}  // namespace lode::insertions

#include "lode/models/terrain/insertions/page_plan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lode/models/terrain/insertions/box_tree.h"
#include "lode/models/terrain/insertions/overlap.h"

namespace lode::insertions {
namespace {

/// Levels closer than that share a band, and bands are not wider than the other.
constexpr double kNarrowBand = 1.25;
constexpr double kWideBand = 2.5;

std::vector<std::uint32_t> band_ends(std::uint32_t n_nodes, std::span<const std::uint32_t> times,
                                     std::uint32_t first_band) {
  std::vector<std::uint32_t> wanted(times.begin(), times.end());
  std::ranges::sort(wanted);
  wanted.push_back(n_nodes);
  std::vector<std::uint32_t> ends;
  std::uint32_t last = 0;
  for (const std::uint32_t end : wanted) {
    const bool is_last = end == n_nodes;
    if (end <= last ||
        (!is_last && end < std::max(kNarrowBand * last, static_cast<double>(first_band))))
      continue;
    const double start = std::max(last, first_band);
    const double ratio = end / start;
    const int n = ratio > kWideBand ? static_cast<int>(std::ceil(std::log2(ratio))) : 1;
    for (int k = last < first_band ? 0 : 1; k < n; ++k) {
      const auto between = static_cast<std::uint32_t>(start * std::pow(ratio, k / double(n)));
      if (between > last && between < end) ends.push_back(last = between);
    }
    ends.push_back(last = end);
  }
  return ends;
}

/// Puts the nodes of pages together.
class Divider {
 public:
  Divider(const History& history, PagePlan& plan) : history_(history), plan_(plan) {}

  void divide(std::span<std::uint32_t> nodes, std::size_t n_pages) {
    if (n_pages == 1) {
      std::ranges::sort(nodes);
      plan_.nodes.insert(plan_.nodes.end(), nodes.begin(), nodes.end());
      plan_.first_node.push_back(static_cast<std::uint32_t>(plan_.nodes.size()));
      return;
    }
    LatticeBox box;
    for (const std::uint32_t node : nodes) box.add(place(node));
    const bool is_wide =
        std::int64_t{box.upper.x} - box.lower.x >= std::int64_t{box.upper.y} - box.lower.y;
    const std::size_t n_left = n_pages / 2;
    const std::size_t middle = nodes.size() * n_left / n_pages;
    std::ranges::nth_element(
        nodes, nodes.begin() + static_cast<std::ptrdiff_t>(middle), {}, [&](std::uint32_t node) {
          const delaunay::LatticePoint p = place(node);
          return is_wide ? std::tuple(p.x, p.y, node) : std::tuple(p.y, p.x, node);
        });
    divide(nodes.first(middle), n_left);
    divide(nodes.subspan(middle), n_pages - n_left);
  }

 private:
  [[nodiscard]] delaunay::LatticePoint place(std::uint32_t node) const {
    return history_.vertices[history_.vertex_of(node)];
  }

  const History& history_;
  PagePlan& plan_;
};

/// Of the triangles that the node's vertex lies in, whether removing begins with the later one.
bool begins_later(const History& history, std::uint32_t node) {
  const delaunay::LatticePoint p = history.vertices[history.vertex_of(node)];
  const std::uint32_t first = history.removed_by(node).front();
  return std::ranges::any_of(history.removed_by(node), [&](std::uint32_t t) {
    const auto& corner = history.triangles[t].corner;
    return t < first && holds({history.vertices[corner[0]], history.vertices[corner[1]],
                               history.vertices[corner[2]]},
                              p);
  });
}

}  // namespace

PagePlan plan_pages(const History& history, std::span<const std::uint32_t> times,
                    std::uint32_t n_page_nodes) {
  PagePlan plan;
  plan.first_node.push_back(0);
  Divider divider(history, plan);
  std::uint32_t begin = 0;
  for (const std::uint32_t end : band_ends(history.n_nodes(), times, n_page_nodes)) {
    std::vector<std::uint32_t> nodes(end - begin);
    for (std::uint32_t i = 0; i < nodes.size(); ++i) nodes[i] = begin + i;
    const std::uint32_t n_pages = (end - begin + n_page_nodes - 1) / n_page_nodes;
    plan.bands.push_back(
        {begin, end, static_cast<std::uint32_t>(plan.first_node.size() - 1), n_pages});
    divider.divide(nodes, n_pages);
    begin = end;
  }
  return plan;
}

PageNodes page_nodes(const History& history, std::span<const std::uint32_t> nodes) {
  PageNodes page;
  page.first_made.push_back(0);
  for (const std::uint32_t node : nodes) {
    page.times.push_back(node);
    page.points.push_back(history.vertices[history.vertex_of(node)]);
    page.heights.push_back(history.heights[history.vertex_of(node)]);
    page.first_made.push_back(page.first_made.back() + history.first_made[node + 1] -
                              history.first_made[node]);
    page.begins_later.push_back(begins_later(history, node));
  }
  return page;
}

PageEntry page_entry(const PageNodes& nodes) {
  LatticeBox box;
  for (const delaunay::LatticePoint& p : nodes.points) box.add(p);
  return {box.lower, box.upper, static_cast<std::uint32_t>(nodes.points.size()),
          nodes.first_made.back()};
}

}  // namespace lode::insertions

#include "lode/models/terrain/insertions/death_finder.h"

#include <algorithm>
#include <optional>

#include "lode/models/terrain/insertions/reach.h"

namespace lode::insertions {

Result<FileNode> DeathFinder::find(const LatticeCorners& triangle, std::uint32_t begin,
                                   std::uint32_t end) {
  const HistoryFile& file = pages_.file();
  const delaunay::InsertionRule rule = rule_of(file.base().model);
  const Reach reach(triangle, rule);
  const auto bands = file.bands();
  for (auto band = std::ranges::upper_bound(bands, begin, {}, &Band::end);
       band != bands.end() && band->begin < end; ++band) {
    FileNode first;
    std::optional<Error> error;
    const auto look = [&](std::uint32_t i) {
      const std::uint32_t number = band->first_page + i;
      const auto page = pages_.page(number);
      if (!page) {
        error = page.error();
        return false;
      }
      const PageNodes& nodes = (*page)->nodes();
      (*page)->for_each_near(reach.box(), [&](std::uint32_t at) {
        const FileNode node{nodes.times[at], number, at};
        if (node.time < begin || node.time >= end || node > first || !reach.has(nodes.points[at]))
          return;
        if (rule == delaunay::InsertionRule::delaunay && edges_.hide(triangle, nodes.points[at]))
          return;
        first = node;
      });
      return true;
    };
    file.boxes_of(static_cast<std::size_t>(band - bands.begin()))
        .for_each([&](const LatticeBox& box) { return reach.may_meet(box); }, look);
    if (error) return *error;
    if (first.time != kNone) return first;
  }
  return FileNode{};
}

}  // namespace lode::insertions

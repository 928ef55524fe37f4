#include "lode/models/tetra_mt/page_tree.h"

namespace lode::tetra_mt {
namespace {

constexpr std::uint16_t kNobody = 0xFFFF;

}  // namespace

PageTree PageTree::of(const PageContent& content, std::uint32_t number) {
  PageTree tree;
  const auto n = static_cast<std::uint32_t>(content.n_discovered.size());
  for (std::uint32_t i = 0; i < n; ++i) {
    tree.n_others.push_back(0);
    for (const std::uint32_t child : content.children[i].first(content.n_discovered[i]))
      tree.add(child, number, n);
    tree.found.end_list();
  }
  tree.find_order();
  return tree;
}

PageTree PageTree::of(const NodePage& page, std::uint32_t number, std::uint32_t n) {
  PageTree tree;
  for (std::uint32_t i = 0; i < n; ++i) {
    tree.n_others.push_back(0);
    auto links = page.links(i);
    for (std::uint32_t k = 0; k < links.n_discovered(); ++k) tree.add(links.next_node(), number, n);
    tree.found.end_list();
  }
  tree.find_order();
  return tree;
}

void PageTree::add(std::uint32_t child, std::uint32_t number, std::uint32_t n) {
  const std::uint32_t place = child - number * kPageNodes;
  if (place < n)
    found.items.push_back(static_cast<std::uint16_t>(place));
  else
    ++n_others.back();
}

/// Those that discover none of the page, ascending; after each, who discovers it where it was the
/// last one that was waited for.
void PageTree::find_order() {
  const std::uint32_t n = n_nodes();
  std::vector<std::uint16_t> n_waiting(n);
  std::vector<std::uint16_t> discoverers(n, kNobody);
  order.reserve(n);
  bool is_tree = true;
  for (std::uint32_t i = 0; i < n; ++i) {
    n_waiting[i] = static_cast<std::uint16_t>(found[i].size());
    if (n_waiting[i] == 0) order.push_back(static_cast<std::uint16_t>(i));
    for (const std::uint16_t child : found[i]) {
      is_tree = is_tree && discoverers[child] == kNobody;
      discoverers[child] = static_cast<std::uint16_t>(i);
    }
  }
  if (!is_tree) order.clear();
  for (std::size_t at = 0; at < order.size(); ++at) {
    const std::uint16_t i = discoverers[order[at]];
    if (i != kNobody && --n_waiting[i] == 0) order.push_back(i);
  }
}

}  // namespace lode::tetra_mt

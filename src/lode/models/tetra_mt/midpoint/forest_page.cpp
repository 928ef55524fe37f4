#include "lode/models/tetra_mt/midpoint/forest_page.h"

#include <algorithm>

namespace lode::tetra_mt::midpoint {

namespace {

/// Of a page's leaves.
template <typename Offset>
LeafOffsets<Offset> exact_of(const LeafOffsets<Offset>& all, const PageTable& table,
                             std::uint32_t page) {
  LeafOffsets<Offset> found;
  const auto leaves = all.leaves();
  auto at = std::ranges::lower_bound(leaves, table.first_leaf(page));
  for (; at != leaves.end() && *at < table.first_leaf(page + 1); ++at)
    found.add(*at, *all.find(*at));
  return found;
}

}  // namespace

ForestContent content_of(const Hierarchy& hierarchy, std::uint32_t page) {
  ForestContent content;
  content.levels = hierarchy.page_levels[page];
  const auto is_far = [&](std::uint32_t label) {
    return hierarchy.pages.locate(label - hierarchy.n_vertices).page != page;
  };
  const std::uint32_t n = hierarchy.pages.n_nodes_of(page);
  for (std::uint32_t place = 0; place < n; ++place) {
    const std::uint32_t node = hierarchy.pages.node_at(page, place);
    content.records.push_back(hierarchy.nodes[node]);
    content.parents.push_back(hierarchy.parent(hierarchy.n_vertices + node));
    if (content.parents.back() == kNone || is_far(content.parents.back()))
      content.records.back().facts = 0;
    content.children.push_back(hierarchy.children(node));
    const auto facts_of = [&](std::uint32_t child) {
      const bool has_facts = !hierarchy.is_leaf(child) && is_far(child);
      return has_facts ? hierarchy.nodes[child - hierarchy.n_vertices].facts : 0;
    };
    const auto [first, second] = content.children.back();
    content.far_facts.push_back({facts_of(first), facts_of(second)});
    const auto regions = hierarchy.regions_of(node);
    content.regions.items.insert(content.regions.items.end(), regions.begin(), regions.end());
    content.regions.end_list();
  }
  content.exact = exact_of(hierarchy.exact, hierarchy.pages, page);
  return content;
}

FieldPage field_page_of(const ForestHead& head, const ForestPage& nodes, const FurtherField& field,
                        std::uint32_t page) {
  FieldPage made;
  const auto facts_of = [&](std::uint32_t child) {
    return head.is_leaf(child) ? 0 : field.nodes[child - head.n_vertices].facts();
  };
  for (std::uint32_t place = 0; place < head.pages.n_nodes_of(page); ++place) {
    const FieldRecord& record = field.nodes[head.pages.node_at(page, place)];
    const auto [first, second] = nodes.children(place);
    made.nodes.push_back({record.difference, record.place(), {facts_of(first), facts_of(second)}});
  }
  made.exact = exact_of(field.exact, head.pages, page);
  return made;
}

ForestPage::ForestPage(const ForestContent& content, const PageTable& table, std::uint32_t page,
                       std::uint32_t n_vertices)
    : records_(content.records),
      biases_(table.biases_of(page)),
      n_vertices_(n_vertices),
      first_leaf_(table.first_leaf(page)),
      exact_(content.exact) {
  std::uint32_t n_groups = 0;
  for (const std::uint16_t end : table.ends_of(page))
    groups_.resize(end, static_cast<std::uint8_t>(n_groups++));
  const auto is_near = [&](std::uint32_t label) {
    return label != kNone && table.locate(label - n_vertices).page == page;
  };
  const auto place_of = [&](std::uint32_t label) {
    return static_cast<Link>(table.locate(label - n_vertices).place);
  };
  const auto link_to = [&](std::uint32_t label, std::uint32_t facts) -> Link {
    if (label < n_vertices) return static_cast<Link>(kFirstLeaf + (label - first_leaf_));
    if (is_near(label)) return place_of(label);
    far_.push_back({label, facts});
    return static_cast<Link>(kFirstFar + far_.size() - 1);
  };
  for (std::uint32_t i = 0; i < content.n_nodes(); ++i) {
    const Link first = link_to(content.children[i].first, content.far_facts[i][0]);
    const Link second = link_to(content.children[i].second, content.far_facts[i][1]);
    Link parent = static_cast<Link>(kFirstLeaf + far_parents_.size());
    if (is_near(content.parents[i]))
      parent = place_of(content.parents[i]);
    else
      far_parents_.push_back(content.parents[i]);
    links_.push_back({first, second, parent});
    if (content.regions[i].empty()) continue;
    mixed_.push_back(i);
    regions_.items.insert(regions_.items.end(), content.regions[i].begin(),
                          content.regions[i].end());
    regions_.end_list();
  }
  far_.shrink_to_fit();
  far_parents_.shrink_to_fit();
}

std::span<const std::uint32_t> ForestPage::regions(std::uint32_t place) const {
  const auto at = std::ranges::lower_bound(mixed_, place);
  if (at == mixed_.end() || *at != place) return {};
  return regions_[static_cast<std::size_t>(at - mixed_.begin())];
}

std::size_t ForestPage::n_bytes() const {
  return sizeof *this + records_.size() * sizeof(NodeRecord) + links_.size() * sizeof(Links) +
         groups_.size() + far_.size() * sizeof(Far) + exact_.n_bytes() +
         (far_parents_.size() + mixed_.size() + regions_.begins.size() + regions_.items.size()) *
             sizeof(std::uint32_t);
}

}  // namespace lode::tetra_mt::midpoint

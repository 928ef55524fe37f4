#include "lode/models/tetra_mt/structure_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "lode/models/tetra_mt/tetra_cut.h"

namespace lode::tetra_mt {
namespace {

using NodeLists = Lists<std::uint32_t>;

/// Of all nodes, as their pages have them.
struct NodeLinks {
  NodeLists children;
  std::vector<std::uint32_t> n_discovered;  ///< The first of them.
  NodeLists parents;

  explicit NodeLinks(const PackedHierarchy& hierarchy) {
    for (std::uint32_t node = 0; node < hierarchy.head().shape.n_nodes; ++node) {
      NodePage::Links links = hierarchy.links(node);
      n_discovered.push_back(links.n_discovered());
      for (std::uint32_t k = links.n_children(); k > 0; --k)
        children.items.push_back(links.next_node());
      for (std::uint32_t k = links.n_parents(); k > 0; --k)
        parents.items.push_back(links.next_node());
      children.end_list();
      parents.end_list();
    }
  }
  [[nodiscard]] std::span<const std::uint32_t> discovered(std::uint32_t node) const {
    return children[node].first(n_discovered[node]);
  }
};

StructureFinding check_discovery(const PackedHierarchy& hierarchy, const NodeLinks& links) {
  const std::uint32_t n_nodes = hierarchy.head().shape.n_nodes;
  std::vector<std::uint32_t> times(n_nodes, 0);
  for (const std::uint32_t root : hierarchy.head().roots) ++times[root];
  for (std::uint32_t node = 0; node < n_nodes; ++node)
    for (const std::uint32_t child : links.discovered(node)) ++times[child];
  // Once each, it is a forest, or has circles that the roots do not reach.
  std::vector<std::uint32_t> open = hierarchy.head().roots;
  std::vector<bool> is_reached(n_nodes, false);
  while (!open.empty()) {
    const std::uint32_t node = open.back();
    open.pop_back();
    if (is_reached[node]) continue;
    is_reached[node] = true;
    for (const std::uint32_t child : links.discovered(node)) open.push_back(child);
  }
  StructureFinding finding;
  for (std::uint32_t node = 0; node < n_nodes; ++node)
    finding.add(times[node] == 1 && is_reached[node],
                fmt::format("node {}: expected to be discovered once from the roots, {} name it{}",
                            node, times[node], is_reached[node] ? "" : ", out of their reach"));
  return finding;
}

/// Whose lists have each node.
NodeLists reversed(const NodeLists& lists, std::uint32_t n_nodes) {
  NodeLists result;
  result.begins.assign(std::size_t{n_nodes} + 1, 0);
  for (const std::uint32_t node : lists.items) ++result.begins[node + std::size_t{1}];
  for (std::size_t i = 1; i <= n_nodes; ++i) result.begins[i] += result.begins[i - 1];
  result.items.resize(lists.items.size());
  std::vector<std::uint32_t> next(result.begins.begin(), result.begins.end() - 1);
  for (std::uint32_t node = 0; node < n_nodes; ++node)
    for (const std::uint32_t other : lists[node]) result.items[next[other]++] = node;
  return result;
}

StructureFinding check_links(const PackedHierarchy& hierarchy, const NodeLinks& links) {
  const HierarchyHead& head = hierarchy.head();
  const NodeLists expected = reversed(links.parents, head.shape.n_nodes);
  StructureFinding finding;
  for (std::uint32_t node = 0; node < head.shape.n_nodes; ++node) {
    std::vector<std::uint32_t> children(links.children[node].begin(), links.children[node].end());
    std::ranges::sort(children);
    finding.add(std::ranges::equal(children, expected[node]),
                fmt::format("node {}: expected the {} children that have it as a parent, got {}",
                            node, expected[node].size(), children.size()));
    const bool is_root = std::ranges::binary_search(head.roots, node);
    if (is_root != links.parents[node].empty())
      finding.add(false, fmt::format("node {}: has {} parents, and is {} root", node,
                                     links.parents[node].size(), is_root ? "a" : "no"));
  }
  return finding;
}

StructureFinding check_nesting(const PackedHierarchy& hierarchy, const NodeLinks& links) {
  const HierarchyHead& head = hierarchy.head();
  StructureFinding finding;
  for (std::uint32_t node = 0; node < head.shape.n_nodes; ++node)
    for (const std::uint32_t child : links.discovered(node)) {
      bool is_nested = hierarchy.bounds(node).contains(hierarchy.bounds(child));
      for (std::size_t f = 0; f < head.fields.size(); ++f) {
        const StoredFacts outer = hierarchy.facts(node, f);
        const StoredFacts inner = hierarchy.facts(child, f);
        is_nested = is_nested && inner.error <= outer.error && outer.low <= inner.low &&
                    inner.high <= outer.high &&
                    hierarchy.world_error(child, f) <= hierarchy.world_error(node, f);
      }
      finding.add(is_nested,
                  fmt::format("node {}: holds less than node {}, which it discovers", node, child));
    }
  return finding;
}

/// An order in which each node comes after those of its list in `before`, at random: shorter than
/// all nodes where these wait for one another. `after`: the reversed lists.
std::vector<std::uint32_t> random_order(const NodeLists& before, const NodeLists& after,
                                        std::uint32_t n_nodes, std::mt19937_64& random) {
  std::vector<std::size_t> n_missing(n_nodes);
  std::vector<std::uint32_t> ready;
  for (std::uint32_t node = 0; node < n_nodes; ++node) {
    n_missing[node] = before[node].size();
    if (n_missing[node] == 0) ready.push_back(node);
  }
  std::vector<std::uint32_t> order;
  while (!ready.empty()) {
    std::swap(ready[random() % ready.size()], ready.back());
    order.push_back(ready.back());
    ready.pop_back();
    for (const std::uint32_t next : after[order.back()])
      if (--n_missing[next] == 0) ready.push_back(next);
  }
  return order;
}

/// `brought`: by node, fills which regions its tetrahedra have; empty where nobody asks.
Result<StructureFinding> check_refinement(const PackedHierarchy& hierarchy, const NodeLinks& links,
                                          std::mt19937_64& random,
                                          std::vector<std::uint64_t>& brought, Progress& progress) {
  const HierarchyHead& head = hierarchy.head();
  const std::uint32_t n_nodes = head.shape.n_nodes;
  StructureFinding finding;
  TetraCut cut(hierarchy);
  const std::vector<Tetrahedron> base = sorted_cells(cut.cells());
  finding.add(base.size() == head.n_base_cells,
              fmt::format("base: {} cells, {} are there", head.n_base_cells, base.size()));
  const auto up = random_order(links.parents, links.children, n_nodes, random);
  const auto down = random_order(links.children, links.parents, n_nodes, random);
  finding.add(up.size() == n_nodes,
              fmt::format("{} of {} nodes wait for one another", n_nodes - up.size(), n_nodes));
  if (finding.n_wrong > 0) return finding;
  std::uint64_t n_cells = head.n_base_cells;
  for (std::size_t i = 0; i < up.size() && !cut.is_damaged(); ++i) {
    if (i % 4096 == 0 && progress.is_cancelled()) return cancelled_error();
    n_cells += cut.apply(NodeId{up[i]});
    if (!brought.empty()) brought[up[i]] = cut.regions_brought();
    finding.add(!cut.is_damaged(),
                fmt::format("node {}: expected to replace tetrahedra, its target has none", up[i]));
  }
  if (cut.is_damaged()) return finding;
  finding.add(n_cells == head.n_cells && cut.cells().size() == n_cells,
              fmt::format("all nodes: expected {} cells, got {}", head.n_cells, n_cells));
  for (const std::uint32_t node : down) cut.undo(NodeId{node});
  finding.add(sorted_cells(cut.cells()) == base,
              "all nodes undone: expected the base, got other cells");
  return finding;
}

/// `brought`: by node.
StructureFinding check_regions(const PackedHierarchy& hierarchy, const NodeLinks& links,
                               std::span<const std::uint64_t> brought) {
  StructureFinding finding;
  for (std::uint32_t node = 0; node < brought.size(); ++node) {
    std::uint64_t expected = brought[node];
    for (const std::uint32_t child : links.discovered(node))
      expected |= hierarchy.region_mask(child);
    const std::uint64_t mask = hierarchy.region_mask(node);
    finding.add(mask == expected, fmt::format("node {}: expected the regions {:#x}, got {:#x}",
                                              node, expected, mask));
  }
  return finding;
}

}  // namespace

std::vector<Tetrahedron> sorted_cells(std::vector<Tetrahedron> cells) {
  for (Tetrahedron& t : cells) {
    bool is_odd = false;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t k = 0; k + 1 < 4; ++k)
        if (t[k] > t[k + 1]) {
          std::swap(t[k], t[k + 1]);
          is_odd = !is_odd;
        }
    if (is_odd) std::swap(t[2], t[3]);
  }
  std::ranges::sort(cells);
  return cells;
}

Result<StructureFindings> check_structure(const PackedHierarchy& hierarchy, std::uint64_t seed,
                                          Progress& progress) {
  progress.report("checking nodes", 0);
  const NodeLinks links(hierarchy);
  LODE_CHECK(hierarchy.check());
  StructureFindings findings;
  findings.discovery = check_discovery(hierarchy, links);
  findings.links = check_links(hierarchy, links);
  findings.nesting = check_nesting(hierarchy, links);
  if (progress.is_cancelled()) return cancelled_error();
  progress.report("checking nodes", 0.3);
  std::mt19937_64 random(seed);
  if (findings.discovery.n_wrong + findings.links.n_wrong == 0) {
    const bool has_masks = hierarchy.head().shape.n_regions > 1;
    std::vector<std::uint64_t> brought(has_masks ? links.n_discovered.size() : 0);
    LODE_TRY(findings.refinement, check_refinement(hierarchy, links, random, brought, progress));
    if (findings.refinement.n_wrong == 0)
      findings.regions = check_regions(hierarchy, links, brought);
  }
  return findings;
}

}  // namespace lode::tetra_mt

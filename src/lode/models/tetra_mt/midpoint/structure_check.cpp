#include "lode/models/tetra_mt/midpoint/structure_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"
#include "lode/models/tetra_mt/random_cut.h"

namespace lode::tetra_mt::midpoint {
namespace {

/// By label: how often it is a root or comes of a split.
StructureFinding check_trees(const Forest& forest) {
  const ForestHead& head = forest.head();
  std::vector<std::uint32_t> times(head.n_labels(), 0);
  for (const std::uint32_t root : head.roots) ++times[root];
  for (std::uint32_t node = 0; node < head.n_nodes(); ++node) {
    const auto [first, second] = forest.children(node);
    for (const std::uint32_t child : {first, second})
      if (child != kNone) ++times[child];
  }
  StructureFinding finding;
  for (std::uint32_t label = 0; label < times.size(); ++label)
    finding.add(times[label] == 1, fmt::format("vertex {}: comes {} times", label, times[label]));
  return finding;
}

StructureFinding check_parents(const Forest& forest) {
  const ForestHead& head = forest.head();
  StructureFinding finding;
  for (const std::uint32_t root : head.roots)
    if (!head.is_leaf(root))
      finding.add(forest.parent(root - head.n_vertices) == kNone,
                  fmt::format("vertex {}: is a root, and has a parent", root));
  for (std::uint32_t node = 0; node < head.n_nodes(); ++node) {
    const auto [first, second] = forest.children(node);
    for (const std::uint32_t child : {first, second})
      if (child != kNone && !head.is_leaf(child)) {
        const std::uint32_t parent = forest.parent(child - head.n_vertices);
        finding.add(parent == head.n_vertices + node,
                    fmt::format("vertex {}: comes of {}, and has {} for its parent", child,
                                head.n_vertices + node, parent));
      }
  }
  return finding;
}

/// Bounds of nodes, found from the base down.
std::vector<Bounds> bounds_of_nodes(const Forest& forest) {
  const ForestHead& head = forest.head();
  std::vector<Code> codes(head.n_labels());
  for (std::size_t i = 0; i < head.roots.size(); ++i) codes[head.roots[i]] = head.root_codes[i];
  std::vector<Bounds> bounds(head.n_nodes());
  for (std::uint32_t node = head.n_nodes(); node-- > 0;) {
    const Split split = forest.split(node);
    const Code& code = codes[head.n_vertices + node];
    bounds[node] = {head.scales.position(code),
                    head.radii.radius(NodeCodes::parts(forest.facts(node)).radius)};
    if (split.children.first == kNone) continue;
    const Ends ends = parted(code, split.difference, split.placement);
    codes[split.children.first] = ends.first;
    codes[split.children.second] = ends.second;
  }
  return bounds;
}

/// Of all fields.
StructureFinding check_nested(const Forest& forest) {
  const ForestHead& head = forest.head();
  const std::vector<Bounds> bounds = bounds_of_nodes(forest);
  StructureFinding finding;
  for (std::size_t field = 0; field < head.fields.size(); ++field)
    for (std::uint32_t node = 0; node < head.n_nodes(); ++node) {
      const NodeCodes::Parts outer = NodeCodes::parts(forest.facts(node, field));
      const auto [first, second] = forest.children(node);
      for (const std::uint32_t child : {first, second}) {
        if (child == kNone || head.is_leaf(child)) continue;
        const std::uint32_t there = child - head.n_vertices;
        const NodeCodes::Parts inner = NodeCodes::parts(forest.facts(there, field));
        finding.add(inner.error <= outer.error && outer.low <= inner.low &&
                        inner.high <= outer.high && bounds[node].contains(bounds[there]) &&
                        forest.world_error(there, field) <= forest.world_error(node, field),
                    fmt::format("node {}: holds less of {} than node {}, which it splits into",
                                node, head.fields[field].name, there));
      }
    }
  return finding;
}

/// What each node needs, as the cut says once it may be applied.
struct Needs {
  std::vector<std::vector<std::uint32_t>> parents;
  std::vector<std::uint32_t> n_dependents;
};

/// Applies all nodes in a random order, and looks whether their balls hold what they change.
std::uint64_t apply_all(MidpointCut& cut, const Forest& forest, std::mt19937_64& random,
                        Needs& needs, StructureFindings& findings) {
  const std::uint32_t n_nodes = cut.head().n_nodes();
  std::vector<std::uint32_t> order(n_nodes);
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::shuffle(order, random);
  std::uint64_t n_cells = cut.n_base_cells();
  std::vector<bool> is_applied(n_nodes, false);
  needs.parents.resize(n_nodes);
  needs.n_dependents.assign(n_nodes, 0);
  /// A cut that notes what is done to it.
  struct Noting {
    MidpointCut& cut;
    const Forest& forest;
    Needs& needs;
    StructureFindings& findings;
    std::uint64_t& n_cells;
    [[nodiscard]] bool is_damaged() const { return cut.is_damaged(); }
    void add_parents(NodeId node, std::vector<NodeId>& out) const { cut.add_parents(node, out); }
    void apply(NodeId node) {
      std::vector<NodeId> parents;
      cut.add_parents(node, parents);
      for (const NodeId parent : parents) {
        needs.parents[static_cast<std::size_t>(node)].push_back(static_cast<std::uint32_t>(parent));
        ++needs.n_dependents[static_cast<std::size_t>(parent)];
      }
      const Bounds bounds = cut.bounds(node);
      const std::uint64_t regions = cut.region_mask(node);
      n_cells += cut.apply(node);
      if (cut.is_damaged()) return;
      const auto number = static_cast<std::uint32_t>(node);
      const auto [first, second] = forest.children(number);
      findings.refinement.add(
          cut.is_star_within(first, bounds) && cut.is_star_within(second, bounds),
          fmt::format("node {}: changes more than its ball holds", number));
      if (cut.head().region_ids.size() <= 1) return;
      const std::uint64_t below = cut.regions_round(first) | cut.regions_round(second);
      findings.regions.add(below == regions,
                           fmt::format("node {}: has the regions {:#x}, and both its ends {:#x}",
                                       number, regions, below));
    }
  };
  Noting noting{cut, forest, needs, findings, n_cells};
  for (const std::uint32_t node : order) {
    if (cut.is_damaged()) break;
    apply_after_parents(NodeId{node}, noting, is_applied);
  }
  return n_cells;
}

void undo_all(MidpointCut& cut, std::mt19937_64& random, Needs& needs) {
  std::vector<std::uint32_t> ready;
  for (std::uint32_t node = 0; node < needs.n_dependents.size(); ++node)
    if (needs.n_dependents[node] == 0) ready.push_back(node);
  while (!ready.empty() && !cut.is_damaged()) {
    std::swap(ready[random() % ready.size()], ready.back());
    const std::uint32_t node = ready.back();
    ready.pop_back();
    cut.undo(NodeId{node});
    for (const std::uint32_t parent : needs.parents[node])
      if (--needs.n_dependents[parent] == 0) ready.push_back(parent);
  }
}

void check_splits(const Forest& forest, std::mt19937_64& random, StructureFindings& findings) {
  const ForestHead& head = forest.head();
  StructureFinding& finding = findings.refinement;
  MidpointCut cut(forest);
  const auto base = sorted_cells(cut.cells());
  finding.add(base.size() == head.n_base_cells,
              fmt::format("base: {} cells, {} are there", head.n_base_cells, base.size()));
  Needs needs;
  const std::uint64_t n_cells = apply_all(cut, forest, random, needs, findings);
  const auto all = cut.check();
  finding.add(all.has_value(), all ? "" : "all nodes: " + all.error().message);
  finding.add(n_cells == head.n_cells && cut.cells().size() == n_cells,
              fmt::format("all nodes: expected {} cells, got {}", head.n_cells, n_cells));
  if (finding.n_wrong > 0) return;
  undo_all(cut, random, needs);
  finding.add(cut.check().has_value() && sorted_cells(cut.cells()) == base,
              "all nodes undone: expected the base, got other cells");
}

}  // namespace

Result<StructureFindings> check_structure(const Forest& forest, std::uint64_t seed,
                                          Progress& progress) {
  progress.report("checking nodes", 0);
  StructureFindings findings;
  findings.discovery = check_trees(forest);
  findings.links = check_parents(forest);
  LODE_CHECK(forest.check());
  findings.nesting = check_nested(forest);
  if (progress.is_cancelled()) return cancelled_error();
  progress.report("checking nodes", 0.3);
  std::mt19937_64 random(seed);
  if (findings.discovery.n_wrong + findings.links.n_wrong == 0)
    check_splits(forest, random, findings);
  LODE_CHECK(forest.check());
  return findings;
}

}  // namespace lode::tetra_mt::midpoint

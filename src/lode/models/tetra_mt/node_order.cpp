#include "lode/models/tetra_mt/node_order.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <span>

#include "lode/models/tetra_mt/space_curve.h"

namespace lode::tetra_mt {
namespace {

/// Of the node that comes at a place in the order of refinement; higher bands come first. The last
/// seven eighths are one, as links from band to band take more than others; before these each has
/// half of what is left, so that a tolerance asks for little more than it looks at.
std::uint32_t band_of(std::size_t place, std::size_t n_nodes) {
  constexpr std::size_t kSmallest = 2048;
  std::uint32_t band = 0;
  for (std::size_t end = n_nodes / 8; place < end; end /= 2) {
    ++band;
    if (end <= kSmallest) break;
  }
  return band;
}

/// One by the range of each of the mesh's fields.
std::vector<double> weights_of(const TetraMesh& mesh) {
  std::vector<double> weights;
  if (mesh.positions.empty()) return weights;
  for (const MeshField& field : mesh.fields) {
    const auto [low, high] = std::ranges::minmax(field.values);
    weights.push_back(high > low ? 1 / (high - low) : 0);
  }
  return weights;
}

/// By collapse, the tolerance below which a query of the whole domain looks at its node: one is
/// applied then that brings a tetrahedron which waits for it. Of one that the base waits for the
/// tolerance below which it is applied, as what it is asked for before lies with the base. Shares
/// of ranges; of several fields the largest.
std::vector<float> find_tolerances(const TetraMesh& mesh, const HalfEdgeCollapses& half_edges) {
  const std::vector<double> weights = weights_of(mesh);
  // By vertex. A node is applied for all that waits for it, whoever discovers that.
  std::vector<float> applied(mesh.positions.size(), 0);
  std::vector<float> looked_at(mesh.positions.size(), 0);
  std::size_t i = 0;
  for (const CollapseStars& stars : half_edges.stars) {
    std::size_t child = 0;
    for (const CollapseStars::Size& size : stars.sizes) {
      float& here = applied[half_edges.collapses[i].removed];
      for (std::size_t f = 0; f < weights.size(); ++f) {
        const double error = half_edges.facts[i * weights.size() + f].error;
        here = std::max(here, static_cast<float>(error * weights[f]));
      }
      const auto children = std::span(stars.children).subspan(child, size.n_children);
      for (const std::uint32_t v : children) here = std::max(here, applied[v]);
      for (const std::uint32_t v : children) looked_at[v] = std::max(looked_at[v], here);
      child += size.n_children;
      ++i;
    }
  }
  const auto look_at_front = [&](std::uint32_t vertex) {
    if (vertex != kNone) looked_at[vertex] = std::max(looked_at[vertex], applied[vertex]);
  };
  for (const std::uint32_t maker : half_edges.base_makers) look_at_front(maker);
  for (const OuterTetrahedron& t : half_edges.outer_base) look_at_front(t.maker);
  std::vector<float> tolerances;
  tolerances.reserve(i);
  for (const Collapse& c : half_edges.collapses) tolerances.push_back(looked_at[c.removed]);
  return tolerances;
}

/// By collapse.
std::vector<std::uint32_t> find_bands(const std::vector<float>& tolerances) {
  const std::size_t n = tolerances.size();
  std::vector<std::uint32_t> order(n);
  std::iota(order.rbegin(), order.rend(), 0U);  // where tolerances are the same, the last first
  std::ranges::stable_sort(order, std::greater(), [&](std::uint32_t i) { return tolerances[i]; });
  std::vector<std::uint32_t> bands(n);
  for (std::size_t place = 0; place < n; ++place) bands[order[place]] = band_of(place, n);
  return bands;
}

}  // namespace

NodeOrder order_nodes(const TetraMesh& mesh, const HalfEdgeCollapses& half_edges) {
  const std::vector<Collapse>& collapses = half_edges.collapses;
  const SpaceCurve curve(mesh.positions);
  std::vector<std::uint8_t> is_base(mesh.positions.size(), 0);
  for (const auto& t : mesh.tetrahedra)
    for (const std::uint32_t v : t) is_base[v] = 1;
  for (const Collapse& c : collapses) is_base[c.removed] = 0;
  struct Keyed {
    std::uint32_t band;
    std::uint64_t key;
    std::uint32_t index;
    auto operator<=>(const Keyed&) const = default;
  };
  std::vector<Keyed> keyed;
  for (std::uint32_t v = 0; v < is_base.size(); ++v)
    if (is_base[v] != 0) keyed.push_back({0, curve(mesh.positions[v]), v});
  std::ranges::sort(keyed);
  NodeOrder order;
  for (const Keyed& k : keyed) order.base_vertices.push_back(k.index);

  keyed.clear();
  const std::size_t n = collapses.size();
  const std::vector<std::uint32_t> bands = find_bands(find_tolerances(mesh, half_edges));
  for (std::uint32_t i = 0; i < n; ++i)
    keyed.push_back({~bands[i], curve(mesh.positions[collapses[i].removed]), i});
  std::ranges::sort(keyed);
  order.nodes.resize(n);
  for (std::uint32_t node = 0; node < n; ++node) order.nodes[keyed[node].index] = node;
  return order;
}

}  // namespace lode::tetra_mt

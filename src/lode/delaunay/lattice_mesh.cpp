// Incremental Delaunay triangulation: A. Bowyer, "Computing Dirichlet tessellations", and D. F.
// Watson, "Computing the n-dimensional Delaunay tessellation", both Computer Journal 24 (2), 1981.
#include "lode/delaunay/lattice_mesh.h"

#include <algorithm>
#include <tuple>

#include "lode/core/expects.h"
#include "lode/core/uninitialized_array.h"

namespace lode::delaunay {
namespace {

constexpr std::array<std::uint32_t, 3> kNext{1, 2, 0};
constexpr std::array<std::uint32_t, 3> kPrevious{2, 0, 1};

/// Links triangles that share an edge, found by sorting all edges by their ends.
void link_twins(std::vector<LatticeTriangle>& triangles) {
  struct Edge {
    std::uint32_t lower, upper, half_edge;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t a = triangles[t].corner[i];
      const std::uint32_t b = triangles[t].corner[kNext[i]];
      edges.push_back({std::min(a, b), std::max(a, b), 4 * t + i});
    }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::tie(a.lower, a.upper, a.half_edge) < std::tie(b.lower, b.upper, b.half_edge);
  });
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const Edge& a = edges[i];
    const Edge& b = edges[i + 1];
    if (a.lower != b.lower || a.upper != b.upper) continue;
    triangles[a.half_edge / 4].twin[a.half_edge % 4] = b.half_edge;
    triangles[b.half_edge / 4].twin[b.half_edge % 4] = a.half_edge;
  }
}

}  // namespace

LatticeMesh::LatticeMesh(LatticePacking packing,
                         std::span<const std::array<std::uint32_t, 3>> triangles)
    : packing_(packing) {
  resize_large(triangles_, triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& corner = triangles[t];
    LODE_EXPECTS(doubled_area(packing_.unpack(corner[0]), packing_.unpack(corner[1]),
                              packing_.unpack(corner[2])) > 0);
    triangles_[t] = {corner, {kNoHalfEdge, kNoHalfEdge, kNoHalfEdge}, 0, 0};
  }
  link_twins(triangles_);
}

void LatticeMesh::remove_round(LatticePoint p, std::uint32_t t) {
  slots_.assign(1, t);
  border_.clear();
  stack_.assign({4 * t + 2, 4 * t + 1, 4 * t});
  while (!stack_.empty()) {
    const std::uint32_t edge = stack_.back();
    stack_.pop_back();
    const LatticeTriangle& inner = triangles_[edge >> 2];
    const std::uint32_t twin = inner.twin[edge & 3];
    if (twin == kNoHalfEdge || !is_hit(triangles_[twin >> 2], p)) {
      border_.push_back({inner.corner[edge & 3], twin});
      continue;
    }
    // Edges come from the stack in the order in which they lie round p.
    slots_.push_back(twin >> 2);
    stack_.push_back((twin & ~3U) + kPrevious[twin & 3]);
    stack_.push_back((twin & ~3U) + kNext[twin & 3]);
  }
}

std::size_t LatticeMesh::split_edge(LatticePoint p) const {
  for (std::size_t i = 0; i < border_.size(); ++i) {
    if (border_[i].twin != kNoHalfEdge) continue;
    const LatticePoint a = packing_.unpack(border_[i].from);
    const LatticePoint b = packing_.unpack(border_[i + 1 < border_.size() ? i + 1 : 0].from);
    if (doubled_area(a, b, p) == 0) return i;
  }
  return border_.size();
}

void LatticeMesh::fill_fan(std::uint32_t p, std::size_t split) {
  const std::size_t n = border_.size();
  const bool is_closed = split == n;
  const std::size_t n_made = is_closed ? n : n - 1;
  // One more in memory than is needed would be clearing it twice; they double.
  const auto n_before = static_cast<std::uint32_t>(triangles_.size());
  LODE_EXPECTS(slots_.size() <= n_made);
  const std::size_t n_added = n_made - slots_.size();
  if (triangles_.capacity() < n_before + n_added)
    resize_large(triangles_, n_before + n_added);
  else
    triangles_.resize(n_before + n_added);
  for (std::uint32_t i = 0; i < n_added; ++i) slots_.push_back(n_before + i);

  const std::size_t first = is_closed ? 0 : split + 1;
  for (std::size_t k = 0; k < n_made; ++k) {
    const std::size_t i = (first + k) % n;
    const BorderEdge& edge = border_[i];
    const std::uint32_t slot = slots_[k];
    const bool has_next = is_closed || k + 1 < n_made;
    const bool has_previous = is_closed || k > 0;
    const std::uint32_t next = slots_[k + 1 < n_made ? k + 1 : 0];
    const std::uint32_t previous = slots_[k > 0 ? k - 1 : n_made - 1];
    LatticeTriangle& made = triangles_[slot];
    made.corner = {edge.from, border_[i + 1 < n ? i + 1 : 0].from, p};
    made.twin = {edge.twin, has_next ? 4 * next + 2 : kNoHalfEdge,
                 has_previous ? 4 * previous + 1 : kNoHalfEdge};
    if (edge.twin != kNoHalfEdge) triangles_[edge.twin >> 2].twin[edge.twin & 3] = 4 * slot;
  }
}

std::span<const std::uint32_t> LatticeMesh::insert(std::uint32_t p, std::uint32_t t) {
  const LatticePoint point = packing_.unpack(p);
  remove_round(point, t);
  fill_fan(p, split_edge(point));
  return slots_;
}

std::uint32_t LatticeMesh::growth(std::uint32_t p, std::uint32_t t) const {
  const LatticeTriangle& triangle = triangles_[t];
  const LatticePoint point = packing_.unpack(p);
  for (std::uint32_t i = 0; i < 3; ++i)
    if (triangle.twin[i] == kNoHalfEdge &&
        doubled_area(packing_.unpack(triangle.corner[i]),
                     packing_.unpack(triangle.corner[kNext[i]]), point) == 0)
      return 1;
  return 2;
}

}  // namespace lode::delaunay

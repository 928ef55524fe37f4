#include "lode/models/terrain/terrain_features/vertex_links.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>

#include "lode/core/expects.h"
#include "lode/delaunay/lattice_mesh.h"

namespace lode::terrain_features {
namespace {

using delaunay::kNoHalfEdge;

constexpr std::array<std::uint32_t, 3> kNextEdge{1, 2, 0};
constexpr std::array<std::uint32_t, 3> kEdgeBefore{2, 0, 1};

}  // namespace

VertexLinks::VertexLinks(const delaunay::Tin& tin)
    : tin_(tin), n_vertices_(static_cast<std::uint32_t>(tin.vertices.size())) {
  LODE_EXPECTS(tin.heights.size() == tin.vertices.size());
  LODE_EXPECTS(tin.twins.size() == tin.triangles.size());
  find_fans();
}

std::int64_t VertexLinks::euler_number() const {
  const auto n_corners = std::ranges::count_if(first_, [](std::uint32_t h) { return h != kNone; });
  const auto n_triangles = static_cast<std::int64_t>(tin_.triangles.size());
  const auto n_edges = (3 * n_triangles + n_outline_edges_) / 2;
  return n_corners - n_edges + n_triangles;
}

void VertexLinks::find_fans() {
  first_.assign(n_vertices_, kNone);
  const auto n_triangles = static_cast<std::uint32_t>(tin_.triangles.size());
  for (std::uint32_t t = 0; t < n_triangles; ++t)
    for (std::uint32_t i = 0; i < 3; ++i) {
      if (tin_.twins[t][i] != kNoHalfEdge) continue;
      const std::uint32_t half_edge = 4 * t + i;
      ++n_outline_edges_;
      std::uint32_t& first = first_[start_of(half_edge)];
      if (first == kNone) {
        first = half_edge;
      } else {
        pinched_.push_back({start_of(half_edge), half_edge});
      }
    }
  std::ranges::sort(pinched_, [](const PinchedFan& a, const PinchedFan& b) {
    return a.vertex != b.vertex ? a.vertex < b.vertex : a.half_edge < b.half_edge;
  });
  for (std::uint32_t t = 0; t < n_triangles; ++t)
    for (std::uint32_t i = 0; i < 3; ++i) {
      std::uint32_t& first = first_[tin_.triangles[t][i]];
      if (first == kNone) first = 4 * t + i;
    }
}

void VertexLinks::add_fan(std::uint32_t half_edge, std::vector<std::uint32_t>& link) const {
  std::uint32_t at = half_edge;
  do {
    const std::uint32_t t = at / 4;
    const std::uint32_t i = at % 4;
    link.push_back(tin_.triangles[t][kNextEdge[i]]);
    at = tin_.twins[t][kEdgeBefore[i]];
    if (at == kNoHalfEdge) link.push_back(tin_.triangles[t][kEdgeBefore[i]]);
  } while (at != kNoHalfEdge && at != half_edge);
}

void VertexLinks::find_link(std::uint32_t vertex, std::vector<std::uint32_t>& link) const {
  link.clear();
  const std::uint32_t first = first_[vertex];
  if (tin_.twins[first / 4][first % 4] == kNoHalfEdge) link.push_back(outside());
  add_fan(first, link);
  if (link.front() != outside()) return;
  for (auto fan = std::ranges::lower_bound(pinched_, vertex, std::less<>{}, &PinchedFan::vertex);
       fan != pinched_.end() && fan->vertex == vertex; ++fan) {
    link.push_back(outside());
    add_fan(fan->half_edge, link);
  }
}

void Arcs::look_round(std::uint32_t vertex) {
  vertex_ = vertex;
  lower_.clear();
  upper_.clear();
  links_.find_link(vertex, link_);
  const std::size_t n = link_.size();
  const auto is_lower = [&](std::size_t i) { return links_.is_below(link_[i], vertex); };
  std::size_t start = 0;  // Where an arc does; 0 where one goes all round.
  for (bool last = is_lower(n - 1); start < n && is_lower(start) == last;) ++start;
  start %= n;
  bool was_lower = !is_lower(start);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t at = start + i < n ? start + i : start + i - n;
    const std::uint32_t node = link_[at];
    const bool is_now_lower = is_lower(at);
    auto& arcs = is_now_lower ? lower_ : upper_;
    if (is_now_lower != was_lower) {
      arcs.push_back(node);
    } else if (is_now_lower ? is_better_lower(node, arcs.back())
                            : links_.is_below(arcs.back(), node)) {
      arcs.back() = node;
    }
    was_lower = is_now_lower;
  }
}

std::uint32_t Arcs::lowest() const {
  if (lower_.empty()) return vertex_;
  return *std::ranges::min_element(
      lower_, [this](std::uint32_t a, std::uint32_t b) { return is_better_lower(a, b); });
}

std::uint32_t Arcs::highest() const {
  if (upper_.empty()) return vertex_;
  return *std::ranges::max_element(
      upper_, [this](std::uint32_t a, std::uint32_t b) { return links_.is_below(a, b); });
}

}  // namespace lode::terrain_features

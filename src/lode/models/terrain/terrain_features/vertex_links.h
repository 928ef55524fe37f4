#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "lode/delaunay/tin.h"

namespace lode::terrain_features {

inline constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// What is round the vertices of a TIN, closed over what is outside of it: one node more, after the
/// vertices, lower than all of them, and beside both ends of each fan that is open.
class VertexLinks {
 public:
  /// The TIN outlives it. O(n), and O(p log p) for p fans that are not the first of a vertex.
  explicit VertexLinks(const delaunay::Tin& tin);

  [[nodiscard]] std::uint32_t n_vertices() const { return n_vertices_; }
  [[nodiscard]] std::uint32_t outside() const { return n_vertices_; }
  /// Whether it is a corner of any triangle.
  [[nodiscard]] bool has_triangles(std::uint32_t vertex) const { return first_[vertex] != kNone; }
  /// Of triangles, their edges and corners.
  [[nodiscard]] std::int64_t euler_number() const;
  [[nodiscard]] double height(std::uint32_t vertex) const { return tin_.heights[vertex]; }
  /// A total order of nodes.
  [[nodiscard]] bool is_below(std::uint32_t a, std::uint32_t b) const {
    if (a == outside() || b == outside()) return b != outside();
    const double za = tin_.heights[a];
    const double zb = tin_.heights[b];
    return za < zb || (za == zb && a < b);
  }
  /// The nodes round a vertex that is a corner, each fan turning left; the last one is beside the
  /// first.
  void find_link(std::uint32_t vertex, std::vector<std::uint32_t>& link) const;

 private:
  /// An open fan of a vertex that has others, by the edge of the outline that leaves the vertex.
  struct PinchedFan {
    std::uint32_t vertex;
    std::uint32_t half_edge;
  };

  [[nodiscard]] std::uint32_t start_of(std::uint32_t half_edge) const {
    return tin_.triangles[half_edge / 4][half_edge % 4];
  }
  void find_fans();
  void add_fan(std::uint32_t half_edge, std::vector<std::uint32_t>& link) const;

  const delaunay::Tin& tin_;
  std::uint32_t n_vertices_;
  std::int64_t n_outline_edges_ = 0;
  std::vector<std::uint32_t> first_;  ///< Per vertex: where a fan starts, of open ones the first.
  std::vector<PinchedFan> pinched_;   ///< Those that are not first, by vertex.
};

/// The parts of a vertex's link that are lower, and those that are higher, turning left.
class Arcs {
 public:
  explicit Arcs(const VertexLinks& links) : links_(links) {}

  /// Looks round another vertex.
  void look_round(std::uint32_t vertex);
  /// Of each lower arc the lowest vertex, or what is outside, where there is nothing else.
  [[nodiscard]] std::span<const std::uint32_t> lower() const { return lower_; }
  /// Of each upper arc the highest vertex.
  [[nodiscard]] std::span<const std::uint32_t> upper() const { return upper_; }
  /// Of all: where a channel goes on, or a ridge; the vertex itself, where it ends.
  [[nodiscard]] std::uint32_t lowest() const;
  [[nodiscard]] std::uint32_t highest() const;

 private:
  [[nodiscard]] bool is_better_lower(std::uint32_t a, std::uint32_t b) const {
    if (a == links_.outside() || b == links_.outside()) return a != links_.outside();
    return links_.is_below(a, b);
  }

  const VertexLinks& links_;
  std::uint32_t vertex_ = kNone;
  std::vector<std::uint32_t> link_;
  std::vector<std::uint32_t> lower_;
  std::vector<std::uint32_t> upper_;
};

}  // namespace lode::terrain_features

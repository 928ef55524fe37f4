#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "lode/core/uninitialized_array.h"
#include "lode/delaunay/lattice.h"

namespace lode::delaunay {

/// Also says that there is no triangle behind an edge.
inline constexpr std::uint32_t kNoHalfEdge = std::numeric_limits<std::uint32_t>::max();
/// A mesh has no more before an insertion, which adds two: half-edges are numbered in 32 bits,
/// four a triangle.
inline constexpr std::uint64_t kMostTriangles = (std::uint64_t{1} << 30) - 8;

/// A triangle whose corners are nodes of a lattice, in 32 bytes, and what a selector keeps with it.
/// Nodes have numbers that a mesh knows to unpack.
struct LatticeTriangle {
  std::array<std::uint32_t, 3> corner;  ///< They turn left.
  /// Behind the edge from corner i to corner i + 1: 4 times that triangle and its edge.
  std::array<std::uint32_t, 3> twin;
  std::uint32_t candidate;  ///< The node to insert, where there is one.
  float error;
};
static_assert(sizeof(LatticeTriangle) == 32);
/// In huge pages where there are many: a mesh is walked here and there while it grows.
using LatticeTriangles = UninitializedArray<LatticeTriangle>;

/// What a node that is inserted replaces. delaunay: the triangles whose circles it lies in (Bowyer
/// 1981, Watson 1981). split: the one that it lies in, or the two beside the edge that it lies on.
enum class InsertionRule : std::uint8_t { delaunay, split };

/// Triangles of a bounded part of the plane into which nodes are inserted one by one. Edges with
/// nothing behind them stay, or are split where a node lies on them. By the rule delaunay all
/// others are Delaunay, exactly: no corner of a neighbour lies inside a triangle's circle. Of a
/// convex domain this is the Delaunay triangulation, else the one constrained by the outline. Edges
/// inside can be fixed, too: the mesh is then cut along them, as if each side were outline, until
/// it is healed.
/// `Nodes`: LatticePacking or ListedNodes, of coordinates >= 0 and below 2^30.
template <typename Nodes>
class NodeMesh {
 public:
  /// `triangles`: corners that turn left; two of them may share an edge, and those that do must be
  /// Delaunay if the rule is. O(n log n).
  NodeMesh(Nodes nodes, std::span<const std::array<std::uint32_t, 3>> triangles,
           InsertionRule rule = InsertionRule::delaunay);

  /// Of triangles that are linked, such as parts of another mesh; those must be right.
  NodeMesh(Nodes nodes, LatticeTriangles linked, InsertionRule rule = InsertionRule::delaunay);

  [[nodiscard]] const Nodes& nodes() const { return nodes_; }
  [[nodiscard]] const LatticeTriangles& triangles() const { return triangles_; }
  [[nodiscard]] LatticeTriangle& triangle(std::uint32_t t) { return triangles_[t]; }

  /// Cuts the mesh along edges, from node to node, that have a triangle on both sides; of others
  /// nothing needs to be done.
  void cut(std::span<const std::array<std::uint32_t, 2>> edges);
  [[nodiscard]] bool has_cuts() const { return !cuts_.empty(); }
  /// What is behind the edge of a triangle, cut or not: 4 times a triangle and its edge, or
  /// kNoHalfEdge.
  [[nodiscard]] std::uint32_t behind(std::uint32_t t, std::uint32_t edge) const;
  /// Joins the sides of all cuts again, after which no more is to be inserted. Returns the edges
  /// that the cuts have become: more where nodes lay on them, and sorted.
  std::vector<std::array<std::uint32_t, 2>> heal();

  /// Inserts the node p, which lies in triangle t and is none of its corners, by the rule, where it
  /// lies on a cut on both sides. Returns the numbers of the new triangles, valid until the next
  /// call: numbers of removed triangles come first, others are new at the end.
  std::span<const std::uint32_t> insert(std::uint32_t p, std::uint32_t t);

  /// The same of a mesh nobody vouches for: false, and nothing done, where what would be removed is
  /// no disk that p sees all of, on both sides of a cut, or p is a corner.
  [[nodiscard]] bool try_insert(std::uint32_t p, std::uint32_t t,
                                std::span<const std::uint32_t>& slots);

  enum class Insertion : std::uint8_t { done, refused, impossible };
  /// The same of a mesh without cuts: refused, and nothing done, where may_change(t) is false of a
  /// triangle that would be removed, or of one beside those; `slots` are then those to be removed.
  template <typename MayChange>
  [[nodiscard]] Insertion insert_if(std::uint32_t p, std::uint32_t t, const MayChange& may_change,
                                    std::span<const std::uint32_t>& slots) {
    const LatticePoint point = nodes_.unpack(p);
    remove_for(point, t);
    slots = slots_;
    const bool may_all = std::ranges::all_of(slots_, may_change) &&
                         std::ranges::all_of(border_, [&](const BorderEdge& edge) {
                           return edge.twin == kNoHalfEdge || may_change(edge.twin / 4);
                         });
    if (!may_all) return Insertion::refused;
    const std::size_t split = split_edge(point);
    if (!is_disk_round(point, split)) return Insertion::impossible;
    fill_fan(p, split);
    slots = slots_;
    return Insertion::done;
  }

  /// Turns edges that are not Delaunay, from half-edges (4 times a triangle and its edge) of those
  /// that may not be, until all are (C. Lawson, "Software for C1 surface interpolation", 1977).
  /// Returns the triangles that became others, some twice.
  std::vector<std::uint32_t> make_delaunay(std::vector<std::uint32_t> suspects);

  /// Takes all triangles away, and leaves none.
  [[nodiscard]] LatticeTriangles take_triangles() { return std::exchange(triangles_, {}); }

  /// Whether all edges with something behind them are Delaunay.
  [[nodiscard]] bool is_delaunay() const;

  /// How many triangles more there are after inserting p into t: 1 where it lies on the outline,
  /// else 2.
  [[nodiscard]] std::uint32_t growth(std::uint32_t p, std::uint32_t t) const;

 private:
  /// An edge round the removed triangles, which are to the left of it.
  struct BorderEdge {
    std::uint32_t from;
    std::uint32_t twin;
  };
  /// An edge of a removed triangle, which is to the left of it; places relative to p.
  struct InnerEdge {
    std::uint32_t twin;
    std::uint32_t start;  ///< Node.
    LatticePoint from, to;
  };
  /// Finds what p replaces, and what is round that.
  void remove_for(LatticePoint p, std::uint32_t t) {
    if (rule_ == InsertionRule::split) return remove_at(p, t);
    is_narrow_ ? remove_round<true>(p, t) : remove_round<false>(p, t);
  }
  template <bool kIsNarrow>
  void remove_round(LatticePoint p, std::uint32_t t);
  void remove_at(LatticePoint p, std::uint32_t t);
  [[nodiscard]] bool is_disk_round(LatticePoint p, std::size_t split);
  /// The border's edge that p lies on, else its size.
  [[nodiscard]] std::size_t split_edge(LatticePoint p) const;
  void fill_fan(std::uint32_t p, std::size_t split);
  /// Of two nodes, in whatever order.
  [[nodiscard]] static std::uint64_t cut_key(std::uint32_t a, std::uint32_t b) {
    return (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
  }
  [[nodiscard]] bool is_disk_behind(LatticePoint p, std::size_t split);
  [[nodiscard]] std::uint32_t behind_cut(std::size_t split) const;
  void fill_beside_cuts(std::uint32_t p, std::size_t split);
  [[nodiscard]] std::uint32_t split_cut(std::uint32_t p, std::size_t split);
  void find_cuts();
  void find_size();
  [[nodiscard]] bool is_turned_better(std::uint32_t half_edge) const;
  void turn(std::uint32_t half_edge);

  Nodes nodes_;
  InsertionRule rule_;
  LatticeTriangles triangles_;
  bool is_narrow_ = false;  ///< All differences of coordinates are below kNarrowLattice.
  std::vector<InnerEdge> stack_;
  std::vector<std::uint32_t> slots_;  ///< Of removed triangles, then also of those to be made.
  std::vector<BorderEdge> border_;
  std::vector<std::uint32_t> sorted_;  ///< Of slots, where they are checked.
  /// By cut_key(), the half-edge that runs to the larger node, and that to the smaller.
  std::unordered_map<std::uint64_t, std::array<std::uint32_t, 2>> cuts_;
};

/// Of the nodes of a raster's lattice, and of scattered points.
using LatticeMesh = NodeMesh<LatticePacking>;
using PointMesh = NodeMesh<ListedNodes>;

}  // namespace lode::delaunay

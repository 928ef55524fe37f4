#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/surface.h"

namespace lode {

/// How many things of one kind are wrong, and the first of them in index order.
struct Offenders {
  std::uint64_t count = 0;
  std::array<std::uint32_t, 2> first{{0, 0}};  ///< Edge: its vertices; else index in [0], twice.

  friend bool operator==(const Offenders&, const Offenders&) = default;
};

/// One connected piece of a surface.
struct ComponentReport {
  std::uint64_t n_simplices = 0;
  std::int64_t euler_number = 0;       ///< Vertices - edges + triangles.
  std::uint64_t n_boundary_edges = 0;  ///< For lines: end points.
  std::uint64_t n_boundary_loops = 0;  ///< That they make; of triangles only.

  friend bool operator==(const ComponentReport&, const ComponentReport&) = default;
};

/// The combinatorics of a surface. Simplices that repeat a vertex are counted as degenerate and
/// left out of everything else. For contour lines the "edges" are the lines themselves.
struct TopologyReport {
  std::uint64_t n_simplices = 0;
  std::uint64_t n_used_vertices = 0;
  std::uint64_t n_edges = 0;
  std::uint64_t n_boundary_edges = 0;  ///< Edges of one triangle; for lines: end points.
  Offenders non_manifold_edges;        ///< Edges of three triangles or more.
  Offenders inconsistent_edges;        ///< Two triangles run along the edge the same way; for
                                       ///< lines: vertices where two lines start or two end.
  Offenders non_manifold_vertices;     ///< More than one fan; for lines: more than two lines.
  Offenders isolated_vertices;         ///< Used by nothing.
  Offenders degenerate_simplices;      ///< Repeated vertex, or zero area (length), exactly.
  Offenders duplicate_vertices;        ///< Same coordinates as another one, and no twin: {lowest
                                       ///< index with the coordinates, this vertex}.
  std::uint64_t n_twins = 0;           ///< Extra vertices that a pinched hole explains.
  std::vector<ComponentReport> components;  ///< In the order of their lowest vertex.
  std::int64_t euler_number = 0;            ///< Of the whole.

  /// Oriented manifold with boundary, nothing degenerate, duplicate or unused.
  [[nodiscard]] bool is_clean_manifold() const;
  [[nodiscard]] bool is_closed() const { return n_boundary_edges == 0; }
  friend bool operator==(const TopologyReport&, const TopologyReport&) = default;
};

struct TopologyOptions {
  /// Whether the domain may be pinched at this vertex: by a hole of the data, or a clip box.
  /// Vertices with equal coordinates are twins where this holds and each of them is on the
  /// surface's boundary; with no function, being on the boundary is enough.
  std::function<bool(std::uint32_t vertex)> may_pinch = {};
  Threads threads = {};
};

/// The Euler number and the boundary loops of each component, sorted: what tells an oriented
/// manifold from all that are not homeomorphic to it.
using ComponentTypes = std::vector<std::array<std::int64_t, 2>>;
[[nodiscard]] ComponentTypes component_types(const TopologyReport& report);

/// Examines a well-formed surface, by sorting its edges.
[[nodiscard]] TopologyReport check_topology(const Surface& surface, const TopologyOptions& options);

/// The edges that exactly one triangle uses, in that triangle's direction, ordered by their lower
/// vertex then the higher. For contour lines: the end points, each as {vertex, vertex}.
[[nodiscard]] std::vector<std::array<std::uint32_t, 2>> find_boundary_edges(const Surface& surface,
                                                                            Threads threads);

}  // namespace lode

#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lode/delaunay/tin.h"
#include "lode/models/terrain/insertions/history.h"
#include "lode/refine/demand.h"

namespace lode::insertions {

/// The mesh at a time, by the rule delaunay such exactly; vertices with heights in rows, triangles
/// as they were made, with twins and errors if `links` says so. O(triangles made until then).
[[nodiscard]] delaunay::Tin tin_at(const History& history, std::uint32_t time,
                                   delaunay::TinLinks links);

/// The fewest nodes after which no triangle of the mesh wants to be refined: where one that was
/// made does, demand(facts) > 0, the node that removes it is applied, after its ancestors. A
/// triangle's facts are its own: its error, the heights in it, its bounds in the world. Unique, for
/// whether a triangle wants to be refined depends on nothing else. O(nodes applied), and a bit for
/// each node.
[[nodiscard]] AppliedNodes select_nodes(const History& history, const Demand& demand);

/// The fewest nodes after which no triangle errs by more than a tolerance, where there are such.
[[nodiscard]] NodeSet nodes_within(const History& history, double tolerance);

/// The same of the least tolerance whose mesh has no more triangles than that, by bisection;
/// nothing where the base has more. Histories that are worst first go on to the last mesh on the
/// way.
[[nodiscard]] std::optional<NodeSet> nodes_of_cells(const History& history,
                                                    std::uint64_t max_cells);

/// The mesh of a consistent set of nodes: it conforms, covers the domain once, and by the
/// rule delaunay is such: see docs/models/delaunay_pyramid.md. Otherwise as tin_at().
[[nodiscard]] delaunay::Tin tin_of(const History& history, const NodeSet& nodes,
                                   delaunay::TinLinks links);
[[nodiscard]] inline delaunay::Tin tin_of(const History& history, AppliedNodes applied,
                                          delaunay::TinLinks links) {
  return tin_of(history, NodeSet(std::move(applied)), links);
}

/// Numbers the vertices of a TIN's triangles, which are the history's, anew, as they lie in rows,
/// and takes places and heights over.
void place_vertices(const History& history, delaunay::Tin& tin);

/// The same of vertices and their heights, wherever they are from.
void place_vertices(std::span<const delaunay::LatticePoint> vertices,
                    std::span<const double> heights, delaunay::Tin& tin);

/// What a demand sees of a triangle.
[[nodiscard]] NodeFacts facts_of(const History& history, const Triangle& triangle);

/// What it sees of a triangle of an error, over a raster or points of that frame and range; without
/// bounds where it does not ask for them.
[[nodiscard]] NodeFacts facts_of(const terrain_file::Source& source,
                                 const delaunay::LatticeCorners& corners,
                                 const std::array<double, 3>& heights, float error,
                                 const Demand& demand);

}  // namespace lode::insertions

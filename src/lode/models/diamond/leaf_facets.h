#pragma once

#include <bit>
#include <vector>

#include "lode/mappers/facet_grid.h"
#include "lode/models/diamond/extract.h"

namespace lode::diamond {

/// Of a leaf simplex, what a facet says of where it comes from.
struct LeafPlace {
  /// Of leaves that cannot be bisected; their facets are those of full resolution.
  static constexpr std::uint64_t kFinest = std::uint64_t{1} << 62;
  /// Marks facets of leaves that the newest nodes have made.
  static constexpr std::uint64_t kFresh = std::uint64_t{1} << 63;
};

/// The point at which a simplex of the hierarchy is bisected: the middle of its longest edge; twice
/// that of its corners' lattice points.
[[nodiscard]] Index<3> doubled_bisection_point(const std::array<Index<3>, 4>& vertex);

/// The centre of the node whose bisection has made a simplex: its latest vertex.
[[nodiscard]] Index<3> newest_vertex(const std::array<Index<3>, 4>& vertex);

/// The facets of F, the surface of full resolution. Places: the sum of the simplex's four vertices.
[[nodiscard]] std::vector<Facet> full_facets(const Model<3>& model, const IsosurfaceQuery& query,
                                             const Progress& progress);

/// The facets of a query's cut, as extract_isosurface() gives them, in a fixed order. Places: the
/// key of the node that would bisect the leaf, or kFinest; marked kFresh where `fresh` has made it
/// (null: all).
[[nodiscard]] std::vector<Facet> cut_facets(const Model<3>& model, const IsosurfaceQuery& query,
                                            const NodeSet<3>* fresh, const Progress& progress);

}  // namespace lode::diamond

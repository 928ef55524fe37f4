#pragma once

#include <limits>
#include <span>
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

/// Some bricks of a field, in a model that holds a part of it.
struct FieldBricks {
  const Model<3>& model;
  Index<3> origin;                   ///< Of the model's lattice in that of the field.
  const RegularGrid& grid;           ///< The field's.
  std::span<const Index<3>> bricks;  ///< Numbered as the model's.
  /// Leaves that reach out of it, on the model's lattice, are left out.
  LatticeBox<3> known;
  /// Not all are found where there are more.
  std::size_t n_most = std::numeric_limits<std::size_t>::max();
};

/// The facets of F, the surface of full resolution. Places: the sum of the simplex's four vertices.
[[nodiscard]] std::vector<Facet> full_facets(const Model<3>& model, const IsosurfaceQuery& query,
                                             const Progress& progress);

/// The facets of a query's cut, as extract_isosurface() gives them, in a fixed order. Places: the
/// key of the node that would bisect the leaf, or kFinest; marked kFresh where `fresh` has made it
/// (null: all).
[[nodiscard]] std::vector<Facet> cut_facets(const Model<3>& model, const IsosurfaceQuery& query,
                                            const NodeSet<3>* fresh, const Progress& progress);

/// The same in some bricks, if all nodes of brick size and larger ones are refined. The query's
/// wanted nodes, and `fresh`, are of the model's lattice.
[[nodiscard]] std::vector<Facet> full_facets(const FieldBricks& bricks,
                                             const IsosurfaceQuery& query,
                                             const Progress& progress);
[[nodiscard]] std::vector<Facet> cut_facets(const FieldBricks& bricks, const IsosurfaceQuery& query,
                                            const NodeSet<3>* fresh, const Progress& progress);

}  // namespace lode::diamond

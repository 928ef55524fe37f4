#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/delaunay/tin.h"
#include "lode/models/terrain/right_triangle_bisection/bisection.h"
#include "lode/refine/demand.h"

namespace lode::bisection {

/// Nodes of a lattice, by their indices.
class NodeSet {
 public:
  explicit NodeSet(const Lattice& lattice) : words_(lattice.size() / 64 + 1, 0) {}

  [[nodiscard]] bool has(std::int64_t i) const {
    return (words_[static_cast<std::size_t>(i) / 64] >> (i % 64) & 1) != 0;
  }
  /// Whether it was not there.
  bool add(std::int64_t i) {
    std::uint64_t& word = words_[static_cast<std::size_t>(i) / 64];
    const std::uint64_t bit = std::uint64_t{1} << (i % 64);
    const bool is_new = (word & bit) == 0;
    word |= bit;
    return is_new;
  }

 private:
  std::vector<std::uint64_t> words_;
};

/// The coarsest mesh whose nodes with errors above the tolerance are refined; errors of triangles
/// are those of the nodes that were not. O(triangles), and a bit for each sample. The grid is the
/// one that the errors are of. The same for any number of threads; triangles of a raster larger
/// than the caches are found by one.
[[nodiscard]] delaunay::Tin tin_within(const Bisection& bisection, const HeightGrid& grid,
                                       double tolerance, Threads threads = {1});
/// The mesh whose refined nodes are these.
[[nodiscard]] delaunay::Tin tin_of(const Bisection& bisection, const HeightGrid& grid,
                                   const NodeSet& nodes);

/// The smallest set of nodes, with those that they wait for, after which a demand wants none of the
/// diamonds of the mesh. Bounds are those of diamonds in the world, with the heights that their
/// corners and errors leave possible within the range.
[[nodiscard]] NodeSet select_nodes(const Bisection& bisection, const HeightGrid& grid,
                                   const HeightRange& range, const Demand& demand);

/// Of tin_within(), or `most` + 1 where there are more than that.
[[nodiscard]] std::uint64_t count_triangles(const Bisection& bisection, double tolerance,
                                            std::uint64_t most);
/// The smallest tolerance whose mesh has no more triangles than that; nothing where even the
/// coarsest has more.
[[nodiscard]] std::optional<double> tolerance_of_cells(const Bisection& bisection,
                                                       std::uint64_t max_cells);

}  // namespace lode::bisection

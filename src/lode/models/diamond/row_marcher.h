#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "lode/models/diamond/brick_isosurface.h"
#include "lode/models/diamond/brick_nodes.h"
#include "lode/models/diamond/cell_marcher.h"
#include "lode/models/diamond/cube_leaves.h"

namespace lode::diamond {

/// Marches the leaves, inside one brick after another, of the cut of a selection: what
/// BrickTraversal finds simplex by simplex is found here in rows (BrickNodes). Nodes that are not
/// refined leave the simplices of CubeLeaves; unit cells are marched as a whole (CellMarcher).
class RowMarcher {
 public:
  RowMarcher(const Selection<3>& selection, const LatticeFrame& frame);

  /// See CellMarcher.
  void set_cubes(const CubeCells* cubes) { cells_.set_cubes(cubes); }
  [[nodiscard]] double farthest_move() const { return cells_.farthest_move(); }

  /// Of the brick that is open; `simplices`: those of its Kuhn simplices that are in the cut.
  /// Returns false, and does nothing, where holes are near (see BrickNodes::open()).
  [[nodiscard]] bool march(const BrickSamples<3>& samples, std::span<const Simplex<3>> simplices,
                           BrickIsosurface<3>& mapper, TraversalStats& stats);

 private:
  /// A point of the brick. All are linear in its coordinates.
  struct Corner {
    std::uint32_t place = 0;  ///< Of two, the sum is where the entry of their edge is.
    std::uint32_t sample = 0;
    LatticeKey key = 0;
  };
  /// A cube of a level.
  struct Cube {
    int level = 0;
    Index<3> at;   ///< In cubes.
    Corner first;  ///< The lowest.
  };

  void march_top(std::span<const Simplex<3>> simplices, TraversalStats& stats);
  template <typename T>
  void march_level(int level, TraversalStats& stats);
  template <typename T>
  void march_finest_cubes(TraversalStats& stats);
  template <typename T>
  void march_cube(const Cube& cube, CubePoints refined, std::uint32_t octants,
                  TraversalStats& stats);
  template <typename T, typename NodeError>
  void march_simplex(const Cube& cube, const CubeSimplex& simplex, CubePoints inside,
                     TraversalStats& stats, const NodeError& error);

  [[nodiscard]] Cube cube_at(int level, const Index<3>& at) const;
  [[nodiscard]] std::uint32_t refined_octants(const Cube& cube) const;
  [[nodiscard]] CubePoints inside_of(const Cube& cube) const;
  [[nodiscard]] ErrorCode stored_error(int level, const Index<3>& local) const;
  template <typename T>
  [[nodiscard]] ErrorCode error_of(const CubeLeaves::Face& face, const Cube& cube) const;
  template <typename T>
  [[nodiscard]] ErrorCode error_of(const CubeLeaves::Edge& edge, const Cube& cube) const;
  template <typename T>
  [[nodiscard]] double midpoint_error(const Cube& cube, CubePoint node, CubePoint first,
                                      CubePoint second) const;
  template <typename T>
  [[nodiscard]] double value(std::uint32_t sample) const;
  [[nodiscard]] static Corner corner_at(const Index<3>& local);
  [[nodiscard]] Corner corner_of(const Cube& cube, CubePoint p) const;

  const Selection<3>& selection_;
  const Model<3>& model_;
  double slack_;
  const BrickSamples<3>* samples_ = nullptr;
  BrickIsosurface<3>* mapper_ = nullptr;
  BrickNodes nodes_;
  CellMarcher cells_;
  ErrorCode largest_finest_ = 0;  ///< That level 0 can have within the tolerance.
  ErrorCode achieved_ = 0;        ///< The largest error seen, in all bricks.
  std::array<Corner, 27> steps_;  ///< By CubePoint, from the first.
};

}  // namespace lode::diamond

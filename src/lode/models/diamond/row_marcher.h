#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "lode/models/diamond/brick_isosurface.h"
#include "lode/models/diamond/brick_rows.h"
#include "lode/models/diamond/cell_edges.h"
#include "lode/models/diamond/cube_leaves.h"

namespace lode::diamond {

/// Marches the leaves, inside one brick after another, of the cut of a selection: what
/// BrickTraversal finds simplex by simplex is found here in rows. Whether nodes are refined, and on
/// which side of the isovalue samples are, is a bit each; nodes that are not refined leave the
/// simplices of CubeLeaves, and unit cells are marched by cases of 256 signs and the simplices that
/// are there.
class RowMarcher {
 public:
  explicit RowMarcher(const Selection<3>& selection);

  /// Of the brick that is open; `simplices`: those of its Kuhn simplices that are in the cut.
  /// Returns false, and does nothing, where holes are beside its samples: where the error of the
  /// whole brick's node is infinite.
  [[nodiscard]] bool march(const BrickSamples<3>& samples, std::span<const Simplex<3>> simplices,
                           BrickIsosurface<3>& mapper, TraversalStats& stats);

 private:
  static constexpr std::size_t kCubes = as_size(kBrickEdge<3> / 2);  ///< Of side 2, along an edge.

  /// A bit for each node of a level from 1 on: bit x of word y + 17 z, in steps of 2^level.
  using LevelBits = std::array<std::uint32_t, (kCubes + 1) * (kCubes + 1)>;
  /// Words of cubes of side 2, y + 16 z; a cube's bit is that of its centre's x.
  using CubeBits = std::array<std::uint64_t, kCubes * kCubes>;

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

  /// A crossed edge of a unit cell, from the cell's lowest corner.
  struct EdgePlace {
    std::uint32_t place = 0;         ///< Of its entry among BrickVertices.
    std::uint32_t first_sample = 0;  ///< At the end with the smaller key.
    std::uint32_t second_sample = 0;
    LatticeKey first_key = 0;
    LatticeKey second_key = 0;
  };
  using EdgePlaces = std::array<EdgePlace, CellEdges::kEdges>;

  void open(const BrickSamples<3>& samples, BrickIsosurface<3>& mapper);
  void march_leaves(std::span<const Simplex<3>> simplices, TraversalStats& stats);
  void find_levels();
  /// Returns whether nodes of tier 2 are refined, so that there are finer ones.
  [[nodiscard]] bool find_level(int level);
  [[nodiscard]] std::uint32_t level_row(int level, const Index<3>& first, std::int32_t n,
                                        std::uint32_t forced) const;
  template <typename T>
  void find_inside_samples();
  template <typename T>
  void find_finest();
  void find_met_cubes(BrickRows& rows);
  void add_forced(const BrickRows& rows);
  void find_refined_cubes();

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
  template <typename T>
  void march_cells();
  template <typename T>
  void march_row(std::size_t y, std::size_t z);

  [[nodiscard]] Cube cube_at(int level, const Index<3>& at) const;
  [[nodiscard]] bool is_refined(int level, const Index<3>& cube) const;
  [[nodiscard]] std::uint32_t refined_octants(const Cube& cube) const;
  [[nodiscard]] CubePoints inside_of(const Cube& cube) const;
  [[nodiscard]] std::size_t stored_at(int level, const Index<3>& local) const;
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
  int top_;  ///< Of the cube that is a whole brick, or all of a smaller root.

  const BrickSamples<3>* samples_ = nullptr;
  const std::byte* data_ = nullptr;
  BrickIsosurface<3>* mapper_ = nullptr;
  Index<3> base_;
  unsigned top_parity_ = 0;  ///< As CubeLeaves::of() has it, of the largest cube.
  Index<3> n_cells_;         ///< Unit cells in the data.
  bool is_whole_ = false;    ///< All are.
  bool is_forced_ = false;   ///< Whether nodes are refined for the sake of the data's end.
  int finest_ = 0;           ///< Level of which there are cubes.
  BrickBits inside_;
  BrickBits refined_;                                          ///< Nodes of level 0.
  std::array<LevelBits, as_size(kBrickLevel<3>) + 1> levels_;  ///< Those from 1 on.
  CubeBits met_;                  ///< Cubes of side 2 that have samples on both sides,
  CubeBits refined_cubes_;        ///< and those of them that are refined.
  ErrorCode largest_finest_ = 0;  ///< That level 0 can have within the tolerance.
  ErrorCode achieved_ = 0;        ///< The largest error seen, in all bricks.
  NodeLimits limits_;
  std::array<Corner, 27> steps_;     ///< By CubePoint, from the first.
  std::array<EdgePlaces, 8> edges_;  ///< By the parity of the cell's lowest corner.
};

}  // namespace lode::diamond

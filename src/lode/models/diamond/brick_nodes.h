#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "lode/models/diamond/brick_rows.h"
#include "lode/models/diamond/brick_samples.h"
#include "lode/models/diamond/selection.h"

namespace lode::diamond {

/// Which nodes a selection refines inside one brick after another, and which samples are inside: a
/// bit each, found in rows. That a node is refined depends on no other's answer (see Selection), so
/// no order is kept.
class BrickNodes {
 public:
  static constexpr std::size_t kCubes = as_size(kBrickEdge<3> / 2);  ///< Of side 2, along an edge.
  /// Every second bit.
  static constexpr std::uint64_t kOdd = 0xAAAAAAAAAAAAAAAAU;
  static constexpr std::uint64_t kEven = ~kOdd;

  explicit BrickNodes(const Selection<3>& selection);

  /// Opens the brick that `samples` has open. Returns false where the surface may meet simplices
  /// beside holes: where one of the finest refined nodes with stored errors has an infinite one. Of
  /// that brick nothing is known here.
  /// `simplices`: those of the brick's Kuhn simplices that are in the cut.
  [[nodiscard]] bool open(const BrickSamples<3>& samples, std::span<const Simplex<3>> simplices);
  /// Whether the surface may be in the brick. If not, nothing of what follows is known.
  [[nodiscard]] bool is_met() const { return is_met_; }

  [[nodiscard]] const Model<3>& model() const { return model_; }
  [[nodiscard]] const Index<3>& base() const { return base_; }
  /// Unit cells in the data, along each axis.
  [[nodiscard]] const Index<3>& n_cells() const { return n_cells_; }
  [[nodiscard]] const std::byte* data() const { return data_; }
  /// Level of the cube that is the whole brick, or all of a smaller root.
  [[nodiscard]] int top() const { return top_; }
  /// The finest level of which there are cubes.
  [[nodiscard]] int finest() const { return finest_; }
  /// As CubeLeaves::of() has it.
  [[nodiscard]] unsigned parity_of(int level, const Index<3>& cube) const;

  /// Bit x: whether the sample is inside.
  [[nodiscard]] std::uint64_t inside(std::size_t y, std::size_t z) const {
    return inside_[brick_row(y, z)];
  }
  /// Bit x: whether the node of level 0 is refined, next to cubes that have samples on both sides.
  [[nodiscard]] std::uint64_t refined(std::size_t y, std::size_t z) const {
    return refined_[brick_row(y, z)];
  }
  /// Likewise of a level from 1 on, in its steps.
  [[nodiscard]] std::uint32_t refined_of(int level, std::size_t y, std::size_t z) const {
    return levels_[as_size(level)][level_word(y, z)];
  }
  /// Bit 2 i + 1: whether cube i of side 2, of a row of them, has samples on both sides and is
  /// refined.
  [[nodiscard]] std::uint64_t refined_cubes(std::size_t j, std::size_t k) const {
    return refined_cubes_[j + kCubes * k];
  }
  /// Whether a cube, in cubes of the level, is refined.
  [[nodiscard]] bool is_refined(int level, const Index<3>& cube) const;
  /// Of a row of unit cells: those of which corners differ.
  [[nodiscard]] std::uint32_t crossed_cells(std::size_t y, std::size_t z) const;
  /// By axis, of a row of unit cells: whether those of its simplices are there that begin at the
  /// even corner along the axis. They are if the node in the middle of their parents' bisected edge
  /// is refined.
  [[nodiscard]] std::array<std::uint64_t, 3> simplices_along(std::size_t y, std::size_t z) const;

  /// Where a node's attributes are in its level's arrays; its centre is given from the brick's
  /// lowest corner. Of level 0 only cubes have any.
  [[nodiscard]] std::size_t stored_at(int level, const Index<3>& local) const;

 private:
  /// A bit for each node of a level from 1 on: bit x of word y + 17 z, in steps of 2^level.
  using LevelBits = std::array<std::uint32_t, (kCubes + 1) * (kCubes + 1)>;
  /// Words of cubes of side 2, y + 16 z; a cube's bit is that of its centre's x.
  using CubeBits = std::array<std::uint64_t, kCubes * kCubes>;

  static constexpr std::size_t level_word(std::size_t y, std::size_t z) {
    return y + (kCubes + 1) * z;
  }
  void find_levels();
  /// Returns whether nodes of tier 2 are refined, so that there are finer ones.
  [[nodiscard]] bool find_level(int level);
  [[nodiscard]] std::uint32_t level_row(int level, const Index<3>& first, std::int32_t n,
                                        std::uint32_t forced) const;
  [[nodiscard]] bool is_any_infinite(int level, const Index<3>& first, std::uint32_t nodes) const;
  template <typename T>
  void find_inside_samples();
  template <typename T>
  void find_finest();
  void find_met_cubes(BrickRows& rows);
  void add_forced(const BrickRows& rows);
  void find_refined_cubes();
  [[nodiscard]] std::uint64_t existing_cubes(std::size_t j, std::size_t k) const;

  const Selection<3>& selection_;
  const Model<3>& model_;
  double slack_;
  int top_;
  NodeLimits limits_;

  const std::byte* data_ = nullptr;
  Index<3> base_;
  Index<3> n_cells_;
  unsigned top_parity_ = 0;
  bool is_met_ = false;
  bool has_holes_ = false;  ///< One of the nodes of the last level that was found is infinite.
  bool is_forced_ = false;  ///< Whether nodes are refined for the sake of the data's end.
  int finest_ = 0;
  BrickBits inside_;
  BrickBits refined_;
  std::array<LevelBits, as_size(kBrickLevel<3>) + 1> levels_;  ///< Those from 1 on.
  CubeBits met_;  ///< Cubes of side 2 that have samples on both sides.
  CubeBits refined_cubes_;
};

}  // namespace lode::diamond

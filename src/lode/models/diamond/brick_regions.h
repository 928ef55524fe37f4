#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "lode/models/diamond/brick_rows.h"
#include "lode/models/diamond/relaxed_box.h"

namespace lode::diamond {

/// The regions of either side of an isovalue in one brick after another: its samples, those on its
/// border among them, that are on one side and that edges of the mesh of full resolution inside it
/// join. Samples p and p + d, d of -1, 0 and 1, have an edge if the coordinates in which they
/// differ are all even in p and odd in p + d, or the other way round. Found in rows, by runs of
/// samples on one side. Holes are in none.
class BrickRegions {
 public:
  using Label = std::uint16_t;
  static constexpr Label kNone = 0xFFFF;  ///< Of holes.
  static_assert(power(as_size(kBrickSamples<3>), 3) < kNone);

  struct Region {
    bool is_inside = false;
    bool is_fixed = false;    ///< Has a sample that can be on this side alone.
    std::uint32_t n_own = 0;  ///< Samples that are the brick's own,
    Index<3> first{};         ///< and where in it the first of them is, in order of z, y, x.
  };

  /// `box` has the brick that begins at `base`, to both ends; `own`: its own samples.
  void find(const RelaxedBox& box, const Index<3>& base, const LatticeBox<3>& own);

  [[nodiscard]] const std::vector<Region>& regions() const { return regions_; }
  /// Which ones have an edge between them, each pair once.
  [[nodiscard]] const std::vector<std::pair<Label, Label>>& touching() const { return touching_; }
  /// On one of its faces, whose place along `axis` is 0 or the last: of all its samples, in order.
  [[nodiscard]] std::vector<Label> face(std::size_t axis, bool is_last) const;
  /// Bit x: whether the sample is in one of the regions that are so marked.
  [[nodiscard]] std::uint64_t row_of(std::int32_t y, std::int32_t z,
                                     const std::vector<bool>& is_marked) const;
  [[nodiscard]] const Index<3>& size() const { return size_; }

 private:
  struct Row {
    std::uint64_t present = 0;
    std::uint64_t inside = 0;
    std::uint64_t fixed = 0;
    std::uint64_t starts = 0;  ///< Of runs,
    std::uint32_t first = 0;   ///< whose numbers begin here.

    [[nodiscard]] std::uint32_t run_at(int x) const;
    /// All samples of the run that begins at bit x.
    [[nodiscard]] std::uint64_t run_from(int x) const;
  };

  void read_row(const RelaxedBox& box, const Index<3>& first, Row& row);
  /// Runs of two rows: edges lead from the first one's samples, those of `mask`, to samples of the
  /// other which are `dx` farther.
  void join_rows(const Row& row, const Row& other, int dx, std::uint64_t mask);
  void join_neighbours(std::int32_t y, std::int32_t z);
  void number_regions(const Index<3>& base, const LatticeBox<3>& own);
  [[nodiscard]] std::uint32_t root_of(std::uint32_t run);
  void join(std::uint32_t a, std::uint32_t b);
  [[nodiscard]] Row& row(std::int32_t y, std::int32_t z) {
    return rows_[brick_row(as_size(y), as_size(z))];
  }
  [[nodiscard]] const Row& row(std::int32_t y, std::int32_t z) const {
    return rows_[brick_row(as_size(y), as_size(z))];
  }

  Index<3> size_;  ///< In samples.
  std::array<Row, std::tuple_size_v<BrickBits>> rows_;
  std::vector<std::uint32_t> parents_;  ///< By run: union-find, the smallest is the root.
  std::vector<Label> labels_;           ///< By run.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> touching_runs_;
  std::vector<Region> regions_;
  std::vector<std::pair<Label, Label>> touching_;
};

}  // namespace lode::diamond

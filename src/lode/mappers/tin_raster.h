#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/delaunay/tin.h"

namespace lode {

/// The heights of a TIN at the nodes of its lattice, strip by strip of rows. Const members are safe
/// from many threads.
class TinRaster {
 public:
  /// As high as the tiles of files.
  static constexpr std::int32_t kStripRows = 256;

  /// Of a TIN with heights, which must outlive it. O(triangles); 4 bytes for each strip that a
  /// triangle reaches into.
  TinRaster(const delaunay::Tin& tin, std::int32_t n_columns, std::int32_t n_rows);

  [[nodiscard]] std::int32_t n_strips() const;
  [[nodiscard]] static std::int32_t first_row(std::int32_t strip) { return strip * kStripRows; }
  /// kStripRows, or what there is at the end.
  [[nodiscard]] std::int32_t n_rows(std::int32_t strip) const;
  [[nodiscard]] std::size_t n_nodes(std::int32_t strip) const {
    return static_cast<std::size_t>(n_rows(strip)) * static_cast<std::size_t>(n_columns_);
  }

  /// Fills n_nodes(strip) heights in rows: at a vertex its own, exactly; elsewhere that of the
  /// plane of a triangle that holds the node, corners and edges included, and of several the last
  /// one's, so that strips and threads change nothing. Which triangles hold a node is decided
  /// exactly. NaN where none does.
  void fill(std::int32_t strip, std::span<double> heights) const;

  /// Heights are not farther from the planes.
  [[nodiscard]] double rounding() const { return rounding_; }
  /// Whether each is on no other side of any whole number than its plane: where all vertices have
  /// whole heights that are small enough.
  [[nodiscard]] bool keeps_whole_numbers() const { return keeps_whole_numbers_; }

 private:
  void count_strips();
  void find_rounding();
  void fill_triangle(std::uint32_t triangle, std::int32_t strip, std::span<double> heights) const;

  const delaunay::Tin& tin_;
  std::int32_t n_columns_;
  std::int32_t n_rows_;
  double rounding_ = 0;
  bool keeps_whole_numbers_ = false;
  std::vector<std::size_t> first_;        ///< Per strip, in `triangles_`; one more.
  std::vector<std::uint32_t> triangles_;  ///< That reach into a strip, in their order.
};

}  // namespace lode

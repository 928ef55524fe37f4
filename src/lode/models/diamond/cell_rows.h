#pragma once

#include <array>
#include <cstdint>

#include "lode/core/surface.h"
#include "lode/mappers/kuhn_cube.h"
#include "lode/models/diamond/sign_field.h"

namespace lode::diamond {

/// The signs at the four rows of corners of 32 cells (row y, z at [y + 2z]), and those of the next
/// word: its first one is at the last cell's other corners.
using CornerRows = std::array<std::uint64_t, 4>;

/// A number for each series of edges that a row of cells touches (edge_series()), and padding.
using PerSeries = std::array<std::uint32_t, 16>;
static_assert(kEdgeSeries <= 16);

/// Series in the cell row's own row of anchors: the first ones. The others belong to the next rows.
inline constexpr std::size_t kOwnSeries = 7;

/// The signs round one row of cells; bits beyond the data are never looked at.
class CellRow {
 public:
  CellRow(const SignField& field, std::int32_t y, std::int32_t z)
      : field_(field),
        has_y_(y + 1 < field.dims[1]),
        has_z_(z + 1 < field.dims[2]),
        parity_(as_size(y & 1) | as_size(z & 1) << 1) {
    // A row beyond the data reads as the row itself.
    for (int i = 0; i < 4; ++i)
      rows_[as_size(i)] =
          field.words.get() +
          (has_row(i & 1, i >> 1) ? field.offset(y + (i & 1), z + (i >> 1)) : field.offset(y, z));
  }

  [[nodiscard]] bool has_row(int row_y, int row_z) const {
    return (row_y == 0 || has_y_) && (row_z == 0 || has_z_);
  }
  [[nodiscard]] const SignField& field() const { return field_; }
  [[nodiscard]] const std::array<const std::uint32_t*, 4>& rows() const { return rows_; }
  /// Bit 0: whether y is odd; bit 1: z.
  [[nodiscard]] std::size_t parity() const { return parity_; }
  [[nodiscard]] CornerRows corners(std::size_t word) const {
    CornerRows r;
    for (std::size_t i = 0; i < 4; ++i)
      r[i] = rows_[i][word] | static_cast<std::uint64_t>(rows_[i][word + 1]) << 32;
    return r;
  }

 private:
  const SignField& field_;
  bool has_y_;
  bool has_z_;
  std::size_t parity_;
  std::array<const std::uint32_t*, 4> rows_{};
};

/// The first vertex of each own series of a row, and its first triangle.
struct RowStart {
  std::array<std::uint32_t, kOwnSeries> vertex;
  std::uint32_t triangle;
};
static_assert(sizeof(RowStart) == 32);

/// What there is to write.
struct SliceCounts {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
};

/// What the surface meets of 16 words of a row, each of 32 cells and anchors.
struct WordGroup {
  static constexpr std::size_t kWords = 16;
  using PerWord = std::array<std::uint32_t, kWords>;

  alignas(64) std::array<PerWord, 16> crossings{};     ///< Crossed anchors, by series; last two: 0.
  alignas(64) PerWord cells{};                         ///< Crossed cells.
  std::array<std::uint32_t, kOwnSeries> with_edges{};  ///< Bits of words with crossed anchors.
  std::uint32_t met = 0;                               ///< Bits of words with any.
  std::size_t first = 0;                               ///< The first word's number.
};

/// Counts the vertices and triangles of a slice of cells, and says where each row's begin in it:
/// modulo 2^32.
[[nodiscard]] SliceCounts count_slice(const SignField& field, std::int32_t z, SurfaceStyle style,
                                      RowStart* starts);
/// Adds to n starts what a slice begins with.
void place_rows(const RowStart* starts, std::size_t n, const RowStart& base, RowStart* out);
/// Lists the groups that the surface meets, for which there is room, and returns their number.
/// Series that the style has no vertices on are left as they are: 0.
[[nodiscard]] std::size_t find_words(const CellRow& row, SurfaceStyle style, WordGroup* out);

}  // namespace lode::diamond

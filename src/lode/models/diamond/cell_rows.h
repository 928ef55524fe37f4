#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

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
      : step_(field.row_stride), parity_(as_size(y & 1) | as_size(z & 1) << 1) {
    // A row beyond the data reads as the row itself.
    for (int i = 0; i < 4; ++i) {
      const std::int32_t row_y = std::min(y + (i & 1), field.dims[1] - 1);
      const std::int32_t row_z = std::min(z + (i >> 1), field.dims[2] - 1);
      rows_[as_size(i)] = &field.words[field.offset(0, row_y, row_z)];
    }
  }

  /// Bit 0: whether y is odd; bit 1: z.
  [[nodiscard]] std::size_t parity() const { return parity_; }
  [[nodiscard]] CornerRows corners(std::size_t word) const {
    CornerRows r;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t* own = rows_[i] + word * step_;
      r[i] = own[0] | static_cast<std::uint64_t>(own[step_]) << 32;
    }
    return r;
  }

 private:
  std::size_t step_;
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

  alignas(64) std::array<PerSeries, kWords> crossings{};  ///< Crossed anchors; last two: 0.
  alignas(64) PerWord cells{};                            ///< Crossed cells.
  std::uint32_t met = 0;                                  ///< Bits of words with any.
  std::size_t first = 0;                                  ///< The first word's number.
};

/// Of SignField::kRows rows, one above the other, each with all groups that its words are of.
class RowGroups {
 public:
  explicit RowGroups(const SignField& field)
      : n_groups_((field.n_words() + WordGroup::kWords - 1) / WordGroup::kWords),
        groups_(SignField::kRows * n_groups_) {
    for (std::size_t i = 0; i < groups_.size(); ++i)
      groups_[i].first = i % n_groups_ * WordGroup::kWords;
  }
  void clear() {
    for (WordGroup& group : groups_) group.met = 0;
  }
  [[nodiscard]] WordGroup& of_word(std::size_t row, std::size_t word) {
    return groups_[row * n_groups_ + word / WordGroup::kWords];
  }
  [[nodiscard]] std::span<const WordGroup> of_row(std::size_t row) const {
    return std::span(groups_).subspan(row * n_groups_, n_groups_);
  }

 private:
  std::size_t n_groups_;
  std::vector<WordGroup> groups_;
};

/// Counts the vertices and triangles of a slice of cells, and says where each row's begin in it:
/// modulo 2^32.
[[nodiscard]] SliceCounts count_slice(const SignField& field, std::int32_t z, SurfaceStyle style,
                                      RowStart* starts);
/// Adds to n starts what a slice begins with.
void place_rows(const RowStart* starts, std::size_t n, const RowStart& base, RowStart* out);
/// What the surface meets in rows y to y + SignField::kRows - 1, of which the first is a multiple
/// of that. What groups have of words that are not met means nothing.
void find_words(const SignField& field, std::int32_t y, std::int32_t z, SurfaceStyle style,
                RowGroups& out);

}  // namespace lode::diamond

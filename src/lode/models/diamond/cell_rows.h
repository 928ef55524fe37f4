#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "lode/mappers/kuhn_cube.h"
#include "lode/models/diamond/sign_field.h"

namespace lode::diamond {

/// The signs at the four rows of corners of 32 cells (row y, z at [y + 2z]); bit 32 is the next
/// word's first.
using CornerRows = std::array<std::uint64_t, 4>;

/// Reads the signs round the cells of one row, and derives from them, 32 cells at a time, which
/// lattice edges the isosurface crosses.
class CellRow {
 public:
  CellRow(const SignField& field, std::int32_t y, std::int32_t z)
      : n_x_(field.dims[0]), parity_y_(y & 1), parity_z_(z & 1) {
    for (int i = 0; i < 4; ++i) {
      has_[as_size(i)] = y + (i & 1) < field.dims[1] && z + (i >> 1) < field.dims[2];
      // A row beyond the data reads as the row itself: nothing crosses between the two.
      row_[as_size(i)] =
          field.words.data() +
          (has_[as_size(i)] ? field.offset(y + (i & 1), z + (i >> 1)) : field.offset(y, z));
    }
  }

  [[nodiscard]] bool has_row(int row_y, int row_z) const {
    return has_[as_size(row_y + 2 * row_z)];
  }
  [[nodiscard]] bool has_cells() const { return has_[3] && n_x_ > 1; }

  [[nodiscard]] CornerRows corners(std::size_t word) const {
    CornerRows r;
    for (std::size_t i = 0; i < 4; ++i)
      r[i] = row_[i][word] | (static_cast<std::uint64_t>(row_[i][word + 1]) & 1) << 32;
    return r;
  }
  /// Whether all corners of the 32 cells have one sign. Bits beyond the data are 0, so that a
  /// row's last word is never taken for uniform by mistake.
  [[nodiscard]] static bool is_uniform(const CornerRows& r) {
    constexpr std::uint64_t kAll = 0x1FFFFFFFF;
    return (r[0] | r[1] | r[2] | r[3]) == 0 || (r[0] & r[1] & r[2] & r[3]) == kAll;
  }
  /// Bits of the word that are samples, and those where a cell starts.
  [[nodiscard]] std::uint32_t sample_bits(std::size_t word) const { return bits(word, n_x_); }
  [[nodiscard]] std::uint32_t cell_bits(std::size_t word) const { return bits(word, n_x_ - 1); }

  /// Cells with corners of both signs.
  [[nodiscard]] std::uint32_t crossed_cells(const CornerRows& r, std::size_t word) const {
    const std::uint64_t any = r[0] | r[1] | r[2] | r[3];
    const std::uint64_t all = r[0] & r[1] & r[2] & r[3];
    return low((any | any >> 1) & ~(all & all >> 1)) & cell_bits(word);
  }

  /// Per series (edge_series), the anchors whose edge is crossed.
  void crossings(const CornerRows& r, std::size_t word,
                 std::array<std::uint32_t, kEdgeSeries>& out) const {
    const std::uint32_t samples = sample_bits(word);
    const std::uint32_t cells = cell_bits(word);
    const auto along_x = [&](std::uint64_t a) { return low(a ^ a >> 1) & cells; };
    const auto across = [&](std::uint64_t a, std::uint64_t b) { return low(a ^ b) & samples; };
    const auto slanted = [&](std::uint64_t a, std::uint64_t b, bool a_is_even) {
      return diagonal(a_is_even ? a : b, a_is_even ? b : a) & cells;
    };
    const bool y_even = parity_y_ == 0;
    const bool z_even = parity_z_ == 0;
    out[0] = along_x(r[0]);
    out[1] = across(r[0], r[1]);
    out[2] = slanted(r[0], r[1], y_even);
    out[3] = across(r[0], r[2]);
    out[4] = slanted(r[0], r[2], z_even);
    out[5] = parity_y_ == parity_z_ ? across(r[0], r[3]) : across(r[1], r[2]);
    out[6] = parity_y_ == parity_z_ ? slanted(r[0], r[3], y_even) : slanted(r[1], r[2], !y_even);
    out[7] = along_x(r[1]);
    out[8] = across(r[1], r[3]);
    out[9] = slanted(r[1], r[3], z_even);
    out[10] = along_x(r[2]);
    out[11] = across(r[2], r[3]);
    out[12] = slanted(r[2], r[3], y_even);
    out[13] = along_x(r[3]);
    mask_missing_rows(out);
  }

  /// Triangles of the word's cells.
  [[nodiscard]] std::uint32_t n_triangles(const CornerRows& r, std::size_t word) const {
    std::array<std::uint32_t, 8> corner;  // By coordinates modulo 2, as in Kuhn's chains.
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint64_t a = r[i ^ static_cast<std::size_t>(parity_y_ + 2 * parity_z_)];
      corner[2 * i] = low((a & kEven) | (a >> 1 & kOdd));
      corner[2 * i + 1] = low((a >> 1 & kEven) | (a & kOdd));
    }
    const std::uint32_t cells = cell_bits(word);
    std::uint32_t n = 0;
    for (const std::size_t first : {1U, 2U, 4U})
      for (const std::size_t second : {1U, 2U, 4U}) {
        if (first == second) continue;
        const std::uint32_t a = corner[0] ^ corner[first];
        const std::uint32_t b = corner[0] ^ corner[first | second];
        const std::uint32_t c = corner[0] ^ corner[7];
        const std::uint32_t crossed = (a | b | c) & cells;
        // Among four signs, one or three differ from the rest when the differences' sum is odd.
        n += static_cast<std::uint32_t>(std::popcount(crossed) +
                                        std::popcount(crossed & ~(a ^ b ^ c)));
      }
    return n;
  }

 private:
  static constexpr std::uint64_t kEven = 0x55555555;
  static constexpr std::uint64_t kOdd = 0xAAAAAAAA;

  static std::uint32_t low(std::uint64_t a) { return static_cast<std::uint32_t>(a); }
  /// Edges along x and other axes join the even corner to the odd one.
  static std::uint32_t diagonal(std::uint64_t even, std::uint64_t odd) {
    return low(((even ^ odd >> 1) & kEven) | ((even >> 1 ^ odd) & kOdd));
  }
  static std::uint32_t bits(std::size_t word, std::int32_t n) {
    const std::int64_t left = std::int64_t{n} - 32 * static_cast<std::int64_t>(word);
    if (left >= 32) return ~std::uint32_t{0};
    return left <= 0 ? 0 : (std::uint32_t{1} << left) - 1;
  }
  void mask_missing_rows(std::array<std::uint32_t, kEdgeSeries>& out) const {
    if (has_[3]) return;
    if (!has_[1]) out[1] = out[2] = out[7] = out[8] = out[9] = 0;
    if (!has_[2]) out[3] = out[4] = out[10] = out[11] = out[12] = 0;
    out[5] = out[6] = out[13] = 0;
    if (!has_[1]) out[12] = out[11] = 0;
    if (!has_[2]) out[8] = out[9] = 0;
  }

  std::int32_t n_x_;
  int parity_y_;
  int parity_z_;
  std::array<const std::uint32_t*, 4> row_{};
  std::array<bool, 4> has_{};
};

}  // namespace lode::diamond

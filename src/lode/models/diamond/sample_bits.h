#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/core/vec.h"
#include "lode/models/diamond/lattice.h"

namespace lode::diamond {

/// A bit for each sample of a lattice, by rows of 64.
class SampleBits {
 public:
  explicit SampleBits(const Index<3>& dims);

  [[nodiscard]] const Index<3>& dims() const { return dims_; }
  [[nodiscard]] std::uint64_t* row(std::int32_t y, std::int32_t z) {
    return words_.data() + (as_size(z) * as_size(dims_[1]) + as_size(y)) * stride_;
  }
  [[nodiscard]] const std::uint64_t* row(std::int32_t y, std::int32_t z) const {
    return words_.data() + (as_size(z) * as_size(dims_[1]) + as_size(y)) * stride_;
  }
  /// Sets those of 64 samples from x = first on that are set in `bits`, none beyond the row.
  static void set(std::uint64_t* row, std::int32_t first, std::uint64_t bits) {
    row += first / 64;
    const int shift = first % 64;
    row[0] |= bits << shift;
    if (shift != 0 && bits >> (64 - shift) != 0) row[1] |= bits >> (64 - shift);
  }
  /// The 64 from x = first on, 0 beyond the row; `first` is a multiple of 32.
  [[nodiscard]] std::uint64_t get(const std::uint64_t* row, std::int32_t first) const;
  /// Whether one from x = first to last is set.
  [[nodiscard]] static bool is_any_set(const std::uint64_t* row, std::int32_t first,
                                       std::int32_t last);
  /// Whether all corners of a cell are.
  [[nodiscard]] bool has_cell(const Index<3>& cell) const;
  /// Whether one in a tetrahedron is, its border included, or within 1e-6 of a step: coordinates
  /// are found in doubles from floats. Right for flat ones, too.
  [[nodiscard]] bool meets(const std::array<Vec3d, 4>& tetrahedron) const;

 private:
  Index<3> dims_;
  std::size_t stride_;  ///< Words a row, one of them beyond its samples or partly so.
  std::vector<std::uint64_t> words_;
};

}  // namespace lode::diamond

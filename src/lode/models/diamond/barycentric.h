#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "lode/models/diamond/lattice.h"

namespace lode::diamond {

/// A simplex's barycentric coordinates, exact: integer adjugate over the determinant.
template <int D>
class Barycentric {
 public:
  explicit Barycentric(const Simplex<D>& s) : origin_(s.v[0]) {
    std::array<std::array<std::int64_t, 3>, 3> e{};
    for (std::size_t i = 0; i < 3; ++i) e[i][i] = 1;  // 2D: the third axis stays apart
    for (std::size_t j = 0; j < as_size(D); ++j)
      for (std::size_t i = 0; i < as_size(D); ++i) e[j][i] = s.v[j + 1][i] - s.v[0][i];
    for (std::size_t j = 0; j < 3; ++j) {
      const auto& a = e[(j + 1) % 3];
      const auto& b = e[(j + 2) % 3];
      for (std::size_t i = 0; i < 3; ++i)
        adjugate_[j][i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
    }
    for (std::size_t i = 0; i < 3; ++i) determinant_ += e[0][i] * adjugate_[0][i];
    if (determinant_ < 0) {
      determinant_ = -determinant_;
      for (auto& row : adjugate_)
        for (std::int64_t& x : row) x = -x;
    }
  }

  /// Weights of p times weight_sum(); false when p is outside.
  [[nodiscard]] bool weights(const Index<D>& p,
                             std::array<std::int64_t, as_size(D) + 1>& out) const {
    out[0] = determinant_;
    for (std::size_t j = 0; j < as_size(D); ++j) {
      std::int64_t w = 0;
      for (std::size_t i = 0; i < as_size(D); ++i) w += adjugate_[j][i] * (p[i] - origin_[i]);
      if (w < 0) return false;
      out[j + 1] = w;
      out[0] -= w;
    }
    return out[0] >= 0;
  }
  [[nodiscard]] std::int64_t weight_sum() const { return determinant_; }

 private:
  Index<D> origin_;
  std::array<std::array<std::int64_t, 3>, 3> adjugate_{};
  std::int64_t determinant_ = 0;
};

}  // namespace lode::diamond

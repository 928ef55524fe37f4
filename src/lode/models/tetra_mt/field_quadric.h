// Garland, Heckbert, Simplifying Surfaces with Color and Texture using Quadric Error Metrics
// (1998), for fields over tetrahedra: Vo, Callahan, Lindstrom, Pascucci, Silva, Streaming
// Simplification of Tetrahedral Meshes (2007).
#pragma once

#include <array>
#include <cstddef>

#include "lode/core/vec.h"

namespace lode::tetra_mt {

/// A sum of squares: of by how much a value at a point differs from what linear functions have
/// there. An order for collapses, and no bound of an error.
struct FieldQuadric {
  static constexpr std::size_t kTerms = 15;  ///< Of a symmetric matrix of 5.

  std::array<double, kTerms> terms{};

  void add(const FieldQuadric& q) {
    for (std::size_t i = 0; i < kTerms; ++i) terms[i] += q.terms[i];
  }
  /// weight times the square of gradient . p + constant - value.
  void add_linear(const Vec3d& gradient, double constant, double weight) {
    const std::array<double, 5> row{gradient[0], gradient[1], gradient[2], constant, -1};
    std::size_t at = 0;
    for (std::size_t i = 0; i < 5; ++i)
      for (std::size_t j = i; j < 5; ++j) terms[at++] += weight * row[i] * row[j];
  }
  [[nodiscard]] double at(const Vec3d& p, double value) const {
    const std::array<double, 5> column{p[0], p[1], p[2], 1, value};
    double sum = 0;
    std::size_t at = 0;
    for (std::size_t i = 0; i < 5; ++i) {
      double row = 0.5 * terms[at] * column[i];
      ++at;
      for (std::size_t j = i + 1; j < 5; ++j) row += terms[at++] * column[j];
      sum += row * column[i];
    }
    return 2 * sum;
  }
};

}  // namespace lode::tetra_mt

#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>

#include "lode/delaunay/tin.h"
#include "lode/models/terrain/squares/square_domain.h"

namespace lode::squares {

/// Collects triangles between samples; vertices come in rows at the end, with heights.
class TinBuilder {
 public:
  explicit TinBuilder(const SquareDomain& domain) : domain_(domain) {}

  /// Corners that turn left (x to the right, y up).
  void add(delaunay::LatticePoint a, delaunay::LatticePoint b, delaunay::LatticePoint c,
           double error) {
    corners_.push_back({a, b, c});
    errors_.push_back(error);
  }
  [[nodiscard]] delaunay::Tin finish() const;

 private:
  const SquareDomain& domain_;
  std::vector<std::array<delaunay::LatticePoint, 3>> corners_;
  std::vector<double> errors_;
};

}  // namespace lode::squares

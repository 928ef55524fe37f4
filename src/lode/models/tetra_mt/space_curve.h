#pragma once

#include <cstdint>
#include <span>

#include "lode/core/vec.h"

namespace lode::tetra_mt {

/// Places on a Morton curve through a cube round some positions: what is near has, as a rule, near
/// places.
class SpaceCurve {
 public:
  explicit SpaceCurve(std::span<const Vec3d> positions);

  [[nodiscard]] std::uint64_t operator()(const Vec3d& p) const;

 private:
  Vec3d lower_;
  double scale_ = 0;
};

}  // namespace lode::tetra_mt

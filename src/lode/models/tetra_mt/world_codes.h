#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/vec.h"

namespace lode::tetra_mt {

/// Of nodes' facts: whether they have the world errors that the field has, or infinite ones.
enum class WorldErrors : std::uint8_t { unknown, known };

/// World errors in 8 bits, rounded up by at most an eighth: 0, and 32 octaves, the last of which
/// begins above the diagonal of the mesh's box; none that is not 0 is below the first. Larger codes
/// stand for larger errors.
class WorldCodes {
 public:
  /// Of an error that is not known.
  static constexpr std::uint8_t kInfinite = 255;

  /// The mesh's box.
  WorldCodes(const Vec3d& lower, const Vec3d& upper);

  /// In the mesh's unit.
  [[nodiscard]] float error(std::uint8_t code) const;
  /// The smallest one of at least `error`.
  [[nodiscard]] std::uint8_t code(float error) const;

 private:
  double unit_;  ///< A power of two.
};

/// By node of a page.
using WorldPage = std::vector<std::uint8_t>;

}  // namespace lode::tetra_mt

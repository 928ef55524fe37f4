#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace lode {

/// A named part of a mesh's boundary: an inlet, a wall.
struct BoundaryPatch {
  std::int64_t id = 0;  ///< As the file numbers it.
  std::string name;     ///< Empty where the file has none.

  friend bool operator==(const BoundaryPatch&, const BoundaryPatch&) = default;
};

/// What people call it: its name, or "patch 3".
[[nodiscard]] inline std::string name_of(const BoundaryPatch& patch) {
  return patch.name.empty() ? "patch " + std::to_string(patch.id) : patch.name;
}

/// A face that one tetrahedron alone has, and the patch that it belongs to.
struct PatchFace {
  std::array<std::uint32_t, 3> corners;
  std::uint32_t patch;  ///< Its place among the patches.
};

}  // namespace lode

#pragma once

#include <cstdint>
#include <string>

namespace lode {

/// A part of a mesh's cells: a block, a material, a zone.
struct MeshRegion {
  std::int64_t id = 0;  ///< As the file numbers it.
  std::string name;     ///< Empty where the file has none.

  friend bool operator==(const MeshRegion&, const MeshRegion&) = default;
};

/// What people call it: its name, or "region 3".
[[nodiscard]] inline std::string name_of(const MeshRegion& region) {
  return region.name.empty() ? "region " + std::to_string(region.id) : region.name;
}

}  // namespace lode

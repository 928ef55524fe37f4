#pragma once

#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lode/core/mesh.h"
#include "lode/core/result.h"
#include "lode/io/surface_output.h"

namespace lode::io {

/// The faces of one patch, as formats have them that keep faces in groups.
struct PatchBlock {
  std::int32_t tag = 1;                  ///< Positive, and different from other blocks'.
  std::string name;                      ///< In one line, and different from other blocks'.
  std::span<const std::uint32_t> sides;  ///< Of SimplexMesh::patch_sides, ascending.
};

/// A mesh's patches, by id, ascending; those without faces are left out.
class PatchBlocks {
 public:
  explicit PatchBlocks(const SimplexMesh& mesh);
  PatchBlocks(const PatchBlocks&) = delete;
  PatchBlocks& operator=(const PatchBlocks&) = delete;

  [[nodiscard]] std::span<const PatchBlock> blocks() const { return blocks_; }
  [[nodiscard]] std::size_t n_faces() const { return sides_.size(); }

 private:
  std::vector<std::uint32_t> sides_;  ///< Block by block.
  std::vector<PatchBlock> blocks_;
};

/// Of a block or group: in one line, of about 200 bytes at most, with the number behind it where
/// the name is taken, and again until it is not.
[[nodiscard]] std::string block_name(std::string_view name, std::int64_t id,
                                     std::set<std::string>& taken);

/// FieldData of VTK XML files that tells what PatchId stands for: PatchIds, and PatchNames as
/// strings. Empty where there are no patches.
[[nodiscard]] std::string vtk_patch_names(std::span<const BoundaryPatch> patches);
/// The same of RegionId: RegionIds and RegionNames.
[[nodiscard]] std::string vtk_region_names(std::span<const MeshRegion> regions);

/// Appends the cells' values, then those of the cells that faces of patches belong to.
template <typename T>
Result<void> write_with_sides(SurfaceOutput& file, const SimplexMesh& mesh,
                              const std::vector<T>& values) {
  LODE_CHECK(write_array(file, std::span(values)));
  return write_records(file, mesh.patch_sides.size(), sizeof(T), [&](std::size_t i, std::byte* to) {
    put(to, values[mesh.patch_sides[i].cell]);
  });
}

}  // namespace lode::io

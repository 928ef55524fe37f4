#include "lode/io/mesh_blocks.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>

#include "lode/io/mesh_patches.h"

namespace lode::io {
namespace {

/// With its name, where it has one.
MeshRegion region_numbered(const SimplexMesh& mesh, std::int64_t id) {
  const auto at = std::lower_bound(
      mesh.region_names.begin(), mesh.region_names.end(), id,
      [](const MeshRegion& region, std::int64_t wanted) { return region.id < wanted; });
  return at != mesh.region_names.end() && at->id == id ? *at : MeshRegion{id, {}};
}

}  // namespace

MeshBlocks::MeshBlocks(const SimplexMesh& mesh) : cells_(mesh.n_cells()) {
  std::iota(cells_.begin(), cells_.end(), 0U);
  if (cells_.empty()) return;
  if (mesh.regions.empty()) {
    blocks_.push_back({.name = {}, .cells = cells_});
    return;
  }
  std::stable_sort(cells_.begin(), cells_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return mesh.regions[a] < mesh.regions[b];
  });
  has_region_tags_ = mesh.regions[cells_.front()] > 0 &&
                     mesh.regions[cells_.back()] <= std::numeric_limits<std::int32_t>::max();
  std::set<std::string> names;
  const std::span<const std::uint32_t> all = cells_;
  for (std::size_t first = 0; first < all.size();) {
    const std::int64_t region = mesh.regions[all[first]];
    std::size_t end = first + 1;
    while (end < all.size() && mesh.regions[all[end]] == region) ++end;
    const auto tag = static_cast<std::int32_t>(
        has_region_tags_ ? region : static_cast<std::int64_t>(blocks_.size() + 1));
    blocks_.push_back({.tag = tag,
                       .name = block_name(name_of(region_numbered(mesh, region)), region, names),
                       .cells = all.subspan(first, end - first)});
    first = end;
  }
}

bool has_whole_attributes(const SimplexMesh& mesh) {
  return std::all_of(mesh.attributes.begin(), mesh.attributes.end(), [&](const Attribute& a) {
    return a.values.size() == mesh.positions.size() &&
           (a.errors.empty() || a.errors.size() == mesh.n_cells());
  });
}

}  // namespace lode::io

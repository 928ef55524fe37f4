#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/api/tetra_dataset.h"
#include "lode/models/tetra_mt/midpoint/hierarchy.h"
#include "lode/models/tetra_mt/packed_hierarchy.h"

namespace lode {

[[nodiscard]] TetraInfo info_of(const tetra_mt::HierarchyHead& head);
[[nodiscard]] TetraInfo info_of(const tetra_mt::midpoint::ForestHead& head);

/// Regions that have a name, by number, ascending.
[[nodiscard]] std::vector<MeshRegion> named_regions(std::span<const std::int64_t> ids,
                                                    std::span<const std::string> names);

/// By vertex of the hierarchy: gradient_code() of a field on the mesh, whose vertices these are.
[[nodiscard]] std::vector<std::uint32_t> gradient_codes(const TetraMesh& mesh, std::size_t field,
                                                        std::span<const std::uint32_t> vertices,
                                                        Threads threads);

}  // namespace lode

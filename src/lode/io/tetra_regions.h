#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"
#include "lode/io/tetrahedra.h"

namespace lode::io {

/// The field of the cells that tells regions apart: its place among them, or their number. Of
/// several the one whose name comes first in the list of TetraOptions; whole numbers of one
/// component, of any type. Fails when the one that the options name is not there or not such.
[[nodiscard]] Result<std::size_t> find_regions(const CellMesh& mesh, const TetraOptions& options);

/// Fields whose names are such, but that are not taken, with the reason: "Material (0.5, which is
/// no whole number)". `regions`: find_regions().
[[nodiscard]] std::vector<std::string> find_regions_not_taken(const CellMesh& mesh,
                                                              std::size_t regions);

/// By region, the names that the mesh has for RegionId, where that is the field of regions, as
/// labels; of a number with several names the first. None at all where no region has one. "region
/// 3" of region 3, as files have it that Lode wrote, is no name.
[[nodiscard]] std::vector<std::string> names_of_regions(const CellMesh& mesh, std::size_t regions,
                                                        std::span<const std::int64_t> ids);

/// Leaves out the solid cells of other regions than those that the options want, by number or name,
/// and counts them. Fails where there is no such region, or none at all.
[[nodiscard]] Result<std::uint64_t> keep_regions(const TetraOptions& options, std::size_t regions,
                                                 CellMesh& mesh);

}  // namespace lode::io

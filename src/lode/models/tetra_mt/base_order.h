#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lode/models/tetra_mt/base_walk.h"

namespace lode::tetra_mt {

/// The same tetrahedra in the order in which BaseWalk comes to them, so turned as it has them:
/// across faces, from the first one on; what has no face in common with these begins anew.
[[nodiscard]] BaseTetrahedra in_base_order(const BaseTetrahedra& base);

/// Of memory for each of a base, to be held against the size of a file: what stays, and part of
/// what reading takes.
inline constexpr std::uint64_t kBaseTetrahedronBytes = 32;

/// The bytes of a base in a file,
[[nodiscard]] std::vector<std::byte> encode_base(const BaseTetrahedra& base,
                                                 const BaseLimits& limits);
/// and what was written. Fails on what no base has; `what`: the block, for messages.
[[nodiscard]] Result<BaseTetrahedra> decode_base(std::span<const std::byte> bytes, std::size_t n,
                                                 const BaseLimits& limits, const std::string& what);

}  // namespace lode::tetra_mt

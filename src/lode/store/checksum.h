#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace lode::store {

/// XXH64 with seed 0: the one checksum of the .lode format.
[[nodiscard]] std::uint64_t checksum(std::span<const std::byte> bytes);

}  // namespace lode::store

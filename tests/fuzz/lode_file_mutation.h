#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "tests/fuzz/harnesses.h"

namespace lode::fuzz {

/// Changes some of the first `size` bytes, and their number, which stays at most `max_size`.
using MutateBytes =
    std::function<std::size_t(std::uint8_t* data, std::size_t size, std::size_t max_size)>;

/// Changes a .lode file where its checksums would stop a fuzzer: in the metadata, the directory or
/// a block, as they are once decompressed, and makes the rest right again. Nothing where it is no
/// .lode file.
[[nodiscard]] std::optional<std::vector<std::byte>> mutate_lode_file(Input file,
                                                                     std::minstd_rand& random,
                                                                     const MutateBytes& change);

}  // namespace lode::fuzz

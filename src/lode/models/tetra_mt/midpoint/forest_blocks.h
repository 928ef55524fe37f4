#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/tetra_mt/midpoint/forest_page.h"

namespace lode::tetra_mt::midpoint {

/// The bytes of a page in a file (docs/format.md, section 7).
[[nodiscard]] std::vector<std::byte> encode_page(const ForestContent& content,
                                                 const ForestHead& head, std::uint32_t page);
/// What encode_page() wrote. Fails on whatever ForestPage does not expect. what: the block, for
/// messages.
[[nodiscard]] Result<ForestContent> decode_page(std::span<const std::byte> bytes,
                                                const std::string& what, const ForestHead& head,
                                                std::uint32_t page);

/// Likewise of a part of the table of pages; `n`: how many are in it.
[[nodiscard]] std::vector<std::byte> encode_table(std::span<const PageCounts> pages);
[[nodiscard]] Result<void> decode_table(std::span<const std::byte> bytes, const std::string& what,
                                        std::size_t n, std::vector<PageCounts>& pages);

}  // namespace lode::tetra_mt::midpoint

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/tetra_mt/byte_streams.h"
#include "lode/models/tetra_mt/midpoint/forest_page.h"

namespace lode::tetra_mt::midpoint {

/// The bytes of what a page has of a further field (docs/format.md, section 7). `nodes`: the page.
[[nodiscard]] std::vector<std::byte> encode_field_page(const FieldPage& content,
                                                       const ForestHead& head,
                                                       const ForestField& field, std::uint32_t page,
                                                       const ForestPage& nodes);
/// What encode_field_page() wrote. Fails on what no field has. what: the block, for messages.
[[nodiscard]] Result<FieldPage> decode_field_page(std::span<const std::byte> bytes,
                                                  const std::string& what, const ForestHead& head,
                                                  const ForestField& field, std::uint32_t page,
                                                  const ForestPage& nodes);

/// Likewise what n roots have of it, from `first` on.
[[nodiscard]] std::vector<std::byte> encode_field_roots(const FieldRoots& roots,
                                                        const ForestHead& head, std::size_t first,
                                                        std::size_t n);
/// Appends them.
[[nodiscard]] Result<void> read_field_roots(StreamReader& in, std::size_t n, const ForestHead& head,
                                            const ForestField& field, FieldRoots& roots);

/// Columns of roots' labels, codes and facts, as codes of 31 bits, and facts with ranges.
[[nodiscard]] Result<std::vector<std::int32_t>> read_codes_of(StreamReader& in, std::size_t n);
[[nodiscard]] Result<std::vector<std::uint32_t>> read_facts_of(StreamReader& in, std::size_t n,
                                                               const NodeCodes& codes);

}  // namespace lode::tetra_mt::midpoint

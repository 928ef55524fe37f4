#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/tetra_mt/page_models.h"
#include "lode/models/tetra_mt/page_tree.h"

namespace lode::tetra_mt {

/// The bytes of a page in a file (docs/format.md, section 7): what nodes have for all fields,
/// `models`: as they are before the page, then as it leaves them.
[[nodiscard]] std::vector<std::byte> encode_links(const PageContent& content, std::uint32_t number,
                                                  const PageShape& shape, LinkModels& models);
/// and what they have for one.
[[nodiscard]] std::vector<std::byte> encode_field(const FieldContent& content,
                                                  const ValueScale& scale, const PageTree& tree,
                                                  bool is_narrow, FieldModels& models);

/// Fills what encode_links() wrote. Fails on whatever NodePage does not expect. what: the block,
/// for messages.
[[nodiscard]] Result<void> decode_links(std::span<const std::byte> bytes, const std::string& what,
                                        std::uint32_t number, const PageShape& shape,
                                        LinkModels& models, PageContent& content);
/// What encode_field() wrote, with the tree of the page's links.
[[nodiscard]] Result<FieldContent> decode_field(std::span<const std::byte> bytes,
                                                const std::string& what, const ValueScale& scale,
                                                const PageTree& tree, bool is_narrow,
                                                FieldModels& models);

/// As coded differences from the one before.
void write_differences_of(std::span<const std::uint32_t> numbers, class StreamWriter& out);
[[nodiscard]] Result<std::vector<std::uint32_t>> read_differences_of(class StreamReader& in,
                                                                     std::size_t n);

/// Positions or values as columns: bits of float32 where they are narrow, or float64; differences
/// from the one before, coded as blocks with codec 3 are.
void write_numbers(std::span<const double> numbers, std::size_t stride, bool is_narrow,
                   class StreamWriter& out);
[[nodiscard]] Result<std::vector<double>> read_numbers(class StreamReader& in, std::size_t n,
                                                       std::size_t stride, bool is_narrow);

}  // namespace lode::tetra_mt

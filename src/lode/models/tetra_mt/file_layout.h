#pragma once

// What save() and open() agree on; docs/format.md, section 7.

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "lode/models/tetra_mt/base_order.h"
#include "lode/models/tetra_mt/packed_hierarchy.h"
#include "lode/models/tetra_mt/page_tree.h"
#include "lode/store/format.h"
#include "lode/store/writer.h"

namespace lode::tetra_mt {

enum class Kind : std::uint32_t {
  base_vertices = 1,
  base_tetrahedra = 2,
  roots = 3,
  links = 4,
  field = 5,
  gradients = 6,
  base_field = 7,
  mesh_vertices = 8,
  world_errors = 9,
  front = 10,
  front_facts = 11,
};

/// Of the metadata and the blocks; files of another one are refused.
inline constexpr std::uint32_t kLayout = 11;

[[nodiscard]] inline store::BlockKey key_of(Kind kind, std::uint32_t number,
                                            std::uint32_t field = 0) {
  return {static_cast<std::uint32_t>(kind), field, {{static_cast<std::int32_t>(number), 0, 0}}};
}

inline constexpr std::uint32_t kMaxFields = 4096;

/// How many the blocks of the base have.
struct BaseCounts {
  std::uint64_t n_tetrahedra = 0;
  std::uint64_t n_roots = 0;
};

[[nodiscard]] std::vector<std::byte> encode_head(const HierarchyHead& head);
/// All but the base's vertices, tetrahedra and roots. Fails on what no hierarchy has.
[[nodiscard]] Result<HierarchyHead> decode_head(std::span<const std::byte> bytes,
                                                const std::string& path, BaseCounts& counts);

/// Of its base.
[[nodiscard]] BaseLimits base_limits_of(const HierarchyHead& head);

/// Of a page of nodes; called by many threads at once.
using TreeOf = std::function<PageTree(std::uint32_t page)>;

/// Writes the blocks of one more field, whose number is that of the head's so far, and tells the
/// head of it. `gradients`: gradient_code()s by vertex.
[[nodiscard]] Result<void> append_field(const NumberedField& field,
                                        std::span<const std::uint32_t> gradients,
                                        const TreeOf& tree_of, HierarchyHead& head, Threads threads,
                                        store::Writer& writer);

}  // namespace lode::tetra_mt

#pragma once

// What save() and open() agree on; docs/format.md, section 7.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "lode/core/progress.h"
#include "lode/models/tetra_mt/base_order.h"
#include "lode/models/tetra_mt/midpoint/forest.h"
#include "lode/store/format.h"
#include "lode/store/writer.h"

namespace lode::tetra_mt::midpoint {

enum class Kind : std::uint32_t {
  table = 1,
  roots = 2,
  base_tetrahedra = 3,
  page = 4,
  field_roots = 5,
  field_page = 6,
  coincident_leaves = 7,
  world_errors = 8,
};

/// Of the metadata and the blocks; files of another one are refused.
inline constexpr std::uint32_t kLayout = 6;

/// Pages of which a block of the table tells.
inline constexpr std::uint32_t kTablePart = 1U << 12;

/// `field`: of what belongs to one but the first.
[[nodiscard]] inline store::BlockKey key_of(Kind kind, std::uint32_t number,
                                            std::size_t field = 0) {
  return {static_cast<std::uint32_t>(kind),
          static_cast<std::uint32_t>(field),
          {{static_cast<std::int32_t>(number), 0, 0}}};
}

/// How many the blocks have.
struct ForestCounts {
  std::uint32_t n_pages = 0;
  std::uint32_t n_roots = 0;
  std::uint64_t n_tetrahedra = 0;  ///< Of the base.
};

[[nodiscard]] std::vector<std::byte> encode_head(const ForestHead& head);
/// All but the table, roots and tetrahedra. Fails on what no hierarchy has.
[[nodiscard]] Result<ForestHead> decode_head(std::span<const std::byte> bytes,
                                             const std::string& path, ForestCounts& counts);

/// Of its base, whose vertices are n_roots.
[[nodiscard]] BaseLimits base_limits_of(const ForestHead& head, std::uint32_t n_roots);

/// Of a page of nodes; called by many threads at once.
using NodesOf = std::function<ForestPage(std::uint32_t page)>;

/// Writes the blocks of a field's world errors, where it has some. `codes`: by node of all.
[[nodiscard]] Result<void> append_world_errors(const ForestHead& head, std::size_t field,
                                               const WorldPage& codes, store::Writer& writer);

/// Writes the blocks of a field but the first, whose place in the head that is.
[[nodiscard]] Result<void> append_field(const ForestHead& head, std::size_t field,
                                        const FurtherField& records, const NodesOf& nodes_of,
                                        Threads threads, store::Writer& writer, Progress& progress);

}  // namespace lode::tetra_mt::midpoint

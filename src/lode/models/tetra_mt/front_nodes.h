#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/tetra_mt/box_codes.h"
#include "lode/models/tetra_mt/closed_mesh.h"
#include "lode/models/tetra_mt/fact_codes.h"
#include "lode/models/tetra_mt/world_codes.h"

namespace lode::tetra_mt {

/// The nodes that tetrahedra of the base wait for, ascending. All queries ask for their facts,
/// first of all an answer that states the errors of its cells: what files say of them lies with the
/// base, so that pages are read of nodes that are applied, and of what these discover.
struct FrontNodes {
  std::vector<std::uint32_t> nodes;
  std::vector<BoxCodes::Lines> boxes;       ///< By place.
  std::vector<std::uint64_t> region_masks;  ///< Of none where there is one region at most.

  /// The place of a node, none where no tetrahedron of the base waits for it.
  [[nodiscard]] std::optional<std::uint32_t> find(std::uint32_t node) const;
};

/// What they have for one field, by place.
struct FrontFacts {
  std::vector<FactCodes> facts;
  WorldPage world_errors;  ///< Of none where the field has none.
};

/// The base, by which what they have is guessed.
struct FrontBase {
  std::span<const Tetrahedron> tetrahedra;
  std::span<const std::uint32_t> makers;
  std::span<const Vec3d> positions;        ///< By vertex of the base.
  std::span<const std::uint32_t> regions;  ///< By tetrahedron; of none where all are of one.
};

/// Those that `makers` name.
[[nodiscard]] std::vector<std::uint32_t> front_nodes_of(std::span<const std::uint32_t> makers);

/// The bytes in a file of boxes and masks of `front`,
[[nodiscard]] std::vector<std::byte> encode_front(const FrontNodes& front, const FrontBase& base,
                                                  const BoxCodes& codes);
/// and these, of `front.nodes`. Fails on what no nodes have; `what`: the block, for messages.
[[nodiscard]] Result<void> decode_front(std::span<const std::byte> bytes, const std::string& what,
                                        const FrontBase& base, const BoxCodes& codes,
                                        std::uint32_t n_regions, FrontNodes& front);

/// Likewise of a field. `values`: by vertex of the base.
[[nodiscard]] std::vector<std::byte> encode_front_facts(const FrontFacts& facts,
                                                        std::span<const std::uint32_t> nodes,
                                                        const FrontBase& base,
                                                        std::span<const double> values,
                                                        const ValueScale& scale);
[[nodiscard]] Result<FrontFacts> decode_front_facts(std::span<const std::byte> bytes,
                                                    const std::string& what,
                                                    std::span<const std::uint32_t> nodes,
                                                    const FrontBase& base,
                                                    std::span<const double> values,
                                                    const ValueScale& scale, bool has_world_errors);

}  // namespace lode::tetra_mt

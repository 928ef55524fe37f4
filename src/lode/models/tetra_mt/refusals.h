#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace lode::tetra_mt {

/// Why a vertex is still there, by the rule that the edge met which passed most of them; in the
/// order in which they are asked. Of midpoints rules are an edge's, of which either end may move,
/// and extrema are asked for after regions.
enum class Refusal : std::uint8_t {
  /// Its link is no sphere; of midpoints, or no link beside it is one.
  non_manifold,
  /// All beside it have lower values of a field, or all higher ones; of midpoints, where one end is
  /// such a maximum and the other a minimum.
  extremum,
  boundary,  ///< The domain's would move too far.
  regions,   ///< What lies between regions would move too far, or ends there.
  shape,     ///< A tetrahedron would be flat or turned round.
  topology,  ///< The mesh, or regions, would be joined or parted.
  crowded,   ///< Too many vertices would be, or are, beside one.
  rounding,  ///< No tetrahedron would be sure to cover a sample; of builds that end early, the
             ///< vertex.
  limit,     ///< None: as few cells are left as were asked for, or nearly; or hardly any would go.
};

/// Of vertices, by refusal.
struct RefusalCounts {
  static constexpr std::size_t kSize = 9;

  std::array<std::uint64_t, kSize> counts{};

  [[nodiscard]] std::uint64_t operator[](Refusal refusal) const {
    return counts[static_cast<std::size_t>(refusal)];
  }
  void add(Refusal refusal) { ++counts[static_cast<std::size_t>(refusal)]; }
};

}  // namespace lode::tetra_mt

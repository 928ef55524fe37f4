#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "lode/api/tetra_dataset.h"
#include "lode/refine/focus.h"

namespace lode {

// What is asked of a TetraDataset.

/// With the tolerance that is meant where none is given. Fails on what cannot be asked.
[[nodiscard]] Result<Query> complete_query(const TetraFieldInfo& field, Query query,
                                           const std::optional<double>& deadline_s);
/// Places of patches by their names or numbers.
[[nodiscard]] Result<std::vector<std::uint32_t>> find_patches(const TetraInfo& info,
                                                              std::span<const std::string> wanted);

/// Fails on a number that no region has.
[[nodiscard]] Result<void> check_regions(const TetraInfo& info,
                                         std::span<const std::int64_t> regions);
[[nodiscard]] Result<void> check_fields(const TetraInfo& info, const TetraFieldUse& use);

/// Whether it asks for more than errors in field units.
[[nodiscard]] inline bool needs_world_errors(const Query& query) {
  return query.max_world_error || query.max_error_px;
}

/// `widening`: how much sections are, world units, as mesh vertices near one count as in it.
[[nodiscard]] Demand demand_of(Query query, double widening);
/// The same where it meets regions; everywhere for none. `regions`: numbers that there are.
[[nodiscard]] Demand in_regions(Demand demand, const TetraInfo& info,
                                std::span<const std::int64_t> regions);

}  // namespace lode

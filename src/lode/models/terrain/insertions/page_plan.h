#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/models/terrain/insertions/history.h"
#include "lode/models/terrain/insertions/page.h"

namespace lode::insertions {

/// Which nodes are in which page of a file.
struct PagePlan {
  std::vector<Band> bands;
  std::vector<std::uint32_t> nodes;       ///< Page by page; in a page ascending.
  std::vector<std::uint32_t> first_node;  ///< By page, and one more.
};

/// Bands end at levels, and where there are about twice as many nodes as before; pages are what
/// halving a band again and again across its longer side leaves.
[[nodiscard]] PagePlan plan_pages(const History& history, std::span<const std::uint32_t> times,
                                  std::uint32_t n_page_nodes);

/// What a page of the plan holds.
[[nodiscard]] PageNodes page_nodes(const History& history, std::span<const std::uint32_t> nodes);
[[nodiscard]] PageEntry page_entry(const PageNodes& nodes);

}  // namespace lode::insertions

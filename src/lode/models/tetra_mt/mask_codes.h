#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/tetra_mt/number_models.h"
#include "lode/models/tetra_mt/page_tree.h"
#include "lode/models/tetra_mt/region_masks.h"

namespace lode::tetra_mt {

struct MaskModels {
  NumberModel sizes;
  WideModel masks;
  std::array<BitModel, 2> is_expected;
  NumberModel places;
};

/// Codes the masks of regions of a page's nodes: those that differ, the most frequent first; and
/// where there are several, of each node which. It is mostly what the node discovers in the page
/// has together, or, of one that discovers nothing there, what the node before has.
template <typename Coder>
class MaskCoder {
 public:
  MaskCoder(Coder& coder, MaskModels& models) : coder_(coder), models_(models) {}

  /// `given`: by node, for a writer; fills `masks`. Fails on what no page has.
  Result<void> code(const PageTree& tree, std::uint32_t n_regions,
                    std::span<const std::uint64_t> given, const std::string& what,
                    std::vector<std::uint64_t>& masks) {
    LODE_CHECK(code_table(tree.n_nodes(), n_regions, given, what));
    masks.assign(tree.n_nodes(), table_.front());
    if (table_.size() == 1) return {};
    std::uint64_t last = table_.front();
    for (const std::uint16_t i : tree.order) {
      const bool discovers = !tree.found[i].empty();
      std::uint64_t expected = discovers ? 0 : last;
      for (const std::uint16_t child : tree.found[i]) expected |= masks[child];
      const std::uint64_t mask = Coder::kReads ? 0 : given[i];
      last = expected;
      if (!coder_.bit(models_.is_expected[discovers ? 1 : 0], mask == expected)) {
        const std::uint32_t place = models_.places.code(coder_, Coder::kReads ? 0 : place_of(mask));
        if (place >= table_.size())
          return fail("{}: node {}: expected one of {} masks, got {}", what, i, table_.size(),
                      place);
        last = table_[place];
      }
      masks[i] = last;
    }
    return {};
  }

 private:
  [[nodiscard]] std::uint32_t place_of(std::uint64_t mask) const {
    return static_cast<std::uint32_t>(std::ranges::find(table_, mask) - table_.begin());
  }
  static std::vector<std::uint64_t> table_of(std::span<const std::uint64_t> masks) {
    std::map<std::uint64_t, std::uint32_t> counts;
    for (const std::uint64_t mask : masks) ++counts[mask];
    std::vector<std::uint64_t> table;
    table.reserve(counts.size());
    for (const auto& [mask, n] : counts) table.push_back(mask);
    std::ranges::stable_sort(
        table, [&](std::uint64_t a, std::uint64_t b) { return counts.at(a) > counts.at(b); });
    return table;
  }
  Result<void> code_table(std::uint32_t n_nodes, std::uint32_t n_regions,
                          std::span<const std::uint64_t> given, const std::string& what) {
    const std::vector<std::uint64_t> wanted = table_of(given);
    const auto n_given = static_cast<std::uint32_t>(wanted.size());
    const std::uint32_t n = models_.sizes.code(coder_, n_given - (Coder::kReads ? 0 : 1)) + 1;
    if (n > n_nodes)
      return fail("{}: expected up to {} masks of regions, got {}", what, n_nodes, n);
    table_.clear();
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint64_t mask = models_.masks.code(coder_, Coder::kReads ? 0 : wanted[k]);
      if (mask == 0 || (mask & ~mask_of_all(n_regions)) != 0 ||
          std::ranges::find(table_, mask) != table_.end())
        return fail("{}: expected masks of {} regions that differ, got {:#x}", what, n_regions,
                    mask);
      table_.push_back(mask);
    }
    return {};
  }

  Coder& coder_;
  MaskModels& models_;
  std::vector<std::uint64_t> table_;
};

}  // namespace lode::tetra_mt

#pragma once

#include <algorithm>
#include <atomic>
#include <span>
#include <string>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/models/diamond/read_region.h"

namespace lode::diamond {

/// A block that cannot be used, and why.
template <int D>
struct LostRegion {
  Region<D> region;
  Kind kind = Kind::samples;
  std::string reason;
};

/// Reads the blocks of a kind as far as they are whole, in parallel: use(i, bytes) takes those of
/// region i, or refuses them before it has put them anywhere. Appends all others to `lost`, in the
/// regions' order. Fails on cancel only.
template <int D, typename Use>
[[nodiscard]] Result<void> salvage_blocks(const store::Reader& reader,
                                          std::span<const Region<D>> regions, Kind kind,
                                          std::size_t element_size, Threads threads,
                                          Progress& progress, const Use& use,
                                          std::vector<LostRegion<D>>& lost) {
  std::vector<Error> errors(regions.size());
  std::atomic<std::size_t> n_done{0};
  parallel_for(regions.size(), threads, 1, [&](std::size_t i, int) {
    if (progress.is_cancelled()) return;
    const auto bytes = read_region<D>(reader, regions[i], kind, element_size);
    if (!bytes)
      errors[i] = bytes.error();
    else if (const Result<void> used = use(i, *bytes); !used)
      errors[i] = used.error();
    progress.report("salvaging",
                    static_cast<double>(++n_done) / static_cast<double>(regions.size()));
  });
  if (progress.is_cancelled()) return cancelled_error();
  for (std::size_t i = 0; i < regions.size(); ++i)
    if (!errors[i].message.empty()) lost.push_back({regions[i], kind, errors[i].message});
  return {};
}

}  // namespace lode::diamond

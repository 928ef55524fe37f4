#include "lode/api/salvage_report.h"

#include <algorithm>
#include <limits>
#include <new>

#include "lode/models/diamond/block_layout.h"
#include "lode/store/header.h"

namespace lode {
namespace {

std::string name_of_kind(std::uint32_t kind) {
  switch (static_cast<diamond::Kind>(kind)) {
    case diamond::Kind::samples: return "samples";
    case diamond::Kind::errors: return "errors";
    case diamond::Kind::lows: return "minima";
    case diamond::Kind::worlds: return "world errors";
    default: return "maxima";
  }
}

Box3d joined(const Box3d& a, const Box3d& b) {
  Box3d box;
  for (std::size_t i = 0; i < 3; ++i) {
    box.lower[i] = std::min(a.lower[i], b.lower[i]);
    box.upper[i] = std::max(a.upper[i], b.upper[i]);
  }
  return box;
}

/// Of the cells that touch these samples.
Box3d world_box(const RegularGrid& grid, const IndexBox& samples) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Box3d box{{{kInfinity, kInfinity, kInfinity}}, {{-kInfinity, -kInfinity, -kInfinity}}};
  for (unsigned corner = 0; corner < 8; ++corner) {
    Vec3d index;
    for (std::size_t i = 0; i < 3; ++i)
      index[i] = (corner >> i & 1U) == 0 ? std::max(samples.lower[i] - 1, 0)
                                         : std::min(samples.upper[i], grid.dims[i] - 1);
    const Vec3d p = grid.to_world(index);
    box = joined(box, {p, p});
  }
  return box;
}

void add_to_levels(const LostBlock& block, std::vector<LostLevel>& levels) {
  auto at = std::ranges::lower_bound(levels, block.level, {}, &LostLevel::level);
  if (at == levels.end() || at->level != block.level)
    at = levels.insert(at, LostLevel{.level = block.level});
  ++at->n_blocks;
  at->n_samples += block.n_samples;
  at->max_error = std::max(at->max_error, block.max_error);
}

}  // namespace

Result<store::Reader> open_damaged(const std::string& path) {
  auto reader = store::Reader::open(path, {.length = store::Length::any});
  if (reader || !store::starts_as_lode(path)) return reader;
  return fail(
      "{}; nothing can be salvaged: only the directory, at the end, and the indexes before blocks "
      "say what these are",
      reader.error().message);
}

bool can_salvage(const std::string& path) try {
  return open_damaged(path).has_value();
} catch (const std::bad_alloc&) {
  return false;
}

SalvageReport to_report(const diamond::SalvageReport& found, const RegularGrid& grid) {
  SalvageReport report{.n_blocks = found.n_blocks,
                       .blocks = {},
                       .levels = {},
                       .n_samples = found.n_samples,
                       .max_error = found.max_error,
                       .box = {},
                       .n_lost_holes = found.n_lost_holes,
                       .n_filled_holes = found.n_holes};
  for (const diamond::LostBlock& lost : found.lost) {
    LostBlock block{.kind = name_of_kind(lost.key.kind),
                    .level = static_cast<int>(lost.key.level),
                    .position = lost.key.position,
                    .reason = lost.reason,
                    .n_samples = lost.n_samples,
                    .box = {},
                    .max_error = lost.max_error};
    if (lost.n_samples > 0) {
      block.box = world_box(grid, lost.box);
      report.box = report.box ? joined(*report.box, *block.box) : *block.box;
    }
    add_to_levels(block, report.levels);
    report.blocks.push_back(std::move(block));
  }
  return report;
}

}  // namespace lode

#include "lode/io/border_plan.h"

#include <algorithm>

namespace lode::io {
namespace {

constexpr int kNone = -1;

IndexRange intersection_of(const IndexRange& a, const IndexRange& b) {
  return {std::max(a.lower, b.lower), std::min(a.upper, b.upper)};
}

/// A part, and what it wants of a unit.
struct Wish {
  int part = 0;
  IndexRange range;
};

std::vector<Wish> wishes_for(const IndexRange& unit, std::span<const IndexRange> parts) {
  std::vector<Wish> wishes;
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (const IndexRange range = intersection_of(unit, parts[i]); range.size() > 0)
      wishes.push_back({static_cast<int>(i), range});
  return wishes;
}

/// What is kept of a unit that `owner` decodes, and how many samples the others read of it.
struct Keeping {
  std::vector<IndexRange> ranges;
  std::int64_t n_written = 0;
  std::int64_t n_read = 0;
};

Keeping keep_for_others(std::span<const Wish> wishes, int owner) {
  Keeping keeping;
  for (const Wish& wish : wishes) {
    if (wish.part == owner) continue;
    keeping.n_read += wish.range.size();
    if (keeping.ranges.empty() || keeping.ranges.back().upper < wish.range.lower)
      keeping.ranges.push_back(wish.range);
    keeping.ranges.back().upper = std::max(keeping.ranges.back().upper, wish.range.upper);
  }
  for (const IndexRange& range : keeping.ranges) keeping.n_written += range.size();
  return keeping;
}

}  // namespace

BorderPlan::BorderPlan(const AxisReads& reads) {
  if (reads.parts.size() < 2 || reads.unit < 2) return;
  const std::int32_t end = reads.parts.back().upper;
  for (std::int32_t lower = 0; lower < end;) {
    const IndexRange unit{lower, reads.unit < end - lower ? lower + reads.unit : end};
    plan_unit(reads, unit);
    lower = unit.upper;
  }
}

void BorderPlan::plan_unit(const AxisReads& reads, IndexRange unit) {
  const std::vector<Wish> wishes = wishes_for(unit, reads.parts);
  if (wishes.size() < 2) return;
  // A unit at the end is decoded with what lies beyond.
  const double decoding = reads.stored_share * static_cast<double>(reads.unit);
  double least = decoding * static_cast<double>(wishes.size());
  Keeping best;
  int owner = kNone;
  const auto consider = [&](int part, double decoded) {
    Keeping keeping = keep_for_others(wishes, part);
    const double bytes = decoded + static_cast<double>(keeping.n_written + keeping.n_read);
    if (bytes >= least) return;
    least = bytes;
    best = std::move(keeping);
    owner = part;
  };
  for (const Wish& wish : wishes) consider(wish.part, decoding);
  consider(kNone, 0);
  kept_.insert(kept_.end(), best.ranges.begin(), best.ranges.end());
  owners_.resize(kept_.size(), owner);
}

bool BorderPlan::keeps(std::int32_t i) const {
  return std::any_of(kept_.begin(), kept_.end(),
                     [i](const IndexRange& range) { return range.lower <= i && i < range.upper; });
}

std::vector<BorderPlan::Run> BorderPlan::runs_of(IndexRange range, int part) const {
  std::vector<Run> runs;
  std::int32_t done = range.lower;
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    const IndexRange here = intersection_of(kept_[i], range);
    if (here.size() == 0 || owners_[i] == part) continue;
    if (done < here.lower) runs.push_back({{done, here.lower}});
    runs.push_back({here, static_cast<int>(i)});
    done = here.upper;
  }
  if (done < range.upper) runs.push_back({{done, range.upper}});
  return runs;
}

}  // namespace lode::io

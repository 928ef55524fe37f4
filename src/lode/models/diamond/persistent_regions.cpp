#include "lode/models/diamond/persistent_regions.h"

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "lode/models/diamond/lattice.h"

namespace lode::diamond {
namespace {

/// Of a sample, a bit each.
enum Mark : std::uint8_t {
  may_be_inside = 1,
  may_be_outside = 2,
  seen_inside = 4,
  seen_outside = 8,
};

/// The steps of the finest tetrahedra's edges from a sample: they change coordinates that are all
/// even, or all odd. By which coordinates are odd, a bit each.
using Steps = std::array<std::vector<Index<3>>, 8>;

Steps edge_steps() {
  Steps steps;
  for (unsigned odd = 0; odd < steps.size(); ++odd)
    for (std::size_t i = 0; i < 27; ++i) {
      const Index<3> step = point_of<3>(all_equal<3>(3), i) - all_equal<3>(1);
      unsigned moved = 0;
      for (unsigned axis = 0; axis < 3; ++axis) moved |= step[axis] != 0 ? 1U << axis : 0;
      if (moved != 0 && ((moved & odd) == moved || (moved & odd) == 0)) steps[odd].push_back(step);
    }
  return steps;
}

class Flood {
 public:
  Flood(const Index3& dims, std::vector<std::uint8_t>& marks, const Progress& progress)
      : dims_(dims), marks_(marks), progress_(progress), steps_(edge_steps()) {}

  /// Of the regions of samples that have the mark `in`, those with one that has no other.
  std::uint64_t count(Mark in, Mark seen) {
    std::uint64_t n = 0;
    for (std::size_t i = 0; i < marks_.size() && !progress_.is_cancelled(); ++i) {
      if (marks_[i] != in) continue;
      ++n;
      front_.assign(1, i);
      marks_[i] |= seen;
      while (!front_.empty() && !progress_.is_cancelled()) advance(in, seen);
    }
    return n;
  }

 private:
  void advance(Mark in, Mark seen) {
    next_.clear();
    for (const std::size_t at : front_) {
      const Index<3> p = point_of<3>(dims_, at);
      const auto odd = static_cast<std::size_t>((p[0] & 1) | (p[1] & 1) << 1 | (p[2] & 1) << 2);
      for (const Index<3>& step : steps_[odd]) {
        const Index<3> q = p + step;
        bool is_sample = true;
        for (std::size_t a = 0; a < 3; ++a) is_sample = is_sample && q[a] >= 0 && q[a] < dims_[a];
        if (!is_sample) continue;
        const std::size_t other = linear_index<3>(dims_, q);
        if ((marks_[other] & (in | seen)) != in) continue;
        marks_[other] |= seen;
        next_.push_back(other);
      }
    }
    std::swap(front_, next_);
  }

  Index3 dims_;
  std::vector<std::uint8_t>& marks_;
  const Progress& progress_;
  Steps steps_;
  std::vector<std::size_t> front_;
  std::vector<std::size_t> next_;
};

}  // namespace

Result<PersistentRegions> count_persistent_regions(const FieldSamples& samples, double isovalue,
                                                   double persistence, Threads threads,
                                                   Progress& progress) {
  const Index3& dims = samples.grid().dims;
  std::vector<std::uint8_t> marks(n_points<3>(dims));
  const auto n_row = as_size(dims[0]);
  parallel_for(marks.size() / n_row, threads, 64, [&](std::size_t row, int) {
    for (std::size_t at = row * n_row; at < (row + 1) * n_row; ++at) {
      const double value = samples.sample(point_of<3>(dims, at));
      if (!std::isfinite(value)) continue;
      marks[at] = static_cast<std::uint8_t>((value >= isovalue - persistence ? may_be_inside : 0) |
                                            (value < isovalue + persistence ? may_be_outside : 0));
    }
  });
  Flood flood(dims, marks, progress);
  PersistentRegions found;
  found.inside = flood.count(may_be_inside, seen_inside);
  found.outside = flood.count(may_be_outside, seen_outside);
  if (progress.is_cancelled()) return cancelled_error();
  return found;
}

}  // namespace lode::diamond

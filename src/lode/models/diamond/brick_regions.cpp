#include "lode/models/diamond/brick_regions.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace lode::diamond {
namespace {

constexpr std::uint64_t kEven = 0x5555555555555555U;
constexpr std::uint64_t kAll = ~std::uint64_t{0};

/// Bits 0 to n - 1; n < 64.
std::uint64_t bits_below(int n) { return (std::uint64_t{1} << n) - 1; }

}  // namespace

std::uint32_t BrickRegions::Row::run_at(int x) const {
  return first + static_cast<std::uint32_t>(std::popcount(starts & bits_below(x + 1))) - 1;
}

std::uint64_t BrickRegions::Row::run_from(int x) const {
  const std::uint64_t later = (starts | ~present) & ~bits_below(x + 1);
  return bits_below(std::countr_zero(later)) & ~bits_below(x);  // rows end before bit 63
}

void BrickRegions::find(const RelaxedBox& box, const Index<3>& base, const LatticeBox<3>& own) {
  for (std::size_t i = 0; i < 3; ++i)
    size_[i] = std::min(base[i] + kBrickSamples<3>, box.sides().box().upper[i]) - base[i];
  parents_.clear();
  touching_runs_.clear();
  for (std::int32_t z = 0; z < size_[2]; ++z)
    for (std::int32_t y = 0; y < size_[1]; ++y)
      read_row(box, base + Index<3>{{0, y, z}}, row(y, z));
  for (std::int32_t z = 0; z < size_[2]; ++z)
    for (std::int32_t y = 0; y < size_[1]; ++y) join_neighbours(y, z);
  number_regions(base, own);
}

void BrickRegions::read_row(const RelaxedBox& box, const Index<3>& first, Row& row) {
  const float* const values = box.values_from(first);
  const std::uint8_t* const marks = box.marks_from(first);
  row = {};
  for (std::int32_t x = 0; x < size_[0]; ++x) {
    row.present |= std::uint64_t{!std::isnan(values[x])} << x;
    row.inside |= std::uint64_t{!std::signbit(values[x])} << x;
    row.fixed |= std::uint64_t{RelaxedBox::is_fixed(marks[x])} << x;
  }
  row.inside &= row.present;
  const std::uint64_t goes_on = row.present & row.present << 1 & ~(row.inside ^ row.inside << 1);
  row.starts = row.present & ~goes_on;
  row.first = static_cast<std::uint32_t>(parents_.size());
  const auto n = static_cast<std::uint32_t>(std::popcount(row.starts));
  for (std::uint32_t run = row.first; run < row.first + n; ++run) parents_.push_back(run);
  for (std::uint64_t ends = row.starts & row.present << 1; ends != 0; ends &= ends - 1) {
    const std::uint32_t run = row.run_at(std::countr_zero(ends));
    touching_runs_.emplace_back(run - 1, run);
  }
}

void BrickRegions::join_neighbours(std::int32_t y, std::int32_t z) {
  for (const auto& [dy, dz] : {std::pair{1, 0}, {0, 1}, {1, 1}, {-1, 1}}) {
    if (y + dy < 0 || y + dy >= size_[1] || z + dz >= size_[2]) continue;
    if (dy != 0 && dz != 0 && ((y ^ z) & 1) != 0) continue;
    const Row& other = row(y + dy, z + dz);
    const std::int32_t moved = dz != 0 ? z : y;
    join_rows(row(y, z), other, 0, kAll);
    for (const int dx : {-1, 1}) join_rows(row(y, z), other, dx, (moved & 1) == 0 ? kEven : ~kEven);
  }
}

void BrickRegions::join_rows(const Row& row, const Row& other, int dx, std::uint64_t mask) {
  const auto moved = [&](std::uint64_t bits) {
    return dx == 0 ? bits : dx > 0 ? bits >> 1 : bits << 1;
  };
  const std::uint64_t both = row.present & moved(other.present) & mask;
  const std::uint64_t differ = row.inside ^ moved(other.inside);
  const std::uint64_t starts = row.starts | moved(other.starts);
  const auto for_each_pair = [&](std::uint64_t bits, const auto& see) {
    while (bits != 0) {
      const int x = std::countr_zero(bits);
      see(row.run_at(x), other.run_at(x + dx));
      const std::uint64_t later = starts & ~bits_below(x + 1);
      if (later == 0) return;
      bits &= ~bits_below(std::countr_zero(later));
    }
  };
  for_each_pair(both & ~differ, [&](std::uint32_t a, std::uint32_t b) { join(a, b); });
  for_each_pair(both & differ,
                [&](std::uint32_t a, std::uint32_t b) { touching_runs_.emplace_back(a, b); });
}

std::uint32_t BrickRegions::root_of(std::uint32_t run) {
  while (parents_[run] != run) run = parents_[run] = parents_[parents_[run]];
  return run;
}

void BrickRegions::join(std::uint32_t a, std::uint32_t b) {
  a = root_of(a);
  b = root_of(b);
  parents_[std::max(a, b)] = std::min(a, b);
}

void BrickRegions::number_regions(const Index<3>& base, const LatticeBox<3>& own) {
  regions_.clear();
  labels_.resize(parents_.size());
  const std::uint64_t own_bits = bits_below(own.upper[0] - base[0]);
  for (std::int32_t z = 0; z < size_[2]; ++z)
    for (std::int32_t y = 0; y < size_[1]; ++y) {
      const Row& samples = row(y, z);
      const bool is_own = base[1] + y < own.upper[1] && base[2] + z < own.upper[2];
      std::uint32_t run = samples.first;
      for (std::uint64_t starts = samples.starts; starts != 0; starts &= starts - 1, ++run) {
        const int x = std::countr_zero(starts);
        const std::uint64_t bits = samples.run_from(x);
        const std::uint32_t root = root_of(run);
        if (root == run) {
          labels_[run] = static_cast<Label>(regions_.size());
          regions_.push_back({.is_inside = (samples.inside >> x & 1) != 0});
        }
        labels_[run] = labels_[root];
        Region& region = regions_[labels_[run]];
        region.is_fixed = region.is_fixed || (samples.fixed & bits) != 0;
        if (!is_own || (bits & own_bits) == 0) continue;
        if (region.n_own == 0) region.first = {{x, y, z}};
        region.n_own += static_cast<std::uint32_t>(std::popcount(bits & own_bits));
      }
    }
  touching_.clear();
  for (const auto& [a, b] : touching_runs_)
    touching_.push_back(std::minmax(labels_[a], labels_[b]));
  std::ranges::sort(touching_);
  touching_.erase(std::unique(touching_.begin(), touching_.end()), touching_.end());
}

std::vector<BrickRegions::Label> BrickRegions::face(std::size_t axis, bool is_last) const {
  Index<3> n = size_;
  n[axis] = 1;
  Index<3> first;
  first[axis] = is_last ? size_[axis] - 1 : 0;
  std::vector<Label> labels(n_points<3>(n), kNone);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const Index<3> p = first + point_of<3>(n, i);
    const Row& samples = row(p[1], p[2]);
    if ((samples.present >> p[0] & 1) != 0) labels[i] = labels_[samples.run_at(p[0])];
  }
  return labels;
}

std::uint64_t BrickRegions::row_of(std::int32_t y, std::int32_t z,
                                   const std::vector<bool>& is_marked) const {
  const Row& samples = row(y, z);
  std::uint64_t result = 0;
  for (std::uint64_t starts = samples.starts; starts != 0; starts &= starts - 1) {
    const int x = std::countr_zero(starts);
    if (is_marked[labels_[samples.run_at(x)]]) result |= samples.run_from(x);
  }
  return result;
}

}  // namespace lode::diamond

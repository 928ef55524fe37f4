#include "lode/models/tetra_mt/midpoint/coincident.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <utility>

namespace lode::tetra_mt::midpoint {
namespace {

std::array<std::uint64_t, 3> bits_of(const Vec3d& p) {
  return {std::bit_cast<std::uint64_t>(p[0]), std::bit_cast<std::uint64_t>(p[1]),
          std::bit_cast<std::uint64_t>(p[2])};
}

}  // namespace

bool is_same_place(const Vec3d& a, const Vec3d& b) { return bits_of(a) == bits_of(b); }

std::vector<std::uint32_t> by_place(std::span<const Vec3d> positions) {
  std::vector<std::uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::sort(order, {},
                    [&](std::uint32_t v) { return std::pair(bits_of(positions[v]), v); });
  return order;
}

std::vector<CoincidentRun> coincident_runs(std::span<const Vec3d> positions,
                                           std::span<const std::uint32_t> order) {
  std::vector<CoincidentRun> runs;
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    for (end = begin + 1;
         end < order.size() && is_same_place(positions[order[begin]], positions[order[end]]);)
      ++end;
    if (end - begin > 1) runs.push_back({begin, end});
  }
  return runs;
}

}  // namespace lode::tetra_mt::midpoint

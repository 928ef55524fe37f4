#include "lode/mappers/border_vertices.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace lode {
namespace {

/// Spreads a number over 64 bits (the finaliser of splitmix64), so that sums of different numbers
/// differ.
std::uint64_t spread(std::uint64_t n) {
  n += 0x9e3779b97f4a7c15U;
  n = (n ^ (n >> 30)) * 0xbf58476d1ce4e5b9U;
  n = (n ^ (n >> 27)) * 0x94d049bb133111ebU;
  return n ^ (n >> 31);
}

}  // namespace

/// Round a vertex inside, each neighbour comes once as the next and once as the one before.
std::vector<std::uint8_t> find_border_vertices(const Surface& surface) {
  std::vector<std::uint64_t> ends(surface.positions.size(), 0);
  for (const auto& t : surface.triangles) {
    const std::array<std::uint64_t, 3> spread_out{spread(t[0]), spread(t[1]), spread(t[2])};
    for (std::size_t k = 0; k < 3; ++k)
      ends[t[k]] += spread_out[(k + 1) % 3] - spread_out[(k + 2) % 3];
  }
  std::vector<std::uint8_t> is_border(ends.size());
  std::ranges::transform(ends, is_border.begin(),
                         [](std::uint64_t end) { return std::uint8_t{end != 0}; });
  return is_border;
}

}  // namespace lode

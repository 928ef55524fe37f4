#include "lode/mappers/coincident_vertices.h"

#include <algorithm>
#include <numeric>

namespace lode {

std::vector<std::uint32_t> find_coincident_vertices(std::span<const Vec3f> positions) {
  std::vector<std::uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), std::uint32_t{0});
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const Vec3f& p = positions[a];
    const Vec3f& q = positions[b];
    for (std::size_t i = 0; i < 3; ++i)
      if (p[i] != q[i]) return p[i] < q[i];
    return a < b;
  });
  std::vector<std::uint32_t> lowest(positions.size());
  std::uint32_t leader = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || positions[order[i]] != positions[leader]) leader = order[i];
    lowest[order[i]] = leader;
  }
  return lowest;
}

}  // namespace lode

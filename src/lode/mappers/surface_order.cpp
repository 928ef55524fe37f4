#include "lode/mappers/surface_order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <vector>

#include "lode/core/expects.h"

namespace lode {
namespace {

template <typename T>
void permute(const std::vector<std::uint32_t>& old_at, std::vector<T>& array) {
  if (array.empty()) return;
  std::vector<T> result;
  result.reserve(array.size());
  for (const std::uint32_t v : old_at) result.push_back(array[v]);
  array = std::move(result);
}

template <typename Cells>
void order_cells(const std::vector<std::uint32_t>& new_at, Cells& cells) {
  for (auto& cell : cells) {
    for (std::uint32_t& v : cell) v = new_at[v];
    // A line's direction says where lower values lie; a triangle's is kept by turning it.
    if constexpr (std::tuple_size_v<typename Cells::value_type> == 3)
      std::rotate(cell.begin(), std::min_element(cell.begin(), cell.end()), cell.end());
  }
  std::sort(cells.begin(), cells.end());
}

}  // namespace

void put_in_order(Surface& surface) {
  LODE_EXPECTS(surface.values.empty() && surface.origins.empty() && surface.errors.empty());
  std::vector<std::uint32_t> old_at(surface.positions.size());
  std::iota(old_at.begin(), old_at.end(), 0U);
  // As integers in the same order, which also puts what is no number somewhere.
  const auto rank = [](float x) {
    const auto bits = std::bit_cast<std::uint32_t>(x);
    return (bits >> 31) != 0 ? ~bits : bits | 0x80000000U;
  };
  const auto place = [&](std::uint32_t v) {
    const Vec3f& p = surface.positions[v];
    return std::array{rank(p[2]), rank(p[1]), rank(p[0])};
  };
  std::sort(old_at.begin(), old_at.end(),
            [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
  std::vector<std::uint32_t> new_at(old_at.size());
  for (std::uint32_t i = 0; i < old_at.size(); ++i) new_at[old_at[i]] = i;
  permute(old_at, surface.positions);
  permute(old_at, surface.normals);
  permute(old_at, surface.isovalues);
  order_cells(new_at, surface.triangles);
  order_cells(new_at, surface.lines);
}

}  // namespace lode

#include "lode/models/terrain/squares/tin_builder.h"

#include "lode/delaunay/triangle_judge.h"

namespace lode::squares {

delaunay::Tin TinBuilder::finish() const {
  const auto index = [&](delaunay::LatticePoint p) {
    return static_cast<std::size_t>(std::int64_t{p.y} * domain_.size_x() + p.x);
  };
  constexpr std::uint32_t kUnused = 0xFFFFFFFF;
  std::vector<std::uint32_t> number(
      static_cast<std::size_t>(std::int64_t{domain_.size_x()} * domain_.size_y()), kUnused);
  for (const auto& corners : corners_)
    for (const delaunay::LatticePoint& p : corners) number[index(p)] = 0;
  delaunay::Tin tin;
  for (std::int32_t y = 0; y < domain_.size_y(); ++y)
    for (std::int32_t x = 0; x < domain_.size_x(); ++x) {
      std::uint32_t& own = number[index({x, y})];
      if (own == kUnused) continue;
      own = static_cast<std::uint32_t>(tin.vertices.size());
      tin.vertices.push_back({x, y});
      tin.heights.push_back(domain_.height(x, y));
    }
  for (std::size_t t = 0; t < corners_.size(); ++t) {
    const auto& [a, b, c] = corners_[t];
    tin.triangles.push_back({number[index(a)], number[index(b)], number[index(c)]});
    tin.errors.push_back(delaunay::to_float_above(errors_[t]));
  }
  return tin;
}

}  // namespace lode::squares

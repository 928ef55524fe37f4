#include "lode/models/diamond/weak_regions.h"

#include <algorithm>
#include <vector>

#include "lode/mappers/stitch.h"

namespace lode::diamond {
namespace {

constexpr std::uint32_t kGone = ~std::uint32_t{0};

/// By vertex what becomes of it.
std::vector<std::uint32_t> new_numbers(const NodeSet<3>& samples, const AxisMap<3>& axes,
                                       const std::vector<EdgePoint>& points) {
  const auto is_weak = [&](LatticeKey end) {
    const Index3 p = to_point(end);
    Index<3> sample;
    for (std::size_t i = 0; i < 3; ++i) sample[i] = p[as_size(axes.axis[i])];
    return samples.contains(sample);
  };
  std::vector<std::uint32_t> numbers;
  numbers.reserve(points.size());
  std::uint32_t n_kept = 0;
  for (const EdgePoint& point : points)
    numbers.push_back(is_weak(point.first) == is_weak(point.second) ? n_kept++ : kGone);
  return numbers;
}

}  // namespace

void leave_out(const NodeSet<3>& samples, const AxisMap<3>& axes, StitchPart<3>& part) {
  auto& [points, cells, largest_step, largest_snap] = part.part;
  const std::vector<std::uint32_t> numbers = new_numbers(samples, axes, points);
  for (std::size_t v = 0; v < numbers.size(); ++v)
    if (numbers[v] != kGone) {
      points[numbers[v]] = points[v];
      if (!part.normals.empty()) part.normals[numbers[v]] = part.normals[v];
    }
  const auto is_gone = [&](std::uint32_t v) { return numbers[v] == kGone; };
  const auto n_kept = static_cast<std::size_t>(
      std::ranges::count_if(numbers, [](std::uint32_t number) { return number != kGone; }));
  points.resize(n_kept);
  if (!part.normals.empty()) part.normals.resize(n_kept);
  std::erase_if(cells, [&](const auto& cell) { return std::ranges::any_of(cell, is_gone); });
  for (auto& cell : cells)
    for (std::uint32_t& v : cell) v = numbers[v];
  std::erase_if(part.shared, [&](const auto& shared) { return is_gone(shared.second); });
  for (auto& shared : part.shared) shared.second = numbers[shared.second];
}

}  // namespace lode::diamond

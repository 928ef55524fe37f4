#include "lode/models/terrain/insertions/point_ground.h"

#include <algorithm>
#include <unordered_map>

#include "lode/delaunay/triangle_error.h"

namespace lode::insertions {

Result<History> begin_history(const PointGround& ground, Model model) {
  History history;
  history.model = model;
  history.is_of_points = true;
  history.frame = ground.frame;
  history.range = ground.range;
  LODE_CHECK(delaunay::check_heights(history.range));
  history.n_samples = ground.samples.nodes.size() - ground.n_left_out;
  history.n_left_out = ground.n_left_out;
  return history;
}

delaunay::PointMesh make_mesh(const PointGround& ground, Model model) {
  delaunay::PointMesh mesh(delaunay::ListedNodes(ground.samples.nodes), ground.triangles,
                           rule_of(model));
  // Edges of triangles that are split stay without being cut.
  if (rule_of(model) == delaunay::InsertionRule::delaunay) mesh.cut(ground.lines);
  return mesh;
}

std::vector<std::array<std::uint32_t, 2>> lines_between(const PointGround& ground,
                                                        std::span<const std::uint32_t> nodes) {
  const auto key = [](std::uint32_t a, std::uint32_t b) {
    return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
  };
  std::unordered_map<std::uint64_t, int> n_sides;
  for (const auto& [a, b] : ground.lines) n_sides[key(a, b)] = 0;
  for (const auto& corner : ground.triangles)
    for (std::size_t i = 0; i < 3; ++i)
      if (const auto found = n_sides.find(key(corner[i], corner[(i + 1) % 3]));
          found != n_sides.end())
        ++found->second;
  std::unordered_map<std::uint32_t, std::uint32_t> vertex_of;
  for (std::uint32_t v = 0; v < nodes.size(); ++v) vertex_of.emplace(nodes[v], v);
  std::vector<std::array<std::uint32_t, 2>> lines;
  for (const auto& [ends, n] : n_sides) {
    if (n < 2) continue;
    const std::uint32_t a = vertex_of.at(static_cast<std::uint32_t>(ends >> 32));
    const std::uint32_t b = vertex_of.at(static_cast<std::uint32_t>(ends));
    lines.push_back({std::min(a, b), std::max(a, b)});
  }
  std::ranges::sort(lines);
  return lines;
}

}  // namespace lode::insertions

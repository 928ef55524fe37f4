#include "lode/models/tetra_mt/space_blocks.h"

#include <algorithm>
#include <array>
#include <utility>

namespace lode::tetra_mt {
namespace {

std::size_t longest_side(std::span<const Vec3d> positions, std::span<const std::uint32_t> points) {
  Vec3d lower = positions[points[0]];
  Vec3d upper = lower;
  for (const std::uint32_t p : points)
    for (std::size_t i = 0; i < 3; ++i) {
      lower[i] = std::min(lower[i], positions[p][i]);
      upper[i] = std::max(upper[i], positions[p][i]);
    }
  const Vec3d sides = upper - lower;
  return static_cast<std::size_t>(std::ranges::max_element(sides.v) - sides.v.begin());
}

/// Returns how many of the points come first.
std::size_t cut(std::span<const Vec3d> positions, std::span<std::uint32_t> points, double share) {
  const std::size_t axis = longest_side(positions, points);
  const auto n = static_cast<std::size_t>(share * static_cast<double>(points.size()));
  const std::size_t below = std::clamp<std::size_t>(n, 1, points.size() - 1);
  std::nth_element(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(below),
                   points.end(), [&](std::uint32_t a, std::uint32_t b) {
                     return std::pair(positions[a][axis], a) < std::pair(positions[b][axis], b);
                   });
  return below;
}

using BlockSlots = std::vector<std::vector<std::uint32_t>>;

/// Adds some slots of all to the lists of blocks.
void add_slots(std::span<const std::uint32_t> block_of, std::span<const Tetrahedron> tetrahedra,
               std::uint32_t begin, std::uint32_t end, BlockSlots& lists) {
  for (std::uint32_t slot = begin; slot < end; ++slot) {
    const Tetrahedron& t = tetrahedra[slot];
    if (t[0] == kNone) continue;
    std::array<std::uint32_t, 4> of{};
    for (std::size_t k = 0; k < 4; ++k) {
      of[k] = block_of[t[k]];
      bool is_new = of[k] != kNone;
      for (std::size_t j = 0; j < k; ++j) is_new = is_new && of[j] != of[k];
      if (is_new) lists[of[k]].push_back(slot);
    }
  }
}

/// By block, ascending: few parts of all slots first, as each has a list for every block, then
/// these one after the other.
BlockSlots find_slots(const MeshBlocks& blocks, std::span<const Tetrahedron> tetrahedra,
                      Threads threads) {
  constexpr std::size_t kMostParts = 16;
  constexpr std::size_t kSmallest = 1U << 16;
  const std::size_t n = tetrahedra.size();
  const std::size_t size = std::max(kSmallest, (n + kMostParts - 1) / kMostParts);
  std::vector<BlockSlots> parts((n + size - 1) / size, BlockSlots(blocks.size()));
  parallel_for(parts.size(), threads, 1, [&](std::size_t i, int) {
    add_slots(blocks.block_of, tetrahedra, static_cast<std::uint32_t>(i * size),
              static_cast<std::uint32_t>(std::min(n, (i + 1) * size)), parts[i]);
  });
  BlockSlots slots(blocks.size());
  parallel_for(blocks.size(), threads, 1, [&](std::size_t b, int) {
    std::size_t n_slots = 0;
    for (const BlockSlots& part : parts) n_slots += part[b].size();
    slots[b].reserve(n_slots);
    for (const BlockSlots& part : parts)
      slots[b].insert(slots[b].end(), part[b].begin(), part[b].end());
  });
  return slots;
}

}  // namespace

SpaceBlocks cut_in_blocks(std::span<const Vec3d> positions, std::vector<std::uint32_t> points,
                          std::size_t max_size, double share, Threads threads) {
  SpaceBlocks blocks;
  blocks.points = std::move(points);
  blocks.begins = {0};
  if (blocks.points.empty()) return blocks;
  blocks.begins.push_back(blocks.points.size());
  for (int depth = 0;; ++depth) {
    std::vector<std::size_t> sizes(2 * blocks.size(), 0);  // of the halves, the second may be none
    parallel_for(blocks.size(), threads, 1, [&](std::size_t b, int) {
      const std::span<std::uint32_t> all =
          std::span(blocks.points)
              .subspan(blocks.begins[b], blocks.begins[b + 1] - blocks.begins[b]);
      const bool is_small = all.size() <= max_size;
      sizes[2 * b] = is_small ? all.size() : cut(positions, all, depth < 3 ? share : 0.5);
      sizes[2 * b + 1] = all.size() - sizes[2 * b];
    });
    std::erase(sizes, 0);
    if (sizes.size() == blocks.size()) break;
    blocks.begins = {0};
    for (const std::size_t size : sizes) blocks.begins.push_back(blocks.begins.back() + size);
  }
  parallel_for(blocks.size(), threads, 1, [&](std::size_t b, int) {
    const auto begin = blocks.points.begin();
    std::sort(begin + static_cast<std::ptrdiff_t>(blocks.begins[b]),
              begin + static_cast<std::ptrdiff_t>(blocks.begins[b + 1]));
  });
  return blocks;
}

MeshBlocks cut_mesh(std::span<const Vec3d> positions, std::vector<std::uint32_t> vertices,
                    std::span<const Tetrahedron> tetrahedra, std::size_t max_size, double share,
                    Threads threads) {
  MeshBlocks blocks;
  blocks.vertices = cut_in_blocks(positions, std::move(vertices), max_size, share, threads);
  blocks.block_of.assign(positions.size() + 1, kNone);  // and of the one outside
  for (std::uint32_t b = 0; b < blocks.size(); ++b)
    for (const std::uint32_t v : blocks.vertices.of(b)) blocks.block_of[v] = b;
  blocks.slots = find_slots(blocks, tetrahedra, threads);
  return blocks;
}

}  // namespace lode::tetra_mt

#include "lode/mappers/zero_normals.h"

#include <algorithm>
#include <atomic>

namespace lode {
namespace {

constexpr std::size_t kChunk = 1 << 16;

}  // namespace

ZeroNormals::ZeroNormals(std::span<const Vec3f> normals, Threads threads)
    : words_(normals.size() / 64 + 1, 0) {
  const std::size_t n = normals.size();
  std::atomic<bool> is_any{false};
  parallel_for((n + kChunk - 1) / kChunk, threads, 1, [&](std::size_t chunk, int) {
    std::uint64_t any = 0;
    for (std::size_t v = chunk * kChunk; v < std::min(n, (chunk + 1) * kChunk); v += 64) {
      std::uint64_t bits = 0;
      for (std::size_t i = 0; i < std::min<std::size_t>(64, n - v); ++i) {
        const Vec3f& normal = normals[v + i];
        const bool is_zero = normal[0] == 0 && normal[1] == 0 && normal[2] == 0;
        bits |= std::uint64_t{is_zero} << i;
      }
      words_[v / 64] = bits;
      any |= bits;
    }
    if (any != 0) is_any = true;
  });
  is_any_ = is_any;
}

std::vector<std::uint32_t> ZeroNormals::triangles_at(const Surface& surface,
                                                     Threads threads) const {
  std::vector<std::uint32_t> all;
  if (!is_any_) return all;
  const auto& triangles = surface.triangles;
  std::vector<std::vector<std::uint32_t>> found((triangles.size() + kChunk - 1) / kChunk);
  parallel_for(found.size(), threads, 1, [&](std::size_t chunk, int) {
    for (std::size_t t = chunk * kChunk; t < std::min(triangles.size(), (chunk + 1) * kChunk); ++t)
      if (std::ranges::any_of(triangles[t], [&](std::uint32_t v) { return has(v); }))
        found[chunk].push_back(static_cast<std::uint32_t>(t));
  });
  for (const auto& chunk : found) all.insert(all.end(), chunk.begin(), chunk.end());
  return all;
}

void fill_zero_normals(Surface& surface, Threads threads) {
  const ZeroNormals zeros(surface.normals, threads);
  for (const std::uint32_t i : zeros.triangles_at(surface, threads)) {
    const auto& t = surface.triangles[i];
    const Vec3f area = area_vector(surface, t);
    for (const std::uint32_t v : t)
      if (zeros.has(v)) surface.normals[v] = surface.normals[v] + area;
  }
  zeros.for_each([&](std::uint32_t v) { surface.normals[v] = normalized(surface.normals[v]); });
}

}  // namespace lode

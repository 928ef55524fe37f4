#include "lode/models/tetra_mt/star.h"

#include <bit>

namespace lode::tetra_mt {
namespace {

constexpr std::uint8_t kNoPlace = 0xFF;
constexpr std::uint8_t kSeen = 0xFE;

std::uint64_t bit(int place) { return std::uint64_t{1} << place; }

}  // namespace

bool StarGatherer::gather(std::uint32_t vertex, Star& star) {
  star.vertex = vertex;
  star.n_link = 0;
  star.outside = -1;
  const auto slots = mesh_.star(vertex);
  star.n_triangles = static_cast<int>(slots.size());
  if (slots.empty() || slots.size() > Star::kMaxTriangles) return false;
  bool fits = true;
  for (std::size_t i = 0; i < slots.size() && fits; ++i) {
    const Tetrahedron& t = mesh_.corners(slots[i]);
    std::size_t place = 0;
    while (t[place] != vertex) ++place;
    const auto face = others(t, place);
    star.slots[i] = slots[i];
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint8_t& at = places_[face[k]];
      if (at == kNoPlace) {
        if (star.n_link == Star::kMaxLink) {
          fits = false;
          break;
        }
        at = static_cast<std::uint8_t>(star.n_link);
        star.adjacent[at] = 0;
        star.link[at] = face[k];
        if (face[k] == mesh_.outside()) star.outside = at;
        ++star.n_link;
      }
      star.triangles[i][k] = at;
    }
    if (!fits) break;
    const auto& s = star.triangles[i];
    for (std::size_t k = 0; k < 3; ++k)
      star.adjacent[s[k]] |= bit(s[(k + 1) % 3]) | bit(s[(k + 2) % 3]);
  }
  for (int i = 0; i < star.n_link; ++i) places_[star.link[static_cast<std::size_t>(i)]] = kNoPlace;
  return fits;
}

bool StarGatherer::is_manifold(const Star& star) {
  if (star.n_link < 4 || star.n_triangles != 2 * star.n_link - 4) return false;
  // Round each link vertex the triangles are one cycle.
  for (int i = 0; i < star.n_link; ++i) {
    std::array<std::uint8_t, Star::kMaxLink> next;
    next.fill(kNoPlace);
    int n = 0;
    int first = 0;
    for (int t = 0; t < star.n_triangles; ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& v = star.triangles[static_cast<std::size_t>(t)];
        if (v[k] != i) continue;
        first = v[(k + 1) % 3];
        if (next[static_cast<std::size_t>(first)] != kNoPlace) return false;  // wound another way
        next[static_cast<std::size_t>(first)] = v[(k + 2) % 3];
        ++n;
      }
    int n_walked = 1;
    for (int at = next[static_cast<std::size_t>(first)]; at != first && n_walked <= n; ++n_walked) {
      if (at == kNoPlace) return false;
      at = next[static_cast<std::size_t>(at)];
    }
    if (n_walked != n) return false;
  }
  std::uint64_t reached = 1;
  for (std::uint64_t last = 0; reached != last;) {
    last = reached;
    for (std::uint64_t left = reached; left != 0; left &= left - 1)
      reached |= star.adjacent[static_cast<std::size_t>(std::countr_zero(left))];
  }
  return std::popcount(reached) == star.n_link;
}

bool StarGatherer::may_collapse(const Star& star, int kept, int max_link) {
  const std::uint32_t vertex = star.link[static_cast<std::size_t>(kept)];
  for (int i = 0; i < star.n_link; ++i)
    places_[star.link[static_cast<std::size_t>(i)]] = static_cast<std::uint8_t>(i);
  // The edge's own link: a cycle.
  std::array<std::uint64_t, Star::kMaxLink> ring{};
  for (int i = 0; i < star.n_triangles; ++i) {
    if (!star.has(i, kept)) continue;
    const auto& t = star.triangles[static_cast<std::size_t>(i)];
    const int sum = t[0] + t[1] + t[2] - kept;
    for (const std::uint8_t a : t)
      if (a != kept) ring[a] |= bit(sum - a);
  }
  const std::uint64_t around = star.adjacent[static_cast<std::size_t>(kept)];
  bool may = true;
  int n_beside = 0;  // of the kept one's link what the other's has not
  seen_.clear();
  for (const std::uint32_t slot : mesh_.star(vertex)) {
    std::array<int, 3> common{};
    int n_common = 0;
    bool has_removed = false;
    for (const std::uint32_t v : mesh_.corners(slot)) {
      if (v == vertex) continue;
      if (v == star.vertex) has_removed = true;
      std::uint8_t& at = places_[v];
      if (at < Star::kMaxLink) {
        common[static_cast<std::size_t>(n_common++)] = at;
      } else if (at == kNoPlace && v != star.vertex) {
        at = kSeen;
        seen_.push_back(v);
        ++n_beside;
      }
    }
    if (has_removed) continue;
    if (n_common == 3) {
      // Both ends have the triangle: one tetrahedron would come twice.
      for (int i = 0; i < star.n_triangles && may; ++i)
        may = !(star.has(i, common[0]) && star.has(i, common[1]) && star.has(i, common[2]));
    }
    for (int i = 0; i < n_common; ++i) {
      const int a = common[static_cast<std::size_t>(i)];
      may = may && (around >> a & 1) != 0;
      for (int j = i + 1; j < n_common; ++j) {
        const int b = common[static_cast<std::size_t>(j)];
        const auto row = static_cast<std::size_t>(a);
        may = may && ((star.adjacent[row] >> b & 1) == 0 || (ring[row] >> b & 1) != 0);
      }
    }
    if (!may) break;
  }
  for (const std::uint32_t v : seen_) places_[v] = kNoPlace;
  for (int i = 0; i < star.n_link; ++i) places_[star.link[static_cast<std::size_t>(i)]] = kNoPlace;
  return may && star.n_link - 1 + n_beside <= max_link;
}

}  // namespace lode::tetra_mt

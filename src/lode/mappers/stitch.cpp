#include "lode/mappers/stitch.h"

#include <algorithm>
#include <limits>

namespace lode {
namespace {

constexpr std::uint32_t kOwned = 0xFFFFFFFFU;

/// Per part: which vertices it owns, their rank among those, and who owns the others.
struct Ownership {
  std::vector<std::uint32_t> owner;  ///< Part, or kOwned.
  std::vector<std::uint32_t> id;     ///< Rank here when owned, local id in the owner otherwise.
  std::uint32_t n_owned = 0;
};

template <int D>
const std::uint32_t* find_shared_vertex(const StitchPart<D>& part, LatticeKey key) {
  const auto at = std::lower_bound(part.shared.begin(), part.shared.end(), key,
                                   [](const auto& entry, LatticeKey k) { return entry.first < k; });
  return at != part.shared.end() && at->first == key ? &at->second : nullptr;
}

template <int D, typename Candidates>
void find_owners(const std::vector<StitchPart<D>>& parts, std::uint32_t self,
                 const Candidates& candidates, Ownership& out) {
  const StitchPart<D>& part = parts[self];
  out.owner.assign(part.part.points.size(), kOwned);
  out.id.assign(part.part.points.size(), 0);
  std::vector<std::uint32_t> others;
  for (const auto& [key, vertex] : part.shared) {
    others.clear();
    candidates(key, others);
    for (const std::uint32_t other : others) {
      if (other >= self) break;
      const std::uint32_t* there = find_shared_vertex<D>(parts[other], key);
      if (there == nullptr) continue;
      out.owner[vertex] = other;
      out.id[vertex] = *there;
      break;
    }
  }
  for (std::uint32_t v = 0; v < out.owner.size(); ++v)
    if (out.owner[v] == kOwned) out.id[v] = out.n_owned++;
}

}  // namespace

template <int D>
void find_shared(StitchPart<D>& part, const std::function<bool(const EdgePoint&)>& is_shared) {
  part.shared.clear();
  const auto& points = part.part.points;
  for (std::uint32_t v = 0; v < points.size(); ++v)
    if (is_shared(points[v])) part.shared.emplace_back(points[v].doubled_midpoint(), v);
  std::sort(part.shared.begin(), part.shared.end());
}

template <int D>
Result<void> stitch(const std::vector<StitchPart<D>>& parts,
                    const std::function<void(LatticeKey, std::vector<std::uint32_t>&)>& candidates,
                    const LatticeFrame& frame, Threads threads, Surface& surface,
                    std::vector<VertexOrigin>* origins) {
  std::vector<Ownership> ownership(parts.size());
  parallel_for(parts.size(), threads, 8, [&](std::size_t i, int) {
    find_owners<D>(parts, static_cast<std::uint32_t>(i), candidates, ownership[i]);
  });
  std::uint64_t n_vertices = surface.positions.size();
  for (const Ownership& own : ownership) n_vertices += own.n_owned;
  if (n_vertices > std::numeric_limits<std::uint32_t>::max())
    return fail("the surface has {} vertices, more than {}: give it a larger tolerance", n_vertices,
                std::numeric_limits<std::uint32_t>::max());
  std::vector<std::uint32_t> first_vertex(parts.size() + 1);
  std::vector<std::size_t> first_cell(parts.size() + 1);
  first_vertex[0] = static_cast<std::uint32_t>(surface.positions.size());
  auto& cells = [&]() -> auto& {
    if constexpr (D == 3)
      return surface.triangles;
    else
      return surface.lines;
  }
  ();
  first_cell[0] = cells.size();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    first_vertex[i + 1] = first_vertex[i] + ownership[i].n_owned;
    first_cell[i + 1] = first_cell[i] + parts[i].part.cells.size();
  }
  surface.positions.resize(first_vertex.back());
  cells.resize(first_cell.back());
  if (origins != nullptr) origins->resize(first_vertex.back());
  parallel_for(parts.size(), threads, 8, [&](std::size_t i, int) {
    const IsoPart<D>& part = parts[i].part;
    const Ownership& own = ownership[i];
    std::vector<std::uint32_t> final_id(part.points.size());
    for (std::uint32_t v = 0; v < part.points.size(); ++v) {
      if (own.owner[v] != kOwned) {
        final_id[v] = first_vertex[own.owner[v]] + ownership[own.owner[v]].id[own.id[v]];
        continue;
      }
      final_id[v] = first_vertex[i] + own.id[v];
      const Vec3d p = frame.position(part.points[v].lattice_position());
      surface.positions[final_id[v]] = {
          {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}};
      if (origins != nullptr) (*origins)[final_id[v]] = {static_cast<std::uint32_t>(i), v};
    }
    for (std::size_t c = 0; c < part.cells.size(); ++c)
      for (std::size_t k = 0; k < static_cast<std::size_t>(D); ++k)
        cells[first_cell[i] + c][k] = final_id[part.cells[c][k]];
  });
  return {};
}

template void find_shared<2>(StitchPart<2>&, const std::function<bool(const EdgePoint&)>&);
template void find_shared<3>(StitchPart<3>&, const std::function<bool(const EdgePoint&)>&);
template Result<void> stitch<2>(const std::vector<StitchPart<2>>&,
                                const std::function<void(LatticeKey, std::vector<std::uint32_t>&)>&,
                                const LatticeFrame&, Threads, Surface&, std::vector<VertexOrigin>*);
template Result<void> stitch<3>(const std::vector<StitchPart<3>>&,
                                const std::function<void(LatticeKey, std::vector<std::uint32_t>&)>&,
                                const LatticeFrame&, Threads, Surface&, std::vector<VertexOrigin>*);

}  // namespace lode

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

/// Which vertices of a part have a cell; only where clipping left some without.
class UsedVertices {
 public:
  UsedVertices() = default;
  template <int D>
  explicit UsedVertices(const IsoPart<D>& part) : is_partial_(part.is_clipped()) {
    if (!is_partial_) return;
    is_used_.resize(part.n_vertices());
    for (const auto& cell : part.cells)
      for (const std::uint32_t v : cell) is_used_[v] = true;
  }
  [[nodiscard]] bool operator[](std::uint32_t v) const { return !is_partial_ || is_used_[v]; }

 private:
  bool is_partial_ = false;
  std::vector<bool> is_used_;
};

template <int D>
const std::uint32_t* find_shared_vertex(const StitchPart<D>& part, const SharedKey& key) {
  const auto at =
      std::lower_bound(part.shared.begin(), part.shared.end(), key,
                       [](const auto& entry, const SharedKey& k) { return entry.first < k; });
  return at != part.shared.end() && at->first == key ? &at->second : nullptr;
}

template <int D, typename Candidates>
void find_owners(const std::vector<StitchPart<D>>& parts, std::uint32_t self,
                 const std::vector<UsedVertices>& used, const Candidates& candidates,
                 Ownership& out) {
  const StitchPart<D>& part = parts[self];
  out.owner.assign(part.part.n_vertices(), kOwned);
  out.id.assign(part.part.n_vertices(), 0);
  std::vector<std::uint32_t> others;
  for (const auto& [key, vertex] : part.shared) {
    others.clear();
    candidates(key.first, others);
    for (const std::uint32_t other : others) {
      if (other >= self) break;
      const std::uint32_t* there = find_shared_vertex<D>(parts[other], key);
      if (there == nullptr || !used[other][*there]) continue;
      out.owner[vertex] = other;
      out.id[vertex] = *there;
      break;
    }
  }
  for (std::uint32_t v = 0; v < out.owner.size(); ++v)
    if (out.owner[v] == kOwned && used[self][v]) out.id[v] = out.n_owned++;
}

}  // namespace

template <int D>
void find_shared(StitchPart<D>& part, const std::function<bool(const EdgePoint&)>& is_shared) {
  part.shared.clear();
  const auto& points = part.part.points;
  const auto n_points = static_cast<std::uint32_t>(points.size());
  std::vector<bool> flags(n_points);
  for (std::uint32_t v = 0; v < n_points; ++v) {
    flags[v] = is_shared(points[v]);
    if (flags[v]) part.shared.push_back({{points[v].doubled_midpoint(), 0, 0}, v});
  }
  // Cutting a segment at two border planes, one after the other, gives clip points whose ends are
  // clip points: all lie on the segment between the same two edge points, their roots.
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::vector<std::array<std::uint32_t, 2>> roots;
  const auto roots_of = [&](std::uint32_t v) {
    return v < n_points ? std::array{v, v} : roots[v - n_points];
  };
  for (std::uint32_t i = 0; i < part.part.clip_points.size(); ++i) {
    const ClipPoint& clip = part.part.clip_points[i];
    const auto p = roots_of(clip.first);
    const auto q = roots_of(clip.second);
    const std::uint32_t low = std::min({p[0], p[1], q[0], q[1]});
    const std::uint32_t high = std::max({p[0], p[1], q[0], q[1]});
    const auto is_end = [&](std::uint32_t v) { return v == low || v == high; };
    const bool is_one_segment =
        high != kNone && is_end(p[0]) && is_end(p[1]) && is_end(q[0]) && is_end(q[1]);
    roots.push_back(is_one_segment ? std::array{low, high} : std::array{kNone, kNone});
    if (!is_one_segment || !flags[low] || !flags[high]) continue;
    const LatticeKey a = points[low].doubled_midpoint();
    const LatticeKey b = points[high].doubled_midpoint();
    part.shared.push_back({{std::min(a, b), std::max(a, b), clip.axis}, n_points + i});
  }
  std::sort(part.shared.begin(), part.shared.end());
}

template <int D>
Result<void> stitch(const std::vector<StitchPart<D>>& parts,
                    const std::function<void(LatticeKey, std::vector<std::uint32_t>&)>& candidates,
                    const LatticeFrame& frame, Threads threads, Surface& surface,
                    std::vector<VertexOrigin>* origins,
                    std::vector<std::uint32_t>& limit_vertices) {
  std::vector<Ownership> ownership(parts.size());
  std::vector<UsedVertices> used(parts.size());
  parallel_for(parts.size(), threads, 8,
               [&](std::size_t i, int) { used[i] = UsedVertices(parts[i].part); });
  parallel_for(parts.size(), threads, 8, [&](std::size_t i, int) {
    find_owners<D>(parts, static_cast<std::uint32_t>(i), used, candidates, ownership[i]);
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
    std::vector<std::uint32_t> final_id(part.n_vertices());
    for (std::uint32_t v = 0; v < part.n_vertices(); ++v) {
      if (!used[i][v]) continue;
      if (own.owner[v] != kOwned) {
        final_id[v] = first_vertex[own.owner[v]] + ownership[own.owner[v]].id[own.id[v]];
        continue;
      }
      final_id[v] = first_vertex[i] + own.id[v];
      const Vec3d p = frame.position(part.position(v));
      surface.positions[final_id[v]] = {
          {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}};
      if (origins != nullptr) (*origins)[final_id[v]] = {static_cast<std::uint32_t>(i), v};
    }
    for (std::size_t c = 0; c < part.cells.size(); ++c)
      for (std::size_t k = 0; k < static_cast<std::size_t>(D); ++k)
        cells[first_cell[i] + c][k] = final_id[part.cells[c][k]];
  });
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (std::uint32_t v = 0; v < parts[i].part.positions.size(); ++v)
      if (ownership[i].owner[v] == kOwned && used[i][v] && parts[i].part.is_on_limit(v))
        limit_vertices.push_back(first_vertex[i] + ownership[i].id[v]);
  return {};
}

template void find_shared<2>(StitchPart<2>&, const std::function<bool(const EdgePoint&)>&);
template void find_shared<3>(StitchPart<3>&, const std::function<bool(const EdgePoint&)>&);
template Result<void> stitch<2>(const std::vector<StitchPart<2>>&,
                                const std::function<void(LatticeKey, std::vector<std::uint32_t>&)>&,
                                const LatticeFrame&, Threads, Surface&, std::vector<VertexOrigin>*,
                                std::vector<std::uint32_t>&);
template Result<void> stitch<3>(const std::vector<StitchPart<3>>&,
                                const std::function<void(LatticeKey, std::vector<std::uint32_t>&)>&,
                                const LatticeFrame&, Threads, Surface&, std::vector<VertexOrigin>*,
                                std::vector<std::uint32_t>&);

}  // namespace lode

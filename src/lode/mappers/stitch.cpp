#include "lode/mappers/stitch.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "lode/core/parallel_fill.h"
#include "lode/mappers/point_positions.h"

namespace lode {
namespace {

constexpr std::uint32_t kOwned = 0xFFFFFFFFU;
constexpr std::uint32_t kEarlier = 0xFFFFFFFEU;

/// Per part: which vertices it owns, their rank among those, and who owns the others.
struct Ownership {
  std::vector<std::uint32_t> owner;  ///< Part, or kOwned, or kEarlier.
  /// Rank here when owned, number in the whole when earlier, local id in the owner otherwise.
  std::vector<std::uint32_t> id;
  std::uint32_t n_owned = 0;
  std::uint32_t n_earlier = 0;
};

template <int D>
const std::uint32_t* find_shared_vertex(const StitchPart<D>& part, LatticeKey key) {
  const auto at = std::lower_bound(part.shared.begin(), part.shared.end(), key,
                                   [](const auto& entry, LatticeKey k) { return entry.first < k; });
  return at != part.shared.end() && at->first == key ? &at->second : nullptr;
}

/// earlier(key): the number of a vertex that belongs to none of the parts but came before them.
template <int D, typename Earlier>
void find_owners(const std::vector<StitchPart<D>>& parts, std::uint32_t self,
                 const StitchCandidates& candidates, const Earlier& earlier, Ownership& out) {
  const StitchPart<D>& part = parts[self];
  out.owner.assign(part.part.points.size(), kOwned);
  out.id.assign(part.part.points.size(), 0);
  std::vector<std::uint32_t> others;
  for (const auto& [key, vertex] : part.shared) {
    if (const std::optional<std::uint32_t> number = earlier(key)) {
      out.owner[vertex] = kEarlier;
      out.id[vertex] = *number;
      ++out.n_earlier;
      continue;
    }
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

Error too_many_vertices(std::uint64_t n) {
  return Error{fmt::format("the surface has {} vertices, more than {}: give it a larger tolerance",
                           n, std::numeric_limits<std::uint32_t>::max())};
}

template <int D>
auto& cells_of(Surface& surface) {
  if constexpr (D == 3)
    return surface.triangles;
  else
    return surface.lines;
}

/// Where each part's vertices and cells lie in the piece that they are joined to.
struct PieceLayout {
  explicit PieceLayout(std::size_t n_parts)
      : ownership(n_parts),
        first_new(n_parts + 1),
        first_earlier(n_parts + 1),
        first_cell(n_parts + 1) {}

  template <int D>
  void add_up(const std::vector<StitchPart<D>>& parts) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      first_new[i + 1] = first_new[i] + ownership[i].n_owned;
      first_earlier[i + 1] = first_earlier[i] + ownership[i].n_earlier;
      first_cell[i + 1] = first_cell[i] + parts[i].part.cells.size();
    }
  }

  /// Where vertex v of part i goes, unless it is an earlier one.
  [[nodiscard]] std::uint32_t place(std::size_t i, std::uint32_t v) const {
    const Ownership& own = ownership[i];
    const std::uint32_t owner = own.owner[v];
    if (owner == kOwned) return first_new[i] + own.id[v];
    return first_new[owner] + ownership[owner].id[own.id[v]];
  }

  std::vector<Ownership> ownership;
  std::vector<std::uint32_t> first_new;
  std::vector<std::uint32_t> first_earlier;
  std::vector<std::size_t> first_cell;
};

/// A part's cells, by the places of its vertices.
template <int D, typename Cell>
void write_cells(const IsoPart<D>& part, const std::vector<std::uint32_t>& place, Cell* out) {
  for (const auto& cell : part.cells) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(D); ++k) (*out)[k] = place[cell[k]];
    ++out;
  }
}

/// Writes one part's vertices and cells where the layout says.
template <int D>
void write_part(const StitchPart<D>& part, std::size_t i, const PieceLayout& layout,
                const LatticeFrame& frame, SurfacePiece& piece) {
  const Ownership& own = layout.ownership[i];
  std::vector<std::uint32_t> place(part.part.points.size());
  std::vector<Vec3f> positions(place.size());
  place_points(part.part.points, frame, positions.data());
  std::uint32_t n_earlier = layout.first_earlier[i];
  for (std::uint32_t v = 0; v < place.size(); ++v) {
    const std::uint32_t owner = own.owner[v];
    if (owner == kEarlier) {
      place[v] = layout.first_new.back() + n_earlier;
      piece.earlier[n_earlier++] = own.id[v];
    } else {
      place[v] = layout.place(i, v);
      if (owner != kOwned) continue;
    }
    piece.surface.positions[place[v]] = positions[v];
    if (!part.normals.empty()) piece.surface.normals[place[v]] = part.normals[v];
  }
  write_cells<D>(part.part, place, cells_of<D>(piece.surface).data() + layout.first_cell[i]);
}

}  // namespace

template <int D>
Result<void> stitch(const std::vector<StitchPart<D>>& parts, const StitchCandidates& candidates,
                    const LatticeFrame& frame, Threads threads, Surface& surface,
                    std::vector<VertexOrigin>* origins) {
  PieceLayout layout(parts.size());
  parallel_for(parts.size(), threads, 8, [&](std::size_t i, int) {
    find_owners<D>(
        parts, static_cast<std::uint32_t>(i), candidates,
        [](LatticeKey) { return std::optional<std::uint32_t>(); }, layout.ownership[i]);
  });
  std::uint64_t n_vertices = surface.positions.size();
  for (const Ownership& own : layout.ownership) n_vertices += own.n_owned;
  if (n_vertices > std::numeric_limits<std::uint32_t>::max()) return too_many_vertices(n_vertices);
  auto& cells = cells_of<D>(surface);
  layout.first_new[0] = static_cast<std::uint32_t>(surface.positions.size());
  layout.first_cell[0] = cells.size();
  layout.add_up<D>(parts);
  resize_large(surface.positions, layout.first_new.back(), threads);
  resize_large(cells, layout.first_cell.back(), threads);
  if (origins != nullptr) origins->resize(layout.first_new.back());
  parallel_for(parts.size(), threads, 8, [&](std::size_t i, int) {
    const IsoPart<D>& part = parts[i].part;
    const Ownership& own = layout.ownership[i];
    std::vector<std::uint32_t> place(part.points.size());
    std::vector<Vec3f> positions(place.size());
    place_points(part.points, frame, positions.data());
    for (std::uint32_t v = 0; v < part.points.size(); ++v) {
      place[v] = layout.place(i, v);
      if (own.owner[v] != kOwned) continue;
      surface.positions[place[v]] = positions[v];
      if (origins != nullptr) (*origins)[place[v]] = {static_cast<std::uint32_t>(i), v};
    }
    write_cells<D>(part, place, cells.data() + layout.first_cell[i]);
  });
  return {};
}

template <int D>
Result<SurfacePiece> PieceStitcher<D>::join(const std::vector<StitchPart<D>>& parts,
                                            const StitchCandidates& candidates,
                                            const std::function<bool(LatticeKey)>& is_kept) {
  const auto earlier = [this](LatticeKey key) {
    std::optional<std::uint32_t> number = kept_.find(key);
    if (number) number = numbers_[*number];
    return number;
  };
  PieceLayout layout(parts.size());
  parallel_for(parts.size(), threads_, 8, [&](std::size_t i, int) {
    find_owners<D>(parts, static_cast<std::uint32_t>(i), candidates, earlier, layout.ownership[i]);
  });
  layout.add_up<D>(parts);
  const std::uint64_t n_vertices = std::uint64_t{n_vertices_} + layout.first_new.back();
  if (n_vertices > std::numeric_limits<std::uint32_t>::max()) return too_many_vertices(n_vertices);

  SurfacePiece piece;
  piece.first_new = n_vertices_;
  piece.surface.origin = frame_.surface_origin;
  piece.earlier.resize(layout.first_earlier.back());
  resize_large(piece.surface.positions, layout.first_new.back() + piece.earlier.size(), threads_);
  const auto has_normals = [](const StitchPart<D>& part) { return !part.normals.empty(); };
  if (std::any_of(parts.begin(), parts.end(), has_normals))
    resize_large(piece.surface.normals, piece.surface.positions.size(), threads_);
  resize_large(cells_of<D>(piece.surface), layout.first_cell.back(), threads_);
  parallel_for(parts.size(), threads_, 8,
               [&](std::size_t i, int) { write_part<D>(parts[i], i, layout, frame_, piece); });
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (const auto& [key, vertex] : parts[i].shared) {
      const Ownership& own = layout.ownership[i];
      if (own.owner[vertex] != kOwned || !is_kept(key)) continue;
      kept_.find_or_add(key);
      numbers_.push_back(n_vertices_ + layout.first_new[i] + own.id[vertex]);
    }
  n_vertices_ = static_cast<std::uint32_t>(n_vertices);
  return piece;
}

template <int D>
void PieceStitcher<D>::forget_all_but(const std::function<bool(LatticeKey)>& is_kept) {
  VertexIds kept;
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t i = 0; i < kept_.size(); ++i) {
    if (!is_kept(kept_.key(i))) continue;
    kept.find_or_add(kept_.key(i));
    numbers.push_back(numbers_[i]);
  }
  kept_ = std::move(kept);
  numbers_ = std::move(numbers);
}

template class PieceStitcher<2>;
template class PieceStitcher<3>;
template Result<void> stitch<2>(const std::vector<StitchPart<2>>&, const StitchCandidates&,
                                const LatticeFrame&, Threads, Surface&, std::vector<VertexOrigin>*);
template Result<void> stitch<3>(const std::vector<StitchPart<3>>&, const StitchCandidates&,
                                const LatticeFrame&, Threads, Surface&, std::vector<VertexOrigin>*);

}  // namespace lode

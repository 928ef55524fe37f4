#include "lode/mappers/surface_edits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "lode/core/disjoint_sets.h"
#include "lode/mappers/vertex_corners.h"

namespace lode {
namespace {

/// Calls visit(array) for all that the surface has per vertex.
template <typename Visit>
void for_each_vertex_array(Surface& surface, const Visit& visit) {
  visit(surface.positions);
  if (!surface.normals.empty()) visit(surface.normals);
  if (!surface.isovalues.empty()) visit(surface.isovalues);
  if (!surface.values.empty()) visit(surface.values);
  if (!surface.origins.empty()) visit(surface.origins);
  for (Attribute& attribute : surface.attributes)
    if (!attribute.values.empty()) visit(attribute.values);
}

/// The same of all that it has per cell, but for the cells.
template <typename Visit>
void for_each_cell_array(Surface& surface, const Visit& visit) {
  if (!surface.errors.empty()) visit(surface.errors);
  if (!surface.regions.empty()) visit(surface.regions);
  if (!surface.patch_marks.empty()) visit(surface.patch_marks);
  for (Attribute& attribute : surface.attributes)
    if (!attribute.errors.empty()) visit(attribute.errors);
}

/// Cells, each with the number of one before an edit, whose error, region and patch it has.
template <std::size_t N>
struct SourcedCells {
  std::vector<std::array<std::uint32_t, N>> cells{};
  std::vector<std::uint32_t> sources{};

  void add(const std::array<std::uint32_t, N>& cell, std::uint32_t source) {
    cells.push_back(cell);
    sources.push_back(source);
  }
  /// Keeps those for which is_kept(cell), which may change it.
  template <typename IsKept>
  void keep_if(const IsKept& is_kept) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (!is_kept(cells[i])) continue;
      cells[n] = cells[i];
      sources[n++] = sources[i];
    }
    cells.resize(n);
    sources.resize(n);
  }
};

/// Puts cells in the place of those before.
template <std::size_t N>
void replace_cells(Surface& surface, SourcedCells<N> made,
                   std::vector<std::array<std::uint32_t, N>>& cells) {
  cells = std::move(made.cells);
  for_each_cell_array(surface, [&](auto& array) {
    std::remove_reference_t<decltype(array)> gathered;
    gathered.reserve(made.sources.size());
    for (const std::uint32_t source : made.sources) gathered.push_back(array[source]);
    array = std::move(gathered);
  });
}

/// Keeps the cells for which is_kept(cell); returns how many went.
template <std::size_t N, typename IsKept>
std::uint64_t keep_cells(Surface& surface, std::vector<std::array<std::uint32_t, N>>& cells,
                         const IsKept& is_kept) {
  SourcedCells<N> kept;
  for (std::uint32_t i = 0; i < cells.size(); ++i)
    if (is_kept(cells[i])) kept.add(cells[i], i);
  const std::uint64_t n_gone = cells.size() - kept.cells.size();
  replace_cells(surface, std::move(kept), cells);
  return n_gone;
}

std::uint32_t copy_vertex(Surface& surface, std::uint32_t v) {
  for_each_vertex_array(surface, [v](auto& array) {
    const auto copy = array[v];
    array.push_back(copy);
  });
  return static_cast<std::uint32_t>(surface.positions.size() - 1);
}

/// Removes vertices no cell uses, keeping the order of the others.
template <std::size_t N>
void compact(Surface& surface, std::vector<std::array<std::uint32_t, N>>& cells) {
  constexpr std::uint32_t kUnused = 0xFFFFFFFFU;
  std::vector<std::uint32_t> renumbered(surface.positions.size(), kUnused);
  for (const auto& cell : cells)
    for (const std::uint32_t v : cell) renumbered[v] = 0;
  std::uint32_t n = 0;
  for (std::uint32_t& id : renumbered)
    if (id != kUnused) id = n++;
  for_each_vertex_array(surface, [&](auto& array) {
    for (std::size_t v = 0; v < renumbered.size(); ++v)
      if (renumbered[v] != kUnused) array[renumbered[v]] = array[v];
    array.resize(n);
  });
  for (auto& cell : cells)
    for (std::uint32_t& v : cell) v = renumbered[v];
}

/// The fans that corners of one vertex form: those of triangles that share an edge there.
class Fans {
 public:
  /// Corner i then belongs to the fan that find(i) names by its first corner.
  DisjointSets<> find(std::span<const std::uint32_t> corners, const Surface& surface) {
    DisjointSets<> fans(corners.size());
    spokes_.clear();
    for (std::uint32_t i = 0; i < corners.size(); ++i)
      for (const std::uint32_t step : {1U, 2U}) {
        const std::uint32_t c = corners[i];
        spokes_.push_back({surface.triangles[c / 3][(c % 3 + step) % 3], i});
      }
    std::sort(spokes_.begin(), spokes_.end());
    for (std::size_t i = 1; i < spokes_.size(); ++i)
      if (spokes_[i].first == spokes_[i - 1].first)
        fans.join(spokes_[i].second, spokes_[i - 1].second);
    return fans;
  }

 private:
  std::vector<std::pair<std::uint32_t, std::uint32_t>> spokes_;  ///< {other end, corner}
};

template <std::size_t N>
Dropped drop_small(Surface& surface, std::vector<std::array<std::uint32_t, N>>& cells,
                   std::uint64_t n) {
  DisjointSets<> groups(surface.positions.size());
  for (const auto& cell : cells)
    for (std::size_t k = 1; k < N; ++k) groups.join(cell[0], cell[k]);
  std::vector<std::uint64_t> sizes(surface.positions.size(), 0);
  for (const auto& cell : cells) ++sizes[groups.find(cell[0])];
  Dropped dropped;
  for (const std::uint64_t size : sizes)
    if (size > 0 && size < n) {
      ++dropped.components;
      dropped.cells += size;
    }
  if (dropped.components == 0) return dropped;
  keep_cells(surface, cells, [&](const auto& cell) { return sizes[groups.find(cell[0])] >= n; });
  compact(surface, cells);
  return dropped;
}

/// Cuts cells at one plane of the crop box: coordinate axis times sign <= limit.
class BoxPlane {
 public:
  /// rounding: vertices so close to the plane are taken to be in it, so that a plane through
  /// vertices cuts beside none of them.
  BoxPlane(Surface& surface, std::size_t axis, double sign, double limit, double rounding)
      : surface_(surface),
        axis_(axis),
        sign_(sign),
        plane_(to_float(sign * limit - surface.origin[axis])),
        rounding_(rounding),
        first_new_(surface.positions.size()) {}

  template <std::size_t N>
  void cut_cells(std::vector<std::array<std::uint32_t, N>>& cells) {
    SourcedCells<N> kept;
    for (std::uint32_t i = 0; i < cells.size(); ++i) cut_cell(cells[i], i, kept);
    weld(kept);
    replace_cells(surface_, std::move(kept), cells);
    compact(surface_, cells);
  }

 private:
  static float to_float(double x) {
    constexpr auto kLargest = static_cast<double>(std::numeric_limits<float>::max());
    return static_cast<float>(std::clamp(x, -kLargest, kLargest));
  }

  double beyond(std::uint32_t v) const {
    const double x =
        static_cast<double>(surface_.positions[v][axis_]) - static_cast<double>(plane_);
    return std::abs(x) <= rounding_ ? 0.0 : sign_ * x;
  }

  /// Makes one of a cell's new vertices that float32 does not tell apart, where a corner lies
  /// hardly before or behind the plane, and drops the cells that leaves without area.
  template <std::size_t N>
  void weld(SourcedCells<N>& made) {
    if (surface_.positions.size() == first_new_) return;
    DisjointSets<> same(surface_.positions.size());
    for (const auto& cell : made.cells)
      for (std::size_t k = 0; k < N; ++k) {
        const std::uint32_t a = cell[k];
        const std::uint32_t b = cell[(k + 1) % N];
        if (std::min(a, b) >= first_new_ && surface_.positions[a] == surface_.positions[b])
          same.join(a, b);
      }
    made.keep_if([&](auto& cell) {
      bool is_flat = false;
      for (std::uint32_t& v : cell) v = same.find(v);
      for (std::size_t k = 0; k < N; ++k) is_flat = is_flat || cell[k] == cell[(k + 1) % N];
      return !is_flat;
    });
  }

  std::uint32_t cut_edge(std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    const auto [entry, is_new] = cuts_.try_emplace({a, b}, 0U);
    if (!is_new) return entry->second;
    const double t = beyond(a) / (beyond(a) - beyond(b));
    const auto mixed = [&](const Vec3f& p, const Vec3f& q) {
      Vec3f r;
      for (std::size_t i = 0; i < 3; ++i)
        r[i] = static_cast<float>(static_cast<double>(p[i]) +
                                  t * (static_cast<double>(q[i]) - static_cast<double>(p[i])));
      return r;
    };
    const std::uint32_t v = copy_vertex(surface_, a);
    surface_.positions[v] = mixed(surface_.positions[a], surface_.positions[b]);
    surface_.positions[v][axis_] = plane_;
    if (!surface_.normals.empty())
      surface_.normals[v] = normalized(mixed(surface_.normals[a], surface_.normals[b]));
    if (!surface_.values.empty())
      surface_.values[v] += t * (surface_.values[b] - surface_.values[a]);
    for (Attribute& attribute : surface_.attributes)
      if (!attribute.values.empty())
        attribute.values[v] += t * (attribute.values[b] - attribute.values[a]);
    if (!surface_.origins.empty())
      surface_.origins[v] = mixed(surface_.origins[a], surface_.origins[b]);
    return entry->second = v;
  }

  template <std::size_t N>
  void cut_cell(const std::array<std::uint32_t, N>& cell, std::uint32_t source,
                SourcedCells<N>& kept) {
    std::array<double, N> d;
    for (std::size_t i = 0; i < N; ++i) d[i] = beyond(cell[i]);
    if (std::none_of(d.begin(), d.end(), [](double x) { return x > 0; })) {
      kept.add(cell, source);
      return;
    }
    if (std::none_of(d.begin(), d.end(), [](double x) { return x < 0; })) return;
    std::array<std::uint32_t, N + 1> polygon{};
    std::size_t n = 0;
    std::size_t nearest = polygon.size();  // to the plane, of the corners kept
    constexpr std::size_t kEdges = N == 2 ? 1 : N;
    for (std::size_t i = 0; i < N; ++i) {
      const std::size_t j = (i + 1) % N;
      if (d[i] <= 0) {
        if (nearest == polygon.size() || d[i] > beyond(polygon[nearest])) nearest = n;
        polygon[n++] = cell[i];
      }
      if (i < kEdges && d[i] * d[j] < 0) polygon[n++] = cut_edge(cell[i], cell[j]);
    }
    if constexpr (N == 2) {
      kept.add({polygon[0], polygon[1]}, source);
    } else {
      // From the nearest: hardly before the plane, it may lie on the line from the other corner
      // to the cut above it.
      const auto corner = [&](std::size_t i) { return polygon[(nearest + i) % n]; };
      for (std::size_t i = 2; i < n; ++i) kept.add({corner(0), corner(i - 1), corner(i)}, source);
    }
  }

  Surface& surface_;
  std::size_t axis_;
  double sign_;
  float plane_;  ///< Coordinate along the axis, from the surface's origin.
  double rounding_;
  std::size_t first_new_;  ///< Vertex: those from here on lie in the plane.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> cuts_;
};

}  // namespace

void split_pinched_vertices(Surface& surface) {
  const VertexCorners corners = find_vertex_corners(surface.triangles, surface.positions.size());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> apart;  // first corner of a further fan, one
  Fans finder;
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    const std::span<const std::uint32_t> here = corners.of(v);
    DisjointSets<> fans = finder.find(here, surface);
    for (std::uint32_t i = 0; i < here.size(); ++i)
      if (const std::uint32_t fan = fans.find(i); fan != 0) apart.emplace_back(here[fan], here[i]);
  }
  std::sort(apart.begin(), apart.end());
  std::uint32_t copy = 0;
  for (std::size_t i = 0; i < apart.size(); ++i) {
    const auto [fan, corner] = apart[i];
    std::uint32_t& v = surface.triangles[corner / 3][corner % 3];
    if (i == 0 || fan != apart[i - 1].first) copy = copy_vertex(surface, v);
    v = copy;
  }
}

namespace {

Box3d world_bounds(const Surface& surface) {
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  Box3d bounds{{{kEndless, kEndless, kEndless}}, {{-kEndless, -kEndless, -kEndless}}};
  for (std::uint32_t v = 0; v < surface.positions.size(); ++v) {
    const Vec3d p = surface.world_position(v);
    for (std::size_t i = 0; i < 3; ++i) {
      bounds.lower[i] = std::min(bounds.lower[i], p[i]);
      bounds.upper[i] = std::max(bounds.upper[i], p[i]);
    }
  }
  return bounds;
}

}  // namespace

double crop_rounding(const Box3d& box, const Box3d& bounds, const Vec3d& origin) {
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (const double end :
         {std::max(box.lower[i], bounds.lower[i]), std::min(box.upper[i], bounds.upper[i])})
      largest = std::max(largest, std::abs(end - origin[i]));
  return 0x1p-20 * largest;
}

void crop(Surface& surface, const Box3d& box) {
  LODE_EXPECTS(surface.triangles.empty() || surface.lines.empty());
  if (surface.is_empty()) return;
  const double rounding = crop_rounding(box, world_bounds(surface), surface.origin);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      const double limit = sign < 0 ? -box.lower[axis] : box.upper[axis];
      if (!surface.triangles.empty())
        BoxPlane(surface, axis, sign, limit, rounding).cut_cells(surface.triangles);
      if (!surface.lines.empty())
        BoxPlane(surface, axis, sign, limit, rounding).cut_cells(surface.lines);
    }
}

Dropped drop_small_components(Surface& surface, std::uint64_t n) {
  if (!surface.lines.empty()) return drop_small(surface, surface.lines, n);
  return drop_small(surface, surface.triangles, n);
}

ComponentNumbers number_components(const Surface& surface) {
  DisjointSets<> groups(surface.positions.size());
  for (const auto& t : surface.triangles)
    for (const std::uint32_t v : t) groups.join(t[0], v);
  ComponentNumbers numbers{std::vector<std::uint32_t>(surface.positions.size()), 0};
  for (std::uint32_t v = 0; v < numbers.of_vertex.size(); ++v) {
    const std::uint32_t first = groups.find(v);
    numbers.of_vertex[v] = first == v ? numbers.n++ : numbers.of_vertex[first];
  }
  return numbers;
}

Dropped drop_components(Surface& surface, const ComponentNumbers& numbers,
                        std::span<const std::uint8_t> is_marked) {
  const std::uint64_t n_gone = keep_cells(surface, surface.triangles, [&](const auto& t) {
    return is_marked[numbers.of_vertex[t[0]]] == 0;
  });
  const Dropped dropped{static_cast<std::uint64_t>(std::ranges::count(is_marked, 1)), n_gone};
  if (dropped.components > 0) compact(surface, surface.triangles);
  return dropped;
}

void flip_orientation(Surface& surface) {
  for (auto& t : surface.triangles) std::swap(t[1], t[2]);
  for (auto& l : surface.lines) std::swap(l[0], l[1]);
  for (Vec3f& n : surface.normals) n = n * -1.0F;
}

}  // namespace lode

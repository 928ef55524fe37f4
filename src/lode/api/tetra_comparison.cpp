#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "lode/api/tetra_cut_shape.h"
#include "lode/api/tetra_verification.h"
#include "lode/models/tetra_mt/region_match.h"

namespace lode {
namespace {

using tetra_mt::Tetrahedron;

/// A vertex as bits, so that 0 and -0 differ.
using VertexBits = std::array<std::uint64_t, 4>;

std::vector<VertexBits> bits_of(std::span<const Vec3d> positions, std::span<const double> values) {
  std::vector<VertexBits> bits(positions.size());
  for (std::size_t v = 0; v < bits.size(); ++v) {
    for (std::size_t i = 0; i < 3; ++i) bits[v][i] = std::bit_cast<std::uint64_t>(positions[v][i]);
    bits[v][3] = std::bit_cast<std::uint64_t>(values[v]);
  }
  return bits;
}

std::vector<VertexBits> used_by(std::span<const Tetrahedron> cells,
                                const std::vector<VertexBits>& vertices) {
  std::vector<bool> is_used(vertices.size(), false);
  for (const Tetrahedron& t : cells)
    for (const std::uint32_t v : t) is_used[v] = true;
  std::vector<VertexBits> used;
  for (std::size_t v = 0; v < vertices.size(); ++v)
    if (is_used[v]) used.push_back(vertices[v]);
  return used;
}

/// Numbers that vertices of both meshes have by their bits alone; equal ones the same.
std::vector<std::uint32_t> ranks_of(const std::vector<VertexBits>& vertices,
                                    const std::vector<VertexBits>& sorted) {
  std::vector<std::uint32_t> ranks;
  ranks.reserve(vertices.size());
  for (const VertexBits& bits : vertices)
    ranks.push_back(
        static_cast<std::uint32_t>(std::ranges::lower_bound(sorted, bits) - sorted.begin()));
  return ranks;
}

/// By ranks, ascending but for the last two where they are turned the other way.
std::vector<Tetrahedron> ranked_cells(std::span<const Tetrahedron> cells,
                                      const std::vector<std::uint32_t>& ranks) {
  std::vector<Tetrahedron> result;
  result.reserve(cells.size());
  for (Tetrahedron t : cells) {
    for (std::uint32_t& v : t) v = ranks[v];
    bool is_odd = false;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t k = 0; k + 1 < 4; ++k)
        if (t[k] > t[k + 1]) {
          std::swap(t[k], t[k + 1]);
          is_odd = !is_odd;
        }
    // Two corners that count as equal can be swapped: such a cell has no side.
    if (is_odd && std::ranges::adjacent_find(t) == t.end()) std::swap(t[2], t[3]);
    result.push_back(t);
  }
  std::ranges::sort(result);
  return result;
}

/// By ranks, ascending, with the id of their regions.
std::vector<tetra_mt::RegionCell> ranked_regions(std::span<const Tetrahedron> cells,
                                                 std::span<const std::uint32_t> regions,
                                                 std::span<const std::int64_t> ids,
                                                 const std::vector<std::uint32_t>& ranks) {
  std::vector<tetra_mt::RegionCell> result;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    Tetrahedron t = cells[i];
    for (std::uint32_t& v : t) v = ranks[v];
    std::ranges::sort(t);
    result.emplace_back(t, ids[ids.size() < 2 ? 0 : regions[i]]);
  }
  std::ranges::sort(result);
  return result;
}

/// Elements of sorted lists that only one of them has.
template <typename T>
std::uint64_t count_differences(const std::vector<T>& a, const std::vector<T>& b) {
  std::vector<T> different;
  std::ranges::set_symmetric_difference(a, b, std::back_inserter(different));
  return different.size();
}

std::string difference_text(std::uint64_t n, std::uint64_t ours, std::uint64_t theirs) {
  return n == 0 ? ""
                : fmt::format("{} are in one of both only: the model has {}, the original {}", n,
                              ours, theirs);
}

}  // namespace

Result<VerifyReport> compare_with_original(const TetraCutSource& source, const TetraMesh& original,
                                           std::span<const std::size_t> fields,
                                           Progress& progress) {
  if (fields.empty() || original.fields.size() != fields.size())
    return fail("expected {} fields, got {}", std::max<std::size_t>(fields.size(), 1),
                original.fields.size());
  progress.report("comparing with the original", 0);
  LODE_TRY(const RefinedCells all, source.refined(fields.front(), 0.0, progress));
  const std::vector<Tetrahedron>& cells = all.cells.corners;
  LODE_TRY(TetraVertices vertices, source.vertices());
  VerifyReport report;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    LODE_CHECK(source.take_values(fields[i], vertices));
    const auto ours = bits_of(vertices.positions, vertices.values);
    const auto theirs = bits_of(original.positions, original.fields[i].values);
    auto our_vertices = used_by(cells, ours);
    auto their_vertices = used_by(original.tetrahedra, theirs);
    std::ranges::sort(our_vertices);
    std::ranges::sort(their_vertices);
    const std::uint64_t n_vertices = count_differences(our_vertices, their_vertices);
    report.add(fields.size() == 1 ? "vertices and values equal the original's"
                                  : fmt::format("vertices and values equal the original's: {}",
                                                original.fields[i].name),
               their_vertices.size(), n_vertices,
               difference_text(n_vertices, our_vertices.size(), their_vertices.size()));
    if (n_vertices > 0) return report;
    const auto our_cells = ranked_cells(cells, ranks_of(ours, our_vertices));
    const auto their_cells = ranked_cells(original.tetrahedra, ranks_of(theirs, our_vertices));
    const std::uint64_t n_cells = count_differences(our_cells, their_cells);
    if (i == 0 || n_cells > 0)
      report.add("tetrahedra equal the original's", their_cells.size(), n_cells,
                 difference_text(n_cells, our_cells.size(), their_cells.size()));
    std::vector<std::int64_t> ids;
    for (const MeshRegion& region : source.info().regions) ids.push_back(region.id);
    if (i > 0 || ids.empty() || original.region_ids.empty()) continue;
    const auto our_regions =
        ranked_regions(cells, all.cells.regions, ids, ranks_of(ours, our_vertices));
    const auto their_regions = ranked_regions(original.tetrahedra, original.regions,
                                              original.region_ids, ranks_of(theirs, our_vertices));
    const std::uint64_t n_regions = count_differences(our_regions, their_regions);
    report.add("regions of tetrahedra equal the original's", their_regions.size(), n_regions,
               difference_text(n_regions, our_regions.size(), their_regions.size()));
  }
  return report;
}

}  // namespace lode

// The triangles of a TIN that hold places, and those around them.
#include "lode/api/terrain_neighbours.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <new>
#include <utility>
#include <vector>

#include "lode/api/round_terrain.h"
#include "lode/api/terrain_tin_impl.h"
#include "lode/core/expects.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"

namespace lode {
namespace {

/// Edges of a triangle whose corners are taken the other way round.
constexpr std::array<std::uint8_t, 3> kMirrored{2, 1, 0};

TerrainTriangle triangle_of(const TerrainTin::Impl& terrain, const RingTriangle& one) {
  const delaunay::Tin& tin = terrain.tin;
  const bool is_mirrored = terrain.frame.is_mirrored();
  TerrainTriangle triangle{.triangle = one.triangle, .ring = one.ring, .corners = {}, .beside = {}};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t v = tin.triangles[one.triangle][is_mirrored ? (3 - i) % 3 : i];
    const Place at = terrain.frame.world(tin.vertices[v].x, tin.vertices[v].y);
    triangle.corners[i] = {{at[0], at[1], tin.heights[v]}};
  }
  triangle.bound = terrain.error_bound(static_cast<double>(tin.errors[one.triangle]));
  for (std::uint8_t edge = 0; edge < 3; ++edge) {
    auto beside = terrain.neighbours().beside(one.triangle, is_mirrored ? kMirrored[edge] : edge);
    if (is_mirrored) std::ranges::reverse(beside);
    for (const TinNeighbours::Beside& other : beside)
      triangle.beside.push_back(
          {edge, is_mirrored ? kMirrored[other.edge] : static_cast<std::uint8_t>(other.edge),
           other.triangle});
  }
  return triangle;
}

/// In columns and rows.
TerrainNeighbours neighbours_at(const TerrainTin::Impl& terrain, const Place& at,
                                std::uint32_t n_rings) {
  std::vector<std::uint32_t> holders = terrain.finder().find_all(at);
  const std::int32_t period = terrain.period();
  // Where the last column is the first again.
  if (period > 0 && (at[0] == 0 || at[0] == period)) {
    const auto more = terrain.finder().find_all({{period - at[0], at[1]}});
    holders.insert(holders.end(), more.begin(), more.end());
  }
  if (holders.empty()) return {terrain.where_off(at), {}};
  TerrainNeighbours answer{TerrainHeight::Where::inside, {}};
  for (const RingTriangle& one : terrain.neighbours().rings(std::move(holders), n_rings))
    answer.triangles.push_back(triangle_of(terrain, one));
  return answer;
}

/// Heights along a column of vertices, by row.
using Rim = std::vector<std::pair<std::int32_t, double>>;

Rim rim_of(const delaunay::Tin& tin, std::int32_t column) {
  Rim rim;
  for (std::size_t v = 0; v < tin.vertices.size(); ++v)
    if (tin.vertices[v].x == column) rim.emplace_back(tin.vertices[v].y, tin.heights[v]);
  std::ranges::sort(rim);
  return rim;
}

/// Whether a rim is as high as another at all of its own rows, within `allowed`.
bool is_as_high(const Rim& rim, const Rim& other, double allowed) {
  return std::ranges::all_of(rim, [&](const auto& here) {
    const auto above = std::ranges::lower_bound(other, here.first, {}, &Rim::value_type::first);
    if (above == other.end()) return false;
    if (above->first == here.first) return std::abs(above->second - here.second) <= allowed;
    if (above == other.begin()) return false;
    const auto& [y, z] = *(above - 1);
    const double share = static_cast<double>(here.first - y) / (above->first - y);
    return std::abs((1 - share) * z + share * above->second - here.second) <= allowed;
  });
}

/// Whether column 0 and that column may be of the same heights, as both are within the error.
bool have_same_heights(const TerrainTin::Impl& terrain, std::int32_t column) {
  const Rim first = rim_of(terrain.tin, 0);
  const Rim last = rim_of(terrain.tin, column);
  double largest = 0;
  for (const auto& [y, z] : first) largest = std::max(largest, std::abs(z));
  const double allowed = 2 * terrain.report.achieved_error + 0x1p-40 * largest;
  return !first.empty() && is_as_high(first, last, allowed) && is_as_high(last, first, allowed);
}

}  // namespace

std::int32_t TerrainTin::Impl::period() const {
  std::call_once(has_period, [this] {
    const std::int32_t n = columns_between_turns(frame, metric);
    if (n > 0 && have_same_heights(*this, n)) made_period = n;
  });
  return made_period;
}

const TinNeighbours& TerrainTin::Impl::neighbours() const {
  std::call_once(has_neighbours,
                 [this] { made_neighbours = std::make_unique<TinNeighbours>(tin, period()); });
  return *made_neighbours;
}

Result<NeighboursReport> TerrainTin::neighbours(std::span<const Place> places,
                                                const NeighboursOptions& options,
                                                std::vector<TerrainNeighbours>& answers,
                                                Progress& progress) const try {
  LODE_EXPECTS(!impl_->parts && !impl_->patches);
  NeighboursReport report;
  const Stopwatch preparing;
  // Made before there are threads that wait for them.
  static_cast<void>(impl_->finder());
  static_cast<void>(impl_->neighbours());
  report.prepare_seconds = preparing.seconds();
  const Stopwatch watch;
  answers.assign(places.size(), {});
  std::atomic<std::uint64_t> n_triangles{0};
  std::atomic<std::size_t> n_done{0};
  constexpr std::size_t kPlacesOfNeighbours = 16;
  parallel_for(places.size(), options.threads, kPlacesOfNeighbours, [&](std::size_t i, int) {
    if (progress.is_cancelled() || n_triangles > options.most_triangles) return;
    answers[i] = neighbours_at(*impl_, impl_->find_place(places[i]), options.n_rings);
    n_triangles += answers[i].triangles.size();
    progress.report("finding neighbours",
                    static_cast<double>(++n_done) / static_cast<double>(places.size()));
  });
  if (progress.is_cancelled()) return cancelled_error();
  if (n_triangles > options.most_triangles)
    return fail(
        "expected at most {} triangles around all places together, got more: fewer rings "
        "or places have less",
        options.most_triangles);
  for (const TerrainNeighbours& answer : answers) {
    report.n_outside += answer.where == TerrainHeight::Where::outside ? 1 : 0;
    report.n_in_gaps += answer.where == TerrainHeight::Where::gap ? 1 : 0;
  }
  report.n_triangles = n_triangles;
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("find neighbours");
}

}  // namespace lode

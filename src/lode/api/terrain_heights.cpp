// Heights of a TIN at many places.
#include <algorithm>
#include <atomic>
#include <new>
#include <numbers>

#include "lode/api/terrain_tin_impl.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/locate/tin_height.h"

namespace lode {
namespace {

/// Places in the raster are looked for by tiles, 64 by 64 of them: what a tile has of the TIN stays
/// in the cache. 2 million random places in 2.1 million triangles take a third of the time so.
constexpr std::uint32_t kTilesAcross = 64;
constexpr std::size_t kPlacesAtOnce = 4096;

class HeightFinder {
 public:
  HeightFinder(const TerrainTin::Impl& tin, std::span<const Place> places,
               std::vector<TerrainHeight>& heights, Threads threads, Progress& progress)
      : tin_(tin), places_(places), heights_(heights), threads_(threads), progress_(progress) {}

  Result<void> run() {
    at_.resize(places_.size());
    for_each_piece([&](std::size_t i) { at_[i] = find_place(places_[i]); }, 0, 0.2);
    const std::vector<std::size_t> order = order_by_tiles();
    for_each_piece([&](std::size_t i) { heights_[order[i]] = height_at(at_[order[i]]); }, 0.2, 1);
    if (progress_.is_cancelled()) return cancelled_error();
    return {};
  }

 private:
  template <typename Body>
  void for_each_piece(const Body& body, double begin, double end) const {
    const std::size_t n_pieces = (places_.size() + kPlacesAtOnce - 1) / kPlacesAtOnce;
    std::atomic<std::size_t> n_done{0};
    parallel_for(n_pieces, threads_, 1, [&](std::size_t piece, int) {
      if (progress_.is_cancelled()) return;
      const std::size_t last = std::min(places_.size(), (piece + 1) * kPlacesAtOnce);
      for (std::size_t i = piece * kPlacesAtOnce; i < last; ++i) body(i);
      const double share = static_cast<double>(++n_done) / static_cast<double>(n_pieces);
      progress_.report("locating", begin + share * (end - begin));
    });
  }

  /// Columns and rows of a place: of the longitudes that are one the first in the raster.
  [[nodiscard]] Place find_place(const Place& world) const {
    const Place at = tin_.to_lattice(world);
    if (!tin_.metric.ellipsoid || tin_.locator().is_in_rectangle(at)) return at;
    const double turn = 2 * std::numbers::pi / tin_.metric.angle_unit;
    for (const double shift : {turn, -turn}) {
      const Place other = tin_.to_lattice({{world[0] + shift, world[1]}});
      if (tin_.locator().is_in_rectangle(other)) return other;
    }
    return at;
  }

  [[nodiscard]] std::uint32_t tile_of(const Place& at) const {
    if (!tin_.locator().is_in_rectangle(at)) return 0;
    const auto tile = [](double x, std::int32_t n) {
      return static_cast<std::uint32_t>(x * kTilesAcross / n);
    };
    return tile(at[1], tin_.frame.n_rows) * kTilesAcross + tile(at[0], tin_.frame.n_columns);
  }

  [[nodiscard]] std::vector<std::size_t> order_by_tiles() const {
    std::vector<std::size_t> first(std::size_t{kTilesAcross} * kTilesAcross + 1, 0);
    for (const Place& at : at_) ++first[tile_of(at) + 1];
    for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
    std::vector<std::size_t> order(at_.size());
    for (std::size_t i = 0; i < at_.size(); ++i) order[first[tile_of(at_[i])]++] = i;
    return order;
  }

  [[nodiscard]] TerrainHeight height_at(const Place& at) const {
    if (const auto triangle = tin_.locator().find(at)) {
      const TinHeight z = height_in(tin_.tin, *triangle, at);
      return {TerrainHeight::Where::inside, z.height,
              tin_.error_bound(static_cast<double>(tin_.tin.errors[*triangle])) + z.rounding};
    }
    const bool is_in_raster = at[0] >= 0 && at[1] >= 0 && at[0] <= tin_.frame.n_columns - 1 &&
                              at[1] <= tin_.frame.n_rows - 1;
    return {is_in_raster ? TerrainHeight::Where::gap : TerrainHeight::Where::outside};
  }

  const TerrainTin::Impl& tin_;
  std::span<const Place> places_;
  std::vector<TerrainHeight>& heights_;
  Threads threads_;
  Progress& progress_;
  std::vector<Place> at_;  ///< Columns and rows.
};

}  // namespace

Result<HeightsReport> TerrainTin::heights(std::span<const Place> places,
                                          std::vector<TerrainHeight>& heights, Threads threads,
                                          Progress& progress) const try {
  HeightsReport report;
  const Stopwatch preparing;
  (void)impl_->locator();
  report.prepare_seconds = preparing.seconds();
  const Stopwatch watch;
  heights.assign(places.size(), {});
  LODE_CHECK(HeightFinder(*impl_, places, heights, threads, progress).run());
  for (const TerrainHeight& height : heights) {
    report.n_outside += static_cast<std::uint64_t>(height.where == TerrainHeight::Where::outside);
    report.n_in_gaps += static_cast<std::uint64_t>(height.where == TerrainHeight::Where::gap);
  }
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("find heights");
}

}  // namespace lode

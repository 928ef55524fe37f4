#include "lode/mappers/surface_distance.h"

#include <cmath>

#include "lode/core/point_triangle.h"
#include "lode/mappers/collapse_mesh.h"
#include "lode/mappers/collapse_pieces.h"
#include "lode/mappers/facet_grid.h"

namespace lode {
namespace {

using simplification::Piece;

/// Of a triangle: along the edges of others the bound of a piece is its size, which an accuracy far
/// below theirs asks for by the million.
constexpr std::size_t kMostPieces = 1 << 14;
constexpr double kEndless = std::numeric_limits<double>::infinity();

/// The triangles, relative to an origin.
std::vector<Facet> facets_of(const Surface& surface, const Vec3d& origin) {
  std::vector<Facet> facets(surface.triangles.size());
  const bool is_moved = surface.origin.v != origin.v;
  for (std::size_t t = 0; t < facets.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t v = surface.triangles[t][i];
      facets[t].corner[i] = surface.positions[v];
      if (!is_moved) continue;
      const Vec3d p = surface.world_position(v) - origin;
      facets[t].corner[i] = {
          {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}};
    }
  return facets;
}

class OneWay {
 public:
  OneWay(std::span<const Facet> from, std::span<const Facet> to, const DistanceOptions& options,
         const Progress& progress)
      : from_(from),
        to_(to, 2 * options.accuracy),
        accuracy_(options.accuracy),
        threads_(options.threads),
        progress_(progress) {}

  [[nodiscard]] DistanceBounds measure() const {
    if (from_.empty()) return {};
    if (to_.facets().empty()) return {kEndless, kEndless};
    // What corners tell first saves most of the cutting.
    const double known = largest_of([&](const Facet& facet, DistanceBounds& found) {
                           for (const Vec3d& p : corners_of(facet))
                             found.lower =
                                 std::max(found.lower, std::sqrt(nearest(p).squared_distance));
                         }).lower;
    DistanceBounds bounds = largest_of(
        [&](const Facet& facet, DistanceBounds& found) { add(corners_of(facet), known, found); });
    bounds.lower = std::max(bounds.lower, known);
    bounds.upper = std::max(bounds.upper, bounds.lower) * (1 + simplification::kRounding);
    return bounds;
  }

 private:
  [[nodiscard]] FacetGrid::Nearest nearest(const Vec3d& p) const {
    for (double limit = 4 * accuracy_;; limit *= 4) {
      const auto found = to_.find(p, {.limit = limit});
      if (found.facet != FacetGrid::kNone) return found;
    }
  }

  /// `known`: a distance that some point has. Larger pieces first.
  void add(const Piece& whole, double known, DistanceBounds& found) const {
    std::vector<Piece> pieces{whole};
    for (std::size_t i = 0; i < pieces.size() && !progress_.is_cancelled(); ++i) {
      const Piece piece = pieces[i];
      const double upper = bound(piece, known, found.lower);
      if (upper <= std::max(known, found.lower) + accuracy_ || pieces.size() >= kMostPieces) {
        found.upper = std::max(found.upper, upper);
        continue;
      }
      simplification::for_each_part(piece, [&](const Piece& part) {
        pieces.push_back(part);
        return true;
      });
    }
  }

  /// What no point of a piece is farther than; raises `lower` to what its middle is.
  [[nodiscard]] double bound(const Piece& piece, double known, double& lower) const {
    const auto there = nearest((piece[0] + piece[1] + piece[2]) * (1.0 / 3));
    const double distance = std::sqrt(there.squared_distance);
    lower = std::max(lower, distance);
    const double upper = distance + simplification::radius_of(piece);
    if (upper <= known + accuracy_) return upper;
    const auto target = corners_of(to_.facets()[there.facet]);
    double farthest = 0;
    for (const Vec3d& corner : piece)
      farthest = std::max(farthest, squared_distance_to_triangle(corner, target));
    return std::min(upper, std::sqrt(farthest));
  }

  /// look(facet, found) at all, in parallel; the largest bounds.
  template <typename Look>
  [[nodiscard]] DistanceBounds largest_of(const Look& look) const {
    constexpr std::size_t kChunk = 1024;
    std::vector<DistanceBounds> parts((from_.size() + kChunk - 1) / kChunk);
    parallel_for(parts.size(), threads_, 1, [&](std::size_t chunk, int) {
      for (const Facet& facet :
           from_.subspan(chunk * kChunk, std::min(kChunk, from_.size() - chunk * kChunk))) {
        if (progress_.is_cancelled()) return;
        look(facet, parts[chunk]);
      }
    });
    DistanceBounds all;
    for (const DistanceBounds& part : parts) {
      all.lower = std::max(all.lower, part.lower);
      all.upper = std::max(all.upper, part.upper);
    }
    return all;
  }

  std::span<const Facet> from_;
  FacetGrid to_;
  double accuracy_;
  Threads threads_;
  const Progress& progress_;
};

}  // namespace

Result<SurfaceDistance> measure_distance(const Surface& first, const Surface& second,
                                         const DistanceOptions& options, Progress& progress) {
  if (!(options.accuracy > 0 && std::isfinite(options.accuracy)))
    return fail("measuring a distance: expected a finite accuracy > 0, got {}", options.accuracy);
  progress.report("measuring the distance", 0);
  const std::vector<Facet> one = facets_of(first, second.origin);
  const std::vector<Facet> other = facets_of(second, second.origin);
  const SurfaceDistance distance{OneWay(one, other, options, progress).measure(),
                                 OneWay(other, one, options, progress).measure()};
  if (progress.is_cancelled()) return cancelled_error();
  return distance;
}

}  // namespace lode

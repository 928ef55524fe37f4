#include "lode/mappers/surface_turning.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "lode/mappers/surface_near.h"
#include "lode/mappers/surface_topology.h"

namespace lode {
namespace {

std::array<Vec3d, 3> corners_of(const Surface& surface, std::size_t t, const Vec3d& origin) {
  std::array<Vec3d, 3> corners;
  for (std::size_t i = 0; i < 3; ++i)
    corners[i] = surface.world_position(surface.triangles[t][i]) - origin;
  return corners;
}

/// Twice the area long.
Vec3d normal_of(const std::array<Vec3d, 3>& t) { return cross(t[1] - t[0], t[2] - t[0]); }

/// By vertex, the lowest of its piece.
std::vector<std::uint32_t> find_pieces(const Surface& surface) {
  std::vector<std::uint32_t> piece(surface.positions.size());
  std::iota(piece.begin(), piece.end(), 0U);
  const auto root = [&](std::uint32_t v) {
    while (piece[v] != v) v = piece[v] = piece[piece[v]];
    return v;
  };
  for (const auto& t : surface.triangles)
    for (const std::uint32_t v : {t[1], t[2]}) {
      const auto [low, high] = std::minmax({root(t[0]), root(v)});
      piece[high] = low;
    }
  for (std::uint32_t v = 0; v < piece.size(); ++v) piece[v] = root(v);
  return piece;
}

/// By triangle, whether its piece ends somewhere.
std::vector<std::uint8_t> find_open(const Surface& surface, const std::vector<std::uint32_t>& piece,
                                    Threads threads) {
  std::vector<std::uint8_t> ends(surface.positions.size(), 0);
  for (const auto& edge : find_boundary_edges(surface, threads)) ends[piece[edge[0]]] = 1;
  std::vector<std::uint8_t> is_open;
  is_open.reserve(surface.triangles.size());
  for (const auto& t : surface.triangles) is_open.push_back(ends[piece[t[0]]]);
  return is_open;
}

class TurningCheck {
 public:
  TurningCheck(const Surface& surface, const Surface& other, double reach)
      : surface_(surface),
        other_(other),
        facets_(facets_of(other)),
        grid_(facets_, reach),
        reach_(reach) {}

  /// By triangle, twice its area, less than 0 where the nearest one faces the other way.
  [[nodiscard]] std::vector<double> votes(Threads threads, const Progress& progress) const {
    std::vector<double> votes(surface_.triangles.size(), 0);
    parallel_for(votes.size(), threads, 1024, [&](std::size_t t, int) {
      if (progress.is_cancelled()) return;
      const auto corners = corners_of(surface_, t, other_.origin);
      const Vec3d normal = normal_of(corners);
      const Vec3d middle = (corners[0] + corners[1] + corners[2]) * (1.0 / 3);
      const Vec3d there = normal_of(lode::corners_of(facets_[nearest(middle)]));
      votes[t] = std::copysign(length(normal), dot(normal, there));
    });
    return votes;
  }

 private:
  [[nodiscard]] std::uint32_t nearest(const Vec3d& p) const {
    for (double limit = reach_;; limit *= 4) {
      const auto found = grid_.find(p, {.limit = limit});
      if (found.facet != FacetGrid::kNone) return found.facet;
    }
  }

  const Surface& surface_;
  const Surface& other_;
  std::vector<Facet> facets_;
  FacetGrid grid_;
  double reach_;
};

}  // namespace

PieceFacing facing_of(const Surface& surface, Threads threads) {
  struct Volume {
    double sum = 0;
    double largest = 0;  ///< Of what was added.
    std::uint64_t n = 0;
  };
  const std::vector<std::uint32_t> piece = find_pieces(surface);
  const std::vector<std::uint8_t> is_open = find_open(surface, piece, threads);
  std::vector<Volume> volumes(piece.size());
  std::vector<std::uint8_t> ends(piece.size(), 0);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const std::uint32_t number = piece[surface.triangles[t][0]];
    // Relative to the piece's first vertex.
    const auto corners = corners_of(surface, t, surface.world_position(number));
    const double part = dot(corners[0], cross(corners[1], corners[2]));
    Volume& volume = volumes[number];
    volume.sum += part;
    volume.largest = std::max(volume.largest, std::abs(part));
    ++volume.n;
    ends[number] = is_open[t];
  }
  PieceFacing facing;
  for (std::size_t v = 0; v < piece.size(); ++v) {
    const Volume& volume = volumes[v];
    if (volume.n == 0) continue;
    constexpr double kRounding = 0x1p-40;
    if (ends[v] != 0)
      ++facing.n_open;
    else if (std::abs(volume.sum) <= kRounding * volume.largest * static_cast<double>(volume.n))
      ++facing.n_flat;
    else
      ++(volume.sum > 0 ? facing.n_outward : facing.n_inward);
  }
  return facing;
}

Result<NearFacing> hold_against(const Surface& surface, const Surface& other, double reach,
                                Threads threads, const Progress& progress) {
  NearFacing facing;
  if (surface.triangles.empty() || other.triangles.empty()) return facing;
  const std::vector<double> votes = TurningCheck(surface, other, reach).votes(threads, progress);
  if (progress.is_cancelled()) return cancelled_error();
  struct Areas {
    double all = 0;
    double turned = 0;
    void add(double vote) {
      all += std::abs(vote);
      if (vote < 0) turned -= vote;
    }
    [[nodiscard]] double share() const { return all > 0 ? turned / all : 0; }
  };
  const std::vector<std::uint32_t> piece = find_pieces(surface);
  const std::vector<std::uint8_t> is_open = find_open(surface, piece, threads);
  Areas whole;
  std::vector<Areas> of_open(piece.size());
  for (std::size_t t = 0; t < votes.size(); ++t) {
    whole.add(votes[t]);
    if (is_open[t] != 0) of_open[piece[surface.triangles[t][0]]].add(votes[t]);
  }
  const double large = 2 * 100 * reach * reach;  // votes are twice the areas
  facing.is_large = whole.all >= large;
  facing.share_turned = whole.share();
  constexpr double kMost = 0.75;
  for (const Areas& areas : of_open) {
    if (!(areas.all >= large)) continue;
    ++facing.n_large_open;
    if (areas.share() > kMost) ++facing.n_turned;
  }
  return facing;
}

}  // namespace lode

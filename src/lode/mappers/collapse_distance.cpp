#include "lode/mappers/collapse_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "lode/core/expects.h"
#include "lode/core/point_triangle.h"
#include "lode/mappers/shadow_cover.h"

namespace lode::simplification {
namespace {

/// The largest squared distance of the corners from a target; stops where it exceeds `enough`.
template <typename SquaredDistance>
double farthest_corner(const Piece& piece, double enough, const SquaredDistance& squared_distance) {
  double largest = 0;
  for (const Vec3d& corner : piece) {
    largest = std::max(largest, squared_distance(corner));
    if (largest > enough) break;
  }
  return largest;
}

/// bound(triangle, worker), squared, of each in parallel.
template <typename Bound>
DistanceReport collect(std::span<const std::uint32_t> triangles, double limit, Threads threads,
                       const Progress& progress, const Bound& bound) {
  constexpr std::size_t kChunk = 64;
  std::vector<DistanceReport> parts((triangles.size() + kChunk - 1) / kChunk);
  parallel_for(parts.size(), threads, 1, [&](std::size_t chunk, int worker) {
    DistanceReport& part = parts[chunk];
    for (const std::uint32_t t :
         triangles.subspan(chunk * kChunk, std::min(kChunk, triangles.size() - chunk * kChunk))) {
      if (progress.is_cancelled()) return;
      const double here = std::sqrt(bound(t, worker)) * (1 + kRounding);
      if (here <= limit)
        part.proven = std::max(part.proven, here);
      else
        part.failing.push_back(t);
    }
  });
  DistanceReport report;
  for (const DistanceReport& part : parts) {
    report.proven = std::max(report.proven, part.proven);
    report.failing.insert(report.failing.end(), part.failing.begin(), part.failing.end());
  }
  return report;
}

}  // namespace

DistanceProof::Corners DistanceProof::original_corners(std::uint32_t triangle) const {
  const auto& v = original_.triangles[triangle];
  return {widened(original_.positions[v[0]]), widened(original_.positions[v[1]]),
          widened(original_.positions[v[2]])};
}

double DistanceProof::bound_from(std::uint32_t triangle, FromOriginal& own) {
  looked_around_[triangle] = 0;
  const Piece piece = original_corners(triangle);
  const double limit = limit_ * (1 - 2 * kRounding);
  const double limit2 = limit * limit;
  if (const double of_one = bound_from_one(triangle); of_one <= limit2) return of_one;
  std::array<std::uint32_t, 3> at{kNone, kNone, kNone};
  std::array<Piece, 3> near;
  std::array<std::size_t, 3> which{};  // of them, by corner
  std::size_t n = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t t = mesh_.attached_to[original_.triangles[triangle][k]];
    LODE_EXPECTS(t != kNone);  // it is a corner of triangles
    which[k] = t == at[0] ? 0 : t == at[1] ? 1 : n;
    if (which[k] < n) continue;
    at[n] = t;
    near[n] = widened_corners(corners(mesh_, t));
    const double here = farthest_corner(piece, limit2, [&](const Vec3d& corner) {
      return squared_distance_to_triangle(corner, near[n]);
    });
    if (here <= limit2) return here;
    ++n;
  }
  if (const double cut = bound_by_cuts(piece, near, which, limit2); cut <= limit2) return cut;
  looked_around_[triangle] = 1;
  return bound_from_around(triangle, own);
}

/// From what it is attached to, and what has a corner with that.
double DistanceProof::bound_from_around(std::uint32_t triangle, FromOriginal& own) const {
  const double limit = limit_ * (1 - 2 * kRounding);
  own.cuts.begin(original_corners(triangle), limit);
  own.around.clear();
  for (const std::uint32_t p : original_.triangles[triangle])
    for (const std::uint32_t corner : mesh_.triangles[mesh_.attached_to[p]].v)
      stars_.for_each_around(corner, [&](std::uint32_t t) {
        if (std::ranges::find(own.around, t) != own.around.end()) return;
        own.around.push_back(t);
        own.cuts.add(widened_corners(corners(mesh_, t)));
      });
  return own.cuts.covers() ? limit * limit : kUnproven;
}

/// Where all three vertices are attached to one triangle, and find_distances() has been called.
double DistanceProof::bound_from_one(std::uint32_t triangle) const {
  if (attached_distance2_.empty()) return kUnproven;
  const auto& v = original_.triangles[triangle];
  const std::uint32_t t = mesh_.attached_to[v[0]];
  if (mesh_.attached_to[v[1]] != t || mesh_.attached_to[v[2]] != t) return kUnproven;
  return std::max(
      {attached_distance2_[v[0]], attached_distance2_[v[1]], attached_distance2_[v[2]]});
}

/// Of original vertices from the triangles they are attached to, squared.
void DistanceProof::find_distances(Threads threads) {
  attached_distance2_.resize(original_.positions.size());
  constexpr std::size_t kPiece = 1 << 14;
  const std::size_t n = attached_distance2_.size();
  parallel_for((n + kPiece - 1) / kPiece, threads, 1, [&](std::size_t piece, int) {
    for (std::size_t v = piece * kPiece; v < std::min(n, (piece + 1) * kPiece); ++v)
      if (mesh_.attached_to[v] != kNone)  // else it is in no triangle
        attached_distance2_[v] = squared_distance_to_triangle(
            widened(original_.positions[v]), widened_corners(corners(mesh_, mesh_.attached_to[v])));
  });
}

DistanceReport DistanceProof::from_original(std::span<const std::uint32_t> triangles,
                                            Threads threads) {
  // Where all are asked for; vertices have some six triangles each, and most of these one they are
  // attached to.
  if (triangles.size() > original_.positions.size()) find_distances(threads);
  std::vector<FromOriginal> workers(static_cast<std::size_t>(n_workers(threads)));
  DistanceReport report =
      collect(triangles, limit_, threads, progress_, [&](std::uint32_t t, int worker) {
        return bound_from(t, workers[static_cast<std::size_t>(worker)]);
      });
  attached_distance2_.clear();
  return report;
}

/// Original vertices attached to the triangle or one that has a vertex with it.
template <typename Add>
void DistanceProof::for_each_near(std::uint32_t triangle, const Add& add) const {
  const auto& v = mesh_.triangles[triangle].v;
  const auto add_points = [&](std::uint32_t t) {
    for (std::uint32_t p = mesh_.triangles[t].points; p != kNone; p = mesh_.next_point[p]) add(p);
  };
  add_points(triangle);  // first, as they are likely to be enough
  stars_.for_each_around(v[0], [&](std::uint32_t t) {
    if (t != triangle) add_points(t);
  });
  stars_.for_each_around(v[1], [&](std::uint32_t t) {
    const auto& w = mesh_.triangles[t].v;
    if (w[0] != v[0] && w[1] != v[0] && w[2] != v[0]) add_points(t);
  });
  stars_.for_each_around(v[2], [&](std::uint32_t t) {
    const auto& w = mesh_.triangles[t].v;
    for (const std::uint32_t x : w)
      if (x == v[0] || x == v[1]) return;
    add_points(t);
  });
}

DistanceReport DistanceProof::to_original(std::span<const std::uint32_t> triangles,
                                          Threads threads) {
  struct Worker {
    ShadowCover shadows;
    Cover cover;
  };
  const Surroundings around = surroundings(threads);
  std::vector<Worker> workers(
      static_cast<std::size_t>(n_workers(threads)),
      {ShadowCover(original_, around, limit_ * (1 - 3 * kRounding)),
       Cover(original_, around, limit_ * (1 - 2 * kRounding), longest_edge_)});
  return collect(triangles, limit_, threads, progress_, [&](std::uint32_t t, int worker) {
    Worker& own = workers[static_cast<std::size_t>(worker)];
    return bound_to(t, own.shadows, own.cover);
  });
}

double DistanceProof::bound_to(std::uint32_t triangle, ShadowCover& shadows, Cover& cover) const {
  const Piece piece = widened_corners(corners(mesh_, triangle));
  double bound = shadows.bound(piece, vertex_near(triangle));
  if (bound < kUnproven) return bound;
  cover.begin(piece);
  for_each_near(triangle, [&](std::uint32_t p) { cover.add(p); });
  const std::uint32_t nearest = cover.nearest((piece[0] + piece[1] + piece[2]) * (1.0 / 3));
  if (nearest == kNone) return kUnproven;
  if (!shadows.has_rims()) bound = shadows.bound_with(nearest);
  if (bound < kUnproven) return bound;
  return cover.covers(piece, shadows.has_rims() ? &shadows : nullptr)
             ? limit_ * limit_ * (1 - 4 * kRounding)
             : kUnproven;
}

/// An original vertex near the middle of the triangle, if there is one.
std::uint32_t DistanceProof::vertex_near(std::uint32_t triangle) const {
  const auto t = corners(mesh_, triangle);
  const Vec3f middle = (1.0F / 3) * (t[0] + t[1] + t[2]);
  std::uint32_t nearest = mesh_.triangles[triangle].v[0];
  float least = std::numeric_limits<float>::infinity();
  for (std::uint32_t p = mesh_.triangles[triangle].points; p != kNone; p = mesh_.next_point[p]) {
    const Vec3f d = original_.positions[p] - middle;
    if (dot(d, d) >= least) continue;
    least = dot(d, d);
    nearest = p;
  }
  return nearest;
}

/// Each thread has vertices of its own, and looks at all triangles: with many that would only be
/// reading.
void DistanceProof::find_triangles_around(Threads threads) {
  constexpr int kMostParts = 8;
  const std::size_t n = original_.positions.size();
  const auto n_parts = static_cast<std::size_t>(std::min(n_workers(threads), kMostParts));
  first_around_.assign(n + 1, 0);
  const auto for_each_corner = [&](std::size_t part, const auto& visit) {
    const std::size_t begin = n * part / n_parts;
    const std::size_t end = n * (part + 1) / n_parts;
    for (std::uint32_t t = 0; t < original_.triangles.size(); ++t)
      for (const std::uint32_t v : original_.triangles[t])
        if (v - begin < end - begin) visit(v, t);
  };
  parallel_for(n_parts, threads, 1, [&](std::size_t part, int) {
    for_each_corner(part, [&](std::uint32_t v, std::uint32_t) { ++first_around_[v]; });
  });
  std::exclusive_scan(first_around_.begin(), first_around_.end(), first_around_.begin(), 0U);
  around_.resize(first_around_.back());
  std::vector<std::uint32_t> at(first_around_.begin(), first_around_.end() - 1);
  parallel_for(n_parts, threads, 1, [&](std::size_t part, int) {
    for_each_corner(part, [&](std::uint32_t v, std::uint32_t t) { around_[at[v]++] = t; });
  });
}

}  // namespace lode::simplification

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "lode/core/surface.h"
#include "lode/models/diamond/build.h"
#include "tests/oracles/random.h"

namespace lode::diamond {

/// A ramp under noise, so that surfaces sweep far and change sides often; NaN as holes.
template <int D>
Model<D> ramp_and_noise(const Index3& dims, std::uint64_t seed, double hole_share = 0) {
  oracles::Random random(seed);
  RegularGrid grid;
  grid.dims = dims;
  grid.spacing = {{0.5, 1, 2}};
  std::vector<float> samples(static_cast<std::size_t>(grid.n_samples()));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto x = static_cast<double>(i % 13);
    samples[i] = static_cast<float>(5 * x + random.uniform(0, 40));
    if (random.uniform(0, 1) < hole_share) samples[i] = std::numeric_limits<float>::quiet_NaN();
  }
  const Volume volume = make_volume<float>(grid, samples);
  const auto source = make_memory_source(volume);
  Progress progress;
  return build<D>(*source, {.threads = {1}}, progress).value();
}

using NamedCell = std::array<std::array<float, 6>, 3>;

/// Cells by their corners' positions and normals, each from its least corner on, in order.
inline std::vector<NamedCell> named_cells(const Surface& surface) {
  const auto corner = [&](std::uint32_t v) {
    const Vec3f& p = surface.positions[v];
    const Vec3f n = surface.normals.empty() ? Vec3f{} : surface.normals[v];
    return std::array{p[0], p[1], p[2], n[0], n[1], n[2]};
  };
  std::vector<NamedCell> cells;
  for (const auto& t : surface.triangles) {
    NamedCell cell{corner(t[0]), corner(t[1]), corner(t[2])};
    std::rotate(cell.begin(), std::min_element(cell.begin(), cell.end()), cell.end());
    cells.push_back(cell);
  }
  for (const auto& l : surface.lines) cells.push_back({corner(l[0]), corner(l[1]), corner(l[1])});
  std::sort(cells.begin(), cells.end());
  return cells;
}

/// Of the point of a triangle that is closest; lines are flat triangles.
inline double distance_to(const Vec3d& p, const std::array<Vec3d, 3>& triangle) {
  const auto to_segment = [&](const Vec3d& a, const Vec3d& b) {
    const Vec3d along = b - a;
    const double square = dot(along, along);
    const double t = square > 0 ? std::clamp(dot(p - a, along) / square, 0.0, 1.0) : 0.0;
    return length(p - (a + along * t));
  };
  const auto& [a, b, c] = triangle;
  double distance = std::min({to_segment(a, b), to_segment(b, c), to_segment(c, a)});
  const Vec3d n = cross(b - a, c - a);
  if (!(length(n) > 0)) return distance;
  const auto is_left = [&](const Vec3d& from, const Vec3d& to) {
    return dot(cross(to - from, p - from), n) >= 0;
  };
  if (is_left(a, b) && is_left(b, c) && is_left(c, a))
    distance = std::min(distance, std::abs(dot(p - a, n)) / length(n));
  return distance;
}

/// Along the axis where it is largest: no more than that to the triangle.
inline double distance_to_box(const Vec3d& p, const std::array<Vec3d, 3>& triangle) {
  double distance = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [low, high] = std::minmax({triangle[0][i], triangle[1][i], triangle[2][i]});
    distance = std::max({distance, low - p[i], p[i] - high});
  }
  return distance;
}

/// The triangles (lines) of a surface in the world.
inline std::vector<std::array<Vec3d, 3>> places_of(const Surface& surface) {
  std::vector<std::array<Vec3d, 3>> places;
  const auto at = [&](std::uint32_t v) { return surface.world_position(v); };
  for (const auto& t : surface.triangles) places.push_back({at(t[0]), at(t[1]), at(t[2])});
  for (const auto& l : surface.lines) places.push_back({at(l[0]), at(l[1]), at(l[1])});
  return places;
}

/// Area, or length of lines.
inline double size_of_all(const Surface& surface) {
  double size = 0;
  for (const auto& [a, b, c] : places_of(surface))
    size += surface.lines.empty() ? length(cross(b - a, c - a)) / 2 : length(b - a);
  return size;
}

/// The largest distance of any of the points from the surface.
inline double farthest_from(const Surface& surface, const std::vector<Vec3d>& points) {
  const auto places = places_of(surface);
  double farthest = 0;
  for (const Vec3d& p : points) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& place : places)
      if (distance_to_box(p, place) < nearest) nearest = std::min(nearest, distance_to(p, place));
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

}  // namespace lode::diamond

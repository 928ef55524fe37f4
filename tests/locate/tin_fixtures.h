#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "lode/delaunay/predicates.h"
#include "lode/models/terrain/delaunay_selector/selector.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/oracles/random.h"

namespace lode::test {

using delaunay::LatticePoint;
using delaunay::Point;
using delaunay::Tin;
using delaunay::test::make_grid;
using delaunay::test::set_missing;

/// A grid and its TIN, with twins, errors and heights.
struct GridTin {
  std::string name;
  HeightGrid grid;
  Tin tin;
};

inline GridTin select_tin(std::string name, HeightGrid grid, double max_error) {
  Progress progress;
  auto made = delaunay_selector::select_samples(
      grid, {.max_error = max_error, .links = delaunay::TinLinks::kept}, progress);
  if (!made) ADD_FAILURE() << made.error().message;
  return {std::move(name), std::move(grid), made ? std::move(made)->tin : Tin{}};
}

/// Of all samples.
inline GridTin full_tin(std::string name, HeightGrid grid) {
  auto made = delaunay_selector::select_all_samples(grid);
  if (!made) ADD_FAILURE() << made.error().message;
  return {std::move(name), std::move(grid), made ? std::move(made)->tin : Tin{}};
}

inline double hilly(std::int32_t x, std::int32_t y) {
  return std::round(800 * std::sin(0.17 * x) * std::cos(0.13 * y) + 30 * std::sin(1.3 * x + y));
}

/// A disc, a slanted border and single samples are missing: islands, gaps, touching corners.
inline HeightGrid holey_grid() {
  HeightGrid grid = make_grid<std::int16_t>(60, 50, hilly);
  for (std::int32_t y = 0; y < 50; ++y)
    for (std::int32_t x = 0; x < 60; ++x)
      if (x > y + 38 || (x * 31 + y * 17) % 47 == 0 ||
          (x - 15) * (x - 15) + (y - 20) * (y - 20) < 40)
        set_missing(grid, x, y);
  return grid;
}

inline std::vector<GridTin> all_tins() {
  std::vector<GridTin> tins;
  const auto flat = [](std::int32_t, std::int32_t) { return 7; };
  tins.push_back(select_tin("flat", make_grid<float>(31, 17, flat), 0));
  tins.push_back(select_tin("two_by_two", make_grid<float>(2, 2, hilly), 0));
  tins.push_back(select_tin("narrow", make_grid<std::int16_t>(200, 2, hilly), 5));
  tins.push_back(select_tin("hills", make_grid<std::int16_t>(50, 40, hilly), 40));
  tins.push_back(select_tin("all_samples", make_grid<std::int16_t>(33, 29, hilly), 0));
  tins.push_back(select_tin("holes", holey_grid(), 60));
  tins.push_back(select_tin("all_samples_and_holes", holey_grid(), 0));
  tins.push_back(full_tin("full", make_grid<std::int16_t>(21, 34, hilly)));
  tins.push_back(full_tin("full_with_holes", holey_grid()));
  return tins;
}

/// By its definition, with CGAL's predicate.
inline bool holds_exactly(const Tin& tin, std::uint32_t t, const Point& p) {
  const auto point = [&](std::size_t i) {
    const LatticePoint q = tin.vertices[tin.triangles[t][i]];
    return Point{{static_cast<double>(q.x), static_cast<double>(q.y)}};
  };
  for (std::size_t i = 0; i < 3; ++i)
    if (delaunay::orientation(point(i), point((i + 1) % 3), p) < 0) return false;
  return true;
}

/// The plane of a triangle at p, in 64 bits of mantissa.
inline double plane_at(const Tin& tin, std::uint32_t t, const Point& p) {
  using Long = long double;
  const auto& corner = tin.triangles[t];
  const auto area = [](std::array<Long, 2> a, std::array<Long, 2> b, std::array<Long, 2> c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  };
  std::array<std::array<Long, 2>, 3> at{};
  for (std::size_t i = 0; i < 3; ++i)
    at[i] = {static_cast<Long>(tin.vertices[corner[i]].x),
             static_cast<Long>(tin.vertices[corner[i]].y)};
  const std::array<Long, 2> q{p[0], p[1]};
  Long sum = 0;
  for (std::size_t i = 0; i < 3; ++i)
    sum += area(at[(i + 1) % 3], at[(i + 2) % 3], q) * tin.heights[corner[i]];
  return static_cast<double>(sum / area(at[0], at[1], at[2]));
}

/// The first triangle that holds p, by trying all; the number of triangles where none does.
inline std::uint32_t find_by_trying(const Tin& tin, const Point& p) {
  std::uint32_t t = 0;
  while (t < tin.triangles.size() && !holds_exactly(tin, t, p)) ++t;
  return t;
}

/// Places that are hard: nodes, on edges, next to them, everywhere, and outside.
inline std::vector<Point> hard_places(const GridTin& one, std::uint64_t seed, std::size_t n) {
  oracles::Random random(seed);
  std::vector<Point> places;
  const double columns = one.grid.n_columns - 1;
  const double rows = one.grid.n_rows - 1;
  for (std::size_t i = 0; i < n; ++i) {
    places.push_back({{random.uniform(-1, columns + 1), random.uniform(-1, rows + 1)}});
    places.push_back({{std::floor(random.uniform(-1, columns + 2)), random.uniform(0, rows)}});
    places.push_back(
        {{std::floor(random.uniform(0, columns + 1)), std::floor(random.uniform(0, rows + 1))}});
    const auto& t = one.tin.triangles[random.below(one.tin.triangles.size())];
    const std::size_t k = random.below(3);
    const LatticePoint a = one.tin.vertices[t[k]];
    const LatticePoint b = one.tin.vertices[t[(k + 1) % 3]];
    const double s = static_cast<double>(random.below(17)) / 16;
    const Point on{{a.x + s * (b.x - a.x), a.y + s * (b.y - a.y)}};
    places.push_back(on);
    places.push_back({{std::nextafter(on[0], -5.0), on[1]}});
    places.push_back({{on[0], std::nextafter(on[1], 1e9)}});
  }
  return places;
}

}  // namespace lode::test

#pragma once

// An oracle: the exact level set of the full-resolution field, tetrahedron by tetrahedron (2D:
// triangle by triangle), written with nothing but the definition of F.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "lode/core/surface.h"
#include "lode/core/volume.h"

namespace lode::test {

inline double sample_at(const Volume& volume, const Index3& p) {
  const Index3& d = volume.info.grid.dims;
  return static_cast<double>(
      volume.as<float>()[static_cast<std::size_t>(p[0] + d[0] * (p[1] + d[1] * p[2]))]);
}

inline Volume random_volume(const RegularGrid& grid, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(-1.0F, 1.0F);
  std::vector<float> samples(static_cast<std::size_t>(grid.n_samples()));
  for (float& sample : samples) sample = value(random);
  return make_volume<float>(grid, samples);
}

/// F by definition, at index coordinates inside the lattice.
inline double field_at(const Volume& volume, const Vec3d& x) {
  const Index3& dims = volume.info.grid.dims;
  Index3 even;
  std::array<std::pair<double, std::size_t>, 3> order;
  Index3 step;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto cell =
        std::clamp(static_cast<std::int32_t>(std::floor(x[i])), 0, std::max(dims[i] - 2, 0));
    even[i] = cell % 2 == 0 ? cell : cell + 1;
    step[i] = dims[i] == 1 ? 0 : (cell % 2 == 0 ? 1 : -1);
    order[i] = {std::abs(x[i] - even[i]), i};
  }
  std::sort(order.rbegin(), order.rend());
  double f = sample_at(volume, even);
  double before = f;
  for (const auto& [u, axis] : order) {
    even[axis] += step[axis];
    const double next = sample_at(volume, even);
    f += u * (next - before);
    before = next;
  }
  return f;
}

class FinestLevelSet {
 public:
  FinestLevelSet(const Volume& volume, double isovalue) : volume_(volume), isovalue_(isovalue) {
    const Index3& dims = volume.info.grid.dims;
    for (std::int32_t z = 0; z < std::max(dims[2] - 1, 1); ++z)
      for (std::int32_t y = 0; y < std::max(dims[1] - 1, 1); ++y)
        for (std::int32_t x = 0; x < std::max(dims[0] - 1, 1); ++x) add_cell({{x, y, z}});
  }
  [[nodiscard]] const Surface& surface() const { return surface_; }

 private:
  void add_cell(const Index3& cell) {
    const Index3& dims = volume_.info.grid.dims;
    std::vector<std::size_t> axes;
    Index3 even;
    Index3 step;
    for (std::size_t i = 0; i < 3; ++i) {
      even[i] = cell[i] + cell[i] % 2;
      step[i] = cell[i] % 2 == 0 ? 1 : -1;
      if (dims[i] > 1) axes.push_back(i);
    }
    for (std::uint32_t corner = 0; corner < (1U << axes.size()); ++corner) {
      Index3 p = even;
      for (std::size_t k = 0; k < axes.size(); ++k)
        if (((corner >> k) & 1U) != 0) p[axes[k]] += step[axes[k]];
      if (!std::isfinite(sample_at(volume_, p))) return;
    }
    do {
      std::vector<Index3> simplex = {even};
      for (const std::size_t axis : axes) {
        Index3 next = simplex.back();
        next[axis] += step[axis];
        simplex.push_back(next);
      }
      add_simplex(simplex);
    } while (std::next_permutation(axes.begin(), axes.end()));
  }

  void add_simplex(const std::vector<Index3>& simplex) {
    std::vector<Index3> above;
    std::vector<Index3> below;
    for (const Index3& p : simplex)
      (sample_at(volume_, p) >= isovalue_ ? above : below).push_back(p);
    if (above.empty() || below.empty()) return;
    if (simplex.size() == 3) {
      const auto& [one, two] =
          above.size() == 1 ? std::pair(above, below) : std::pair(below, above);
      surface_.lines.push_back({vertex(one[0], two[0]), vertex(one[0], two[1])});
    } else if (above.size() == 2) {
      const std::array<std::uint32_t, 4> v = {
          vertex(above[0], below[0]), vertex(above[0], below[1]), vertex(above[1], below[1]),
          vertex(above[1], below[0])};
      add_triangle({v[0], v[1], v[2]}, above, below);
      add_triangle({v[0], v[2], v[3]}, above, below);
    } else {
      const bool is_one_above = above.size() == 1;
      const Index3 tip = is_one_above ? above[0] : below[0];
      const std::vector<Index3>& base = is_one_above ? below : above;
      add_triangle({vertex(tip, base[0]), vertex(tip, base[1]), vertex(tip, base[2])}, above,
                   below);
    }
  }

  /// Turns the triangle so that it is counter-clockwise seen from lower values.
  void add_triangle(std::array<std::uint32_t, 3> t, const std::vector<Index3>& above,
                    const std::vector<Index3>& below) {
    const Vec3d a = surface_.world_position(t[0]);
    const Vec3d normal =
        cross(surface_.world_position(t[1]) - a, surface_.world_position(t[2]) - a);
    if (dot(normal, mean_of(above) - mean_of(below)) > 0) std::swap(t[1], t[2]);
    surface_.triangles.push_back(t);
  }

  [[nodiscard]] Vec3d mean_of(const std::vector<Index3>& points) const {
    Vec3d sum;
    for (const Index3& p : points) sum = sum + volume_.info.grid.to_world(to_double(p));
    return sum * (1.0 / static_cast<double>(points.size()));
  }

  static Vec3d to_double(const Index3& p) {
    return {{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])}};
  }

  std::uint32_t vertex(const Index3& p, const Index3& q) {
    const auto key = std::minmax(p, q);
    const auto [found, is_new] = numbers_.try_emplace(
        {key.first, key.second}, static_cast<std::uint32_t>(surface_.positions.size()));
    if (is_new) {
      const double a = sample_at(volume_, key.first) - isovalue_;
      const double b = sample_at(volume_, key.second) - isovalue_;
      const double t = std::clamp(a / (a - b), 1e-3, 1 - 1e-3);
      const Vec3d x = to_double(key.first) * (1 - t) + to_double(key.second) * t;
      const Vec3d w = volume_.info.grid.to_world(x) - surface_.origin;
      surface_.positions.push_back(
          {{static_cast<float>(w[0]), static_cast<float>(w[1]), static_cast<float>(w[2])}});
    }
    return found->second;
  }

  const Volume& volume_;
  double isovalue_;
  Surface surface_;
  std::map<std::pair<Index3, Index3>, std::uint32_t> numbers_;
};

inline Surface finest_level_set(const Volume& volume, double isovalue) {
  return FinestLevelSet(volume, isovalue).surface();
}

}  // namespace lode::test

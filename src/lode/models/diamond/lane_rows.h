#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace lode::diamond {

/// Where a lane's cube lies in memory: its origin, and how far apart points are along each axis;
/// along x a step forwards or back.
template <typename V>
struct LaneCube {
  const V* origin = nullptr;
  std::array<std::ptrdiff_t, 3> step{};
};

/// Puts the points of cubes side by side: out[((z · n[1] + y) · n[0] + x) · lanes + lane]. n[0] - 1
/// and the number of lanes are multiples of 8.
void interleave_cubes(std::span<const LaneCube<std::uint16_t>> cubes,
                      const std::array<std::size_t, 3>& n, std::uint16_t* out);
void interleave_cubes(std::span<const LaneCube<float>> cubes, const std::array<std::size_t, 3>& n,
                      float* out);
void interleave_cubes(std::span<const LaneCube<double>> cubes, const std::array<std::size_t, 3>& n,
                      double* out);

}  // namespace lode::diamond

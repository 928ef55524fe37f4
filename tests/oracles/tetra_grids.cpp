#include "tests/oracles/tetra_grids.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace lode::oracles {
namespace {

std::uint64_t mix(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15U;
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31U);
}

/// One octave: a gradient at each lattice point, and between them a polynomial of degree five.
double octave(const Vec3d& p, std::uint64_t seed) {
  std::array<std::int64_t, 3> cell{};
  Vec3d local;
  Vec3d fade;
  for (std::size_t i = 0; i < 3; ++i) {
    cell[i] = static_cast<std::int64_t>(std::floor(p[i]));
    const double t = p[i] - static_cast<double>(cell[i]);
    local[i] = t;
    fade[i] = t * t * t * (t * (t * 6 - 15) + 10);
  }
  double sum = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    std::uint64_t hash = seed;
    double weight = 1;
    Vec3d from = local;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t upper = corner >> i & 1;
      hash = mix(hash ^ static_cast<std::uint64_t>(cell[i] + static_cast<std::int64_t>(upper)));
      weight *= upper == 1 ? fade[i] : 1 - fade[i];
      from[i] -= static_cast<double>(upper);
    }
    Vec3d gradient;
    for (std::size_t i = 0; i < 3; ++i)
      gradient[i] = static_cast<double>(hash >> (21 * i) & 0x1FFFFF) / 0x100000 - 1;
    sum += weight * dot(gradient, from);
  }
  return sum;
}

using Ids = std::array<std::uint32_t, 8>;

/// Six round the diagonal from corner 0 to corner 7; corners by bits of x, y and z.
void cut_in_six(const Ids& v, TetraMesh& mesh) {
  constexpr std::array<std::array<std::size_t, 2>, 6> kPaths{
      {{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}}};
  for (const auto& [a, b] : kPaths) mesh.tetrahedra.push_back({v[0], v[a], v[b], v[7]});
}

/// One in the middle and four at corners, mirrored from cell to cell.
void cut_in_five(const Ids& v, bool is_odd, TetraMesh& mesh) {
  const std::size_t flip = is_odd ? 1 : 0;
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
    mesh.tetrahedra.push_back(
        {v[a ^ flip], v[(is_odd ? c : b) ^ flip], v[(is_odd ? b : c) ^ flip], v[d ^ flip]});
  };
  add(0, 3, 6, 5);
  add(1, 3, 0, 5);
  add(2, 0, 3, 6);
  add(4, 0, 6, 5);
  add(7, 6, 3, 5);
}

}  // namespace

double gradient_noise(const Vec3d& p, std::uint64_t seed) {
  return octave(p, seed) + 0.5 * octave(p * 2.0, seed + 1) + 0.25 * octave(p * 4.0, seed + 2);
}

TetraMesh noise_mesh(int n, Cut cut, std::uint64_t seed) {
  constexpr double kFrequency = 4;
  TetraMesh mesh;
  mesh.has_narrow_positions = true;
  MeshField field{.name = "noise", .type = ScalarType::float32, .n_components = 1, .values = {}};
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        Vec3d p{{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}};
        p = p * (1.0 / (n - 1));
        const double value = gradient_noise(p * kFrequency, seed);
        field.values.push_back(static_cast<double>(static_cast<float>(value)));
        for (double& c : p.v) c = static_cast<double>(static_cast<float>(c));
        mesh.positions.push_back(p);
      }
  for (int z = 0; z + 1 < n; ++z)
    for (int y = 0; y + 1 < n; ++y)
      for (int x = 0; x + 1 < n; ++x) {
        Ids v{};
        for (int corner = 0; corner < 8; ++corner)
          v[static_cast<std::size_t>(corner)] = static_cast<std::uint32_t>(
              ((z + (corner >> 2 & 1)) * n + y + (corner >> 1 & 1)) * n + x + (corner & 1));
        if (cut == Cut::in_six)
          cut_in_six(v, mesh);
        else
          cut_in_five(v, ((x + y + z) & 1) != 0, mesh);
      }
  mesh.fields.push_back(std::move(field));
  return mesh;
}

}  // namespace lode::oracles

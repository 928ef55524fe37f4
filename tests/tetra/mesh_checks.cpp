#include "tests/tetra/mesh_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

namespace lode::test {
namespace {

using Face = std::array<std::uint32_t, 3>;

double six_volumes(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  return dot(cross(b - a, c - a), d - a);
}

double six_volumes(const TetraMesh& mesh, const std::array<std::uint32_t, 4>& t) {
  const auto& p = mesh.positions;
  return six_volumes(p[t[0]], p[t[1]], p[t[2]], p[t[3]]);
}

/// Whether swapping into ascending order takes an odd number of swaps.
template <std::size_t N>
bool sort_corners(std::array<std::uint32_t, N>& v) {
  bool is_odd = false;
  for (std::size_t i = 0; i < N; ++i)
    for (std::size_t j = 0; j + 1 < N; ++j)
      if (v[j] > v[j + 1]) {
        std::swap(v[j], v[j + 1]);
        is_odd = !is_odd;
      }
  return is_odd;
}

}  // namespace

double volume_of(const TetraMesh& mesh, const Tetrahedra& tetrahedra) {
  double sum = 0;
  for (const auto& t : tetrahedra) sum += six_volumes(mesh, t) / 6;
  return sum;
}

double expect_conforming(const TetraMesh& mesh, const Tetrahedra& tetrahedra) {
  std::map<Face, std::array<int, 2>> faces;  // by sense
  for (const auto& t : tetrahedra) {
    EXPECT_GT(six_volumes(mesh, t), 0);
    constexpr std::array<std::array<std::size_t, 3>, 4> kFaces{
        {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
    for (const auto& f : kFaces) {
      Face face{t[f[0]], t[f[1]], t[f[2]]};
      const bool is_odd = sort_corners(face);
      EXPECT_TRUE(face[0] < face[1] && face[1] < face[2]);
      ++faces[face][is_odd ? 1 : 0];
    }
  }
  for (const auto& [face, n] : faces)
    EXPECT_TRUE(n[0] <= 1 && n[1] <= 1) << face[0] << " " << face[1] << " " << face[2];
  return volume_of(mesh, tetrahedra);
}

namespace {

enum class Candidates : std::uint8_t { all, boxed };

bool is_in_box(const TetraMesh& mesh, const std::array<std::uint32_t, 4>& t, const Vec3d& p) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bool is_above = true;
    bool is_below = true;
    for (const std::uint32_t v : t) {
      is_above = is_above && mesh.positions[v][axis] < p[axis];
      is_below = is_below && mesh.positions[v][axis] > p[axis];
    }
    if (is_above || is_below) return false;
  }
  return true;
}

Located locate(const TetraMesh& mesh, const Tetrahedra& tetrahedra, const Vec3d& p,
               std::size_t field, Candidates candidates) {
  Located best{-std::numeric_limits<double>::infinity(), 0};
  for (std::size_t cell = 0; cell < tetrahedra.size(); ++cell) {
    const auto& t = tetrahedra[cell];
    if (candidates == Candidates::boxed && !is_in_box(mesh, t, p)) continue;
    const double whole = six_volumes(mesh, t);
    double least = std::numeric_limits<double>::infinity();
    double value = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      std::array<Vec3d, 4> corners;
      for (std::size_t i = 0; i < 4; ++i) corners[i] = i == k ? p : mesh.positions[t[i]];
      const double weight = six_volumes(corners[0], corners[1], corners[2], corners[3]) / whole;
      least = std::min(least, weight);
      value += weight * mesh.fields[field].values[t[k]];
    }
    if (least > best.least_weight) best = {least, value, cell};
  }
  return best;
}

}  // namespace

Located locate(const TetraMesh& mesh, const Tetrahedra& tetrahedra, const Vec3d& p,
               std::size_t field) {
  const Located inside = locate(mesh, tetrahedra, p, field, Candidates::boxed);
  return inside.least_weight >= 0 ? inside : locate(mesh, tetrahedra, p, field, Candidates::all);
}

Tetrahedra replay(const Tetrahedra& tetrahedra,
                  std::span<const std::array<std::uint32_t, 2>> collapses) {
  std::map<std::uint32_t, std::vector<std::size_t>> stars;
  Tetrahedra live = tetrahedra;
  std::vector<bool> is_there(live.size(), true);
  for (std::size_t i = 0; i < live.size(); ++i)
    for (const std::uint32_t v : live[i]) stars[v].push_back(i);
  for (const auto& [removed, kept] : collapses) {
    for (const std::size_t i : stars[removed]) {
      if (!is_there[i]) continue;
      is_there[i] = std::ranges::find(live[i], kept) == live[i].end();
      if (!is_there[i]) continue;
      std::ranges::replace(live[i], removed, kept);
      stars[kept].push_back(i);
    }
    stars.erase(removed);
  }
  Tetrahedra left;
  for (std::size_t i = 0; i < live.size(); ++i)
    if (is_there[i]) left.push_back(live[i]);
  return left;
}

Tetrahedra normalised(Tetrahedra tetrahedra) {
  for (auto& t : tetrahedra)
    if (sort_corners(t)) std::swap(t[2], t[3]);
  std::ranges::sort(tetrahedra);
  return tetrahedra;
}

}  // namespace lode::test

#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "lode/io/tetrahedra.h"
#include "tests/io/cell_mesh_files.h"

namespace lode::io::test {

using FaceKey = std::array<std::uint32_t, 3>;

/// How many tetrahedra each face has, its vertices in their order.
inline std::map<FaceKey, int> count_faces(const TetraMesh& mesh) {
  std::map<FaceKey, int> counts;
  for (const auto& t : mesh.tetrahedra)
    for (std::size_t i = 0; i < 4; ++i) {
      FaceKey face = {t[(i + 1) % 4], t[(i + 2) % 4], t[(i + 3) % 4]};
      std::sort(face.begin(), face.end());
      ++counts[face];
    }
  return counts;
}

inline double volume_of(const TetraMesh& mesh, std::size_t i) {
  const auto& t = mesh.tetrahedra[i];
  const Vec3d& a = mesh.positions[t[0]];
  return dot(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a), mesh.positions[t[3]] - a) /
         6;
}

inline double total_volume(const TetraMesh& mesh) {
  double sum = 0;
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) sum += volume_of(mesh, i);
  return sum;
}

/// Whether a face lies in a side of the cube [0, n]^3, mirrored or not.
inline bool is_in_hull(const TetraMesh& mesh, const FaceKey& face, double n) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const double side : {0.0, n})
      if (std::all_of(face.begin(), face.end(), [&](std::uint32_t vertex) {
            return std::abs(mesh.positions[vertex][axis]) == side;
          }))
        return true;
  return false;
}

/// Inner faces have two tetrahedra, those in the hull one, and the volume is the cube's.
inline void expect_conforming(const TetraMesh& mesh, int n) {
  for (const auto& [face, count] : count_faces(mesh))
    ASSERT_EQ(count, is_in_hull(mesh, face, n) ? 1 : 2);
  // Each of some thousand volumes of at most n^3 is off by some units in the last place.
  EXPECT_NEAR(total_volume(mesh), std::pow(n, 3), 1e-10);
}

/// What must become of a mesh that can be made tetrahedra.
inline TetrahedraOutcome tetrahedra_of(CellMesh mesh, const TetraOptions& options = {}) {
  Result<TetrahedraOutcome> outcome = to_tetrahedra(std::move(mesh), options);
  EXPECT_TRUE(outcome) << outcome.error().message;
  return outcome ? std::move(outcome).value() : TetrahedraOutcome{};
}

/// Expects an error that names the mesh and contains all `parts`.
inline void expect_no_tetrahedra(CellMesh mesh, const std::vector<std::string>& parts,
                                 const TetraOptions& options = {}) {
  mesh.path = "the mesh";
  const Result<TetrahedraOutcome> outcome = to_tetrahedra(std::move(mesh), options);
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().message.find("the mesh: "), 0U) << outcome.error().message;
  for (const std::string& part : parts)
    EXPECT_NE(outcome.error().message.find(part), std::string::npos)
        << outcome.error().message << " lacks " << part;
}

}  // namespace lode::io::test

// Meshes whose edges do not collapse to their midpoints.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "lode/models/tetra_mt/midpoint/edge_collapses.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::tetra_mt::midpoint {
namespace {

TEST(midpoint, refuses_what_is_no_mesh_with_fields) {
  Progress progress;
  const auto message = [&](const TetraMesh& mesh) {
    const auto result = collapse_edges(mesh, {}, progress);
    return result ? std::string("taken") : result.error().message;
  };
  TetraMesh mesh = oracles::noise_mesh(3, oracles::Cut::in_five, 1);
  TetraMesh bad = mesh;
  bad.tetrahedra[2][1] = 27;
  EXPECT_EQ(message(bad), "tetrahedron 2: expected corners below 27, got 27");
  bad = mesh;
  bad.fields[0].values[5] = std::nan("");
  EXPECT_EQ(message(bad), "field noise: expected finite values, got nan at vertex 5");
  bad = mesh;
  bad.fields.push_back(bad.fields[0]);
  bad.fields[1].values.pop_back();
  EXPECT_EQ(message(bad), "field noise: expected 27 values, got 26");
  bad.fields.clear();
  EXPECT_EQ(message(bad), "midpoints: expected a field, got none");
  progress.cancel();
  EXPECT_EQ(message(mesh), cancelled_error().message);
}

}  // namespace
}  // namespace lode::tetra_mt::midpoint

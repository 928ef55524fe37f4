#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/io/tetra_checks.h"
#include "tests/oracles/random.h"

namespace lode::io {
namespace {

using oracles::Random;
using Cube = std::array<std::uint32_t, 8>;

/// What a random mesh of cubes, [0, n]^3 in all, is made of.
struct MixedOptions {
  std::uint64_t seed = 0;
  int n = 4;
  bool has_turned_wedges = false;  ///< Wound so that the first triangle faces away.
  bool is_mirrored = false;
};

/// Cubes of which some are hexahedra or voxels, some polyhedra, some six pyramids, and columns of
/// which are two wedges each. Inner points are jittered, and all are numbered at random.
class MixedMesh {
 public:
  explicit MixedMesh(const MixedOptions& options) : options_(options), random_(options.seed) {
    make_points();
    for (int x = 0; x < options.n; ++x)
      for (int y = 0; y < options.n; ++y) add_column(x, y, random_.below(3));
    number_points();
    mesh_.point_fields = {{"f", ScalarType::float64, 1, {}}};
    for (const Vec3d& p : mesh_.points)
      mesh_.point_fields[0].values.push_back(3 * p[0] - 2 * p[1] + p[2] + 1);
  }

  [[nodiscard]] const CellMesh& mesh() const { return mesh_; }

 private:
  void make_points() {
    mesh_ = test::empty_cells();
    const int n = options_.n;
    for (int z = 0; z <= n; ++z)
      for (int y = 0; y <= n; ++y)
        for (int x = 0; x <= n; ++x) {
          Vec3d p{{1.0 * x, 1.0 * y, 1.0 * z}};
          for (double& c : p.v)
            if (c > 0 && c < n) c += random_.uniform(-0.05, 0.05);
          if (options_.is_mirrored) p[0] = -p[0];
          mesh_.points.push_back(p);
        }
  }

  [[nodiscard]] std::uint32_t id(int x, int y, int z) const {
    const int n = options_.n + 1;
    return static_cast<std::uint32_t>((z * n + y) * n + x);
  }

  [[nodiscard]] Cube cube(int x, int y, int z) const {
    return {id(x, y, z),     id(x + 1, y, z),     id(x + 1, y + 1, z),     id(x, y + 1, z),
            id(x, y, z + 1), id(x + 1, y, z + 1), id(x + 1, y + 1, z + 1), id(x, y + 1, z + 1)};
  }

  void add_column(int x, int y, std::uint64_t kind) {
    for (int z = 0; z < options_.n; ++z) {
      const Cube c = cube(x, y, z);
      if (kind == 0) {
        add_wedge({c[0], c[1], c[2], c[4], c[5], c[6]});
        add_wedge({c[0], c[2], c[3], c[4], c[6], c[7]});
      } else {
        add_cube(c, random_.below(4));
      }
    }
  }

  void add_wedge(std::array<std::uint32_t, 6> w) {
    if (options_.has_turned_wedges) std::rotate(w.begin(), w.begin() + 3, w.end());
    test::add_cell(mesh_, CellType::wedge, {w.begin(), w.end()});
  }

  void add_cube(const Cube& c, std::uint64_t kind) {
    if (kind == 0) {
      test::add_cell(mesh_, CellType::voxel, {c[0], c[1], c[3], c[2], c[4], c[5], c[7], c[6]});
    } else if (kind == 1) {
      add_pyramids(c);
    } else if (kind == 2) {
      test::add_polyhedron(mesh_, turned_faces(c));
    } else {
      // A quarter turn about the z axis, as often as it may be.
      const std::size_t turn = random_.below(4);
      std::vector<std::uint32_t> corners;
      for (std::size_t i = 0; i < 8; ++i) corners.push_back(c[i / 4 * 4 + (i + turn) % 4]);
      test::add_cell(mesh_, CellType::hexahedron, corners);
    }
  }

  static std::vector<std::vector<std::uint32_t>> faces_of(const Cube& c) {
    return {{c[0], c[4], c[7], c[3]}, {c[1], c[2], c[6], c[5]}, {c[0], c[1], c[5], c[4]},
            {c[3], c[7], c[6], c[2]}, {c[0], c[3], c[2], c[1]}, {c[4], c[5], c[6], c[7]}};
  }

  /// Faces that begin anywhere, some wound the other way.
  std::vector<std::vector<std::uint32_t>> turned_faces(const Cube& c) {
    auto faces = faces_of(c);
    for (auto& face : faces) {
      std::rotate(face.begin(), face.begin() + static_cast<std::ptrdiff_t>(random_.below(4)),
                  face.end());
      if (random_.below(2) == 0) std::reverse(face.begin(), face.end());
    }
    return faces;
  }

  void add_pyramids(const Cube& c) {
    Vec3d centre;
    for (const std::uint32_t corner : c) centre = centre + mesh_.points[corner] * 0.125;
    const auto apex = static_cast<std::uint32_t>(mesh_.points.size());
    mesh_.points.push_back(centre);
    for (const auto& face : faces_of(c))
      test::add_cell(mesh_, CellType::pyramid, {face[3], face[2], face[1], face[0], apex});
  }

  void number_points() {
    std::vector<std::uint32_t> ids(mesh_.points.size());
    std::iota(ids.begin(), ids.end(), 0U);
    for (std::size_t i = ids.size(); i > 1; --i) std::swap(ids[i - 1], ids[random_.below(i)]);
    std::vector<Vec3d> points(ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) points[ids[i]] = mesh_.points[i];
    mesh_.points = points;
    for (std::uint32_t& corner : mesh_.corners) corner = ids[corner];
    for (std::size_t at = 0; at < mesh_.faces.size(); at += mesh_.faces[at] + std::size_t{1})
      for (std::size_t i = 1; i <= mesh_.faces[at]; ++i)
        mesh_.faces[at + i] = ids[mesh_.faces[at + i]];
  }

  MixedOptions options_;
  Random random_;
  CellMesh mesh_;
};

/// Whether a face lies in a side of the cube [0, n]^3, mirrored or not.
bool is_in_hull(const TetraMesh& mesh, const test::FaceKey& face, double n) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const double side : {0.0, n})
      if (std::all_of(face.begin(), face.end(), [&](std::uint32_t vertex) {
            return std::abs(mesh.positions[vertex][axis]) == side;
          }))
        return true;
  return false;
}

/// Inner faces have two tetrahedra, those in the hull one, and the volume is the cube's.
void expect_conforming(const TetraMesh& mesh, int n) {
  for (const auto& [face, count] : test::count_faces(mesh))
    ASSERT_EQ(count, is_in_hull(mesh, face, n) ? 1 : 2);
  // Each of some thousand volumes of at most n^3 is off by some units in the last place.
  EXPECT_NEAR(test::total_volume(mesh), std::pow(n, 3), 1e-10);
}

class mixed_meshes : public testing::TestWithParam<std::uint64_t> {};

TEST_P(mixed_meshes, become_conforming_tetrahedra) {
  const MixedOptions options{.seed = GetParam()};
  const CellMesh mesh = MixedMesh(options).mesh();
  const TetrahedraOutcome outcome = test::tetrahedra_of(mesh);
  expect_conforming(outcome.mesh, options.n);
  EXPECT_EQ(outcome.report.n_cells, mesh.n_cells());
  EXPECT_EQ(outcome.report.n_inverted, 0U);
  EXPECT_EQ(outcome.report.n_zero_volume, 0U);
  EXPECT_EQ(outcome.report.n_left_handed, 0U);
  EXPECT_EQ(outcome.report.n_turned_wedges, 0U);
  EXPECT_EQ(outcome.report.n_components, 1U);
  EXPECT_EQ(outcome.report.n_unused_points, 0U);
  // The centres of polyhedra have the field's value too, since it is linear.
  const TetraMesh& result = outcome.mesh;
  for (std::size_t i = 0; i < result.positions.size(); ++i) {
    const Vec3d& p = result.positions[i];
    ASSERT_NEAR(result.fields[0].values[i], 3 * p[0] - 2 * p[1] + p[2] + 1, 1e-13);
  }
}

TEST_P(mixed_meshes, of_turned_wedges_become_conforming_tetrahedra) {
  const MixedOptions options{.seed = GetParam(), .has_turned_wedges = true};
  const TetrahedraOutcome outcome = test::tetrahedra_of(MixedMesh(options).mesh());
  expect_conforming(outcome.mesh, options.n);
  EXPECT_EQ(outcome.report.n_inverted, 0U);
  EXPECT_GT(outcome.report.n_turned_wedges, 0U);
}

TEST_P(mixed_meshes, that_are_mirrored_are_turned_round) {
  const MixedOptions options{.seed = GetParam(), .is_mirrored = true};
  const TetrahedraOutcome outcome = test::tetrahedra_of(MixedMesh(options).mesh());
  expect_conforming(outcome.mesh, options.n);
  EXPECT_EQ(outcome.report.n_inverted, 0U);
  EXPECT_GT(outcome.report.n_left_handed, 0U);
}

INSTANTIATE_TEST_SUITE_P(seeds, mixed_meshes, testing::Range(std::uint64_t{1}, std::uint64_t{13}));

TEST(single_hexahedron, becomes_5_or_6_tetrahedra_that_fill_it_whatever_its_ids) {
  std::array<std::uint32_t, 8> ids = {0, 1, 2, 3, 4, 5, 6, 7};
  const std::array<Vec3d, 8> cube = {{{{0, 0, 0}},
                                      {{1, 0, 0}},
                                      {{1, 1, 0}},
                                      {{0, 1, 0}},
                                      {{0, 0, 1}},
                                      {{1, 0, 1}},
                                      {{1, 1, 1}},
                                      {{0, 1, 1}}}};
  std::array<std::size_t, 2> counts{};
  do {
    CellMesh mesh = test::empty_cells();
    mesh.points.resize(8);
    for (std::size_t i = 0; i < 8; ++i) mesh.points[ids[i]] = cube[i];
    test::add_cell(mesh, CellType::hexahedron, {ids.begin(), ids.end()});
    const TetraMesh result = test::tetrahedra_of(std::move(mesh)).mesh;
    const std::size_t n = result.tetrahedra.size();
    ASSERT_TRUE(n == 5 || n == 6);
    ++counts[n - 5];
    double volume = 0;
    for (std::size_t i = 0; i < n; ++i) {
      ASSERT_GT(test::volume_of(result, i), 0.1);
      volume += test::volume_of(result, i);
    }
    ASSERT_NEAR(volume, 1, 1e-14);
    for (const auto& [face, count] : test::count_faces(result))
      ASSERT_EQ(count, is_in_hull(result, face, 1) ? 1 : 2);
  } while (std::next_permutation(ids.begin(), ids.begin() + 7));
  EXPECT_GT(counts[0], 0U);
  EXPECT_GT(counts[1], counts[0]);
}

}  // namespace
}  // namespace lode::io

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "lode/io/inner_point.h"
#include "lode/io/polygon_triangles.h"
#include "tests/io/tetra_checks.h"
#include "tests/oracles/random.h"

namespace lode::io {
namespace {

using test::tetrahedra_of;

using Outline = std::vector<std::array<double, 2>>;

const Outline kEll = {{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}};
// No point sees both of its arms' ends.
const Outline kCup = {{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};

double area_of(const Outline& outline) {
  double sum = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const auto& a = outline[i];
    const auto& b = outline[(i + 1) % outline.size()];
    sum += (a[0] * b[1] - a[1] * b[0]) / 2;
  }
  return sum;
}

/// A prism of height 1 whose points have shuffled numbers, as a polyhedron, with a linear field.
CellMesh prism(const Outline& outline, std::uint64_t seed) {
  oracles::Random random(seed);
  const std::size_t n = outline.size();
  std::vector<std::uint32_t> ids(2 * n);
  std::iota(ids.begin(), ids.end(), 0U);
  for (std::size_t i = ids.size(); i > 1; --i) std::swap(ids[i - 1], ids[random.below(i)]);
  CellMesh mesh = test::empty_cells();
  mesh.points.resize(2 * n);
  for (std::size_t i = 0; i < 2 * n; ++i)
    mesh.points[ids[i]] = {{outline[i % n][0], outline[i % n][1], i < n ? 0.0 : 1.0}};
  std::vector<std::vector<std::uint32_t>> faces(2);
  for (std::size_t i = 0; i < n; ++i) {
    faces[0].push_back(ids[n - 1 - i]);
    faces[1].push_back(ids[n + i]);
    const std::size_t next = (i + 1) % n;
    faces.push_back({ids[i], ids[next], ids[n + next], ids[n + i]});
  }
  test::add_polyhedron(mesh, faces);
  mesh.point_fields = {{"f", ScalarType::float64, 1, {}}};
  for (const Vec3d& p : mesh.points)
    mesh.point_fields[0].values.push_back(3 * p[0] - 2 * p[1] + p[2]);
  return mesh;
}

void expect_filled(const CellMesh& mesh, double volume) {
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  EXPECT_EQ(outcome.report.n_inverted, 0U);
  EXPECT_EQ(outcome.report.n_zero_volume, 0U);
  for (std::size_t i = 0; i < outcome.mesh.tetrahedra.size(); ++i)
    EXPECT_GT(test::volume_of(outcome.mesh, i), 0);
  EXPECT_NEAR(test::total_volume(outcome.mesh), volume, 1e-12 * volume);
  for (std::size_t i = 0; i < outcome.mesh.positions.size(); ++i) {
    const Vec3d& p = outcome.mesh.positions[i];
    EXPECT_NEAR(outcome.mesh.fields.at(0).values[i], 3 * p[0] - 2 * p[1] + p[2], 1e-12);
  }
}

class concave_polyhedra : public testing::TestWithParam<std::uint64_t> {};

TEST_P(concave_polyhedra, are_split_round_a_point_that_sees_all_faces) {
  expect_filled(prism(kEll, GetParam()), 5);
}

TEST_P(concave_polyhedra, of_any_star_are_filled_once) {
  oracles::Random random(GetParam());
  Outline star;
  const auto n = 5 + 2 * random.below(8);
  // The kernel holds what is within 0.1 of 0, which is far from the mean where one tip is long.
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
    const double radius = i == 0 ? 20 : 0.3 + static_cast<double>(random.below(1000)) / 1000;
    star.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  expect_filled(prism(star, GetParam()), area_of(star));
}

/// A sphere of 128 triangles whose points are at random distances from its middle, which so sees
/// all of them; the mean does not, for one spike.
CellMesh spiky_ball(oracles::Random& random) {
  CellMesh mesh = test::empty_cells();
  mesh.points = {{{1, 0, 0}}, {{-1, 0, 0}}, {{0, 1, 0}}, {{0, -1, 0}}, {{0, 0, 1}}, {{0, 0, -1}}};
  std::vector<std::vector<std::uint32_t>> faces = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                                   {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < 2; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.points.size()));
      if (is_new) mesh.points.push_back(normalized(mesh.points[a] + mesh.points[b]));
      return at->second;
    };
    std::vector<std::vector<std::uint32_t>> finer;
    for (const auto& f : faces) {
      const std::uint32_t a = middle(f[0], f[1]);
      const std::uint32_t b = middle(f[1], f[2]);
      const std::uint32_t c = middle(f[2], f[0]);
      for (const auto& part : {std::vector{f[0], a, c}, {f[1], b, a}, {f[2], c, b}, {a, b, c}})
        finer.push_back(part);
    }
    faces = finer;
  }
  for (Vec3d& p : mesh.points) p = p * (0.5 + static_cast<double>(random.below(1000)) / 1000);
  mesh.points[4] = mesh.points[4] * 100;
  for (Vec3d& p : mesh.points) p = p + Vec3d{{10, -20, 30}};
  test::add_polyhedron(mesh, faces);
  return mesh;
}

TEST_P(concave_polyhedra, with_spikes_are_filled_once) {
  oracles::Random random(GetParam());
  const CellMesh mesh = spiky_ball(random);
  const Vec3d middle{{10, -20, 30}};
  double volume = 0;
  for (std::size_t at = 0; at < mesh.faces.size(); at += 4) {
    const auto arm = [&](std::size_t k) { return mesh.points[mesh.faces[at + k]] - middle; };
    volume += dot(cross(arm(1), arm(2)), arm(3)) / 6;
  }
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  EXPECT_EQ(outcome.report.n_inverted, 0U);
  EXPECT_EQ(outcome.mesh.tetrahedra.size(), 128U);
  EXPECT_NEAR(test::total_volume(outcome.mesh), volume, 1e-11 * volume);
}

TEST_P(concave_polyhedra, meet_what_fills_their_notches) {
  CellMesh mesh = prism(kEll, GetParam());
  const auto at = [&](double x, double y, double z) {
    const Vec3d place = {{x, y, z}};
    const auto found = std::find(mesh.points.begin(), mesh.points.end(), place);
    if (found == mesh.points.end()) mesh.points.push_back(place);
    return static_cast<std::uint32_t>(std::find(mesh.points.begin(), mesh.points.end(), place) -
                                      mesh.points.begin());
  };
  const std::vector<std::uint32_t> corners = {at(1, 1, 0), at(3, 1, 0), at(3, 3, 0), at(1, 3, 0),
                                              at(1, 1, 1), at(3, 1, 1), at(3, 3, 1), at(1, 3, 1)};
  test::add_cell(mesh, CellType::hexahedron, corners);
  // An L on top of it, whose lower face is the first one's upper face.
  std::vector<std::uint32_t> lower;
  std::vector<std::uint32_t> upper;
  for (const auto& [x, y] : kEll) {
    lower.push_back(at(x, y, 1));
    upper.push_back(at(x, y, 2));
  }
  std::vector<std::vector<std::uint32_t>> faces = {lower, upper};
  for (std::size_t i = 0; i < 6; ++i)
    faces.push_back({lower[i], lower[(i + 1) % 6], upper[(i + 1) % 6], upper[i]});
  test::add_polyhedron(mesh, faces);
  mesh.point_fields[0].values.clear();
  for (const Vec3d& p : mesh.points)
    mesh.point_fields[0].values.push_back(3 * p[0] - 2 * p[1] + p[2]);
  expect_filled(mesh, 5 + 4 + 5);
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  EXPECT_EQ(outcome.report.n_components, 1U);
  // An L's prism has 20 triangles, a hexahedron 12; what two cells share is inside.
  EXPECT_EQ(outcome.report.n_boundary_faces, 20U + 12U + 20U - 2 * (2 + 2) - 2 * 4);
}

INSTANTIATE_TEST_SUITE_P(seeds, concave_polyhedra,
                         testing::Range(std::uint64_t{1}, std::uint64_t{21}));

TEST(polyhedra_without_a_centre, are_counted_and_the_first_is_named) {
  CellMesh mesh = prism(kEll, 1);
  for (int i = 0; i < 2; ++i) {
    const CellMesh cup = prism(kCup, 2);
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), cup.points.begin(), cup.points.end());
    std::vector<std::vector<std::uint32_t>> faces;
    for (std::size_t at = 0; at < cup.faces.size(); at += cup.faces[at] + std::size_t{1}) {
      faces.emplace_back();
      for (std::size_t k = 1; k <= cup.faces[at]; ++k)
        faces.back().push_back(first + cup.faces[at + k]);
    }
    test::add_polyhedron(mesh, faces);
  }
  mesh.point_fields.clear();
  test::expect_no_tetrahedra(mesh,
                             {"some point sees all triangles", "got 2", "first of them cell 1"});
}

TEST(polyhedra_that_are_flat, are_kept) {
  CellMesh mesh = prism({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, 1);
  for (Vec3d& p : mesh.points) p[2] = 0;
  EXPECT_EQ(tetrahedra_of(mesh).report.n_zero_volume, 12U);
}

TEST(polyhedra_with_points_along_edges, are_split_though_triangles_there_have_no_plane) {
  // A box whose edges have points that rounding has moved by some units in the last place.
  Outline outline;
  for (int i = 0; i < 20; ++i) outline.push_back({0.1 * i / 2, 1e-17 * ((i * 7) % 5)});
  outline.push_back({1, 0});
  outline.push_back({1, 1});
  outline.push_back({0, 1});
  for (auto& p : outline) p = {p[0] * 0.6 - p[1] * 0.8, p[0] * 0.8 + p[1] * 0.6};
  const TetrahedraOutcome outcome = tetrahedra_of(prism(outline, 3));
  EXPECT_NEAR(test::total_volume(outcome.mesh), area_of(outline), 1e-14);
}

TEST(values_at_moved_centres, stay_within_those_of_the_corners) {
  CellMesh mesh = prism(kEll, 1);
  std::vector<double>& values = mesh.point_fields[0].values;
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = mesh.points[i][0] == 0 ? 0 : 1;
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  const double centre = outcome.mesh.fields.at(0).values.back();
  EXPECT_GT(centre, 0);
  EXPECT_LT(centre, 0.7);  // 8 of 12 corners have 1; the centre is at the others' side.
  for (double& value : values) value = 1e300;
  EXPECT_DOUBLE_EQ(tetrahedra_of(mesh).mesh.fields.at(0).values.back(), 1e300);
}

TEST(innermost_point, is_that_of_half_spaces_however_many_tie) {
  std::vector<HalfSpace> box;
  for (int copy = 0; copy < 50; ++copy)
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const double side : {1.0, -1.0}) {
        Vec3d normal;
        normal[axis] = side;
        box.push_back({normal, side > 0 ? 0.25 : 0.05});
      }
  const Vec3d p = innermost_point(box);
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(p[axis], 0.1, 1e-12);
}

TEST(innermost_point, is_the_middle_of_the_sphere_that_planes_touch) {
  oracles::Random random(5);
  const auto number = [&] { return static_cast<double>(random.below(2001)) / 1000 - 1; };
  for (int trial = 0; trial < 100; ++trial) {
    const Vec3d middle = Vec3d{{number(), number(), number()}} * 0.5;
    std::vector<HalfSpace> planes;
    for (int i = 0; i < 200; ++i) {
      const Vec3d normal = normalized(Vec3d{{number(), number(), number()}});
      if (length(normal) > 0) planes.push_back({normal, dot(normal, middle) + 0.01});
    }
    EXPECT_LT(length(innermost_point(planes) - middle), 1e-10);
  }
}

TEST(polygon_triangles, are_the_same_from_any_point_and_side_on) {
  std::vector<Vec3d> points;
  for (const auto& [x, y] : kCup) points.push_back({{x, y, 0.1 * x}});
  const auto sorted = [&](std::vector<std::uint32_t> polygon) {
    auto triangles = polygon_triangles(points, polygon);
    double area = 0;
    for (auto& t : triangles) {
      const Vec3d normal = cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]);
      area += std::abs(normal[2]) / 2;
      std::sort(t.begin(), t.end());
    }
    EXPECT_NEAR(area, 7, 1e-14);
    std::sort(triangles.begin(), triangles.end());
    return triangles;
  };
  std::vector<std::uint32_t> polygon = {0, 1, 2, 3, 4, 5, 6, 7};
  const auto first = sorted(polygon);
  EXPECT_EQ(first.size(), 6U);
  for (int turn = 0; turn < 8; ++turn) {
    std::rotate(polygon.begin(), polygon.begin() + 1, polygon.end());
    EXPECT_EQ(sorted(polygon), first);
    EXPECT_EQ(sorted({polygon.rbegin(), polygon.rend()}), first);
  }
}

}  // namespace
}  // namespace lode::io

// Errors that hold everywhere: against the overlay of each tetrahedron that comes of a collapse
// with all of the reference, and at random points.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "lode/api/tetra_dataset.h"
#include "lode/mappers/cell_overlap.h"
#include "lode/models/tetra_mt/everywhere_errors.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"

namespace lode {
namespace {

using oracles::Cut;
using oracles::noise_mesh;
using tetra_mt::HalfEdgeCollapses;
using tetra_mt::Tetrahedron;

double volume_of(const std::array<Vec3d, 4>& c) {
  return dot(cross(c[1] - c[0], c[2] - c[0]), c[3] - c[0]);
}

std::array<Vec3d, 4> corners_of(const TetraMesh& mesh, const Tetrahedron& t) {
  return {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]], mesh.positions[t[3]]};
}

/// A point as shares of a tetrahedron's corners.
std::array<double, 4> shares_of(const std::array<Vec3d, 4>& corners, const Vec3d& p) {
  std::array<double, 4> shares{};
  for (std::size_t k = 0; k < 4; ++k) {
    auto part = corners;
    part[k] = p;
    shares[k] = volume_of(part) / volume_of(corners);
  }
  return shares;
}

double value_in(const TetraMesh& mesh, std::size_t field, const Tetrahedron& t,
                const std::array<double, 4>& shares) {
  double value = 0;
  for (std::size_t k = 0; k < 4; ++k) value += shares[k] * mesh.fields[field].values[t[k]];
  return value;
}

/// The largest |F - F'| on a tetrahedron of vertices of the mesh, by a look at all of the mesh's.
double largest_on(const TetraMesh& mesh, std::size_t field, const Tetrahedron& cell) {
  const auto corners = corners_of(mesh, cell);
  double largest = 0;
  for (const Tetrahedron& t : mesh.tetrahedra) {
    std::array<OverlapCorner, 4> seen;
    for (std::size_t k = 0; k < 4; ++k) {
      seen[k].weights = shares_of(corners, mesh.positions[t[k]]);
      seen[k].difference =
          mesh.fields[field].values[t[k]] - value_in(mesh, field, cell, seen[k].weights);
    }
    if (const auto overlap = find_overlap(seen)) largest = std::max(largest, overlap->largest);
  }
  return largest;
}

/// visit(collapse, tetrahedra that come of it)
template <typename Visit>
void visit_made(const TetraMesh& mesh, const HalfEdgeCollapses& collapses, const Visit& visit) {
  const auto outside = static_cast<std::uint32_t>(mesh.positions.size());
  std::size_t collapse = 0;
  for (const tetra_mt::CollapseStars& stars : collapses.stars) {
    std::size_t link = 0;
    std::size_t triangle = 0;
    for (const auto& size : stars.sizes) {
      const std::uint32_t kept = collapses.collapses[collapse].kept;
      std::vector<Tetrahedron> made;
      for (std::size_t i = 0; i < size.n_triangles; ++i) {
        Tetrahedron t{kept};
        for (std::size_t k = 0; k < 3; ++k)
          t[k + 1] = stars.link[link + stars.triangles[triangle + i][k]];
        if (std::ranges::count(t, kept) == 1 && std::ranges::count(t, outside) == 0)
          made.push_back(t);
      }
      visit(collapse++, made);
      link += size.n_link;
      triangle += size.n_triangles;
    }
  }
}

HalfEdgeCollapses collapsed(const TetraMesh& mesh, Threads threads = {2}) {
  Progress progress;
  auto collapses = tetra_mt::collapse_half_edges(
      mesh, {.base_cells = mesh.tetrahedra.size() / 20, .rules = {}, .threads = threads}, progress);
  EXPECT_TRUE(collapses) << collapses.error().message;
  return std::move(*collapses);
}

/// Errors everywhere are those of the overlay, and not below those at samples.
void expect_those_of_the_overlay(const TetraMesh& mesh) {
  HalfEdgeCollapses collapses = collapsed(mesh);
  ASSERT_GT(collapses.collapses.size(), 10U);
  const auto at_samples = collapses.facts;
  Progress progress;
  const auto report = make_errors_hold_everywhere(mesh, collapses, {2}, progress);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->n_by_range, 0U);
  EXPECT_TRUE(collapses.has_errors_everywhere);
  const std::size_t n_fields = mesh.fields.size();
  visit_made(mesh, collapses, [&](std::size_t collapse, const std::vector<Tetrahedron>& made) {
    for (std::size_t f = 0; f < n_fields; ++f) {
      const auto [low, high] = std::ranges::minmax(mesh.fields[f].values);
      double largest = 0;
      for (const Tetrahedron& t : made) largest = std::max(largest, largest_on(mesh, f, t));
      const double rounding = 1e-9 * (high - low);
      const double stated = collapses.facts[collapse * n_fields + f].error;
      const double before = at_samples[collapse * n_fields + f].error;
      EXPECT_GE(stated, largest - rounding) << collapse;
      EXPECT_LE(stated, std::max(before, largest * (1 + 1e-5)) + rounding) << collapse;
      EXPECT_GE(stated, before);
    }
  });
}

TEST(everywhere_errors, are_those_of_the_overlay) {
  for (const Cut cut : {Cut::in_five, Cut::in_six}) {
    TetraMesh mesh = noise_mesh(5, cut, 7);
    mesh.fields.push_back(mesh.fields[0]);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
      mesh.fields[1].values[v] = length(mesh.positions[v]);
    expect_those_of_the_overlay(mesh);
  }
}

TEST(everywhere_errors, are_those_of_the_overlay_off_the_lattice) {
  TetraMesh mesh = noise_mesh(6, Cut::in_six, 3);
  oracles::Random random(5);
  for (Vec3d& p : mesh.positions)
    for (std::size_t i = 0; i < 3; ++i)
      if (p[i] > 0 && p[i] < 1) p[i] += 0.03 * (random.uniform() - 0.5);
  expect_those_of_the_overlay(mesh);
}

TEST(everywhere_errors, are_those_of_the_overlay_of_thin_cells) {
  TetraMesh mesh = noise_mesh(5, Cut::in_five, 9);
  for (Vec3d& p : mesh.positions) p = {{p[0], p[1] * 100, p[2] * 1e-2}};
  expect_those_of_the_overlay(mesh);
}

TEST(everywhere_errors, are_those_of_the_overlay_beside_cavities) {
  TetraMesh mesh = noise_mesh(7, Cut::in_five, 21);
  std::erase_if(mesh.tetrahedra, [&](const Tetrahedron& t) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    return std::abs(centre[0] - 0.5) < 0.18 && std::abs(centre[1] - 0.5) < 0.18;
  });
  expect_those_of_the_overlay(mesh);
}

TEST(everywhere_errors, of_linear_fields_are_those_of_rounding) {
  TetraMesh mesh = noise_mesh(7, Cut::in_five, 1);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    mesh.fields[0].values[v] = 5 + dot(mesh.positions[v], Vec3d{{1, -2, 3}});
  HalfEdgeCollapses collapses = collapsed(mesh);
  Progress progress;
  ASSERT_TRUE(make_errors_hold_everywhere(mesh, collapses, {2}, progress));
  for (const auto& facts : collapses.facts) EXPECT_LT(facts.error, 1e-11);
}

TEST(everywhere_errors, are_the_same_of_any_number_of_threads) {
  const TetraMesh mesh = noise_mesh(9, Cut::in_five, 4);
  HalfEdgeCollapses one = collapsed(mesh, {1});
  HalfEdgeCollapses three = collapsed(mesh, {3});
  Progress progress;
  ASSERT_TRUE(make_errors_hold_everywhere(mesh, one, {1}, progress));
  ASSERT_TRUE(make_errors_hold_everywhere(mesh, three, {3}, progress));
  ASSERT_EQ(one.facts.size(), three.facts.size());
  for (std::size_t i = 0; i < one.facts.size(); ++i)
    EXPECT_EQ(one.facts[i].error, three.facts[i].error);
}

TEST(everywhere_errors, hold_at_random_points_of_cuts) {
  const TetraMesh mesh = noise_mesh(9, Cut::in_five, 11);
  Progress progress;
  const auto dataset =
      TetraDataset::build(mesh, {.error_place = ErrorPlace::everywhere, .threads = {2}}, progress);
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(dataset->describe().fields[0].error_place, ErrorPlace::everywhere);
  oracles::Random random(2);
  std::uint64_t n_above_samples = 0;
  for (const double tolerance : {0.05, 0.2, 10.0}) {
    SimplexMesh cut;
    TetraMeshOptions options;
    options.query.max_error = tolerance;
    const auto report = dataset->extract_mesh(options, cut, progress);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_LE(report->achieved_error, tolerance);
    for (std::size_t i = 0; i < cut.tetrahedra.size(); i += 1 + cut.tetrahedra.size() / 40) {
      std::array<Vec3d, 4> corners;
      for (std::size_t k = 0; k < 4; ++k) corners[k] = cut.positions[cut.tetrahedra[i][k]];
      for (int n = 0; n < 20; ++n) {
        std::array<double, 4> shares{};
        double sum = 0;
        for (double& share : shares) sum += share = -std::log(1 - random.uniform());
        Vec3d p;
        double there = 0;
        for (std::size_t k = 0; k < 4; ++k) {
          p = p + corners[k] * (shares[k] / sum);
          there += shares[k] / sum * cut.values[cut.tetrahedra[i][k]];
        }
        for (const Tetrahedron& t : mesh.tetrahedra) {
          const auto in = shares_of(corners_of(mesh, t), p);
          if (std::ranges::min(in) < 0) continue;
          const double error = std::abs(value_in(mesh, 0, t, in) - there);
          EXPECT_LE(error, static_cast<double>(cut.errors[i]) + 1e-12);
          n_above_samples += error > 0 ? 1 : 0;
          break;
        }
      }
    }
  }
  EXPECT_GT(n_above_samples, 100U);
}

TEST(everywhere_errors, take_a_boundary_that_stays) {
  Progress progress;
  const auto dataset = TetraDataset::build(
      noise_mesh(4, Cut::in_five, 1),
      {.boundary_tolerance = 0.1, .error_place = ErrorPlace::everywhere}, progress);
  ASSERT_FALSE(dataset);
  EXPECT_NE(dataset.error().message.find("boundary tolerance: expected 0"), std::string::npos);
}

TEST(everywhere_errors, of_meshes_without_cells_are_none) {
  TetraMesh empty;
  empty.fields.push_back({.name = "f", .type = ScalarType::float32, .n_components = 1});
  Progress progress;
  HalfEdgeCollapses none;
  EXPECT_TRUE(make_errors_hold_everywhere(empty, none, {2}, progress));
}

TEST(everywhere_errors, can_be_stopped) {
  const TetraMesh mesh = noise_mesh(5, Cut::in_five, 1);
  HalfEdgeCollapses collapses = collapsed(mesh);
  Progress progress;
  progress.cancel();
  const auto report = make_errors_hold_everywhere(mesh, collapses, {2}, progress);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message, cancelled_error().message);
  EXPECT_FALSE(collapses.has_errors_everywhere);
}

}  // namespace
}  // namespace lode

// Meshes of cuts, clipped at the border: exact in the lattice, whatever the cut.
#include "lode/models/diamond/cut_mesh.h"
#include "lode/models/diamond/build.h"
#include "lode/models/diamond/query_cut.h"
#include "tests/models/mesh_fixtures.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

const std::vector<Index3> kDims{{{11, 6, 9}}, {{17, 17, 17}}, {{33, 5, 9}}, {{2, 2, 2}},
                                {{3, 2, 5}},  {{20, 31, 14}}, {{6, 7, 8}}};

/// How many faces have one cell; none has more than two, and those of one end at the border.
void expect_conforming(const SimplexMesh& mesh, const std::vector<Index3>& points,
                       const Index3& dims) {
  std::map<std::vector<std::uint32_t>, int> n_cells;
  for (const auto& cell : mesh.tetrahedra)
    for (std::size_t skip = 0; skip < 4; ++skip) {
      std::vector<std::uint32_t> face;
      for (std::size_t i = 0; i < 4; ++i)
        if (i != skip) face.push_back(cell[i]);
      std::sort(face.begin(), face.end());
      ++n_cells[face];
    }
  for (const auto& [face, n] : n_cells) {
    ASSERT_LE(n, 2);
    if (n == 2) continue;
    ASSERT_TRUE(is_on_border({points[face[0]], points[face[1]], points[face[2]]}, dims));
  }
}

/// All cells turned as they must be, and together as large as the domain, exactly.
void expect_volume(const SimplexMesh& mesh, const std::vector<Index3>& points,
                   const RegularGrid& grid, std::int64_t n_unit_cells) {
  const bool is_mirrored = determinant(grid.index_to_world_matrix()) < 0;
  std::int64_t sum = 0;
  for (std::size_t cell = 0; cell < mesh.tetrahedra.size(); ++cell) {
    const std::int64_t size = volume6(corners_of(mesh, points, cell)) * (is_mirrored ? -1 : 1);
    ASSERT_GT(size, 0);
    sum += size;
  }
  EXPECT_EQ(sum, 6 * n_unit_cells);
}

/// Every sample in every cell is within the cell's error.
void expect_errors_true(const SimplexMesh& mesh, const std::vector<Index3>& points,
                        const Volume& volume) {
  for (std::size_t cell = 0; cell < mesh.tetrahedra.size(); ++cell) {
    const auto t = corners_of(mesh, points, cell);
    Index3 low = t[0];
    Index3 high = t[0];
    for (const Index3& p : t)
      for (std::size_t i = 0; i < 3; ++i) {
        low[i] = std::min(low[i], p[i]);
        high[i] = std::max(high[i], p[i]);
      }
    const std::int64_t whole = volume6(t);
    for (std::int32_t z = low[2]; z <= high[2]; ++z)
      for (std::int32_t y = low[1]; y <= high[1]; ++y)
        for (std::int32_t x = low[0]; x <= high[0]; ++x) {
          double value = 0;
          bool is_in = true;
          for (std::size_t i = 0; i < 4 && is_in; ++i) {
            auto part = t;
            part[i] = {{x, y, z}};
            const double weight = static_cast<double>(volume6(part)) / static_cast<double>(whole);
            is_in = weight >= 0;
            value += weight * mesh.values[mesh.tetrahedra[cell][i]];
          }
          // Four products and sums of numbers below 128.
          if (is_in)
            ASSERT_LE(std::abs(value - sample_at(volume, {{x, y, z}})),
                      static_cast<double>(mesh.errors[cell]) + 1e-12);
        }
  }
}

std::int64_t n_unit_cells(const Index3& dims) {
  return std::int64_t{dims[0] - 1} * (dims[1] - 1) * (dims[2] - 1);
}

void expect_sound(const SimplexMesh& mesh, const Volume& volume) {
  const RegularGrid& grid = volume.info.grid;
  const std::vector<Index3> points = lattice_points(mesh, grid);
  ASSERT_EQ(mesh.values.size(), points.size());
  ASSERT_EQ(mesh.errors.size(), mesh.n_cells());
  expect_conforming(mesh, points, grid.dims);
  expect_volume(mesh, points, grid, n_unit_cells(grid.dims));
  expect_errors_true(mesh, points, volume);
}

MeshReport extract(const Dataset& dataset, const Query& query, SimplexMesh& mesh) {
  Progress progress;
  const auto report = dataset.extract_mesh({.query = query}, mesh, progress);
  EXPECT_TRUE(report) << report.error().message;
  return report ? report.value() : MeshReport{};
}

TEST(cut_mesh, is_conforming_and_fills_the_domain_at_any_tolerance) {
  for (const Index3& dims : kDims)
    for (const RegularGrid& grid : {plain_grid(dims), awkward_grid(dims)}) {
      const Volume volume = noisy_volume(grid, 1);
      const Dataset dataset = dataset_of(volume);
      for (const double tolerance : {0.0, 4.0, 9.0, 20.0, 1e30}) {
        SimplexMesh mesh;
        const MeshReport report = extract(dataset, {.max_error = tolerance}, mesh);
        EXPECT_LE(report.achieved_error, tolerance);
        EXPECT_EQ(report.n_cells, mesh.tetrahedra.size());
        EXPECT_GE(report.n_cells, report.n_cut_cells / 4);
        EXPECT_EQ(report.largest_error, report.achieved_error);
        expect_sound(mesh, volume);
        if (tolerance == 0) {
          EXPECT_EQ(report.n_cells, static_cast<std::uint64_t>(6 * n_unit_cells(dims)));
        }
      }
    }
}

TEST(cut_mesh, is_conforming_for_any_cut) {
  for (const Index3& dims : kDims) {
    const Volume volume = noisy_volume(plain_grid(dims), 2);
    Progress progress;
    const auto source = make_memory_source(volume);
    const auto model = diamond::build<3>(*source, {.threads = {1}}, progress);
    for (std::uint32_t seed = 0; seed < 15; ++seed) {
      const Demand random([&](const NodeFacts& facts) {
        double key = seed;
        for (const double x : facts.bounds.centre.v) key = key * 7.3 + x;
        return std::fmod(std::abs(std::sin(key)) * 1000, 1.0) < 0.6 ? 1.0 : 0.0;
      });
      diamond::Refinable<3> opened(*model);
      const Cut cut = one_shot(opened, random);
      SimplexMesh mesh;
      ASSERT_TRUE(diamond::mesh_of_cut<3>(opened, cut, {}, mesh, progress));
      expect_sound(mesh, volume);
    }
  }
}

TEST(cut_mesh, is_fine_in_the_focus_and_says_how_fine) {
  const Volume volume = noisy_volume(plain_grid({{30, 22, 27}}), 3);
  const Dataset dataset = dataset_of(volume);
  const std::vector<Query> queries{
      {.isovalues = {60}, .max_error = 2},
      {.field_ranges = {{70, 90}}, .max_error = 2},
      {.boxes = {{{{3, 3, 3}}, {{8, 9, 10}}}}, .max_error = 2},
      {.balls = {{{{20, 11, 13}}, 4}}, .max_error = 2, .max_error_outside = 12},
      {.isovalues = {80}, .max_error = 2, .max_error_outside = 10},
  };
  for (const Query& query : queries) {
    SimplexMesh mesh;
    const MeshReport report = extract(dataset, query, mesh);
    EXPECT_LE(report.achieved_error, *query.max_error);
    EXPECT_GT(report.largest_error, *query.max_error);
    if (query.max_error_outside) {
      EXPECT_LE(report.largest_error, *query.max_error_outside);
    }
    expect_sound(mesh, volume);
  }
}

TEST(cut_mesh, keeps_a_budget_and_says_when_it_cannot) {
  const Volume volume = noisy_volume(plain_grid({{30, 22, 27}}), 3);
  const Dataset dataset = dataset_of(volume);
  double previous = std::numeric_limits<double>::infinity();
  for (const std::uint64_t budget : {100U, 1000U, 10000U}) {
    SimplexMesh mesh;
    const MeshReport report = extract(dataset, {.budget = {budget}}, mesh);
    EXPECT_TRUE(report.budget_met);
    EXPECT_LE(report.n_cut_cells, budget);
    EXPECT_LT(report.achieved_error, previous);
    previous = report.achieved_error;
    expect_sound(mesh, volume);
  }
  SimplexMesh base;
  EXPECT_FALSE(extract(dataset, {.budget = {1}}, base).budget_met);
  expect_sound(base, volume);
}

/// The border cuts simplices in several: what is written is counted.
TEST(cut_mesh, has_no_more_cells_than_its_budget_also_where_the_border_cuts_them) {
  for (const Index3& dims : {Index3{{30, 22, 27}}, Index3{{41, 19, 23}}, Index3{{37, 1, 21}}}) {
    const Volume volume = noisy_volume(plain_grid(dims), 3);
    const Dataset dataset = dataset_of(volume);
    for (const std::uint64_t budget : {200U, 1000U, 10000U}) {
      SCOPED_TRACE(budget);
      SimplexMesh mesh;
      const MeshReport report = extract(dataset, {.budget = {budget}}, mesh);
      EXPECT_TRUE(report.budget_met);
      EXPECT_LE(mesh.n_cells(), budget);
      EXPECT_EQ(report.n_cells, mesh.n_cells());
      const bool is_full = report.achieved_error == 0;
      EXPECT_TRUE(is_full || 2 * report.n_cells > budget) << report.n_cells;
    }
    // As many as the coarsest mesh has, and one less.
    SimplexMesh base;
    const std::uint64_t n_base = extract(dataset, {.budget = {1}}, base).n_cells;
    EXPECT_TRUE(extract(dataset, {.budget = {n_base}}, base).budget_met);
    EXPECT_EQ(base.n_cells(), n_base);
    if (n_base > 1) EXPECT_FALSE(extract(dataset, {.budget = {n_base - 1}}, base).budget_met);
  }
}

TEST(cut_mesh, leaves_out_what_holes_remove) {
  for (const Index3& dims : kDims)
    for (std::uint32_t seed = 0; seed < oracles::trials(6U, 2U); ++seed) {
      const Volume volume = holed_volume(plain_grid(dims), seed);
      const Dataset dataset = dataset_of(volume);
      const auto n_present =
          n_unit_cells(dims) - static_cast<std::int64_t>(dataset.describe().n_removed_cells);
      for (const double tolerance : {0.0, 10.0, 1e30}) {
        SimplexMesh mesh;
        const MeshReport report = extract(dataset, {.max_error = tolerance}, mesh);
        EXPECT_EQ(report.n_left_out, 0U);
        EXPECT_LE(report.achieved_error, tolerance);
        const std::vector<Index3> points = lattice_points(mesh, volume.info.grid);
        expect_volume(mesh, points, volume.info.grid, n_present);
        expect_errors_true(mesh, points, volume);
      }
    }
}

TEST(cut_mesh, counts_the_simplices_that_a_budget_leaves_mixed) {
  const Volume volume = holed_volume(plain_grid({{17, 17, 17}}), 1);
  SimplexMesh mesh;
  const MeshReport report = extract(dataset_of(volume), {.max_error = 1, .budget = {500}}, mesh);
  EXPECT_GT(report.n_left_out, 0U);
  for (const double value : mesh.values) EXPECT_TRUE(std::isfinite(value));
  for (const float error : mesh.errors) EXPECT_TRUE(std::isfinite(error));
  expect_errors_true(mesh, lattice_points(mesh, volume.info.grid), volume);
}

TEST(cut_mesh, of_2d_data_is_made_of_triangles) {
  for (const Index3& dims : {Index3{{37, 1, 21}}, Index3{{6, 9, 1}}, Index3{{1, 12, 12}}}) {
    const Volume volume = noisy_volume(plain_grid(dims), 4);
    const Dataset dataset = dataset_of(volume);
    for (const double tolerance : {0.0, 6.0, 1e30}) {
      SimplexMesh mesh;
      const MeshReport report = extract(dataset, {.max_error = tolerance}, mesh);
      EXPECT_LE(report.achieved_error, tolerance);
      EXPECT_TRUE(mesh.tetrahedra.empty());
      double area = 0;
      std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
      for (const auto& t : mesh.triangles) {
        const Vec3d n = cross(mesh.positions[t[1]] - mesh.positions[t[0]],
                              mesh.positions[t[2]] - mesh.positions[t[0]]);
        const double size = dims[1] == 1 ? -n[1] : dims[0] == 1 ? n[0] : n[2];
        ASSERT_GT(size, 0);
        area += size / 2;
        for (std::size_t i = 0; i < 3; ++i) ++edges[std::minmax(t[i], t[(i + 1) % 3])];
      }
      double expected = 1;
      for (const std::int32_t dim : dims.v) expected *= std::max(1, dim - 1);
      EXPECT_DOUBLE_EQ(area, expected);
      for (const auto& [edge, n] : edges) ASSERT_LE(n, 2);
    }
  }
}

TEST(cut_mesh, of_too_many_cells_is_refused_before_it_is_made) {
  const Volume volume = noisy_volume(plain_grid({{30, 22, 27}}), 3);
  Progress progress;
  const auto source = make_memory_source(volume);
  const auto model = diamond::build<3>(*source, {.threads = {1}}, progress);
  const diamond::Refinable<3> opened(*model);
  std::uint64_t n_cells = 0;
  const auto count = [&](const Cut&, const diamond::QueryCutReport& report) -> Result<void> {
    n_cells = report.n_cells;
    return {};
  };
  for (const Budget& budget : {Budget{}, Budget{2000}}) {
    const auto refused =
        diamond::with_cut<3>(opened, {uniform_demand(0), budget, 1000}, progress, count);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("at most 1000 cells"), std::string::npos);
    EXPECT_EQ(n_cells, 0U);
  }
  ASSERT_TRUE(diamond::with_cut<3>(opened, {uniform_demand(0), {}, 200000}, progress, count));
  EXPECT_EQ(n_cells, 6U * 29 * 21 * 26);
  progress.cancel();
  EXPECT_FALSE(diamond::with_cut<3>(opened, {uniform_demand(0), {}, 200000}, progress, count));
}

TEST(cut_mesh, is_the_same_every_time) {
  const Volume volume = noisy_volume(plain_grid({{20, 31, 14}}), 5);
  SimplexMesh a;
  SimplexMesh b;
  (void)extract(dataset_of(volume), {.max_error = 5}, a);
  (void)extract(dataset_of(volume), {.max_error = 5}, b);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.values, b.values);
  EXPECT_EQ(a.tetrahedra, b.tetrahedra);
  EXPECT_EQ(a.errors, b.errors);
}

TEST(cut_mesh, keeps_double_values_that_float32_does_not_hold) {
  std::vector<double> samples(7 * 6 * 5);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = 1e6 + 1.0 / (3.0 + double(i));
  const Volume volume = make_volume<double>(plain_grid({{7, 6, 5}}), samples);
  SimplexMesh mesh;
  (void)extract(dataset_of(volume), {.max_error = 0}, mesh);
  EXPECT_FALSE(mesh.has_narrow_values);
  EXPECT_EQ(*std::max_element(mesh.values.begin(), mesh.values.end()),
            *std::max_element(samples.begin(), samples.end()));
}

}  // namespace
}  // namespace lode::test

// Several fields of one hierarchy: meshes and surfaces that have others along.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "lode/api/tetra_dataset.h"
#include "lode/locate/cell_locator.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::test {
namespace {

double tilt(const Vec3d& p) { return 3 * p[0] - 2 * p[1] + 0.5 * p[2] + 7; }

MeshField field_named(const char* name, const TetraMesh& mesh,
                      const std::function<double(const Vec3d&)>& f) {
  MeshField field{.name = name, .type = ScalarType::float64, .n_components = 1, .values = {}};
  for (const Vec3d& p : mesh.positions) field.values.push_back(f(p));
  return field;
}

/// Noise, waves and a plane's height, of which F' is F on any cut.
TetraMesh three_fields() {
  TetraMesh mesh = oracles::noise_mesh(13, oracles::Cut::in_five, 3);
  mesh.fields.push_back(field_named("waves", mesh, [](const Vec3d& p) {
    return std::sin(9 * p[0]) * std::cos(7 * p[1] + p[2]);
  }));
  mesh.fields.push_back(field_named("tilt", mesh, tilt));
  return mesh;
}

class tetra_fields : public testing::TestWithParam<Placement> {
 protected:
  static TetraDataset build(const TetraMesh& mesh) {
    Progress progress;
    auto dataset = TetraDataset::build(mesh, {.placement = GetParam(), .threads = {2}}, progress);
    EXPECT_TRUE(dataset);
    return std::move(*dataset);
  }
  void expect_tilt(const Surface& surface, std::size_t place) const {
    ASSERT_EQ(surface.attributes.at(place).name, "tilt");
    const std::vector<double>& values = surface.attributes[place].values;
    ASSERT_EQ(values.size(), surface.positions.size());
    ASSERT_GT(values.size(), 100U);
    // Positions of surfaces are float32s in [0, 1]; tilt changes by less than 4 a unit.
    for (std::size_t v = 0; v < values.size(); ++v)
      EXPECT_NEAR(values[v], tilt(widened(surface.positions[v])), 4 * 3 * 0x1p-24);
  }

  /// Of vertices that steps of codes hold, and do not.
  const double outside_ = GetParam() == Placement::half_edge ? 1e-12 : 1e-6;
  const double rounding_ = GetParam() == Placement::half_edge ? 1e-10 : 1e-7;
  TetraMesh mesh_ = three_fields();
  TetraDataset dataset_ = build(mesh_);
  Progress progress_;
};

TEST_P(tetra_fields, are_named_with_ranges_and_errors) {
  const TetraInfo& info = dataset_.describe();
  ASSERT_EQ(info.fields.size(), 3U);
  for (std::size_t f = 0; f < 3; ++f) {
    const auto [low, high] = std::ranges::minmax(mesh_.fields[f].values);
    EXPECT_EQ(info.fields[f].name, mesh_.fields[f].name);
    EXPECT_EQ(info.fields[f].range_min, low);
    EXPECT_EQ(info.fields[f].range_max, high);
    EXPECT_EQ(find_field(info, mesh_.fields[f].name).value(), f);
  }
  EXPECT_LT(info.fields[2].base_error, rounding_);
  const auto none = find_field(info, "wave");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().message, "expected one of the fields noise, waves, tilt, got 'wave'");
}

/// Values are those of the vertices, and errors hold at all samples, found by a search.
TEST_P(tetra_fields, go_along_with_their_own_errors) {
  std::size_t n_errors = 0;
  for (const std::size_t measured : {0U, 1U, 2U})
    for (const double tolerance : {0.0, 0.05, 1.0}) {
      TetraMeshOptions options;
      options.query.max_error = tolerance;
      options.fields = {measured, {}};
      for (std::size_t f = 0; f < 3; ++f)
        if (f != measured) options.fields.along.push_back(f);
      SimplexMesh cut;
      const auto report = dataset_.extract_mesh(options, cut, progress_);
      ASSERT_TRUE(report) << report.error().message;
      EXPECT_LE(report->achieved_error, tolerance);
      ASSERT_EQ(cut.attributes.size(), 2U);
      const CellLocator locator(cut.positions, cut.tetrahedra, {1});
      for (std::size_t i = 0; i < 2; ++i) {
        const Attribute& attribute = cut.attributes[i];
        const MeshField& field = mesh_.fields[options.fields.along[i]];
        EXPECT_EQ(attribute.name, field.name);
        ASSERT_EQ(attribute.values.size(), cut.positions.size());
        ASSERT_EQ(attribute.errors.size(), cut.tetrahedra.size());
        EXPECT_EQ(attribute.error, static_cast<double>(std::ranges::max(attribute.errors)));
        if (tolerance == 0) EXPECT_EQ(attribute.error, 0);
        for (std::size_t v = 0; v < mesh_.positions.size(); ++v) {
          double least = 1e9;
          locator.visit_near(mesh_.positions[v], 1e3 * outside_, [&](std::uint32_t cell) {
            const CellWeights found = locator.weights_in(cell, mesh_.positions[v]);
            if (std::ranges::min(found.weights) < -outside_) return;
            double there = 0;
            for (std::size_t k = 0; k < 4; ++k)
              there += found.weights[k] * attribute.values[cut.tetrahedra[cell][k]];
            const double off = std::abs(there - field.values[v]);
            least = std::min(least, off - static_cast<double>(attribute.errors[cell]));
            n_errors += off > 0.01 ? 1 : 0;
          });
          EXPECT_LE(least, outside_);
        }
      }
    }
  EXPECT_GT(n_errors, 1000U);
}

TEST_P(tetra_fields, colour_isosurfaces_sections_isolines_and_the_boundary_of_another) {
  const TetraFieldUse fields{.measured = 0, .along = {1, 2}};
  for (const double tolerance : {0.0, 0.1}) {
    TetraSurfaceOptions isosurface;
    isosurface.query.isovalues = {0.1, -0.2};
    isosurface.query.max_error = tolerance;
    isosurface.fields = fields;
    Surface surface;
    const auto found = dataset_.extract_surface(isosurface, surface, progress_);
    ASSERT_TRUE(found) << found.error().message;
    ASSERT_EQ(surface.attributes.size(), 2U);
    EXPECT_LT(surface.attributes[1].error, 100 * rounding_);  // The smallest that is stored.
    expect_tilt(surface, 1);
    TetraSectionOptions section;
    section.planes = {{{{0, 0, 0.4}}, {{0, 0.1, 1}}}, {{{0.3, 0, 0}}, {{1, 0.2, 0}}}};
    section.max_error = tolerance;
    section.fields = fields;
    ASSERT_TRUE(dataset_.extract_section(section, surface, progress_));
    expect_tilt(surface, 1);
    section.isovalues = {0, 0.1};
    ASSERT_TRUE(dataset_.extract_section(section, surface, progress_));
    expect_tilt(surface, 1);
    TetraMeshOptions boundary;
    boundary.query.max_error = tolerance;
    boundary.fields = fields;
    boundary.threshold = Range{-0.3, 0.4};
    ASSERT_TRUE(dataset_.extract_boundary(boundary, surface, progress_));
    expect_tilt(surface, 1);
  }
}

TEST_P(tetra_fields, of_any_place_are_measured_and_probed) {
  const std::array<Vec3d, 2> points{{{{0.21, 0.33, 0.71}}, {{0.5, 0.01, 0.97}}}};
  std::vector<ProbedPoint> found;
  ASSERT_TRUE(dataset_.probe(points, {.field = 2}, found, progress_));
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_NEAR(found[i].value.value, tilt(points[i]), outside_ / 10);
  const auto integral = dataset_.integrate({.max_error = 0.5, .field = 2}, progress_);
  ASSERT_TRUE(integral);
  EXPECT_NEAR(integral->integral.value, tilt({{0.5, 0.5, 0.5}}), outside_);
  EXPECT_FALSE(dataset_.probe(points, {.field = 3}, found, progress_));
  SimplexMesh cut;
  TetraMeshOptions options;
  options.fields = {0, {3}};
  const auto none = dataset_.extract_mesh(options, cut, progress_);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().message, "fields: expected places of 3, got 3");
}

TEST_P(tetra_fields, are_verified_each_and_compared_each) {
  const auto report =
      dataset_.verify({.n_random_cuts = 2, .is_exact = true, .threads = {2}}, progress_);
  ASSERT_TRUE(report);
  std::size_t n_of_waves = 0;
  for (const VerifyReport::Check& check : report->checks) {
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
    n_of_waves += check.name.ends_with(": waves") ? 1U : 0U;
  }
  EXPECT_EQ(n_of_waves, 9U);
  const std::array<std::size_t, 3> all{0, 1, 2};
  EXPECT_TRUE(dataset_.verify_against(mesh_, all, progress_)->passed());
  TetraMesh other = mesh_;
  other.fields[1].values[5] += 1e-9;
  const auto compared = dataset_.verify_against(other, all, progress_);
  ASSERT_TRUE(compared);
  EXPECT_FALSE(compared->passed());
  EXPECT_EQ(compared->checks.back().name, "vertices and values equal the original's: waves");
}

INSTANTIATE_TEST_SUITE_P(placements, tetra_fields,
                         testing::Values(Placement::half_edge, Placement::midpoint),
                         [](const auto& placement) {
                           return placement.param == Placement::half_edge ? "half_edge"
                                                                          : "midpoint";
                         });

}  // namespace
}  // namespace lode::test

// Fields attached to a model that was built without them.
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "lode/api/tetra_attachment.h"
#include "tests/oracles/tetra_grids.h"

namespace lode {
namespace {

/// Noise in a cube with a cavity, in two regions.
TetraMesh noise_in_regions() {
  TetraMesh mesh = oracles::noise_mesh(9, oracles::Cut::in_five, 21);
  const auto centre_of = [&](const auto& t) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    return centre;
  };
  std::erase_if(mesh.tetrahedra, [&](const auto& t) {
    return length(centre_of(t) - Vec3d{{0.5, 0.5, 0.4}}) < 0.2;
  });
  mesh.region_ids = {3, 8};
  for (const auto& t : mesh.tetrahedra) mesh.regions.push_back(centre_of(t)[0] < 0.4 ? 0 : 1);
  return mesh;
}

/// The same mesh with the cosine of its field.
TetraMesh with_cosine(TetraMesh mesh, double frequency) {
  for (double& value : mesh.fields[0].values) value = std::cos(frequency * value);
  mesh.fields[0].name = "cosine";
  mesh.fields[0].type = ScalarType::float64;
  return mesh;
}

class tetra_attachment : public testing::TestWithParam<Placement> {
 protected:
  tetra_attachment() {
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("attach-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder);
    model_ = folder / "model.lode";
    output_ = folder / "output.lode";
    build({.threads = {2}});
  }
  ~tetra_attachment() override {
    std::filesystem::remove_all(std::filesystem::path(model_).parent_path());
  }

  void build(TetraBuildOptions options) const {
    Progress progress;
    options.placement = GetParam();
    EXPECT_TRUE(TetraDataset::build_file(mesh_, model_, options, progress));
  }
  [[nodiscard]] Result<TetraAttachReport> attach(std::vector<TetraStep> steps,
                                                 Threads threads = {2}) const {
    std::size_t at = 0;
    Progress progress;
    return attach_fields(
        model_, output_,
        [&]() -> Result<std::optional<TetraStep>> {
          if (at == steps.size()) return std::optional<TetraStep>();
          return std::optional(steps[at++]);
        },
        threads, progress);
  }
  [[nodiscard]] std::string refusal(const TetraStep& step) const {
    const auto report = attach({step});
    EXPECT_FALSE(std::filesystem::exists(output_));
    return report ? "taken" : report.error().message;
  }

  TetraMesh mesh_ = noise_in_regions();
  std::string model_;
  std::string output_;
};

TEST_P(tetra_attachment, states_of_a_field_what_building_with_it_did) {
  TetraMesh again = mesh_;
  again.fields[0].name = "again";
  const auto report = attach({{again, {}, "again"}});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->n_attached, 1U);
  ASSERT_EQ(report->info.fields.size(), 2U);
  EXPECT_NEAR(report->info.fields[1].base_error, report->info.fields[0].base_error, 1e-6);
  EXPECT_EQ(report->file_bytes, std::filesystem::file_size(output_));
  const auto dataset = TetraDataset::open(output_);
  ASSERT_TRUE(dataset);
  Progress progress;
  for (const double tolerance : {0.0, 0.03, 0.1, 0.3}) {
    std::array<SimplexMesh, 2> cuts;
    for (std::size_t f = 0; f < 2; ++f) {
      TetraMeshOptions options;
      options.query.max_error = tolerance;
      options.fields = {.measured = f, .along = {1 - f}};
      ASSERT_TRUE(dataset->extract_mesh(options, cuts[f], progress));
    }
    EXPECT_EQ(cuts[0].tetrahedra, cuts[1].tetrahedra);
    EXPECT_EQ(cuts[0].values, cuts[1].values);
    EXPECT_EQ(cuts[0].attributes[0].values, cuts[0].values);
    EXPECT_EQ(cuts[0].attributes[0].error, cuts[1].attributes[0].error);
    EXPECT_EQ(cuts[0].regions, cuts[1].regions);
  }
}

TEST_P(tetra_attachment, is_a_step_beside_that_of_the_build) {
  build({.time = 1.5, .threads = {2}});
  EXPECT_EQ(TetraDataset::open(model_)->describe().fields[0].time, 1.5);
  EXPECT_NE(refusal({mesh_, 1.5, "same"}).find("or another time"), std::string::npos);
  const auto report = attach({{mesh_, 0.5, "earlier"}});
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->info.fields.size(), 2U);
  EXPECT_EQ(report->info.fields[0].time, 1.5);
  EXPECT_EQ(report->info.fields[1].time, 0.5);
  EXPECT_EQ(*find_field(TetraDataset::open(output_)->describe(), mesh_.fields[0].name, 0.5), 1U);
  Progress progress;
  TetraBuildOptions options{.placement = GetParam(), .time = -2, .threads = {2}};
  EXPECT_EQ(TetraDataset::build(mesh_, options, progress)->describe().fields[0].time, -2);
  for (const double time : {std::nan(""), HUGE_VAL}) {
    options.time = time;
    const auto refused = TetraDataset::build_file(mesh_, output_, options, progress);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("time: expected a finite"), std::string::npos);
  }
}

TEST_P(tetra_attachment, holds_of_other_fields_and_times) {
  const auto report =
      attach({{with_cosine(mesh_, 5), 0.5, "first"}, {with_cosine(mesh_, 9), 1.5, "second"}});
  ASSERT_TRUE(report) << report.error().message;
  const auto dataset = TetraDataset::open(output_);
  ASSERT_TRUE(dataset);
  const auto& fields = dataset->describe().fields;
  ASSERT_EQ(fields.size(), 3U);
  EXPECT_EQ(fields[1].time, 0.5);
  EXPECT_EQ(fields[2].time, 1.5);
  EXPECT_EQ(*find_field(dataset->describe(), "cosine", 1.5), 2U);
  Progress progress;
  const auto verified = dataset->verify({.n_random_cuts = 4, .threads = {2}}, progress);
  ASSERT_TRUE(verified);
  for (const VerifyReport::Check& check : verified->checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
  TetraMesh all = mesh_;
  all.fields.push_back(with_cosine(mesh_, 5).fields[0]);
  all.fields.push_back(with_cosine(mesh_, 9).fields[0]);
  const auto compared = dataset->verify_against(all, std::array<std::size_t, 3>{0, 1, 2}, progress);
  ASSERT_TRUE(compared) << compared.error().message;
  EXPECT_TRUE(compared->passed());
  // Normals of a surface are those of its own field.
  Surface surface;
  TetraSurfaceOptions options;
  options.query.isovalues = {0.4};
  options.query.max_error = 0;
  options.fields = {.measured = 2, .along = {0}};
  ASSERT_TRUE(dataset->extract_surface(options, surface, progress));
  ASSERT_GT(surface.triangles.size(), 100U);
  EXPECT_EQ(surface.normals.size(), surface.positions.size());
  ASSERT_EQ(surface.attributes.size(), 1U);
  // Along edges both are linear: where the cosine is 0.4, what it is of is near that.
  for (const double value : surface.attributes[0].values) EXPECT_LT(std::abs(value), 1.2);
}

TEST_P(tetra_attachment, holds_where_the_boundary_has_moved) {
  Progress progress;
  build({.boundary_tolerance = 0.05, .threads = {2}});
  ASSERT_TRUE(attach({{with_cosine(mesh_, 5), {}, "cosine"}}));
  const auto verified =
      TetraDataset::open(output_)->verify({.n_random_cuts = 3, .threads = {2}}, progress);
  ASSERT_TRUE(verified);
  for (const VerifyReport::Check& check : verified->checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
}

TEST_P(tetra_attachment, may_replace_the_model_itself) {
  output_ = model_;
  ASSERT_TRUE(attach({{with_cosine(mesh_, 5), 0.5, "first"}}));
  ASSERT_TRUE(attach({{with_cosine(mesh_, 9), 1.5, "second"}}));
  EXPECT_EQ(TetraDataset::open(model_)->describe().fields.size(), 3U);
}

TEST_P(tetra_attachment, takes_no_other_mesh) {
  TetraMesh other = with_cosine(mesh_, 5);
  other.positions[40][1] += 1e-9;
  EXPECT_NE(refusal({other, {}, "moved.vtu"}).find("moved.vtu: expected the mesh that was built"),
            std::string::npos);
  other = with_cosine(mesh_, 5);
  other.tetrahedra.pop_back();
  other.regions.pop_back();
  EXPECT_NE(refusal({other, {}, "less.vtu"}).find("expected the mesh that was built, of"),
            std::string::npos);
  other = with_cosine(mesh_, 5);
  other.tetrahedra[7] = other.tetrahedra[8];
  EXPECT_NE(refusal({other, {}, "cells.vtu"}).find("got one with a cell of vertices"),
            std::string::npos);
  // In another region, or renumbered; one without regions is the mesh all the same.
  other = with_cosine(mesh_, 5);
  other.regions[11] = 1 - other.regions[11];
  EXPECT_NE(refusal({other, {}, "moved.vtu"}).find("moved.vtu: expected the mesh that was built"),
            std::string::npos);
  EXPECT_NE(refusal({other, {}, "moved.vtu"}).find("in region"), std::string::npos);
  other = with_cosine(mesh_, 5);
  other.region_ids = {3, 9};
  EXPECT_NE(refusal({other, {}, "other.vtu"}).find("in region 8, got it in region 9"),
            std::string::npos);
  other = with_cosine(mesh_, 5);
  other.region_ids = {3};
  other.regions.clear();
  EXPECT_NE(refusal({other, {}, "one.vtu"}).find("in region 8, got it in region 3"),
            std::string::npos);
  other = with_cosine(mesh_, 5);
  other.fields[0].values[3] = std::nan("");
  EXPECT_NE(refusal({other, {}, "nan.vtu"}).find("expected finite values"), std::string::npos);
  EXPECT_NE(refusal({mesh_, {}, "same.vtu"}).find("expected a field that the model has not got"),
            std::string::npos);
}

TEST_P(tetra_attachment, takes_a_mesh_without_regions_whose_original_verifies) {
  TetraMesh other = with_cosine(mesh_, 5);
  other.regions.clear();
  other.region_ids.clear();
  ASSERT_TRUE(attach({{other, {}, "plain.vtu"}}));
  const TetraDataset dataset = TetraDataset::open(output_).value();
  Progress progress;
  const std::vector<std::size_t> second{1};
  EXPECT_TRUE(dataset.verify_against(other, second, progress)->passed());
  TetraMesh moved = with_cosine(mesh_, 5);
  EXPECT_TRUE(dataset.verify_against(moved, second, progress)->passed());
  moved.regions[4] = 1 - moved.regions[4];
  const auto report = dataset.verify_against(moved, second, progress);
  ASSERT_TRUE(report);
  EXPECT_FALSE(report->passed());
  EXPECT_EQ(report->checks.back().name, "regions of tetrahedra equal the original's");
}

TEST_P(tetra_attachment, is_the_same_for_any_number_of_threads) {
  const auto bytes = [&](Threads threads) {
    EXPECT_TRUE(attach(
        {{with_cosine(mesh_, 5), 0.5, "first"}, {with_cosine(mesh_, 9), 1.5, "second"}}, threads));
    std::ifstream file(output_, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string one = bytes({1});
  EXPECT_GT(one.size(), 1'000U);
  EXPECT_TRUE(one == bytes({3}));
}

TEST_P(tetra_attachment, can_be_stopped) {
  Progress progress;
  progress.cancel();
  const auto report = attach_fields(
      model_, output_,
      [&]() -> Result<std::optional<TetraStep>> {
        return std::optional(TetraStep{with_cosine(mesh_, 5), {}, "step"});
      },
      {2}, progress);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message, cancelled_error().message);
  EXPECT_FALSE(std::filesystem::exists(output_));
}

INSTANTIATE_TEST_SUITE_P(placements, tetra_attachment,
                         testing::Values(Placement::half_edge, Placement::midpoint),
                         [](const auto& of) {
                           return of.param == Placement::midpoint ? "midpoint" : "half_edge";
                         });

}  // namespace
}  // namespace lode

// Opening files and taking surfaces, meshes and pictures out of them while calls fail.
#include <optional>

#include "lode/api/focused_surface.h"
#include "lode/api/mesh_extraction.h"
#include "lode/api/progressive.h"
#include "tests/faults/fault_scratch.h"
#include "tests/faults/fault_storm.h"
#include "tests/oracles/analytic_fields.h"

namespace lode::test {
namespace {

constexpr double kIsovalue = 0.3;

bool are_same(const Surface& a, const Surface& b) {
  return a.origin == b.origin && a.positions == b.positions && a.normals == b.normals &&
         a.isovalues == b.isovalues && a.triangles == b.triangles && a.values == b.values;
}

/// A .lode file of a small volume, which has levels that are read block by block.
class StoredField {
 public:
  StoredField() {
    const Volume volume = oracles::sample(oracles::Field::gaussians40, 17);
    const auto source = make_memory_source(volume);
    Progress progress;
    auto dataset = Dataset::build(*source, {}, progress);
    EXPECT_TRUE(dataset && dataset->save(path(), {}, progress));
    memory_.emplace(std::move(*dataset));
  }
  [[nodiscard]] const std::string& path() const { return scratch_.output(); }
  [[nodiscard]] const Dataset& memory() const { return *memory_; }

 private:
  FaultScratch scratch_{"field.lode"};
  std::optional<Dataset> memory_;
};

class fault_extract : public FaultTest {
 protected:
  /// An operation that gives a surface, the same as it gives without faults.
  void expect_same_surface(const std::function<Result<Surface>()>& extract) const {
    const auto expected = extract();
    ASSERT_TRUE(expected) << expected.error().message;
    EXPECT_FALSE(expected->is_empty());
    Surface surface;
    Operation operation;
    operation.files = {stored_.path()};
    operation.run = [&]() -> Result<void> {
      LODE_TRY(surface, extract());
      return {};
    };
    operation.expect_done = [&] {
      EXPECT_TRUE(are_same(surface, *expected)) << "the surface differs";
    };
    expect_survives_all(operation);
  }

  /// From the file.
  void expect_same_extraction(const ExtractOptions& options) const {
    expect_same_surface([&]() -> Result<Surface> {
      LODE_TRY(const auto dataset, Dataset::open(stored_.path(), options.threads));
      Surface surface;
      Progress progress;
      LODE_CHECK(dataset.extract(options, surface, progress));
      return surface;
    });
  }

  StoredField stored_;
};

TEST_F(fault_extract, of_a_file_chunk_by_chunk_ends_in_an_error_or_the_surface) {
  for (const int threads : {1, 2})
    expect_same_extraction({.isovalues = {kIsovalue}, .max_error = 0.02, .threads = {threads}});
}

TEST_F(fault_extract, of_a_file_at_full_resolution_ends_in_an_error_or_the_surface) {
  expect_same_extraction({.isovalues = {kIsovalue}, .max_error = 0, .threads = {2}});
}

TEST_F(fault_extract, of_a_file_with_all_edits_ends_in_an_error_or_the_surface) {
  expect_same_extraction({.isovalues = {kIsovalue},
                          .max_error = 0.02,
                          .border = Border::closed,
                          .min_component = 10,
                          .orientation = Orientation::from_higher_values,
                          .threads = {2}});
  expect_same_extraction({.isovalues = {kIsovalue, 0.5},
                          .max_error = 0.02,
                          .clip = Box3d{{{-0.5, -0.5, -0.5}}, {{0.5, 0.5, 0.5}}},
                          .threads = {2}});
}

TEST_F(fault_extract, can_be_tried_again_on_the_dataset_where_it_failed) {
  std::optional<Dataset> dataset;
  Surface surface;
  std::optional<Surface> expected;
  Operation operation;
  operation.files = {stored_.path()};
  operation.prepare = [&] { dataset.emplace(Dataset::open(stored_.path(), {2}).value()); };
  const ExtractOptions options{.isovalues = {kIsovalue}, .max_error = 0.02, .threads = {2}};
  operation.run = [&]() -> Result<void> {
    Progress progress;
    LODE_CHECK(dataset->extract(options, surface, progress));
    return dataset->load(progress);
  };
  operation.expect_done = [&] {
    if (!expected) expected = surface;
    EXPECT_TRUE(are_same(surface, *expected)) << "the surface differs";
  };
  expect_survives(operation, Fault::memory);
  expect_survives(operation, Fault::read);
}

TEST_F(fault_extract, of_focused_surfaces_ends_in_an_error_or_the_surface) {
  FocusedOptions options;
  options.query.isovalues = {kIsovalue};
  options.query.max_error = 0.02;
  options.query.budget.max_cells = 2000;
  expect_same_surface([&]() -> Result<Surface> {
    LODE_TRY(const auto dataset, Dataset::open(stored_.path(), {1}));
    Surface surface;
    Progress progress;
    LODE_CHECK(extract_focused(dataset, options, surface, progress));
    return surface;
  });
}

TEST_F(fault_extract, of_sections_ends_in_an_error_or_the_section) {
  expect_same_surface([&]() -> Result<Surface> {
    SectionOptions options;
    options.plane = {{{0, 0, 0.1}}, {{0, 0, 1}}};
    options.max_error = 0.05;
    Surface section;
    Progress progress;
    LODE_CHECK(stored_.memory().extract_section(options, section, progress));
    return section;
  });
}

TEST_F(fault_extract, of_progressive_steps_ends_in_an_error_or_the_last_step) {
  double achieved = 0;
  Operation operation;
  const ExtractOptions options{.isovalues = {kIsovalue}, .max_error = 0.1};
  operation.run = [&]() -> Result<void> {
    Progress progress;
    LODE_TRY(auto steps, ProgressiveSurface::begin(stored_.memory(), options, progress));
    for (bool is_there = true; is_there;) {
      LODE_TRY(is_there, steps.advance(progress));
      if (is_there) achieved = steps.step().achieved_error;
    }
    return {};
  };
  operation.expect_done = [&] { EXPECT_LE(achieved, 0.1); };
  expect_survives(operation, Fault::memory);
}

TEST_F(fault_extract, of_meshes_ends_in_an_error_or_the_mesh) {
  SimplexMesh mesh;
  std::optional<SimplexMesh> expected;
  Operation operation;
  MeshOptions options;
  options.query.isovalues = {kIsovalue};
  options.query.max_error = 0.2;
  operation.run = [&]() -> Result<void> {
    Progress progress;
    LODE_CHECK(stored_.memory().extract_mesh(options, mesh, progress));
    return {};
  };
  operation.expect_done = [&] {
    if (!expected) expected = mesh;
    EXPECT_EQ(mesh.tetrahedra, expected->tetrahedra);
    EXPECT_EQ(mesh.positions, expected->positions);
  };
  expect_survives(operation, Fault::memory);
}

TEST_F(fault_extract, verifying_a_file_ends_in_an_error_or_the_report) {
  Operation operation;
  operation.files = {stored_.path()};
  operation.run = [&]() -> Result<void> {
    Progress progress;
    if (auto report = verify_file(stored_.path(), {2}, progress); !report) return report.error();
    return {};
  };
  expect_survives_all(operation);
}

}  // namespace
}  // namespace lode::test

// Files of midpoints with fields that came later: what verification finds of them, and real meshes.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lode/api/files.h"
#include "lode/api/tetra_attachment.h"
#include "lode/models/tetra_mt/midpoint/edge_collapses.h"
#include "lode/models/tetra_mt/midpoint/field_appender.h"
#include "lode/models/tetra_mt/midpoint/measured_fields.h"
#include "lode/models/tetra_mt/midpoint/persist.h"
#include "lode/models/tetra_mt/midpoint/reference_mesh.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/trials.h"
#include "tests/tetra/midpoint_fixtures.h"

namespace lode {
namespace {

using tetra_mt::midpoint::EdgeCollapses;
using tetra_mt::midpoint::FieldAppender;
using tetra_mt::midpoint::FieldRecord;
using tetra_mt::midpoint::FieldRecords;
using tetra_mt::midpoint::NodeCodes;
using tetra_mt::midpoint::ReferenceMesh;

class midpoint_attached : public testing::Test {
 protected:
  midpoint_attached() { std::filesystem::create_directories(folder_); }
  ~midpoint_attached() override { std::filesystem::remove_all(folder_); }

  /// The mesh's second field attached to a file of its first, changed before it is written.
  void attach_changed(const std::function<void(FieldRecords&)>& change) {
    TetraMesh first = mesh_;
    first.fields.resize(1);
    TetraMesh second = mesh_;
    second.fields.erase(second.fields.begin());
    ASSERT_TRUE(tetra_mt::midpoint::save(test::midpoints_of(first, 100), model_, {2}, progress_));
    const auto opened = tetra_mt::midpoint::open(model_);
    ASSERT_TRUE(opened);
    const auto reference = ReferenceMesh::of(opened->forest, {}, progress_);
    ASSERT_TRUE(reference) << reference.error().message;
    const auto vertices = reference->match(second);
    ASSERT_TRUE(vertices) << vertices.error().message;
    auto fields = measure_fields(opened->forest, *vertices, second, {2}, progress_);
    ASSERT_TRUE(fields) << fields.error().message;
    change(fields->front());
    auto appender = FieldAppender::create(model_, opened->forest, output_, progress_);
    ASSERT_TRUE(appender);
    ASSERT_TRUE(appender->append(std::move(fields->front()), {2}, progress_));
    ASSERT_TRUE(appender->finish(progress_));
  }
  /// Names of what fails of the output by itself, and against the mesh.
  [[nodiscard]] std::vector<std::string> failures() {
    const auto dataset = TetraDataset::open(output_);
    EXPECT_TRUE(dataset) << dataset.error().message;
    const auto report = dataset->verify({.n_random_cuts = 6, .threads = {2}}, progress_);
    EXPECT_TRUE(report) << report.error().message;
    std::vector<std::string> names;
    for (const VerifyReport::Check& check : report->checks)
      if (!check.passed) names.push_back(check.name);
    return names;
  }
  [[nodiscard]] bool is_of_mesh() {
    const auto compared = TetraDataset::open(output_)->verify_against(
        mesh_, std::array<std::size_t, 2>{0, 1}, progress_);
    EXPECT_TRUE(compared) << compared.error().message;
    return compared->passed();
  }
  static std::string bytes_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  static TetraMesh noise_and_waves() {
    TetraMesh mesh = test::with_fields(oracles::noise_mesh(11, oracles::Cut::in_five, 21));
    mesh.fields.resize(2);
    return mesh;
  }

  TetraMesh mesh_ = noise_and_waves();
  Progress progress_;
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("midpoint-attached-" + std::to_string(getpid()));
  std::string model_ = folder_ / "model.lode";
  std::string output_ = folder_ / "output.lode";
};

TEST_F(midpoint_attached, passes_where_nothing_was_altered) {
  attach_changed([](FieldRecords&) {});
  EXPECT_EQ(failures(), std::vector<std::string>{});
  EXPECT_TRUE(is_of_mesh());
}

TEST_F(midpoint_attached, is_found_out_where_an_error_was_lowered) {
  attach_changed([](FieldRecords& field) {
    for (FieldRecord& record : field.records.nodes) {
      NodeCodes::Parts parts = NodeCodes::parts(record.facts());
      parts.error -= std::min(parts.error, 8U);
      record = {record.difference, NodeCodes::word(parts), record.place()};
    }
  });
  const auto failed = failures();
  EXPECT_FALSE(failed.empty());
  for (const std::string& name : failed) EXPECT_TRUE(name.ends_with(": waves")) << name;
  EXPECT_TRUE(is_of_mesh());
}

/// Of what the first collapse left: it was one that did hardly any harm.
TEST_F(midpoint_attached, is_found_out_where_a_value_was_altered) {
  attach_changed([](FieldRecords& field) {
    FieldRecord& record = field.records.nodes.front();
    record = {record.difference + (1 << 28), record.facts(), record.place()};
  });
  const auto failed = failures();
  EXPECT_FALSE(failed.empty());
  for (const std::string& name : failed) EXPECT_TRUE(name.ends_with(": waves")) << name;
  EXPECT_FALSE(is_of_mesh());
}

TEST_F(midpoint_attached, is_found_out_where_one_offset_was_altered) {
  attach_changed([](FieldRecords& field) {
    ASSERT_GT(field.records.exact.size(), 0U);
    tetra_mt::midpoint::ExactValues other;
    for (const std::uint32_t leaf : field.records.exact.leaves())
      other.add(leaf, leaf == field.records.exact.leaves().back()
                          ? -*field.records.exact.find(leaf)
                          : *field.records.exact.find(leaf));
    field.records.exact = other;
  });
  EXPECT_FALSE(is_of_mesh());
}

/// A field of which nearly every vertex is an extremum, where the hierarchy's is smooth.
TEST_F(midpoint_attached, holds_of_fields_that_the_order_knew_nothing_of) {
  oracles::Random random(8);
  for (double& value : mesh_.fields[1].values) value = random.uniform(-3, 5);
  attach_changed([](FieldRecords&) {});
  EXPECT_EQ(failures(), std::vector<std::string>{});
  EXPECT_TRUE(is_of_mesh());
}

std::filesystem::path tetra_data() {
  if (const char* directory = std::getenv("LODE_DATA"))
    return std::filesystem::path(directory) / "tetra";
  return (std::filesystem::path(__FILE__).parent_path() / "../../../shared/data/tetra")
      .lexically_normal();
}

struct RealMesh {
  const char* name;
  std::vector<std::string> fields;  ///< Of a vector the magnitude.
};

/// Curved boundaries, flat cells, points at one place with other values, scalars and vectors: the
/// file of all fields, byte for byte.
TEST_F(midpoint_attached, is_of_real_meshes_what_building_with_all_fields_makes) {
  const RealMesh disk{"disk_out_44832tets.vtu", {"Temp", "Pres", "V", "AsH3"}};
  const RealMesh fin{"blunt_fin_187395tets.vtu", {"Density", "Momentum", "StagnationEnergy"}};
  for (const RealMesh& real : oracles::trials<std::vector<RealMesh>>({disk, fin}, {disk})) {
    const std::filesystem::path path = tetra_data() / real.name;
    if (!std::filesystem::exists(path))
      GTEST_SKIP() << "no tetra/" << real.name << "; set LODE_DATA";
    auto cells = read_cell_mesh(path, {});
    ASSERT_TRUE(cells) << cells.error().message;
    auto read = to_tetrahedra(std::move(*cells), {.fields = real.fields});
    ASSERT_TRUE(read) << read.error().message;
    const TetraMesh& mesh = read->mesh;
    const std::size_t n = mesh.fields.size();
    ASSERT_EQ(n, real.fields.size());
    const auto all = tetra_mt::midpoint::collapse_edges(mesh, {.threads = {2}}, progress_);
    ASSERT_TRUE(all) << all.error().message;
    const auto save = [&](const TetraMesh& of, const EdgeCollapses& collapses, const auto& to) {
      const auto hierarchy = tetra_mt::midpoint::make_hierarchy(of, collapses, {2});
      ASSERT_TRUE(hierarchy) << hierarchy.error().message;
      ASSERT_TRUE(tetra_mt::midpoint::save(*hierarchy, to, {2}, progress_));
    };
    const std::string together = folder_ / "together.lode";
    save(mesh, *all, together);
    EdgeCollapses first = *all;
    first.facts.clear();
    first.errors.clear();
    for (std::size_t i = 0; i < all->facts.size(); i += n) first.facts.push_back(all->facts[i]);
    for (std::size_t i = 0; i < all->errors.size(); i += n) first.errors.push_back(all->errors[i]);
    TetraMesh alone = mesh;
    alone.fields.resize(1);
    save(alone, first, model_);
    std::size_t at = 1;
    const auto next = [&]() -> Result<std::optional<TetraStep>> {
      if (at == n) return std::optional<TetraStep>();
      TetraMesh step = mesh;
      step.fields = {mesh.fields[at++]};
      return std::optional(TetraStep{std::move(step), {}, real.name});
    };
    const auto report = attach_fields(model_, output_, next, {2}, progress_);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->n_attached, n - 1);
    EXPECT_TRUE(bytes_of(output_) == bytes_of(together)) << real.name;
  }
}

}  // namespace
}  // namespace lode

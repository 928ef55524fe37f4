// Fields for hierarchies of midpoints that were built without them: what is measured later is what
// building with them measures.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lode/models/tetra_mt/midpoint/coincident.h"
#include "lode/models/tetra_mt/midpoint/field_appender.h"
#include "lode/models/tetra_mt/midpoint/measured_fields.h"
#include "lode/models/tetra_mt/midpoint/persist.h"
#include "lode/models/tetra_mt/midpoint/reference_mesh.h"
#include "lode/models/tetra_mt/midpoint/repeated_collapses.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/trials.h"
#include "tests/tetra/file_fixtures.h"
#include "tests/tetra/midpoint_checks.h"
#include "tests/tetra/midpoint_fixtures.h"

namespace lode::tetra_mt::midpoint {
namespace {

using oracles::Cut;
using oracles::Random;

/// Points an axis: odd, and of several blocks.
const int kSmall = oracles::trials(13, 9);
const int kLarge = oracles::trials(24, 19);

/// A ball in a cube of noise is one region, and below the middle is a patch.
TetraMesh noise_with_labels(int n, Cut cut) {
  TetraMesh mesh = test::with_fields(oracles::noise_mesh(n, cut, 9));
  mesh.region_ids = {2, 4};
  mesh.patches = {{7, "floor"}};
  for (const Tetrahedron& t : mesh.tetrahedra) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    mesh.regions.push_back(length(centre - Vec3d{{0.5, 0.5, 0.5}}) < 0.35 ? 1 : 0);
    for (std::size_t place = 0; place < 4; ++place) {
      const auto face = others(t, place);
      if (std::ranges::all_of(face, [&](std::uint32_t v) { return mesh.positions[v][2] == 0; }))
        mesh.patch_faces.push_back({face, 0});
    }
  }
  return mesh;
}

/// Vertices in the plane x = 1/2 twice, with values of their own on both sides.
TetraMesh parted_noise(int n) {
  TetraMesh mesh = test::with_fields(oracles::noise_mesh(n, Cut::in_five, 5));
  const auto n_before = static_cast<std::uint32_t>(mesh.positions.size());
  std::vector<std::uint32_t> twins(n_before, kNone);
  for (std::uint32_t v = 0; v < n_before; ++v) {
    if (mesh.positions[v][0] != 0.5) continue;
    twins[v] = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back(mesh.positions[v]);
    for (MeshField& field : mesh.fields) field.values.push_back(field.values[v] + 0.25);
  }
  for (Tetrahedron& t : mesh.tetrahedra) {
    const bool is_left =
        std::ranges::any_of(t, [&](std::uint32_t v) { return mesh.positions[v][0] < 0.5; });
    for (std::uint32_t& v : t)
      if (is_left && twins[v] != kNone) v = twins[v];
  }
  return mesh;
}

/// A sphere of it, so that collapses that bend the boundary leave samples outside.
TetraMesh ball() {
  TetraMesh mesh = test::with_fields(oracles::noise_mesh(10, Cut::in_six, 7));
  for (Vec3d& p : mesh.positions) {
    const Vec3d d = p - Vec3d{{0.5, 0.5, 0.5}};
    const double most = std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])});
    p = most > 0 ? d * (most / length(d)) : d;
  }
  return mesh;
}

TetraMesh with_field(const TetraMesh& mesh, std::size_t field) {
  TetraMesh one = mesh;
  one.fields = {mesh.fields[field]};
  return one;
}

EdgeCollapses collapsed_by(const TetraMesh& mesh, const EdgeCollapseOptions& options) {
  Progress progress;
  auto result = collapse_edges(mesh, options, progress);
  EXPECT_TRUE(result) << result.error().message;
  return result ? std::move(*result) : EdgeCollapses{};
}

/// What is known of one field alone.
EdgeCollapses of_field(const EdgeCollapses& all, std::size_t field, std::size_t n_fields) {
  EdgeCollapses one = all;
  one.facts.clear();
  one.errors.clear();
  for (std::size_t i = field; i < all.facts.size(); i += n_fields)
    one.facts.push_back(all.facts[i]);
  for (std::size_t i = field; i < all.errors.size(); i += n_fields)
    one.errors.push_back(all.errors[i]);
  return one;
}

void expect_same_bits(const EdgeFacts& a, const EdgeFacts& b) {
  EXPECT_EQ(std::bit_cast<std::uint64_t>(a.error), std::bit_cast<std::uint64_t>(b.error));
  EXPECT_EQ(std::bit_cast<std::uint64_t>(a.low), std::bit_cast<std::uint64_t>(b.low));
  EXPECT_EQ(std::bit_cast<std::uint64_t>(a.high), std::bit_cast<std::uint64_t>(b.high));
  EXPECT_EQ(a.value, b.value);
}

/// All fields at once, then each alone.
void expect_repeated(const TetraMesh& mesh, const EdgeCollapseOptions& options) {
  const EdgeCollapses built = collapsed_by(mesh, options);
  ASSERT_GT(built.collapses.size(), 100U);
  Progress progress;
  const std::size_t n = mesh.fields.size();
  const auto all = repeat_collapses(
      mesh, built.collapses, {.boundary_tolerance = options.boundary_tolerance}, {2}, progress);
  ASSERT_TRUE(all) << all.error().message;
  ASSERT_EQ(all->facts.size(), built.facts.size());
  for (std::size_t i = 0; i < built.facts.size(); ++i)
    expect_same_bits(all->facts[i], built.facts[i]);
  EXPECT_EQ(all->errors, built.errors);
  for (std::size_t f = 0; f < n; ++f) {
    const auto one =
        repeat_collapses(with_field(mesh, f), built.collapses,
                         {.boundary_tolerance = options.boundary_tolerance}, {2}, progress);
    ASSERT_TRUE(one) << one.error().message;
    const EdgeCollapses expected = of_field(built, f, n);
    for (std::size_t i = 0; i < expected.facts.size(); ++i)
      expect_same_bits(one->facts[i], expected.facts[i]);
    EXPECT_EQ(one->errors, expected.errors);
  }
}

TEST(midpoint_attachment, measures_bit_for_bit_what_the_build_measured) {
  for (const CollapseOrder order :
       {CollapseOrder::squared_error, CollapseOrder::space_error, CollapseOrder::quadric}) {
    expect_repeated(noise_with_labels(kSmall, Cut::in_five),
                    {.base_cells = 100, .order = order, .threads = {2}});
    if (!oracles::trials(true, order == CollapseOrder::quadric)) continue;
    // Rounds of several blocks each, and samples on faces and edges between cells.
    expect_repeated(test::with_fields(oracles::noise_mesh(kLarge, Cut::in_six, 3)),
                    {.base_cells = 1'000, .order = order, .threads = {2}});
  }
  expect_repeated(parted_noise(kSmall), {.base_cells = 100, .threads = {2}});
  expect_repeated(ball(), {.boundary_tolerance = 0.03, .threads = {2}});
}

class midpoint_attached_file : public testing::Test {
 protected:
  midpoint_attached_file() { std::filesystem::create_directories(folder_); }
  ~midpoint_attached_file() override { std::filesystem::remove_all(folder_); }

  static std::string bytes_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void save_to(const std::string& path, const TetraMesh& mesh, const EdgeCollapses& collapses) {
    const auto saved = save(hierarchy_of(mesh, collapses), path, {2}, progress_);
    ASSERT_TRUE(saved) << saved.error().message;
  }
  /// To model_, as output_; each mesh a step.
  [[nodiscard]] Result<std::uint64_t> attach(std::span<const TetraMesh> steps, Threads threads) {
    LODE_TRY(const auto opened, open(model_));
    LODE_TRY(const auto coincident, opened.coincident_leaves());
    LODE_TRY(const auto reference, ReferenceMesh::of(opened.forest, coincident, progress_));
    LODE_TRY(auto appender, FieldAppender::create(model_, opened.forest, output_, progress_));
    for (const TetraMesh& step : steps) {
      LODE_TRY(const auto vertices, reference.match(step));
      LODE_TRY(auto fields, measure_fields(opened.forest, vertices, step, threads, progress_));
      for (FieldRecords& field : fields)
        LODE_CHECK(appender.append(std::move(field), threads, progress_));
    }
    return appender.finish(progress_);
  }
  /// The first field's hierarchy with the others attached against that of all, byte for byte.
  void expect_bytes_of_all(const TetraMesh& mesh, const EdgeCollapseOptions& options) {
    const EdgeCollapses all = collapsed_by(mesh, options);
    const std::string together = folder_ / "together.lode";
    save_to(together, mesh, all);
    save_to(model_, with_field(mesh, 0), of_field(all, 0, mesh.fields.size()));
    TetraMesh rest = mesh;
    rest.fields.erase(rest.fields.begin());
    const std::string expected = bytes_of(together);
    ASSERT_GT(expected.size(), 10'000U);
    const auto once = attach(std::array{rest}, {2});
    ASSERT_TRUE(once) << once.error().message;
    EXPECT_EQ(*once, expected.size());
    EXPECT_TRUE(bytes_of(output_) == expected);
    std::vector<TetraMesh> steps;
    for (std::size_t f = 1; f < mesh.fields.size(); ++f) steps.push_back(with_field(mesh, f));
    const auto one_by_one = attach(steps, {3});
    ASSERT_TRUE(one_by_one) << one_by_one.error().message;
    EXPECT_TRUE(bytes_of(output_) == expected);
  }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("midpoint-attach-" + std::to_string(getpid()));
  std::string model_ = folder_ / "model.lode";
  std::string output_ = folder_ / "output.lode";
  Progress progress_;
};

TEST_F(midpoint_attached_file, is_that_of_building_with_all_fields) {
  expect_bytes_of_all(noise_with_labels(kSmall, Cut::in_five), {.base_cells = 100, .threads = {2}});
  expect_bytes_of_all(test::with_fields(oracles::noise_mesh(kLarge, Cut::in_six, 3)),
                      {.base_cells = 1'000, .threads = {2}});
  expect_bytes_of_all(parted_noise(kSmall), {.base_cells = 100, .threads = {2}});
  expect_bytes_of_all(ball(), {.boundary_tolerance = 0.03, .threads = {2}});
}

/// Nothing collapses: no nodes, and no pages.
TEST_F(midpoint_attached_file, may_be_a_base_alone) {
  const TetraMesh mesh = test::with_fields(oracles::noise_mesh(9, Cut::in_five, 3));
  expect_bytes_of_all(mesh, {.base_cells = mesh.tetrahedra.size(), .threads = {2}});
}

TEST_F(midpoint_attached_file, tells_vertices_at_one_place_apart) {
  const TetraMesh mesh = parted_noise(13);
  const Hierarchy hierarchy = test::midpoints_of(with_field(mesh, 0), 100);
  const auto n_twins = static_cast<std::uint32_t>(mesh.positions.size()) - 13 * 13 * 13;
  EXPECT_EQ(hierarchy.n_coincident_leaves, 2 * n_twins);
  ASSERT_TRUE(save(hierarchy, model_, {2}, progress_));
  const auto opened = open(model_);
  ASSERT_TRUE(opened);
  const auto coincident = opened->coincident_leaves();
  ASSERT_TRUE(coincident);
  EXPECT_EQ(*coincident, hierarchy.coincident_leaves);
  const auto reference = ReferenceMesh::of(opened->forest, *coincident, progress_);
  ASSERT_TRUE(reference) << reference.error().message;
  const auto matched = reference->match(mesh);
  ASSERT_TRUE(matched) << matched.error().message;
  EXPECT_EQ(*matched, hierarchy.mesh_vertices);
  // Told apart otherwise, or not at all.
  std::vector<std::uint32_t> swapped = *coincident;
  std::swap(swapped[0], swapped[1]);
  const auto other = ReferenceMesh::of(opened->forest, swapped, progress_);
  ASSERT_TRUE(other);
  EXPECT_FALSE(other->match(mesh));
  std::swap(swapped[1], swapped[2]);
  EXPECT_FALSE(ReferenceMesh::of(opened->forest, swapped, progress_));
  EXPECT_FALSE(ReferenceMesh::of(opened->forest, {}, progress_));
  swapped = *coincident;
  swapped.push_back(0);
  EXPECT_FALSE(ReferenceMesh::of(opened->forest, swapped, progress_));
}

/// Renumbered, and with its cells and their corners in another order: which of two tetrahedra takes
/// a sample on the face between them is decided otherwise, and what rounding adds to errors.
TEST_F(midpoint_attached_file, has_the_same_values_of_a_mesh_in_another_order) {
  const TetraMesh mesh = test::with_fields(oracles::noise_mesh(11, Cut::in_five, 5));
  ASSERT_TRUE(save(test::midpoints_of(with_field(mesh, 0), 200), model_, {2}, progress_));
  const auto opened = open(model_);
  ASSERT_TRUE(opened);
  const auto reference = ReferenceMesh::of(opened->forest, {}, progress_);
  ASSERT_TRUE(reference) << reference.error().message;
  TetraMesh other = mesh;
  const auto n = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::uint32_t v = 0; v < n; ++v) {
    other.positions[n - 1 - v] = mesh.positions[v];
    for (std::size_t f = 0; f < mesh.fields.size(); ++f)
      other.fields[f].values[n - 1 - v] = mesh.fields[f].values[v];
  }
  for (Tetrahedron& t : other.tetrahedra) {
    for (std::uint32_t& v : t) v = n - 1 - v;
    std::rotate(t.begin(), t.begin() + 1, t.begin() + 3);
  }
  std::ranges::reverse(other.tetrahedra);
  const auto measured = [&](const TetraMesh& of) {
    const auto vertices = reference->match(of);
    EXPECT_TRUE(vertices) << vertices.error().message;
    auto fields = measure_fields(opened->forest, *vertices, of, {2}, progress_);
    EXPECT_TRUE(fields) << fields.error().message;
    return std::move(*fields);
  };
  const auto ours = measured(mesh);
  const auto theirs = measured(other);
  for (std::size_t f = 0; f < ours.size(); ++f) {
    EXPECT_EQ(ours[f].records.roots.codes, theirs[f].records.roots.codes);
    EXPECT_EQ(ours[f].records.exact, theirs[f].records.exact);
    std::size_t n_alike = 0;
    for (std::size_t node = 0; node < ours[f].records.nodes.size(); ++node) {
      const FieldRecord& a = ours[f].records.nodes[node];
      const FieldRecord& b = theirs[f].records.nodes[node];
      EXPECT_EQ(a.difference, b.difference);
      EXPECT_EQ(a.place(), b.place());
      n_alike += a.facts() == b.facts() ? 1 : 0;
    }
    EXPECT_GT(n_alike, ours[f].records.nodes.size() * 3 / 4);
  }
}

TEST_F(midpoint_attached_file, is_of_its_own_mesh_alone) {
  const TetraMesh mesh = oracles::noise_mesh(9, Cut::in_five, 5);
  const Hierarchy hierarchy = test::midpoints_of(mesh, 100);
  const Forest forest(hierarchy);
  const auto reference = ReferenceMesh::of(forest, hierarchy.coincident_leaves, progress_);
  ASSERT_TRUE(reference) << reference.error().message;
  ASSERT_TRUE(reference->match(mesh));
  const auto refusal = [&](const auto& change) {
    TetraMesh other = mesh;
    change(other);
    const auto matched = reference->match(other);
    return matched ? "taken" : matched.error().message;
  };
  const auto expect = [](const std::string& said, const char* part) {
    EXPECT_NE(said.find(part), std::string::npos) << said;
  };
  expect(refusal([](TetraMesh& m) { m.positions[40][1] = std::nextafter(m.positions[40][1], 9); }),
         "expected the mesh that was built, with a vertex at");
  // Another zero is another place: nothing but the same bits is the mesh.
  expect(refusal([](TetraMesh& m) { m.positions[0][0] = -0.0; }), "with a vertex at 0, 0, 0, got");
  expect(refusal([](TetraMesh& m) { m.tetrahedra.pop_back(); }), "of 729 vertices and 2560 cells");
  expect(refusal([](TetraMesh& m) { m.tetrahedra[7] = m.tetrahedra[8]; }),
         "got one with a cell of vertices");
  expect(refusal([](TetraMesh& m) { std::swap(m.tetrahedra[7][0], m.tetrahedra[7][1]); }),
         "got one with a cell of vertices");
  expect(refusal([](TetraMesh& m) { std::swap(m.positions[40], m.positions[41]); }),
         "got one with a cell of vertices");
  expect(refusal([](TetraMesh& m) { m.tetrahedra[7][0] = 1'000'000; }), "corner");
  expect(refusal([](TetraMesh& m) { m.fields[0].values[3] = std::nan(""); }), "finite values");
}

/// Of noise of its own at each vertex all but every edge is between extrema.
TEST(midpoint_attachment, takes_what_lies_there_between_a_maximum_and_a_minimum) {
  TetraMesh mesh = oracles::noise_mesh(11, Cut::in_five, 5);
  const EdgeCollapses collapses = collapsed(mesh, 150);
  Random random(3);
  for (double& value : mesh.fields[0].values) value = random.uniform();
  Progress progress;
  const auto repeated = repeat_collapses(mesh, collapses.collapses, {}, {2}, progress);
  ASSERT_TRUE(repeated) << repeated.error().message;
  std::size_t n_own = 0;
  for (std::size_t k = 0; k < repeated->facts.size(); ++k) {
    const EdgeFacts& facts = repeated->facts[k];
    EXPECT_GE(facts.low, 0);
    EXPECT_LE(facts.high, 1);
    EXPECT_LE(facts.error, 1 + 1e-9);
    n_own += facts.value != collapses.collapses[k].position ? 1 : 0;
  }
  EXPECT_GT(n_own, repeated->facts.size() / 4);
  EXPECT_LT(n_own, repeated->facts.size());
}

TEST(midpoint_attachment, refuses_collapses_that_the_mesh_has_not_got) {
  const TetraMesh mesh = oracles::noise_mesh(7, Cut::in_five, 5);
  EdgeCollapses collapses = collapsed(mesh, 50);
  collapses.collapses[10].removed = collapses.collapses[0].removed;
  Progress progress;
  const auto repeated = repeat_collapses(mesh, collapses.collapses, {}, {2}, progress);
  ASSERT_FALSE(repeated);
  EXPECT_NE(repeated.error().message.find("collapse 10 of"), std::string::npos)
      << repeated.error().message;
  progress.cancel();
  EXPECT_FALSE(repeat_collapses(mesh, collapses.collapses, {}, {2}, progress));
}

/// Whose vertices lie where they do, but by codes from which the build would not make its nodes.
TEST_F(midpoint_attached_file, is_of_codes_in_the_mesh_s_own_steps) {
  const TetraMesh mesh = parted_noise(9);
  Hierarchy hierarchy = test::midpoints_of(with_field(mesh, 0), 100);
  std::array<Scale, 3> axes = hierarchy.scales.axes();
  axes[0] = Scale(axes[0].exponent(), axes[0].first() - 1);
  hierarchy.scales = Scales(axes);
  for (Code& code : hierarchy.root_codes) ++code[0];
  ASSERT_TRUE(save(hierarchy, model_, {2}, progress_));
  const auto made = attach(std::array{with_field(mesh, 1)}, {2});
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().message.find("steps of the mesh"), std::string::npos)
      << made.error().message;
  EXPECT_FALSE(std::filesystem::exists(output_));
}

TEST_F(midpoint_attached_file, is_refused_or_made_of_a_file_that_lies) {
  const TetraMesh mesh = parted_noise(9);
  ASSERT_TRUE(save(test::midpoints_of(with_field(mesh, 0), 100), model_, {2}, progress_));
  const std::string honest = folder_ / "honest.lode";
  std::filesystem::rename(model_, honest);
  Random random(4);
  int n_attached = 0;
  for (int trial = 0; trial < 300; ++trial) {
    test::rewrite(honest, model_, random);
    std::filesystem::remove(output_);
    const auto made = attach(std::array{with_field(mesh, 1)}, {2});
    EXPECT_EQ(std::filesystem::exists(output_), made.has_value());
    if (!made) {
      EXPECT_FALSE(made.error().message.empty());
      continue;
    }
    ++n_attached;
    const auto opened = open(output_);
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_EQ(opened->forest.head().fields.size(), 2U);
  }
  EXPECT_GT(n_attached, 0);
  EXPECT_LT(n_attached, 300);
}

}  // namespace
}  // namespace lode::tetra_mt::midpoint

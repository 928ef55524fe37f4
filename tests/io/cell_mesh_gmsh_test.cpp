#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lode/core/label.h"
#include "tests/io/cell_mesh_files.h"
#include "tests/io/tetra_checks.h"

namespace lode::io {
namespace {

using test::TempDir;

struct MshForm {
  std::string name;
  bool has_blocks = false;
  bool is_binary = false;
  ByteOrder order = ByteOrder::little;
};

/// Writes numbers of a .msh file as words, or in binary.
class MshWriter {
 public:
  explicit MshWriter(MshForm form) : form_(std::move(form)) {
    text = fmt::format("$MeshFormat\n{} {} 8\n", form_.has_blocks ? "4.1" : "2.2",
                       form_.is_binary ? 1 : 0);
    if (form_.is_binary) text += test::bytes_of<std::int32_t>({1}, form_.order) + "\n";
    text += "$EndMeshFormat\n";
  }
  void wholes(const std::vector<std::int32_t>& numbers) {
    for (const std::int32_t number : numbers) put(number);
  }
  void large(const std::vector<std::int64_t>& numbers) {
    for (const std::int64_t number : numbers)
      form_.has_blocks ? put(number) : put(static_cast<std::int32_t>(number));
  }
  void reals(const std::vector<double>& numbers) {
    for (const double number : numbers) put(number);
  }

  std::string text;

 private:
  template <typename T>
  void put(T number) {
    text +=
        form_.is_binary ? test::bytes_of<T>({number}, form_.order) : fmt::format("{}\n", number);
  }

  MshForm form_;
};

// Five nodes with tags far apart, a triangle in group 4 and tetrahedra in groups 9 and 8, the last
// one quadratic, and fields that leave some without a value.
constexpr std::array<std::int64_t, 10> kTags = {3, 1, 40, 500, 7, 11, 12, 13, 14, 15};
const std::vector<Vec3d> kPoints = {{{0, 0, 0}},   {{1, 0, 0}},   {{0, 1, 0}},  {{0, 0, 1}},
                                    {{.5, 0, 0}},  {{.5, .5, 0}}, {{0, .5, 0}}, {{0, 0, .5}},
                                    {{0, .5, .5}}, {{.5, 0, .5}}};

std::vector<std::int64_t> tags_at(const std::vector<std::size_t>& places) {
  std::vector<std::int64_t> tags;
  for (const std::size_t place : places) tags.push_back(kTags[place]);
  return tags;
}

struct MshElement {
  std::int32_t type;
  std::int32_t dimension;
  std::int32_t entity;
  std::int32_t group;
  std::int64_t tag;
  std::vector<std::size_t> nodes;
};

std::vector<MshElement> elements() {
  return {{2, 2, 1, 4, 21, {0, 1, 2}},
          {4, 3, 1, 9, 22, {0, 1, 2, 3}},
          {11, 3, 2, 8, 77, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}}};
}

void write_mesh_2(MshWriter& file, bool is_binary, const std::vector<MshElement>& all) {
  file.text += fmt::format("$Nodes\n{}\n", kPoints.size());
  for (std::size_t i = 0; i < kPoints.size(); ++i) {
    file.large({kTags[i]});
    file.reals({kPoints[i].v.begin(), kPoints[i].v.end()});
  }
  file.text += fmt::format("\n$EndNodes\n$Elements\n{}\n", all.size());
  for (const MshElement& e : all) {
    if (is_binary) file.wholes({e.type, 1, 2});
    file.large({e.tag});
    if (!is_binary) file.wholes({e.type, 2});
    file.wholes({e.group, e.entity});
    file.large(tags_at(e.nodes));
  }
  file.text += "\n$EndElements\n";
}

void write_mesh_4(MshWriter& file, const std::vector<MshElement>& all) {
  file.text += "$Entities\n";
  file.large({1, 0, 1, 2});
  file.wholes({5});
  file.reals({0, 0, 0});
  file.large({0});
  for (const auto& [tag, group] : {std::pair(1, 4), std::pair(1, 9), std::pair(2, 8)}) {
    file.wholes({tag});
    file.reals({0, 0, 0, 1, 1, 1});
    file.large({2});
    file.wholes({group, 99});
    file.large({1});
    file.wholes({-5});
  }
  file.text += "\n$EndEntities\n$Nodes\n";
  file.large({2, 10, 1, 500});
  file.wholes({2, 1, 1});
  file.large({3, kTags[0], kTags[1], kTags[2]});
  for (std::size_t i = 0; i < 3; ++i) {
    file.reals({kPoints[i].v.begin(), kPoints[i].v.end()});
    file.reals({0.25, 0.75});
  }
  file.wholes({3, 1, 0});
  file.large({7});
  file.large({kTags.begin() + 3, kTags.end()});
  for (std::size_t i = 3; i < 10; ++i) file.reals({kPoints[i].v.begin(), kPoints[i].v.end()});
  file.text += "\n$EndNodes\n$Elements\n";
  const auto n = static_cast<std::int64_t>(all.size());
  file.large({n, n, 21, 99});
  for (const MshElement& e : all) {
    file.wholes({e.dimension, e.entity, e.type});
    file.large({1, e.tag});
    file.large(tags_at(e.nodes));
  }
  file.text += "\n$EndElements\n";
}

std::string msh_of(const MshForm& form, const std::vector<MshElement>& all = elements()) {
  MshWriter file(form);
  file.text += "$PhysicalNames\n2\n2 4 \"its door\"\n3 9 \"a room\"\n$EndPhysicalNames\n";
  if (form.has_blocks)
    write_mesh_4(file, all);
  else
    write_mesh_2(file, form.is_binary, all);
  file.text += "$Comments\nwhatever $ stands here\n$EndComments\n";
  file.text += "$NodeData\n1\n\"a field\"\n1\n0.5\n3\n0\n1\n2\n";
  file.wholes({500});
  file.reals({2.5});
  file.wholes({3});
  file.reals({-1});
  file.text += "\n$EndNodeData\n$NodeData\n1\n\"a field\"\n1\n0.5\n3\n6\n3\n1\n";
  file.wholes({1});
  file.reals({1, 2, 3});
  file.text += "\n$EndNodeData\n$ElementData\n1\n\"e\"\n1\n0.5\n4\n0\n1\n1\n0\n";
  file.wholes({77});
  file.reals({8});
  file.text += "\n$EndElementData\n";
  return file.text;
}

std::vector<MshForm> msh_forms() {
  return {
      {"text_2"},       {"binary_2", false, true}, {"big_binary_2", false, true, ByteOrder::big},
      {"text_4", true}, {"binary_4", true, true},  {"big_binary_4", true, true, ByteOrder::big}};
}

class msh_meshes : public testing::TestWithParam<MshForm> {};

TEST_P(msh_meshes, are_read_with_groups_and_data) {
  const TempDir directory;
  const CellMesh mesh = test::read_mesh(directory.write("x.msh", msh_of(GetParam())));
  EXPECT_EQ(mesh.points, kPoints);
  EXPECT_EQ(mesh.patch_names, (std::vector<BoundaryPatch>{{4, "its door"}}));
  EXPECT_EQ(mesh.region_names, (std::vector<MeshRegion>{{9, "a room"}}));
  EXPECT_EQ(mesh.types, (std::vector<std::uint8_t>{5, 10, 24}));
  EXPECT_EQ(mesh.corners,
            (std::vector<std::uint32_t>{0, 1, 2, 0, 1, 2, 3, 0, 1, 2, 3, 4, 5, 6, 7, 9, 8}));
  ASSERT_EQ(mesh.cell_fields.size(), 2U);
  EXPECT_EQ(mesh.cell_fields[0].name, "RegionId");
  EXPECT_EQ(mesh.cell_fields[0].values, (std::vector<double>{4, 9, 8}));
  EXPECT_TRUE(std::isnan(mesh.cell_fields[1].at(0)));
  EXPECT_EQ(mesh.cell_fields[1].at(2), 8);
  ASSERT_EQ(mesh.point_fields.size(), 2U);
  EXPECT_EQ(mesh.point_fields[0].name, "a field");
  EXPECT_EQ(mesh.point_fields[1].name, "a field@6");
  EXPECT_EQ(mesh.point_fields[0].at(0), -1);
  EXPECT_EQ(mesh.point_fields[0].at(3), 2.5);
  EXPECT_TRUE(std::isnan(mesh.point_fields[0].at(1)));
  EXPECT_EQ(mesh.point_fields[1].at(1, 2), 3);
}

TEST_P(msh_meshes, of_quadratic_tetrahedra_are_split_right) {
  const TempDir directory;
  CellMesh mesh = test::read_mesh(directory.write("x.msh", msh_of(GetParam())));
  mesh.types[1] = static_cast<std::uint8_t>(CellType::quad);
  const TetrahedraOutcome outcome = test::tetrahedra_of(mesh);
  ASSERT_EQ(outcome.mesh.tetrahedra.size(), 8U);
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_NEAR(test::volume_of(outcome.mesh, i), 1.0 / 48, 1e-16);
  EXPECT_EQ(outcome.mesh.region_ids, (std::vector<std::int64_t>{8}));
}

TEST_P(msh_meshes, cut_or_changed_give_an_error_or_a_valid_mesh) {
  const TempDir directory;
  const std::string bytes = msh_of(GetParam());
  std::mt19937_64 random(3);
  for (int i = 0; i < 400; ++i) {
    const std::string changed =
        i < 100 ? bytes.substr(0, bytes.size() * static_cast<std::size_t>(i) / 100)
                : test::mutated(bytes, random);
    if (changed.empty()) continue;
    const Result<CellMesh> mesh = read_cell_mesh(directory.write("x.msh", changed), {});
    if (!mesh) continue;
    for (const std::uint32_t corner : mesh->corners) ASSERT_LT(corner, mesh->points.size());
  }
}

INSTANTIATE_TEST_SUITE_P(forms, msh_meshes, testing::ValuesIn(msh_forms()),
                         [](const auto& form) { return form.param.name; });

TEST_P(msh_meshes, of_types_that_are_not_known_are_refused) {
  const TempDir directory;
  std::vector<MshElement> all = elements();
  const auto add = [&](std::int32_t type, std::size_t n_nodes) {
    all.push_back({type, 3, 1, 9, static_cast<std::int64_t>(90 + all.size()),
                   std::vector<std::size_t>(n_nodes, 1)});
  };
  add(29, 20);
  add(92, 64);
  EXPECT_EQ(test::read_mesh(directory.write("x.msh", msh_of(GetParam(), all))).types,
            (std::vector<std::uint8_t>{5, 10, 24, 71, 72}));
  // How many nodes this one has is not known, so that nothing behind can be read.
  add(34, 5);
  add(29, 20);
  test::expect_mesh_failure(directory.write("x.msh", msh_of(GetParam(), all)),
                            {"118 or 119, got at least 1 of type 34"});
}

TEST(msh_mesh, that_is_wrong_is_refused_by_what_is_wrong) {
  const TempDir directory;
  const std::string good = msh_of({"text_2"});
  const auto refused = [&](const std::string& from, const std::string& to,
                           const std::vector<std::string>& parts) {
    std::string text = good;
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    test::expect_mesh_failure(directory.write("x.msh", text), parts);
  };
  refused("2.2 0", "3.0 0", {"2.2 or 4.1", "3.0"});
  refused("2.2 0 8", "2.2 0 4", {"8 bytes"});
  refused("\n500\n", "\n3\n", {"tag 3 twice"});
  refused("$Elements\n3\n", "$Elements\n9\n", {"an element's tag", "$EndElements"});
  refused("$Nodes\n10\n", "$Nodes\n99999999999\n", {"a node's tag", "$EndNodes"});
  refused("$Elements\n3\n", "$Elements\n2\n", {"expected $EndElements behind as many", "'77'"});
  refused("$Nodes\n10\n", "$Nodes\n4\n", {"$EndNodes behind as many", "'7'"});
  refused("0\n1\n2\n500\n", "0\n1\n1\n500\n", {"$EndNodeData behind as many", "'3'"});
  refused("22\n4\n", "22\n99\n", {"Gmsh's types", "got at least 1 of type 99"});
  refused("22\n4\n2\n9\n1\n3\n", "22\n4\n2\n9\n1\n6\n", {"element 22", "the tag 6"});
  refused("3\n6\n3\n1\n", "3\n6\n999999\n1\n", {"components"});
  refused("3\n6\n3\n1\n", "3\n6\n3\n999999\n", {"999999 values"});
  refused("$EndElements", "$EndElement", {"$EndElements"});
}

/// Two tetrahedra of the groups `a` and `b`, as version 2.2, with what a file begins and ends with.
std::string two_groups(const std::string& names, int a, int b, const std::string& rest = "") {
  return fmt::format(
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n{}$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
      "5 0 0 -1\n$EndNodes\n$Elements\n2\n1 4 2 {} 1 1 2 3 4\n2 4 2 {} 2 1 3 2 5\n$EndElements\n{}",
      names, a, b, rest);
}

std::string names_section(const std::string& n, const std::string& rows) {
  return "$PhysicalNames\n" + n + "\n" + rows + "$EndPhysicalNames\n";
}

TetraMesh msh_mesh_of(const std::string& text) {
  const TempDir directory;
  return test::tetrahedra_of(test::read_mesh(directory.write("x.msh", text))).mesh;
}

TEST(msh_mesh, gives_regions_the_names_of_their_groups) {
  const TetraMesh mesh = msh_mesh_of(two_groups(
      names_section("4", "3 8 \"rotor blade\"\n2 7 \"door\"\n3 9 \"of no cell\"\n1 8 \"x\"\n"), 8,
      7));
  EXPECT_EQ(mesh.region_ids, (std::vector<std::int64_t>{7, 8}));
  EXPECT_EQ(mesh.region_names, (std::vector<std::string>{"", "rotor blade"}));
  EXPECT_TRUE(msh_mesh_of(two_groups("", 8, 7)).region_names.empty());
  EXPECT_TRUE(msh_mesh_of(two_groups(names_section("0", ""), 8, 7)).region_names.empty());
  // One region alone.
  EXPECT_EQ(msh_mesh_of(two_groups(names_section("1", "3 7 \"all\"\n"), 7, 7)).region_names,
            (std::vector<std::string>{"all"}));
}

TEST(msh_mesh, has_odd_names_as_labels) {
  // Of two names the first; "region 8" is what Lode writes for none; no quotes, and what is no
  // text.
  const TetraMesh mesh = msh_mesh_of(two_groups(
      names_section("5",
                    "3 -3 \"a \x01\xFF\"\n3 -3 \"later\"\n3 8 \"region 8\"\n3 8 \"\"\n3 8 bare\n"),
      -3, 8));
  EXPECT_EQ(mesh.region_names, (std::vector<std::string>{"a  ?", "bare"}));
  const TetraMesh wide = msh_mesh_of(
      two_groups(names_section("1", "3 8 \"" + std::string(100'000, 'n') + "\"\n"), 7, 8));
  EXPECT_EQ(wide.region_names[1].size(), kMaxLabelBytes);
  // There are fewer names than it says.
  const TempDir directory;
  for (const char* const n : {"2147483648", "4294967295", "2"})
    test::expect_mesh_failure(
        directory.write("x.msh", two_groups(names_section(n, "3 8 \"rotor\"\n"), 7, 8)),
        {"a group's dimension"});
  test::expect_mesh_failure(directory.write("x.msh", two_groups(names_section("-1", ""), 7, 8)),
                            {"a number of names >= 0", "-1"});
}

TEST(msh_mesh, whose_numbers_of_regions_are_data_keeps_the_names_of_groups) {
  const auto with_ids = [](const char* a, const char* b) {
    return msh_mesh_of(two_groups(
        names_section("2", "3 1 \"rotor\"\n3 2 \"air\"\n"), 1, 2,
        fmt::format(
            "$ElementData\n1\n\"RegionId\"\n1\n0\n3\n0\n1\n2\n1 {}\n2 {}\n$EndElementData\n", a,
            b)));
  };
  const TetraMesh mesh = with_ids("0", "-4");
  EXPECT_EQ(mesh.region_ids, (std::vector<std::int64_t>{-4, 0}));
  EXPECT_EQ(mesh.region_names, (std::vector<std::string>{"air", "rotor"}));
  // No whole numbers that doubles tell apart: groups it is.
  EXPECT_EQ(with_ids("0.5", "1").region_ids, (std::vector<std::int64_t>{1, 2}));
  EXPECT_EQ(with_ids("1e300", "1").region_names, (std::vector<std::string>{"rotor", "air"}));
  // A group of several regions is none's name.
  const TempDir directory;
  const TetrahedraOutcome outcome = test::tetrahedra_of(test::read_mesh(directory.write(
      "x.msh", two_groups(names_section("1", "3 5 \"both\"\n"), 5, 5,
                          "$ElementData\n1\n\"RegionId\"\n1\n0\n3\n0\n1\n2\n1 6\n2 7\n"
                          "$EndElementData\n"))));
  EXPECT_EQ(outcome.mesh.region_ids, (std::vector<std::int64_t>{6, 7}));
  EXPECT_TRUE(outcome.mesh.region_names.empty());
  EXPECT_EQ(outcome.report.skipped_arrays,
            (std::vector<std::string>{"the name 'both' of several regions"}));
}

TEST(msh_mesh, has_groups_as_regions_where_regionid_is_a_vector) {
  const TetraMesh mesh =
      msh_mesh_of(two_groups(names_section("2", "3 1 \"rotor\"\n3 2 \"air\"\n"), 1, 2,
                             "$ElementData\n1\n\"RegionId\"\n1\n0\n3\n0\n3\n2\n1 7 8 9\n2 4 5 6\n"
                             "$EndElementData\n"));
  EXPECT_EQ(mesh.region_ids, (std::vector<std::int64_t>{1, 2}));
  EXPECT_EQ(mesh.region_names, (std::vector<std::string>{"rotor", "air"}));
}

/// A section of values, of `tags` what follows.
void add_section(const std::string& section, const std::string& name, double time, int step,
                 const std::vector<std::int32_t>& tags, const std::vector<double>& values,
                 MshWriter& file) {
  file.text += fmt::format("\n${}\n1\n\"{}\"\n1\n{}\n3\n{}\n1\n{}\n", section, name, time, step,
                           tags.size());
  for (std::size_t i = 0; i < tags.size(); ++i) {
    file.wholes({tags[i]});
    file.reals({values[i]});
  }
  file.text += fmt::format("\n$End{}\n", section);
}

/// heat has three steps, not in order; load, of elements, the first two of these; still none.
std::string series_of(const MshForm& form) {
  MshWriter file(form);
  if (form.has_blocks)
    write_mesh_4(file, elements());
  else
    write_mesh_2(file, form.is_binary, elements());
  add_section("NodeData", "still", 7, 3, {3}, {-5}, file);
  add_section("NodeData", "heat", 0.25, 1, {3, 500}, {11, 12}, file);
  add_section("NodeData", "heat", 1.5, 2, {3, 500}, {21, 22}, file);
  add_section("ElementData", "load", 0, 0, {77}, {100}, file);
  add_section("NodeData", "heat", 0, 0, {3, 500}, {1, 2}, file);
  add_section("ElementData", "load", 0.25, 1, {77}, {101}, file);
  return file.text;
}

TEST_P(msh_meshes, with_steps_are_read_one_at_a_time) {
  const TempDir directory;
  const std::string path = directory.write("x.msh", series_of(GetParam()));
  const std::vector<double> times{0, 0.25, 1.5};
  for (const std::size_t step : {0U, 1U, 2U}) {
    const auto mesh = read_cell_mesh(path, {.step = step});
    ASSERT_TRUE(mesh) << mesh.error().message;
    EXPECT_EQ(mesh->times, times);
    EXPECT_EQ(mesh->step, step);
    EXPECT_EQ(mesh->time, times[step]);
    ASSERT_EQ(mesh->point_fields.size(), 2U);
    EXPECT_EQ(mesh->point_fields[0].name, "still");
    EXPECT_EQ(mesh->point_fields[0].at(0), -5);
    EXPECT_EQ(mesh->point_fields[1].name, "heat");
    EXPECT_EQ(mesh->point_fields[1].at(0), 10 * static_cast<double>(step) + 1);
    EXPECT_EQ(mesh->point_fields[1].at(3), 10 * static_cast<double>(step) + 2);
    ASSERT_EQ(mesh->cell_fields.size(), step < 2 ? 2U : 1U);  // RegionId, too
    if (step < 2) {
      EXPECT_EQ(mesh->cell_fields[1].at(2), 100 + static_cast<double>(step));
      EXPECT_TRUE(mesh->skipped_arrays.empty());
    } else {
      EXPECT_EQ(mesh->skipped_arrays,
                (std::vector<std::string>{"load (at other times than 1.5: --time chooses one)"}));
    }
  }
  EXPECT_EQ(test::read_mesh(path).step, 2U);
  const auto beyond = read_cell_mesh(path, {.step = 3});
  ASSERT_FALSE(beyond);
  EXPECT_NE(beyond.error().message.find("expected a step from 0 to 2, got 3"), std::string::npos);
}

TEST(msh_mesh, without_a_series_has_the_time_of_its_data) {
  const auto data = [](const char* name, const char* time, int step, const char* value = "1 5") {
    return fmt::format("$NodeData\n1\n\"{}\"\n1\n{}\n3\n{}\n1\n1\n{}\n$EndNodeData\n", name, time,
                       step, value);
  };
  const TempDir directory;
  const auto read = [&](const std::string& sections) {
    return read_cell_mesh(directory.write("x.msh", two_groups("", 1, 1, sections)), {.step = 9});
  };
  const auto alone = read(data("a", "0.5", 3) + data("b", "0.5", 4));
  ASSERT_TRUE(alone);
  EXPECT_EQ(alone->time, 0.5);
  EXPECT_TRUE(alone->times.empty());
  // Of several times none; at one step twice there are two fields; and -1 comes before 0.
  EXPECT_EQ(read(data("a", "0.5", 0) + data("b", "1.5", 0))->time, std::nullopt);
  EXPECT_EQ(read("")->time, std::nullopt);
  const auto twice = read(data("a", "0.5", 3) + data("a", "0.5", 3) + data("a", "0.5", 3));
  ASSERT_EQ(twice->point_fields.size(), 3U);
  EXPECT_EQ(twice->point_fields[1].name, "a@3");
  EXPECT_EQ(twice->point_fields[2].name, "a@3@3");
  const auto negative = read_cell_mesh(
      directory.write("x.msh", two_groups("", 1, 1, data("a", "0", 1) + data("a", "-1", -7))), {});
  EXPECT_EQ(negative->times, (std::vector<double>{-1, 0}));
  for (const char* const time : {"nan", "inf", "x"}) {
    const auto wrong = read(data("a", time, 0));
    ASSERT_FALSE(wrong) << time;
    EXPECT_NE(wrong.error().message.find("x.msh"), std::string::npos);
  }
}

TEST(msh_mesh, with_a_field_of_one_name_and_step_too_often_is_refused) {
  const std::string section = "$NodeData\n1\n\"a\"\n1\n0\n3\n5\n1\n0\n$EndNodeData\n";
  const TempDir directory;
  const auto read = [&](int n_sections) {
    std::string sections;
    for (int i = 0; i < n_sections; ++i) sections += section;
    return read_cell_mesh(directory.write("x.msh", two_groups("", 1, 1, sections)), {});
  };
  const auto most = read(64);
  ASSERT_TRUE(most) << most.error().message;
  EXPECT_EQ(most->point_fields.size(), 64U);
  // Their names together would be longer than a gigabyte.
  for (const int n : {65, 30000}) {
    const auto more = read(n);
    ASSERT_FALSE(more);
    EXPECT_NE(more.error().message.find("expected at most 64 fields of the name 'a' at step 5"),
              std::string::npos)
        << more.error().message;
  }
}

std::string medit_of(const std::string& rest) {
  return "MeshVersionFormatted 2 # a comment\nDimension\n3\nVertices\n5\n0 0 0 1\n1 0 0 1\n"
         "0 1 0 2 # Tetrahedra 5\n0 0 1 2\n0 0 -3 0\n" +
         rest;
}

TEST(medit_mesh, is_read_with_references_as_regions) {
  const TempDir directory;
  const CellMesh mesh = test::read_mesh(directory.write(
      "x.mesh", medit_of("Triangles\n1\n1 2 3 5\nTetrahedra\n2\n1 2 3 4 7\n1 3 2 5 -1\n"
                         "RequiredVertices 1\n1\nEnd\n")));
  EXPECT_EQ(mesh.points[4], (Vec3d{{0, 0, -3}}));
  EXPECT_EQ(mesh.types, (std::vector<std::uint8_t>{5, 10, 10}));
  EXPECT_EQ(mesh.corners, (std::vector<std::uint32_t>{0, 1, 2, 0, 1, 2, 3, 0, 2, 1, 4}));
  const TetrahedraOutcome outcome = test::tetrahedra_of(mesh);
  EXPECT_EQ(outcome.mesh.region_ids, (std::vector<std::int64_t>{-1, 7}));
  EXPECT_EQ(outcome.mesh.regions, (std::vector<std::uint32_t>{1, 0}));
  EXPECT_TRUE(outcome.mesh.fields.empty());
}

TEST(medit_mesh, that_is_wrong_is_refused) {
  const TempDir directory;
  const auto refused = [&](const std::string& rest, const std::vector<std::string>& parts) {
    test::expect_mesh_failure(directory.write("x.mesh", medit_of(rest)), parts);
  };
  refused("Tetrahedra\n1\n1 2 3 6 7\n", {"corners below 5", "got 5 in cell 0"});
  refused("Tetrahedra\n1\n0 2 3 4 7\n", {"a vertex from 1"});
  refused("Tetrahedra\n2\n1 2 3 4 7\n", {"a vertex"});
  refused("Tetrahedra\n1\n1 2 3 4 7\n1 3 2 5 -1\n",
          {"line 14", "a keyword behind as many tetrahedra as the file says, got '1'"});
  refused("Tetrahedra\n99999999999\n", {"a number of cells"});
  refused("Dimension 2\n", {"3 dimensions"});
  refused("Vertices\n1\n0 0 nan 0\nTetrahedra\n1\n1 2 3 6 7\n", {"finite", "for point 5"});
}

}  // namespace
}  // namespace lode::io

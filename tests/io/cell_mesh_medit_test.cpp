// MEDIT's binary meshes, and solutions in files of their own.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <random>

#include "tests/io/cell_mesh_files.h"
#include "tests/io/tetra_checks.h"

namespace lode::io {
namespace {

using test::TempDir;

const std::vector<Vec3d> kCorners{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}, {{0, 0, -3}}};

std::string mesh_text() {
  return "MeshVersionFormatted 2\nDimension 3\nVertices\n5\n0 0 0 1\n1 0 0 1\n0 1 0 2\n0 0 1 2\n"
         "0 0 -3 0\nTetrahedra\n2\n1 2 3 4 7\n1 3 2 5 -1\nEnd\n";
}

/// Numbers as libMeshb writes them, by version and byte order.
class MeditBytes {
 public:
  MeditBytes(int version, bool is_big) : version_(version), is_big_(is_big) {
    put<std::int32_t>(1);
    put<std::int32_t>(version);
  }
  /// Ends the keyword before.
  void keyword(std::int32_t code) {
    end();
    put(code);
    next_ = bytes_.size();
    if (version_ < 3)
      put<std::int32_t>(0);
    else
      put<std::int64_t>(0);
  }
  void small(std::int64_t number) { put(static_cast<std::int32_t>(number)); }
  void whole(std::int64_t number) {
    if (version_ < 4)
      small(number);
    else
      put(number);
  }
  void real(double number) {
    if (version_ == 1)
      put(static_cast<float>(number));
    else
      put(number);
  }
  [[nodiscard]] std::string take() {
    keyword(54);
    return bytes_;
  }

 private:
  template <typename T>
  void put(T number) {
    std::array<char, sizeof(T)> raw = std::bit_cast<std::array<char, sizeof(T)>>(number);
    if (is_big_) std::reverse(raw.begin(), raw.end());
    bytes_.append(raw.data(), raw.size());
  }
  void end() {
    if (next_ == 0) return;
    MeditBytes here = *this;
    here.bytes_.clear();
    if (version_ < 3)
      here.put(static_cast<std::int32_t>(bytes_.size()));
    else
      here.put(static_cast<std::int64_t>(bytes_.size()));
    bytes_.replace(next_, here.bytes_.size(), here.bytes_);
  }

  int version_;
  bool is_big_;
  std::string bytes_;
  std::size_t next_ = 0;
};

struct MeditForm {
  int version = 2;
  bool is_big = false;
};

std::string mesh_bytes(const MeditForm& form) {
  MeditBytes file(form.version, form.is_big);
  file.keyword(3);
  file.small(3);
  file.keyword(4);
  file.whole(5);
  for (const Vec3d& p : kCorners) {
    for (const double x : p.v) file.real(x);
    file.whole(2);
  }
  file.keyword(20);  // normals, or what not
  file.whole(1);
  file.real(5);
  file.keyword(8);
  file.whole(2);
  for (const std::int64_t number : {1, 2, 3, 4, 7, 1, 3, 2, 5, -1}) file.whole(number);
  return file.take();
}

/// A scalar, a vector, a symmetric tensor and a full one at each of five vertices.
double stored(std::size_t vertex, std::size_t i) {
  return static_cast<double>(vertex) + 0.125 * static_cast<double>(i);
}

std::string solution_bytes(const MeditForm& form) {
  MeditBytes file(form.version, form.is_big);
  file.keyword(3);
  file.small(3);
  file.keyword(66);  // of tetrahedra
  file.whole(2);
  file.small(1);
  file.small(1);
  file.real(1);
  file.real(1);
  file.keyword(62);
  file.whole(5);
  for (const std::int64_t number : {4, 1, 2, 3, 4}) file.small(number);
  for (std::size_t v = 0; v < 5; ++v)
    for (std::size_t i = 0; i < 19; ++i) file.real(stored(v, i));
  return file.take();
}

std::string solution_text() {
  std::string text =
      "MeshVersionFormatted 2\n\nDimension\n3\nSolAtTetrahedra\n2\n1 1\n1\n1\nSolAtVertices # "
      "all\n5\n"
      "4 1 2 3 4\n";
  for (std::size_t v = 0; v < 5; ++v) {
    for (std::size_t i = 0; i < 19; ++i) text += fmt::format("{} ", stored(v, i));
    text += '\n';
  }
  return text + "End\n";
}

void expect_solution(const CellMesh& mesh) {
  ASSERT_EQ(mesh.point_fields.size(), 4U);
  const std::vector<int> n_components{1, 3, 9, 9};
  for (std::size_t f = 0; f < 4; ++f) {
    EXPECT_EQ(mesh.point_fields[f].name, fmt::format("solution_{}", f + 1));
    EXPECT_EQ(mesh.point_fields[f].n_components, n_components[f]);
  }
  // xx, xy, yy, xz, yz, zz are stored of a symmetric one, from the fifth number on.
  const std::vector<std::size_t> symmetric{4, 5, 7, 5, 6, 8, 7, 8, 9};
  for (std::size_t v = 0; v < 5; ++v) {
    EXPECT_EQ(mesh.point_fields[0].at(v), stored(v, 0));
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(mesh.point_fields[1].at(v, k), stored(v, 1 + static_cast<std::size_t>(k)));
    for (int k = 0; k < 9; ++k) {
      EXPECT_EQ(mesh.point_fields[2].at(v, k), stored(v, symmetric[static_cast<std::size_t>(k)]));
      EXPECT_EQ(mesh.point_fields[3].at(v, k), stored(v, 10 + static_cast<std::size_t>(k)));
    }
  }
  ASSERT_EQ(mesh.skipped_arrays.size(), 1U);
  EXPECT_TRUE(mesh.skipped_arrays[0].starts_with("solution at tetrahedra ("));
}

TEST(medit_binary, meshes_and_solutions_are_those_of_text) {
  for (int version = 1; version <= 4; ++version)
    for (const bool is_big : {false, true}) {
      const TempDir directory;
      const MeditForm form{version, is_big};
      const CellMesh text = test::read_mesh(directory.write("a.mesh", mesh_text()));
      const std::string path = directory.write("b.meshb", mesh_bytes(form));
      const CellMesh bare = test::read_mesh(path);
      EXPECT_EQ(bare.points, text.points);
      EXPECT_EQ(bare.types, text.types);
      EXPECT_EQ(bare.corners, text.corners);
      ASSERT_EQ(bare.cell_fields.size(), 1U);
      EXPECT_EQ(bare.cell_fields[0].values, text.cell_fields[0].values);
      EXPECT_TRUE(bare.point_fields.empty());
      directory.write("b.solb", solution_bytes(form));
      expect_solution(test::read_mesh(path));
    }
}

TEST(medit_mesh, of_higher_order_is_refused_or_faces_left_out_by_name) {
  const TempDir directory;
  const auto with = [&](const std::string& section) {
    std::string text = mesh_text();
    return directory.write("a.mesh", text.insert(text.find("End"), section));
  };
  test::expect_mesh_failure(with("TetrahedraP2\n1\n1 2 3 4 1 2 3 4 1 2 0\n"),
                            {"expected cells of the first order, got 1 of tetrahedrap2"});
  test::expect_mesh_failure(with("HexahedraQ2\n3\n"), {"got 3 of hexahedraq2"});
  const CellMesh mesh = test::read_mesh(with("TrianglesP2\n1\n1 2 3 1 2 3 0\nPrismsP2\n0\n"));
  EXPECT_EQ(mesh.n_cells(), 2U);
  EXPECT_EQ(mesh.skipped_arrays, std::vector<std::string>{"1 trianglesp2"});
}

TEST(medit_solution, beside_a_mesh_gives_its_fields) {
  const TempDir directory;
  const std::string path = directory.write("a.mesh", mesh_text());
  EXPECT_TRUE(test::read_mesh(path).point_fields.empty());
  directory.write("a.solb", solution_bytes({}));
  expect_solution(test::read_mesh(path));
  directory.write("a.sol", solution_text());
  expect_solution(test::read_mesh(path));
  // One alone has no number; and one elsewhere, where it is asked for.
  const std::string other = directory.write(
      "steps.sol",
      "MeshVersionFormatted 1 Dimension 3 SolAtVertices 5 1 2 3 4 0 0 0 1 1 2 2 1 0 0 0 5 1e3");
  const auto mesh = read_cell_mesh(path, {.solution = other});
  ASSERT_TRUE(mesh) << mesh.error().message;
  ASSERT_EQ(mesh->point_fields.size(), 1U);
  EXPECT_EQ(mesh->point_fields[0].name, "solution");
  const TetrahedraOutcome outcome =
      test::tetrahedra_of(*mesh, {.fields = {"solution", "solution:1"}});
  EXPECT_EQ(outcome.mesh.fields[0].values, (std::vector<double>{5, 1, 3, 1, std::hypot(5, 1e3)}));
  EXPECT_EQ(outcome.mesh.fields[1].values, (std::vector<double>{4, 0, 2, 0, 5}));
}

TEST(medit_solution, of_a_symmetric_tensor_has_its_norm) {
  const TempDir directory;
  const std::string path = directory.write("a.mesh", mesh_text());
  directory.write("a.sol", "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n5\n1 3\n" +
                               std::string("1 2 3 4 5 6\n") +
                               "0 0 0 0 0 0\n0 0 0 0 0 0\n"
                               "0 0 0 0 0 0\n0 0 0 0 0 0\nEnd\n");
  const TetrahedraOutcome outcome = test::tetrahedra_of(test::read_mesh(path));
  // Those off the diagonal twice.
  EXPECT_NEAR(outcome.mesh.fields[0].values[0], std::sqrt(1 + 9 + 36 + 2 * (4 + 16 + 25.)), 1e-12);
}

TEST(medit_solution, without_values_at_vertices_is_refused_only_where_it_is_named) {
  const std::string head = "MeshVersionFormatted 2\nDimension 3\n";
  for (const std::string cells : {"", "SolAtTetrahedra\n2\n1 1\n5\n6\n"}) {
    const TempDir directory;
    const std::string path = directory.write("a.mesh", mesh_text());
    const std::string solution = directory.write("a.sol", head + cells + "End\n");
    const CellMesh mesh = test::read_mesh(path);
    EXPECT_EQ(mesh.points, kCorners);
    EXPECT_TRUE(mesh.point_fields.empty());
    EXPECT_EQ(mesh.skipped_arrays,
              cells.empty() ? std::vector<std::string>{}
                            : std::vector<std::string>{"solution at tetrahedra (a.sol)"});
    const auto named = read_cell_mesh(path, {.solution = solution});
    ASSERT_FALSE(named);
    for (const char* const part : {"a.sol: expected SolAtVertices", "5 vertices", "got none"})
      EXPECT_NE(named.error().message.find(part), std::string::npos) << named.error().message;
  }
}

TEST(medit_solution, that_is_wrong_is_refused_by_file_and_line) {
  const TempDir directory;
  const std::string path = directory.write("a.mesh", mesh_text());
  const std::string head = "MeshVersionFormatted 2\nDimension 3\n";
  const auto refused = [&](const std::string& text, const std::vector<std::string>& parts) {
    directory.write("a.sol", text);
    const Result<CellMesh> mesh = read_cell_mesh(path, {});
    ASSERT_FALSE(mesh) << text;
    for (const std::string& part : parts)
      EXPECT_NE(mesh.error().message.find(part), std::string::npos)
          << mesh.error().message << " lacks " << part;
  };
  refused(head + "SolAtVertices\n4\n1 1\n1\n2\n3\n4\n",
          {"a.sol: line 4: expected values at the 5 vertices of", "a.mesh", "got 4"});
  refused(head + "SolAtVertices\n2147483648\n1 1\n", {"a.sol: line 4", "got 2147483648"});
  refused(head + "SolAtVertices\n-1\n", {"a.sol: line 4", "a number of vertices from 0", "'-1'"});
  refused(head + "SolAtVertices\n5\n0\n", {"a.sol: line 5", "a number of solutions from 1", "'0'"});
  refused(head + "SolAtVertices\n5\n4294967296 1\n", {"a.sol: line 5", "a number of solutions"});
  refused(head + "SolAtVertices\n5\n1 5\n", {"a.sol: line 5", "2 for a vector", "'5'"});
  refused(head + "SolAtVertices\n5\n4000 1\n", {"a.sol: line 6", "1 for a scalar", "''"});
  refused(head + "SolAtVertices\n5\n2 4 4\n1 2 3\n", {"a.sol", "18 values at 5 vertices"});
  refused(head + "SolAtVertices\n5\n1 1\n1\n2\nx\n4\n5\nEnd\n",
          {"a.sol: line 8: expected a value, got 'x'"});
  refused(head + "SolAtVertices\n5\n1 1\n1\n2\n3\n4\n5\n6\nEnd\n",
          {"a.sol: line 11", "a keyword behind as many values as the file says, got '6'"});
  refused(head + "SolAtVertices\n5\n1 1\n1\n2\n3\n4\nEnd\n",
          {"a.sol: line 10", "a value", "'End'"});
  refused(head + "SolAtVertices\n5\n1 1\n1 2 3 4 5\nSolAtVertices\n5\n1 1\n1 2 3 4 5\n",
          {"a.sol: line 7", "SolAtVertices once"});
  refused("MeshVersionFormatted 2\nDimension\n2\n", {"a.sol: line 3", "3 dimensions, got 2"});
  refused("", {"a.sol", "empty"});
  refused("solid", {"a.sol: expected MeshVersionFormatted", "'solid'"});
  // Of another form of mesh there is none to be told.
  const auto other =
      read_cell_mesh(directory.write("x.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"),
                     {.solution = directory.write("x.sol", solution_text())});
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message.find("x.msh: expected a MEDIT mesh with the solution"),
            std::string::npos);
}

TEST(medit_binary, files_cut_or_changed_give_an_error_or_a_valid_mesh) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 600; ++i) {
    const TempDir directory;
    const MeditForm form{1 + i % 4, i % 8 >= 4};
    std::string mesh = mesh_bytes(form);
    std::string solution = solution_bytes(form);
    std::string& changed = i % 2 == 0 ? mesh : solution;
    changed = i < 100 ? changed.substr(0, changed.size() * static_cast<std::size_t>(i) / 100)
                      : test::mutated(changed, random);
    directory.write("x.solb", solution);
    const Result<CellMesh> read = read_cell_mesh(directory.write("x.meshb", mesh), {});
    if (!read) continue;
    for (const std::uint32_t corner : read->corners) ASSERT_LT(corner, read->points.size());
    for (const MeshField& field : read->point_fields)
      ASSERT_EQ(field.values.size(),
                read->points.size() * static_cast<std::size_t>(field.n_components));
  }
}

TEST(medit_binary, files_whose_keywords_go_in_a_circle_are_refused) {
  const TempDir directory;
  std::string bytes = mesh_bytes({.version = 2});
  const std::int32_t back = 8;
  std::memcpy(bytes.data() + 12, &back, 4);  // of the first keyword, to itself
  test::expect_mesh_failure(directory.write("x.meshb", bytes), {"behind byte 8, got 8"});
  const std::int32_t far = 1 << 30;
  std::memcpy(bytes.data() + 12, &far, 4);
  test::expect_mesh_failure(directory.write("x.meshb", bytes), {"1073741824"});
  bytes = mesh_bytes({.version = 2});
  bytes[4] = 5;
  test::expect_mesh_failure(directory.write("x.meshb", bytes), {"version 1 to 4, got 5"});
}

TEST(medit_binary, files_whose_data_reach_into_the_next_keyword_are_refused) {
  const TempDir directory;
  std::string bytes = mesh_bytes({.version = 1});
  ASSERT_EQ(bytes[28], 5);  // vertices, of 16 bytes each from byte 32 on
  bytes[28] = 6;
  test::expect_mesh_failure(directory.write("x.meshb", bytes),
                            {"at byte 112, got some to byte 128"});
}

TEST(medit_binary, files_that_have_more_than_they_count_are_refused) {
  const TempDir directory;
  std::string bytes = mesh_bytes({.version = 1});
  ASSERT_EQ(bytes[28], 5);
  bytes[28] = 4;
  test::expect_mesh_failure(directory.write("x.meshb", bytes),
                            {"at byte 96, behind as many vertices", "got byte 112"});
}

TEST(medit_binary, keywords_that_share_their_data_do_not_take_more_memory_than_the_file) {
  constexpr std::int32_t kVerticesCode = 4;
  constexpr std::int32_t kHead = 12;
  constexpr std::int32_t kVertex = 16;
  constexpr std::int32_t kSize = 1 << 20;
  std::vector<std::int32_t> words{1, 1};
  // Of as many vertices as the rest of the file has room for, at every 12 bytes.
  for (std::int32_t at = 8; at + kHead < kSize; at += kHead)
    for (const std::int32_t word : {kVerticesCode, at + kHead, (kSize - at - kHead) / kVertex})
      words.push_back(word);
  words.resize(kSize / 4);
  const TempDir directory;
  test::expect_mesh_failure(directory.write("x.meshb", test::bytes_of(words)),
                            {"expected data that end before the next keyword"});
}

}  // namespace
}  // namespace lode::io

#include <gtest/gtest.h>

#include <cstring>

#include "tests/io/surface_fixtures.h"

namespace lode::io {
namespace {

std::uint32_t word_at(const std::string& bytes, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof(word));
  return word;
}

std::string written_bytes(const Surface& surface, const SurfaceWriteOptions& options = {}) {
  const std::string path = temporary_path("bytes.glb");
  expect_written(path, surface, options);
  return bytes_of(path);
}

/// A container of one JSON chunk and `n_data` zero bytes.
std::string make_glb(std::string json, std::size_t n_data) {
  while (json.size() % 4 != 0) json += ' ';
  const auto word = [](std::size_t value) {
    const auto narrow = static_cast<std::uint32_t>(value);
    std::string bytes(4, '\0');
    std::memcpy(bytes.data(), &narrow, 4);
    return bytes;
  };
  return "glTF" + word(2) + word(28 + json.size() + n_data) + word(json.size()) + "JSON" + json +
         word(n_data) + std::string("BIN\0", 4) + std::string(n_data, '\0');
}

std::string one_mesh(std::string_view view, std::string_view accessor) {
  return fmt::format(
      R"({{"nodes":[{{"matrix":[1,0,0,0,0,0,-1,0,0,1,0,0,0,0,0,1],"children":[1]}},)"
      R"({{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},)"
      R"("mode":0}}]}}],"bufferViews":[{{"buffer":0,{}}}],"accessors":[{{"bufferView":0,)"
      R"("componentType":5126,"type":"VEC3",{}}}]}})",
      view, accessor);
}

TEST(glb_file, is_made_of_two_chunks_of_whole_words) {
  const std::string bytes = written_bytes(make_torus(5), {.comment = "odd"});
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(word_at(bytes, 4), 2U);
  EXPECT_EQ(word_at(bytes, 8), bytes.size());
  const std::uint32_t json_size = word_at(bytes, 12);
  EXPECT_EQ(json_size % 4, 0U);
  const std::uint32_t bin_size = word_at(bytes, 20 + json_size);
  EXPECT_EQ(bin_size, 25U * 28 + 50 * 12);
  EXPECT_EQ(28 + json_size + bin_size, bytes.size());
}

TEST(glb_file, has_no_mesh_when_the_surface_is_empty) {
  const std::string bytes = written_bytes({});
  EXPECT_EQ(bytes.size(), 20 + word_at(bytes, 12));
  EXPECT_EQ(bytes.find("accessors"), std::string::npos);
  EXPECT_EQ(bytes.find("mesh"), std::string::npos);
}

TEST(glb_file, states_the_bounds_and_puts_the_origin_into_the_node) {
  Surface surface;
  surface.origin = {{1e6, 0.1, 0}};
  surface.positions = {{{0, 0, 0}}, {{0.5F, 0, -2}}, {{0, 1, 0}}};
  surface.triangles = {{0, 1, 2}};
  const std::string bytes = written_bytes(surface);
  EXPECT_NE(bytes.find(R"("max":[0.5,1.0,0.0])"), std::string::npos);
  EXPECT_NE(bytes.find(R"("min":[0.0,0.0,-2.0])"), std::string::npos);
  EXPECT_NE(bytes.find(R"("translation":[1000000.0,0.1,0.0])"), std::string::npos);
}

/// Renderers add to positions in floats: they should be small where that loses nothing.
TEST(glb_file, counts_positions_that_lie_far_away_from_one_of_them) {
  Surface surface;
  surface.positions = {
      {{557820, 5108010, 1611}}, {{557850, 5108010, 1620}}, {{557820, 5108040, 9}}};
  surface.triangles = {{0, 1, 2}};
  const std::string bytes = written_bytes(surface);
  EXPECT_NE(bytes.find(R"("max":[30.0,30.0,9.0])"), std::string::npos) << bytes;
  EXPECT_NE(bytes.find(R"("translation":[557820.0,5108010.0,1611.0])"), std::string::npos);
  const auto read = read_bytes(".glb", bytes);
  ASSERT_TRUE(read);
  for (std::uint32_t v = 0; v < 3; ++v)
    EXPECT_EQ(read->world_position(v), surface.world_position(v));
  // What rounding may be of them is that of where they lie.
  EXPECT_EQ(read->positions, surface.positions);
  EXPECT_EQ(read->origin, surface.origin);
  surface.origin = {{1e9, 0.1, -7}};
  const auto moved = read_bytes(".glb", written_bytes(surface));
  ASSERT_TRUE(moved);
  EXPECT_EQ(moved->positions, surface.positions);
  EXPECT_EQ(moved->origin, surface.origin);
  // Where another program has put it elsewhere it is there.
  std::string edited = written_bytes(surface);
  const std::string from = R"("translation":[1000557820)";
  ASSERT_NE(edited.find(from), std::string::npos) << edited;
  edited.replace(edited.find(from), from.size(), R"("translation":[1000657820)");
  const auto elsewhere = read_bytes(".glb", edited);
  ASSERT_TRUE(elsewhere);
  EXPECT_EQ(elsewhere->world_position(0)[0], surface.world_position(0)[0] + 1e5);
  surface.origin = {};
  // Where floats do not have the differences they stay as they are.
  surface.positions = {{{8e6F, 0.1F, 0}}, {{8.001e6F, 1.0F, 0}}, {{8e6F, 1.0F, 0}}};
  EXPECT_EQ(written_bytes(surface).find("translation"), std::string::npos);
}

TEST(glb_file, stands_upright) {
  const std::string bytes = written_bytes(make_torus(3));
  EXPECT_NE(bytes.find(R"("nodes":[{"children":[1],"matrix":[1.0,0.0,0.0,0.0,0.0,0.0,-1.0,0.0,)"
                       R"(0.0,1.0,0.0,0.0,0.0,0.0,0.0,1.0])"),
            std::string::npos);
}

TEST(glb_file, is_in_metres_and_read_back_in_its_own_units) {
  const Surface torus = make_torus(3);
  const std::string bytes = written_bytes(torus, {.metres = {{80000, 110000, 0.25}}});
  EXPECT_NE(bytes.find(R"("matrix":[80000.0,0.0,0.0,0.0,0.0,0.0,-110000.0,0.0,)"
                       R"(0.0,0.25,0.0,0.0,0.0,0.0,0.0,1.0])"),
            std::string::npos);
  const auto read = read_bytes(".glb", bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->positions, torus.positions);
}

TEST(glb_file, replaces_comment_bytes_that_are_no_utf8) {
  const std::string bytes = written_bytes(make_torus(3), {.comment = "\xff\xfe"});
  EXPECT_TRUE(read_bytes(".glb", bytes));
}

TEST(glb_file, refuses_arrays_outside_the_file) {
  EXPECT_EQ(complaint_about(".glb", make_glb(one_mesh(R"("byteLength":24)", R"("count":2)"), 24)),
            "");
  for (const auto& [view, accessor] :
       {std::pair{R"("byteLength":36)", R"("count":2)"},
        std::pair{R"("byteLength":24)", R"("count":3)"},
        std::pair{R"("byteLength":24)", R"("count":18446744073709551615)"},
        std::pair{R"("byteLength":24)", R"("count":1537228672809129302)"},
        std::pair{R"("byteLength":24,"byteOffset":18446744073709551615)", R"("count":2)"},
        std::pair{R"("byteLength":24)", R"("count":1,"byteOffset":18446744073709551604)"},
        std::pair{R"("byteLength":-24)", R"("count":2)"},
        std::pair{R"("byteLength":24)", R"("count":1.5)"},
        std::pair{R"("byteLength":24)", R"("count":"2")"},
        std::pair{R"("byteLength":24,"byteStride":16)", R"("count":1)"}})
    EXPECT_NE(complaint_about(".glb", make_glb(one_mesh(view, accessor), 24)), "")
        << view << " " << accessor;
}

TEST(glb_file, refuses_json_of_other_shapes) {
  const auto of_nodes = [](const std::string& outer, const std::string& inner) {
    return R"({"nodes":[)" + outer + "," + inner + "]}";
  };
  const std::string turned = R"({"matrix":[1,0,0,0,0,0,-1,0,0,1,0,0,0,0,0,1],"children":[1]})";
  const std::string mirrored = R"({"matrix":[1,0,0,0,0,0,1,0,0,1,0,0,0,0,0,1],"children":[1]})";
  const std::string not_turned = R"({"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],"children":[1]})";
  EXPECT_EQ(complaint_about(".glb", make_glb(of_nodes(turned, "{}"), 4)), "");
  for (const std::string& json : std::vector<std::string>{
           "", "[]", "7", "{", "{}", R"({"nodes":7})", R"({"nodes":[7]})", R"({"nodes":[7,7]})",
           of_nodes(turned, "7"), of_nodes(not_turned, "{}"), of_nodes(mirrored, "{}"),
           of_nodes("{}", "{}"), of_nodes(R"({"matrix":[1,0]})", "{}"),
           of_nodes(turned, R"({"mesh":0})"),
           of_nodes(turned, R"({"mesh":0}],"meshes":[{"primitives":{}})"),
           of_nodes(turned, R"({"mesh":0}],"meshes":[{"primitives":[{"attributes":[]}]})"),
           of_nodes(turned, R"({"scale":[2,2,2]})"),
           of_nodes(turned, R"({"translation":["a",0,0]})"),
           of_nodes(turned, R"({"mesh":0,"extras":{"lode_origin":[0,0,0],"lode_first":[0]}})")})
    EXPECT_NE(complaint_about(".glb", make_glb(json, 4)), "") << json;
}

}  // namespace
}  // namespace lode::io

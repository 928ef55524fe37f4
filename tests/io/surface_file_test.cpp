#include "lode/io/surface_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/io/surface_fixtures.h"

namespace lode::io {
namespace {

class surface_formats : public testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] std::string extension() const { return GetParam(); }
  [[nodiscard]] bool is_stl() const { return extension() == ".stl"; }
  /// What a format without that attribute gives back.
  [[nodiscard]] Surface as_held(Surface surface) const {
    if (!can_hold_isovalues(extension())) surface.isovalues.clear();
    if (is_stl()) surface.normals.clear();
    return surface;
  }
};

/// Corner positions triangle by triangle: what STL keeps.
std::vector<Vec3f> corners_of(const Surface& surface) {
  std::vector<Vec3f> corners;
  for (const auto& triangle : surface.triangles)
    for (const std::uint32_t vertex : triangle) corners.push_back(surface.positions[vertex]);
  return corners;
}

TEST_P(surface_formats, give_back_what_was_written) {
  const Surface torus = make_torus(20);
  const Surface read = written_and_read(extension(), torus, {.comment = "a -- <torus>"});
  if (is_stl()) {
    EXPECT_EQ(corners_of(read), corners_of(torus));
    EXPECT_EQ(read.positions.size(), torus.positions.size());
  } else {
    expect_same_surface(read, as_held(torus));
  }
}

TEST(surface_isovalues, are_kept_to_the_last_bit_where_formats_have_doubles) {
  Surface torus = make_torus(6);
  for (std::size_t i = 0; i < torus.positions.size(); ++i)
    torus.isovalues[i] = i % 2 == 0 ? 1e6 + 0.0025 : -3e300;
  for (const char* const extension : {".ply", ".vtp"})
    EXPECT_EQ(written_and_read(extension, torus, {}).isovalues, torus.isovalues) << extension;
}

/// As properties of one word, none of which is taken for what else a vertex has.
TEST(surface_attributes, are_properties_of_ply_vertices) {
  Surface torus = make_torus(5);
  const std::size_t n = torus.positions.size();
  const std::vector<const char*> names{"heat", "x", "two words", "two_words", "u", "field_x"};
  for (const char* name : names) {
    Attribute attribute{name, false, {}};
    for (std::size_t i = 0; i < n; ++i)
      attribute.values.push_back(static_cast<double>(i + attribute.name.size()) / 3);
    torus.attributes.push_back(std::move(attribute));
  }
  const std::string path = temporary_path("attributes") + ".ply";
  Progress progress;
  ASSERT_TRUE(write_surface(path, torus, {}, progress));
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  std::filesystem::remove(path);
  const std::string wanted =
      "property double heat\nproperty double field_x\nproperty double two_words\n"
      "property double two_words_2\nproperty double field_u\nproperty double field_x_2\n";
  EXPECT_NE(bytes.find(wanted), std::string::npos);
  const std::size_t begin = bytes.find("end_header\n") + 11;
  const std::size_t record = (bytes.size() - begin - torus.triangles.size() * 13) / n;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < names.size(); ++k) {
      double value = 0;
      std::memcpy(&value, &bytes[begin + (i + 1) * record - (names.size() - k) * sizeof(double)],
                  sizeof(double));
      EXPECT_EQ(value, torus.attributes[k].values[i]);
    }
  const Surface read = written_and_read(".ply", torus);
  expect_same_surface(read, torus);
}

TEST_P(surface_formats, need_no_attributes) {
  Surface torus = make_torus(5);
  torus.normals.clear();
  torus.isovalues.clear();
  const Surface read = written_and_read(extension(), torus);
  EXPECT_EQ(corners_of(read), corners_of(torus));
  EXPECT_TRUE(read.normals.empty());
  EXPECT_TRUE(read.isovalues.empty());
}

TEST_P(surface_formats, give_back_lines_or_say_why_not) {
  const Surface circle = make_circle(30);
  EXPECT_EQ(can_hold_lines(extension()), !is_stl());
  if (can_hold_lines(extension())) {
    expect_same_surface(written_and_read(extension(), circle), as_held(circle));
    return;
  }
  const std::string path = temporary_path("lines") + extension();
  Progress progress;
  const Result<void> written = write_surface(path, circle, {}, progress);
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message.find("triangles only"), std::string::npos);
  EXPECT_FALSE(std::ifstream(path).good());
}

TEST_P(surface_formats, hold_empty_surfaces) {
  const Surface read = written_and_read(extension(), {});
  EXPECT_TRUE(read.is_empty());
  EXPECT_TRUE(read.positions.empty());
}

TEST_P(surface_formats, hold_empty_surfaces_with_an_origin) {
  Surface surface;
  surface.origin = {{500000.1, 4649776.25, -1e9}};
  const Surface read = written_and_read(extension(), surface);
  EXPECT_TRUE(read.is_empty());
  EXPECT_TRUE(read.positions.empty());
}

TEST_P(surface_formats, give_back_large_origins_exactly_or_say_why_not) {
  Surface torus = make_torus(20);
  torus.origin = {{500000.1, 4649776.25, -1e9}};
  if (is_stl()) {
    Progress progress;
    const Result<void> written = write_surface(temporary_path("far.stl"), torus, {}, progress);
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().message.find(".ply"), std::string::npos);
    return;
  }
  const Surface read = written_and_read(extension(), torus);
  ASSERT_EQ(read.positions.size(), torus.positions.size());
  EXPECT_EQ(read.origin, torus.origin);
  for (std::uint32_t i = 0; i < torus.positions.size(); ++i)
    ASSERT_EQ(read.world_position(i), torus.world_position(i));
  EXPECT_EQ(read.triangles, torus.triangles);
}

TEST_P(surface_formats, give_back_places_in_float64_where_they_can_hold_them) {
  const std::string path = temporary_path("places") + extension();
  for (const Vec3d& origin : {Vec3d{{0, 0, 0}}, Vec3d{{5e5, 4e6, 1e3}}}) {
    Surface surface = make_torus(6);
    surface.origin = origin;
    std::vector<Vec3d> places;
    for (std::uint32_t v = 0; v < surface.positions.size(); ++v)
      places.push_back(surface.world_position(v) + Vec3d{{0, 0, v % 2 == 0 ? 1e9 + 0.01 : 0.01}});
    Progress progress;
    const auto written = write_surface(path, surface, {.places = places}, progress);
    // STL has no origin.
    ASSERT_EQ(written.has_value(), !is_stl() || origin == Vec3d{});
    if (!written) continue;
    const auto read = read_placed_surface(path);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->places.empty(), !can_hold_places(path));
    if (can_hold_places(path)) EXPECT_EQ(read->places, places);
    // STL numbers corners anew.
    EXPECT_EQ(read->surface.triangles.size(), surface.triangles.size());
    if (!is_stl()) EXPECT_EQ(read->surface.triangles, surface.triangles);
    ::unlink(path.c_str());
  }
  // What floats have comes without.
  Progress progress;
  const Surface plain = make_torus(6);
  ASSERT_TRUE(write_surface(path, plain, {}, progress));
  const auto read = read_placed_surface(path);
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->places.empty());
  ::unlink(path.c_str());
}

TEST_P(surface_formats, keep_small_surfaces_far_from_zero_without_an_origin) {
  Surface torus = make_torus(6);
  for (Vec3f& p : torus.positions) p[0] = p[0] * 1e-3F + 3000.1F;
  const Surface read = written_and_read(extension(), torus);
  EXPECT_EQ(read.origin, Vec3d{});
  EXPECT_EQ(corners_of(read), corners_of(torus));
}

TEST_P(surface_formats, refuse_every_cut_binary_file) {
  const std::string path = temporary_path("whole") + extension();
  expect_written(path, make_torus(4), {.comment = "cut"});
  const std::string bytes = bytes_of(path);
  const bool detects_all = extension() != ".obj" && extension() != ".vtp";
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const std::string complaint = complaint_about(extension(), bytes.substr(0, size));
    if (detects_all) {
      EXPECT_NE(complaint, "") << size << " of " << bytes.size() << " bytes";
    }
  }
  ::unlink(path.c_str());
}

TEST_P(surface_formats, survive_flipped_bytes) {
  const std::string path = temporary_path("sound") + extension();
  expect_written(path, make_torus(4), {.comment = "flipped"});
  const std::string sound = bytes_of(path);
  constexpr unsigned kSeed = 20;
  std::mt19937 random(kSeed);
  for (int round = 0; round < 2000; ++round) {
    std::string bytes = sound;
    // Half of the flips hit the head, where the sizes are.
    const std::size_t reach =
        round % 2 == 0 ? bytes.size() : std::min<std::size_t>(400, bytes.size());
    for (int flip = 0; flip <= round % 3; ++flip)
      bytes[random() % reach] = static_cast<char>(random() % 256);
    const Result<Surface> read = read_bytes(extension(), bytes);
    if (!read) continue;
    for (const auto& triangle : read.value().triangles)
      for (const std::uint32_t vertex : triangle)
        ASSERT_LT(vertex, read.value().positions.size()) << "seed " << kSeed;
  }
  ::unlink(path.c_str());
}

TEST_P(surface_formats, refuse_empty_and_foreign_files) {
  EXPECT_NE(complaint_about(extension(), ""), "");
  if (extension() == ".obj") return;  // Any text is an OBJ file of unknown lines.
  EXPECT_NE(complaint_about(extension(), "hello\n"), "");
  EXPECT_NE(complaint_about(extension(), std::string(1000, '\0')), "");
}

TEST_P(surface_formats, leave_no_file_where_writing_fails) {
  const std::string path = "/no/such/directory/surface" + extension();
  Progress progress;
  const Result<void> written = write_surface(path, make_torus(3), {}, progress);
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message.find(path), std::string::npos);
}

TEST_P(surface_formats, report_how_far_they_are) {
  const std::string path = temporary_path("reported") + extension();
  std::vector<double> fractions;
  Progress progress([&](std::string_view phase, double fraction, std::uint64_t) {
    EXPECT_EQ(phase, "writing");
    fractions.push_back(fraction);
  });
  ASSERT_TRUE(write_surface(path, make_torus(20), {}, progress));
  ::unlink(path.c_str());
  ASSERT_FALSE(fractions.empty());
  EXPECT_TRUE(std::ranges::is_sorted(fractions));
  EXPECT_GT(fractions.front(), 0);
  EXPECT_LE(fractions.back(), 1);
  EXPECT_GT(fractions.back(), 0.5);
}

TEST_P(surface_formats, leave_no_file_where_they_are_cancelled) {
  const std::filesystem::path directory = temporary_path("cancelled");
  std::filesystem::create_directory(directory);
  const std::string path = (directory / "surface").string() + extension();
  // Cancelled after the first piece, the second, and so on until one run is through.
  int n_stopped = 0;
  while (!std::filesystem::exists(path)) {
    int n_pieces = 0;
    Progress progress([&](std::string_view, double, std::uint64_t) {
      if (n_pieces++ == n_stopped) progress.cancel();
    });
    const Result<void> written = write_surface(path, make_torus(20), {}, progress);
    EXPECT_EQ(written.has_value(), n_pieces <= n_stopped);
    if (written) break;
    EXPECT_EQ(written.error().message, cancelled_error().message);
    EXPECT_TRUE(std::filesystem::is_empty(directory));
    ++n_stopped;
  }
  EXPECT_GT(n_stopped, 0);
  std::filesystem::remove_all(directory);
}

INSTANTIATE_TEST_SUITE_P(all, surface_formats,
                         testing::Values(".ply", ".stl", ".obj", ".vtp", ".glb"),
                         [](const auto& instance) { return std::string(instance.param + 1); });

TEST(surface_file, knows_formats_by_extension_in_any_case) {
  EXPECT_TRUE(check_surface_path("a/b.c/bone.PLY"));
  EXPECT_TRUE(check_surface_path("bone.glb"));
  EXPECT_TRUE(can_hold_isovalues("bone.Vtp"));
  EXPECT_FALSE(can_hold_isovalues("bone.stl"));
  EXPECT_FALSE(can_hold_isovalues("bone.obj"));
}

TEST(surface_file, lists_the_known_extensions_when_it_gets_another) {
  Progress progress;
  for (const char* path : {"bone.xyz", "bone", "bone.ply/", "dir.ply/bone"}) {
    const Result<void> checked = check_surface_path(path);
    ASSERT_FALSE(checked) << path;
    EXPECT_NE(checked.error().message.find(".ply, .stl, .obj, .vtp or .glb"), std::string::npos);
    EXPECT_FALSE(read_surface(path));
    EXPECT_FALSE(write_surface(path, {}, {}, progress));
  }
}

TEST(surface_file, names_a_missing_file) {
  const Result<Surface> missing = read_surface("/no/such/bone.ply");
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("/no/such/bone.ply"), std::string::npos);
}

}  // namespace
}  // namespace lode::io

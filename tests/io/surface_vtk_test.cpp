// VTK, which shares no code with Lode, reads what Lode writes and writes what Lode reads.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <vector>

#include "tests/io/surface_fixtures.h"
#include "tests/io/vtk_oracle.h"

namespace lode::io {
namespace {

using test::has_vtk;

std::string oracle(const std::string& arguments) {
  return test::run_oracle(LODE_SURFACE_ORACLE, arguments);
}

struct Description {
  std::size_t n_points = 0;
  std::size_t n_cells = 0;
  std::array<double, 6> bounds{};
};

std::istream& operator>>(std::istream& in, Description& description) {
  in >> description.n_points >> description.n_cells;
  for (double& bound : description.bounds) in >> bound;
  return in;
}

Description describe(const Surface& surface) {
  Description description{
      surface.positions.size(), surface.triangles.size() + surface.lines.size(), {}};
  for (std::uint32_t i = 0; i < surface.positions.size(); ++i) {
    const Vec3d p = surface.world_position(i);
    for (std::size_t k = 0; k < 3; ++k) {
      double& lower = description.bounds[2 * k];
      double& upper = description.bounds[2 * k + 1];
      lower = i == 0 ? p[k] : std::min(lower, p[k]);
      upper = i == 0 ? p[k] : std::max(upper, p[k]);
    }
  }
  return description;
}

/// `tolerance` is relative to the largest bound: 0 where both sides keep all digits.
void expect_same(const Description& a, const Description& b, double tolerance,
                 const std::string& what) {
  EXPECT_EQ(a.n_points, b.n_points) << what;
  EXPECT_EQ(a.n_cells, b.n_cells) << what;
  double largest = 0;
  for (const double bound : b.bounds) largest = std::max(largest, std::abs(bound));
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(a.bounds[i], b.bounds[i], tolerance * largest) << what << ", bound " << i;
}

/// As glTF has it, whose up is y: x, z, -y.
Description upright(Description description) {
  const auto [x0, x1, y0, y1, z0, z1] = description.bounds;
  description.bounds = {x0, x1, z0, z1, -y1, -y0};
  return description;
}

struct Written {
  std::string path;
  Description expected;
  double tolerance = 0;
};

/// Three surfaces in each format: near, far, empty; and lines for those VTK reads lines from.
std::vector<Written> write_all() {
  // VTK's OBJ reader rounds to float32 once; its glTF reader the node's translation and the sum.
  constexpr double kFloatRounding = 2 * 6e-8;
  const Surface torus = make_torus(30);
  Surface far = torus;
  far.origin = {{500000.5, 4649776.25, 0}};
  std::vector<Written> all;
  const auto add = [&](const std::string& name, const Surface& surface, double tolerance) {
    const Description expected = describe(surface);
    all.push_back(
        {temporary_path(name), name.ends_with(".glb") ? upright(expected) : expected, tolerance});
    expect_written(all.back().path, surface, {.comment = "oracle --"});
  };
  for (const char* extension : {".ply", ".stl", ".obj", ".vtp", ".glb"}) {
    add(std::string("torus") + extension, torus, 0);
    // VTK's STL and OBJ readers call files without content errors.
    if (extension != std::string(".stl") && extension != std::string(".obj"))
      add(std::string("empty") + extension, {}, 0);
  }
  for (const char* extension : {".obj", ".glb"})
    add(std::string("far") + extension, far, kFloatRounding);
  add("far.vtp", far, 0);
  // VTK's PLY reader stores float32 too.
  add("far.ply", far, kFloatRounding);
  for (const char* extension : {".obj", ".vtp", ".glb"})
    add(std::string("lines") + extension, make_circle(30), 0);
  return all;
}

TEST(surfaces_in_vtk, are_read_with_the_same_counts_and_bounds) {
  ASSERT_TRUE(has_vtk()) << test::kVtkMissing;
  const std::vector<Written> all = write_all();
  std::string arguments = "read";
  for (const Written& written : all) arguments += " " + written.path;
  std::istringstream lines(oracle(arguments));
  for (const Written& written : all) {
    std::string line;
    ASSERT_TRUE(std::getline(lines, line)) << written.path;
    std::istringstream words(line);
    Description description;
    std::string lowest;
    std::string highest;
    words >> description >> lowest >> highest;
    expect_same(description, written.expected, written.tolerance, written.path);
    if (written.path.ends_with("torus.vtp")) {
      const std::vector<double> isovalues = make_torus(30).isovalues;
      const auto [least, most] = std::minmax_element(isovalues.begin(), isovalues.end());
      EXPECT_EQ(std::stod(lowest), *least);
      EXPECT_EQ(std::stod(highest), *most);
    }
    ::unlink(written.path.c_str());
  }
}

TEST(surfaces_from_vtk, are_read_in_every_form_that_vtk_writes) {
  ASSERT_TRUE(has_vtk()) << test::kVtkMissing;
  std::istringstream lines(oracle("write " + temporary_path("vtk_")));
  std::size_t n_files = 0;
  std::string path;
  Description expected;
  while (lines >> path >> expected) {
    ++n_files;
    const Result<Surface> read = read_surface(path);
    ASSERT_TRUE(read) << read.error().message;
    // VTK's text formats print six digits or so.
    const bool is_rounded = path.ends_with("ASCII.ply") || path.ends_with("ASCII.stl") ||
                            path.ends_with(".obj") || path.find("Ascii") != std::string::npos;
    expect_same(describe(read.value()), expected, is_rounded ? 1e-5 : 0, path);
    if (path.ends_with(".vtp")) {
      EXPECT_EQ(read.value().normals.size(), expected.n_points) << path;
    }
    ::unlink(path.c_str());
  }
  EXPECT_EQ(n_files, 29U);
}

}  // namespace
}  // namespace lode::io

// Where vertices come from, written and read.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/io/surface_fixtures.h"

namespace lode::io {
namespace {

/// A torus whose vertices come from elsewhere, but for every third; on a grid, so that nothing is
/// lost far from 0.
Surface make_moved_torus() {
  Surface torus = make_torus(12);
  for (Vec3f& p : torus.positions)
    for (std::size_t i = 0; i < 3; ++i) p[i] = std::round(p[i] * 1024) / 1024;
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t v = 0; v < torus.positions.size(); ++v)
    torus.origins.push_back(v % 3 == 0 ? Vec3f{{kNone, kNone, kNone}}
                                       : torus.positions[v] + Vec3f{{0.125F, -0.25F, 0.5F}});
  return torus;
}

/// NaN is equal to NaN here.
void expect_same_origins(const Surface& a, const Surface& b) {
  ASSERT_EQ(a.origins.size(), b.origins.size());
  for (std::size_t v = 0; v < a.origins.size(); ++v)
    for (std::size_t i = 0; i < 3; ++i) {
      const float x = a.origins[v][i];
      const float y = b.origins[v][i];
      ASSERT_TRUE(x == y || (std::isnan(x) && std::isnan(y))) << v << ": " << x << ", " << y;
    }
}

TEST(surface_origins, come_back_from_formats_that_hold_them) {
  const Surface torus = make_moved_torus();
  for (const char* extension : {".ply", ".vtp"}) {
    SCOPED_TRACE(extension);
    const Surface read = written_and_read(extension, torus);
    expect_same_surface(read, torus);
    expect_same_origins(read, torus);
  }
  for (const char* extension : {".obj", ".glb", ".stl"}) {
    SCOPED_TRACE(extension);
    EXPECT_TRUE(written_and_read(extension, torus).origins.empty());
  }
}

TEST(surface_origins, are_relative_to_what_positions_are) {
  Surface torus = make_moved_torus();
  torus.origin = {{1048576, -2097152, 524288}};
  for (const char* extension : {".ply", ".vtp"}) {
    SCOPED_TRACE(extension);
    const Surface read = written_and_read(extension, torus);
    expect_same_surface(read, torus);
    expect_same_origins(read, torus);
  }
}

TEST(surface_origins, must_be_as_many_as_vertices) {
  EXPECT_NE(complaint_about(".ply",
                            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                            "property float y\nproperty float z\nproperty float origin_x\n"
                            "property float origin_y\nproperty float origin_z\nend_header\n"
                            "1 2 3 4 5"),
            "");
}

}  // namespace
}  // namespace lode::io

// Meshes that are deformed by a vector of theirs, through the program.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/cli/tetra_fields_fixture.h"

namespace lode::test {
namespace {

TEST_F(cli_tetra_fields, deform) {
  const std::string model = scratch_ / "vector.lode";
  done({"build", mesh_, model, "--field", "noise", "--with", "shift:xyz"});
  const auto points_of = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"extract", model, out_, "--mesh", "--max-error", "0.1"});
    const nlohmann::json json = done(words);
    EXPECT_EQ(json.value("inverted_cells", 0), 0);
    EXPECT_EQ(fields_of(out_), std::vector<std::string>{"noise"});
    return read_cell_mesh(out_, {})->points;
  };
  const std::vector<Vec3d> before = points_of({});
  const std::vector<Vec3d> after = points_of({"--warp", "shift", "--scale", "2"});
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t v = 0; v < before.size(); ++v) {
    const Vec3d p = before[v];
    EXPECT_NEAR(after[v][0], p[0] + 2 * 0.1 * p[2], 1e-12);
    EXPECT_EQ(after[v][1], p[1]);
    EXPECT_NEAR(after[v][2], p[2] + 2 * 0.2 * p[0] * p[1], 1e-12);
  }
  // Turned round where a shift upward is taken from what is above it.
  const Finished turned = run_lode({"extract", model, out_, "--mesh", "--max-error", "0", "--warp",
                                    "shift", "--scale", "-30", "--json"});
  EXPECT_EQ(turned.exit_code, 0) << turned.err;
  EXPECT_GT(turned.json().at("inverted_cells"), 0);
  EXPECT_NE(turned.err.find("turned round"), std::string::npos);
  for (const std::vector<std::string>& of : {std::vector<std::string>{"--boundary"},
                                             {"--isovalue", "0.1"},
                                             {"--section", "0.5,0.5,0.5:0,0,1"}}) {
    std::vector<std::string> words{"extract", model,   scratch_ / "s.ply", "--max-error", "0",
                                   "--warp",  "shift", "--scale",          "-30",         "--json"};
    words.insert(words.end(), of.begin(), of.end());
    const Finished surface_turned = run_lode(words);
    EXPECT_GT(surface_turned.json().at("inverted_cells"), 0) << surface_turned.err;
    EXPECT_NE(surface_turned.err.find("turned round"), std::string::npos);
  }
  // Boundaries and isosurfaces as well, and what is built in memory.
  const std::string surface = scratch_ / "s.ply";
  for (const std::vector<std::string>& of :
       {std::vector<std::string>{"--boundary"}, {"--isovalue", "0.1"}}) {
    std::vector<std::string> words{"extract", mesh_,     surface, "--field",     "noise", "--warp",
                                   "shift",   "--scale", "2",     "--max-error", "0"};
    words.insert(words.end(), of.begin(), of.end());
    EXPECT_GT(done(words).at("triangles"), 100);
    const auto made = read_surface(surface);
    ASSERT_TRUE(made);
    float highest = 0;
    for (const Vec3f& p : made->positions) highest = std::max(highest, p[2]);
    EXPECT_GT(highest, 1.1F);
  }
  EXPECT_EQ(run_lode({"render", model, scratch_ / "p.png", "--boundary", "--warp", "shift",
                      "--size", "64x64"})
                .exit_code,
            0);
  refused({"extract", model, out_, "--mesh", "--scale", "2"}, "--warp");
  refused({"extract", model, out_, "--mesh", "--warp", "heat"}, "heat:0");
  refused({"extract", mesh_, out_, "--mesh", "--field", "noise", "--warp", "noise"},
          "--warp: noise:xyz: expected a field of three components");
  refused({"extract", model, out_, "--mesh", "--warp", "shift", "--scale", "much"}, "--scale");
}

/// Isosurfaces have no values of the field they are of: it is what they are at.
TEST_F(cli_tetra_fields, deform_surfaces_of_a_component_of_the_vector_itself) {
  const std::string model = scratch_ / "vector.lode";
  const std::string surface = scratch_ / "s.ply";
  done({"build", mesh_, model, "--field", "shift:xyz", "--with", "noise"});
  for (const std::string& input : {model, mesh_})
    for (const Words& of :
         {Words{"--isovalue", "0.04"}, Words{"--isovalue", "0.02", "--isovalue", "0.04"},
          Words{"--section", "0.5,0.5,0.5:1,0,0", "--isovalue", "0.04"},
          Words{"--section", "0.5,0.5,0.5:1,0,0"}, Words{"--boundary"}, Words{"--mesh"}}) {
      const std::string out = of[0] == "--mesh" ? out_ : surface;
      Words words{"extract", input,     out,  "--field",     "shift:x", "--warp",
                  "shift",   "--scale", "10", "--max-error", "0"};
      words.insert(words.end(), of.begin(), of.end());
      SCOPED_TRACE(fmt::format("{} {}", input, fmt::join(of, " ")));
      const nlohmann::json json = done(words);
      EXPECT_EQ(json.at("warp").at("field"), "shift");
      // Isolines are fine where they are, and not all along the plane.
      if (of[0] != "--section" || of.size() == 2) EXPECT_EQ(json.at("warp").at("error"), 0);
      EXPECT_EQ(json.at("with").size(), 0U);
      if (of.size() != 2 || of[0] != "--isovalue") continue;
      // shift:x is a tenth of z, so all of it was at z = 0.4 and went by 0.4 along x.
      float lowest = 9;
      const Surface made = read_surface(surface).value();
      for (const Vec3f& p : made.positions) lowest = std::min(lowest, p[0]);
      EXPECT_NEAR(lowest, 0.4F, 1e-6F);
    }
  // The vector's name is found whatever the field is called by.
  done({"extract", model, out_, "--mesh", "--warp", "shift"});
  done({"extract", model, out_, "--mesh", "--warp", "shift:xyz", "--field", "shift:y"});
  done({"extract", model, out_, "--mesh", "--warp", "noise,shift:x,shift:1", "--field", "shift:2"});
  refused({"extract", model, out_, "--mesh", "--warp", "noise,shift:x"}, "three scalars");
  refused({"extract", model, out_, "--mesh", "--warp", "shift:x"}, "got 'shift:x'");
  refused({"extract", model, out_, "--mesh", "--warp", "shift", "--view", "camera.json"}, "--view");
  refused({"extract", model, surface, "--boundary", "--warp", "shift", "--scale", "1e300"},
          "float32");
}

TEST_F(cli_tetra_fields, that_deform_stay_where_they_are_asked_for) {
  const std::string model = scratch_ / "vector.lode";
  done({"build", mesh_, model, "--field", "noise", "--with", "shift:xyz", "--at", "1"});
  const auto names = [&](const Words& options) {
    Words words{"extract", model, out_, "--mesh", "--warp", "shift"};
    words.insert(words.end(), options.begin(), options.end());
    const nlohmann::json json = done(words);
    Words found;
    for (const auto& with : json.at("with")) found.push_back(with.at("field"));
    return found;
  };
  const Words all{"shift:0", "shift:1", "shift:2"};
  EXPECT_EQ(names({}), Words{});
  EXPECT_EQ(names({"--with", "all"}), all);
  EXPECT_EQ(names({"--with", "shift:xyz"}), all);
  EXPECT_EQ(names({"--field", "noise at 1", "--with", "shift:xyz at 1"}), all);
  EXPECT_EQ(names({"--with", "shift:y"}), Words{"shift:1"});
  EXPECT_EQ(names({"--field", "noise at 1", "--with", "shift:0 at 1"}), Words{"shift:0"});
  const std::string picture = scratch_ / "p.png";
  for (const char* const color : {"shift:0 at 1", "shift:x at 1", "shift:x"})
    EXPECT_EQ(run_lode({"render", model, picture, "--boundary=field", "--color-by", color, "--warp",
                        "shift", "--size", "64x64"})
                  .exit_code,
              0)
        << color;
}

TEST_F(cli_tetra_fields, of_warped_isosurfaces_have_no_normals_and_say_so) {
  const std::string model = scratch_ / "vector.lode";
  done({"build", mesh_, model, "--field", "noise", "--with", "shift:xyz"});
  const auto warnings = [&](const char* normals) {
    return done({"extract", model, scratch_ / "s.ply", "--isovalue", "0.1", "--warp", "shift",
                 "--max-error", "0", "--normals", normals})
        .at("warnings")
        .dump();
  };
  EXPECT_NE(warnings("on").find("normals are left out"), std::string::npos);
  EXPECT_EQ(warnings("off").find("normals are left out"), std::string::npos);
}

}  // namespace
}  // namespace lode::test

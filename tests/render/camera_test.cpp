#include "lode/render/camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <string>

#include "lode/render/camera_file.h"
#include "lode/render/camera_path.h"

namespace lode {
namespace {

class camera_file : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }

  Result<Camera> read(const std::string& text) {
    std::ofstream(path_, std::ios::binary) << text;
    return read_camera(path_);
  }

  const std::string path_ = testing::TempDir() + "lode_" +
                            testing::UnitTest::GetInstance()->current_test_info()->name() + ".json";
};

// How far the box's corners reach from the picture's centre, 1 being its border.
struct Reach {
  double left = 0;
  double right = 0;
  double bottom = 0;
  double top = 0;

  [[nodiscard]] double largest() const {
    return std::max(std::max(left, right), std::max(bottom, top));
  }
};

Reach reach_of(const Box3d& box, const Camera& camera, double aspect) {
  const CameraAxes axes = axes_of(camera);
  const double tan_v = std::tan(camera.field_of_view_deg * std::numbers::pi / 360);
  Reach reach{-1e300, -1e300, -1e300, -1e300};
  for (int i = 0; i < 8; ++i) {
    const Vec3d corner{{(i & 1) != 0 ? box.upper[0] : box.lower[0],
                        (i & 2) != 0 ? box.upper[1] : box.lower[1],
                        (i & 4) != 0 ? box.upper[2] : box.lower[2]}};
    const Vec3d p = corner - camera.eye;
    const double depth = dot(p, axes.forward);
    EXPECT_GT(depth, 0);
    const double x = dot(p, axes.right) / (depth * tan_v * aspect);
    const double y = dot(p, axes.up) / (depth * tan_v);
    reach.left = std::max(reach.left, -x);
    reach.right = std::max(reach.right, x);
    reach.bottom = std::max(reach.bottom, -y);
    reach.top = std::max(reach.top, y);
  }
  return reach;
}

TEST(default_camera, shows_all_of_any_box_with_a_small_margin) {
  for (const Box3d& box :
       {Box3d{{{0, 0, 0}}, {{1, 1, 1}}}, Box3d{{{0, 0, 0}}, {{300, 20, 5}}},
        Box3d{{{-1, -1, -1}}, {{1, 1, 80}}},
        Box3d{{{1e6, -1e6, 5e6}}, {{1e6 + 3, -1e6 + 4, 5e6 + 5}}},
        Box3d{{{0, 0, 0}}, {{1e-7, 2e-7, 1e-7}}}, Box3d{{{0, 0, 0}}, {{1e9, 1e9, 1e9}}}}) {
    for (const double aspect : {0.5, 4.0 / 3, 3.0}) {
      for (const Mat3& axes : {Mat3::identity(), viewing_axes(Frame::ras)}) {
        const Camera camera = default_camera(box, axes, aspect);
        ASSERT_TRUE(check_camera(camera)) << check_camera(camera).error().message;
        const Reach reach = reach_of(box, camera, aspect);
        EXPECT_LT(reach.largest(), 0.97);
        EXPECT_GT(reach.largest(), 0.90);
        EXPECT_NEAR(reach.left, reach.right, 0.02);
        EXPECT_NEAR(reach.bottom, reach.top, 0.02);
      }
    }
  }
}

TEST(default_camera, looks_at_patients_from_the_front) {
  const Box3d box{{{-1, -1, -1}}, {{1, 1, 1}}};
  EXPECT_GT(default_camera(box, viewing_axes(Frame::ras), 1).eye[1], 0);  // +y is anterior.
  EXPECT_LT(default_camera(box, viewing_axes(Frame::lps), 1).eye[1], 0);  // -y is anterior.
  EXPECT_GT(default_camera(box, viewing_axes(Frame::ras), 1).eye[2], 0);
}

TEST(default_camera, is_usable_for_a_box_that_is_one_point) {
  const Box3d box{{{5, 6, 7}}, {{5, 6, 7}}};
  EXPECT_TRUE(check_camera(default_camera(box, Mat3::identity(), 1)));
  EXPECT_TRUE(check_camera(top_camera(box, 1)));
}

TEST(top_camera, looks_along_the_thin_side) {
  const Camera z = top_camera({{{0, 0, 3}}, {{10, 5, 3}}}, 2);
  EXPECT_EQ(normalized(z.target - z.eye), (Vec3d{{0, 0, -1}}));
  EXPECT_EQ(z.up, (Vec3d{{0, 1, 0}}));
  const Camera y = top_camera({{{0, 3, 0}}, {{10, 3, 5}}}, 2);
  EXPECT_EQ(normalized(y.target - y.eye), (Vec3d{{0, 1, 0}}));
  const Camera x = top_camera({{{3, 0, 0}}, {{3, 10, 5}}}, 2);
  EXPECT_EQ(normalized(x.target - x.eye), (Vec3d{{-1, 0, 0}}));
}

TEST(check_camera, refuses_cameras_that_show_nothing) {
  const Camera good;
  EXPECT_TRUE(check_camera(good));
  Camera bad = good;
  bad.eye = bad.target;
  EXPECT_FALSE(check_camera(bad));
  bad = good;
  bad.up = bad.target - bad.eye;
  EXPECT_FALSE(check_camera(bad));
  bad.up = {};
  EXPECT_FALSE(check_camera(bad));
  bad = good;
  bad.target[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(check_camera(bad));
  for (const double angle : {0.0, -5.0, 171.0, std::numeric_limits<double>::quiet_NaN()}) {
    bad = good;
    bad.field_of_view_deg = angle;
    EXPECT_FALSE(check_camera(bad)) << angle;
  }
}

TEST_F(camera_file, reads_back_exactly_what_was_written) {
  const Camera camera{.eye = {{1.0 / 3, -1e-300, 1e6 + 0.1}},
                      .target = {{0.1, 0.2, 0.3}},
                      .up = {{0, std::sqrt(2.0), 1}},
                      .field_of_view_deg = 33.3};
  ASSERT_TRUE(write_camera(camera, path_));
  const auto read_back = read_camera(path_);
  ASSERT_TRUE(read_back) << read_back.error().message;
  EXPECT_EQ(*read_back, camera);
}

TEST_F(camera_file, fills_in_up_and_field_of_view) {
  const auto camera = read(R"({"eye": [1, 2, 3], "target": [0, 0, 0]})");
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_EQ(camera->up, (Vec3d{{0, 0, 1}}));
  EXPECT_EQ(camera->field_of_view_deg, 30);
}

TEST_F(camera_file, refuses_hostile_json_naming_the_file) {
  const std::string head = R"({"eye": [1, 2, 3], "target": )";
  for (const std::string& text :
       {std::string(), std::string("{"), std::string("[1, 2, 3]"), std::string("null"),
        std::string("\x00\xff\xfe", 3), std::string(R"({"eye": [1, 2, 3]})"), head + "[0, 0]}",
        head + "[0, 0, 0, 0]}", head + "[0, 0, \"0\"]}", head + "{\"x\": 0}}", head + "[1, 2, 3]}",
        head + "[1e999, 0, 0]}", head + "[0, 0, 0], \"up\": [0, 0, 0]}",
        head + "[0, 0, 0], \"field_of_view_deg\": \"wide\"}",
        head + "[0, 0, 0], \"field_of_view_deg\": 180}", head + "[0, 0, 0], \"zoom\": 2}",
        std::string(60000, '['), std::string(200000, ' ')}) {
    const auto camera = read(text);
    ASSERT_FALSE(camera) << text.substr(0, 80);
    EXPECT_NE(camera.error().message.find(path_), std::string::npos) << camera.error().message;
  }
}

TEST_F(camera_file, names_a_missing_field_and_an_unknown_one) {
  EXPECT_NE(read(R"({"target": [0, 0, 0]})").error().message.find("\"eye\""), std::string::npos);
  EXPECT_NE(
      read(R"({"eye": [1, 2, 3], "target": [0, 0, 0], "fov": 3})").error().message.find("\"fov\""),
      std::string::npos);
}

TEST_F(camera_file, names_a_file_that_is_not_there) {
  const auto camera = read_camera(testing::TempDir() + "no_such_camera.json");
  ASSERT_FALSE(camera);
  EXPECT_NE(camera.error().message.find("no_such_camera.json"), std::string::npos);
}

TEST_F(camera_file, holds_a_whole_path) {
  const Box3d bounds{{{1, 2, 3}}, {{11, 22, 33}}};
  for (const char* name : {"orbit", "fly-in", "jump"}) {
    const auto cameras = camera_path(name, bounds);
    ASSERT_TRUE(cameras);
    for (const Camera& camera : *cameras) ASSERT_TRUE(check_camera(camera));
    ASSERT_TRUE(write_cameras(*cameras, path_));
    const auto again = camera_path(path_, bounds);
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(*again, *cameras);
  }
  EXPECT_EQ(orbit_path(bounds).size(), 360U);
  const Camera last = fly_in_path(bounds).back();
  EXPECT_NEAR(length(last.eye - last.target), length(bounds.upper - bounds.lower) / 2, 1e-9);
}

TEST(camera_path, has_all_of_a_box_in_sight) {
  for (const Vec3d& size : {Vec3d{{30, 30, 5}}, {{2, 9, 40}}, {{1, 1, 1}}, {{9, 0, 0}}}) {
    const Box3d bounds{{{-3, 2, 7}}, Vec3d{{-3, 2, 7}} + size};
    for (const double aspect : {0.5, 1.0, 4.0 / 3}) {
      double largest = 0;  // 1 at the frame
      for (const Camera& camera : orbit_path(bounds, aspect)) {
        const CameraAxes axes = axes_of(camera);
        const double slope = std::tan(camera.field_of_view_deg / 2 * std::numbers::pi / 180);
        for (int corner = 0; corner < 8; ++corner) {
          Vec3d p = bounds.lower;
          for (std::size_t k = 0; k < 3; ++k)
            if ((corner >> k & 1) != 0) p[k] = bounds.upper[k];
          const Vec3d seen = p - camera.eye;
          const double depth = dot(seen, axes.forward);
          ASSERT_GT(depth, 0);
          largest = std::max({largest, std::abs(dot(seen, axes.up)) / (depth * slope),
                              std::abs(dot(seen, axes.right)) / (depth * slope * aspect)});
        }
      }
      EXPECT_LE(largest, 1);
      EXPECT_GE(largest, 0.85);
    }
  }
}

TEST_F(camera_file, names_the_frame_of_a_path_that_is_wrong) {
  for (const char* text :
       {"[]", "{}", "[3]", "x", R"([{"eye": [0, 0, 0], "target": [0, 0, 0]}])"}) {
    std::ofstream(path_) << text;
    const auto cameras = read_cameras(path_);
    ASSERT_FALSE(cameras) << text;
    EXPECT_NE(cameras.error().message.find(path_), std::string::npos);
  }
  std::ofstream(path_) << R"([{"eye": [0, 1, 0], "target": [0, 0, 0]}, {"eye": [0, 1, 0]}])";
  const auto cameras = read_cameras(path_);
  ASSERT_FALSE(cameras);
  EXPECT_NE(cameras.error().message.find("frame 1"), std::string::npos);
}

}  // namespace
}  // namespace lode

#include "lode/io/quantized_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>

#include "tests/oracles/random.h"

namespace lode::io {
namespace {

/// A lattice of n by n cells, each in two triangles.
QuantizedMesh make_mesh(std::int32_t n, double west, double size) {
  QuantizedMesh mesh{.west = west, .south = 30, .east = west + size, .north = 30 + size};
  mesh.lowest = -128;
  mesh.highest = -128 + 32767 * 0.25;
  const auto width = static_cast<std::uint32_t>(n + 1);
  for (std::int32_t y = 0; y <= n; ++y)
    for (std::int32_t x = 0; x <= n; ++x) {
      mesh.nodes.push_back({x * QuantizedMesh::kLast / n, y * QuantizedMesh::kLast / n});
      mesh.heights.push_back(static_cast<std::uint16_t>((x * 7919 + y * 104729) % 32768));
    }
  for (std::uint32_t y = 0; y + 1 < width; ++y)
    for (std::uint32_t x = 0; x + 1 < width; ++x) {
      const std::uint32_t a = y * width + x;
      mesh.triangles.push_back({a, a + 1, a + width + 1});
      mesh.triangles.push_back({a, a + width + 1, a + width});
    }
  return mesh;
}

Result<QuantizedMesh> decode(std::span<const std::byte> bytes, const QuantizedMesh& like) {
  return decode_quantized_mesh(bytes, like.west, like.south, like.east, like.north, "a.terrain");
}

/// Vertices in whatever order.
using Corner = std::tuple<std::int32_t, std::int32_t, std::uint16_t>;
std::vector<std::array<Corner, 3>> content_of(const QuantizedMesh& mesh) {
  std::vector<std::array<Corner, 3>> triangles;
  for (const auto& triangle : mesh.triangles) {
    std::array<Corner, 3> corners;
    for (std::size_t i = 0; i < 3; ++i)
      corners[i] = {mesh.nodes[triangle[i]].x, mesh.nodes[triangle[i]].y,
                    mesh.heights[triangle[i]]};
    triangles.push_back(corners);
  }
  return triangles;
}

template <typename T>
T value_at(const std::vector<std::byte>& bytes, std::size_t offset) {
  T value{};
  std::memcpy(&value, &bytes[offset], sizeof value);
  return value;
}

TEST(quantized_mesh, holds_what_was_put_in) {
  for (const std::int32_t n : {1, 2, 31, 260}) {  // the last has more vertices than 16 bits count
    const QuantizedMesh mesh = make_mesh(n, 7, 0.5);
    const auto decoded = decode(encode(mesh), mesh);
    ASSERT_TRUE(decoded) << decoded.error().message;
    EXPECT_EQ(decoded->lowest, mesh.lowest);
    EXPECT_EQ(decoded->highest, mesh.highest);
    EXPECT_EQ(content_of(*decoded), content_of(mesh));
  }
}

TEST(quantized_mesh, has_the_bytes_that_the_format_says) {
  QuantizedMesh mesh = make_mesh(1, 0, 90);
  mesh.heights = {0, 4, 32767, 2};
  const auto bytes = encode(mesh);
  EXPECT_EQ(value_at<std::uint32_t>(bytes, 88), 4);          // vertices: 0, 1, 3 and 2 by use
  const std::array<std::uint16_t, 4> u{0, 65534, 0, 65533};  // 0, +32767, 0, -32767 in zigzag
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(value_at<std::uint16_t>(bytes, 92 + 2 * i), u[i]);
  EXPECT_EQ(value_at<std::uint16_t>(bytes, 108), 0);  // heights 0, 4, 2, 32767
  EXPECT_EQ(value_at<std::uint16_t>(bytes, 110), 8);
  EXPECT_EQ(value_at<std::uint16_t>(bytes, 112), 3);
  EXPECT_EQ(value_at<std::uint32_t>(bytes, 116), 2);  // triangles
  const std::array<std::uint16_t, 6> codes{0, 0, 0, 3, 1, 0};
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_EQ(value_at<std::uint16_t>(bytes, 120 + 2 * i), codes[i]);
  EXPECT_EQ(value_at<std::uint32_t>(bytes, 132), 2);  // west
  EXPECT_EQ(value_at<std::uint16_t>(bytes, 136), 0);
  EXPECT_EQ(value_at<std::uint16_t>(bytes, 138), 3);
  EXPECT_EQ(bytes.size(), 132 + 4 * 8);
}

TEST(quantized_mesh, has_a_sphere_and_a_horizon_that_hide_nothing) {
  for (const double size : {0.01, 5.0, 90.0}) {
    const QuantizedMesh mesh = make_mesh(6, 20, size / 2);
    const auto bytes = encode(mesh);
    std::array<double, 7> facts{};
    std::memcpy(facts.data(), &bytes[32], sizeof facts);
    const double a = 6378137;
    const double b = a * (1 - 1 / 298.257223563);
    for (std::size_t v = 0; v < mesh.nodes.size(); ++v) {
      const double degree = std::numbers::pi / 180;
      const double lon = (mesh.west + (mesh.east - mesh.west) * mesh.nodes[v].x / 32767.0) * degree;
      const double lat =
          (mesh.south + (mesh.north - mesh.south) * mesh.nodes[v].y / 32767.0) * degree;
      const double e2 = 1 - b * b / (a * a);
      const double n = a / std::sqrt(1 - e2 * std::sin(lat) * std::sin(lat));
      const double h = mesh.height(v);
      const std::array<double, 3> p{(n + h) * std::cos(lat) * std::cos(lon),
                                    (n + h) * std::cos(lat) * std::sin(lon),
                                    (n * b * b / (a * a) + h) * std::sin(lat)};
      EXPECT_LE(std::hypot(p[0] - facts[0], p[1] - facts[1], p[2] - facts[2]), facts[3] + 1e-6);
      // In the space of the unit sphere: wherever the eye sees p it sees the occlusion point.
      const std::array<double, 3> unit{p[0] / a, p[1] / a, p[2] / b};
      const std::array<double, 3> occlusion{facts[4], facts[5], facts[6]};
      oracles::Random random(v);
      for (int i = 0; i < 200; ++i) {
        std::array<double, 3> eye{random.uniform() - 0.5, random.uniform() - 0.5,
                                  random.uniform() - 0.5};
        const double r = std::hypot(eye[0], eye[1], eye[2]);
        const double far = 1 + 3 * random.uniform();
        for (double& x : eye) x *= far / r;
        const auto is_seen = [&](const std::array<double, 3>& q) {
          // No point of the segment is inside of the sphere.
          double dd = 0, ed = 0, ee = 0;
          for (std::size_t k = 0; k < 3; ++k) {
            dd += (q[k] - eye[k]) * (q[k] - eye[k]);
            ed += eye[k] * (q[k] - eye[k]);
            ee += eye[k] * eye[k];
          }
          const double t = std::clamp(-ed / dd, 0.0, 1.0);
          return ee + 2 * t * ed + t * t * dd >= 1 + 1e-9;
        };
        if (h > 0 && is_seen(unit)) EXPECT_TRUE(is_seen(occlusion));
      }
    }
  }
}

TEST(quantized_mesh, has_an_occlusion_point_that_is_seen_from_above_the_tile) {
  // Half the world, with vertices within it on one side alone.
  QuantizedMesh mesh = make_mesh(1, -180, 180);
  mesh.south = -90;
  mesh.north = 90;
  mesh.nodes.push_back({32000, 26000});
  mesh.heights.push_back(9);
  mesh.triangles = {{0, 1, 4}, {1, 3, 4}, {3, 2, 4}, {2, 0, 4}};
  const auto decoded = decode(encode(mesh), mesh);
  ASSERT_TRUE(decoded);
  const auto& point = decoded->bounds.occlusion_point;
  for (int longitude = -179; longitude < 0; ++longitude)
    for (const double height : {0.01, 0.1, 0.5, 2.0}) {
      const double angle = longitude * std::numbers::pi / 180;
      const Vec<double, 3> eye{(1 + height) * std::cos(angle), (1 + height) * std::sin(angle), 0};
      // As clients decide: beyond the plane of the horizon, and within its cone.
      const double horizon = dot(eye, eye) - 1;
      const double way = dot(eye - point, eye);
      EXPECT_FALSE(way > horizon && way * way / dot(point - eye, point - eye) > horizon)
          << longitude << ", " << height;
    }
}

TEST(quantized_mesh, has_bounds_that_can_be_checked) {
  QuantizedMesh mesh = make_mesh(5, 7, 0.5);
  const auto decoded = decode(encode(mesh), mesh);
  ASSERT_TRUE(decoded);
  EXPECT_TRUE(check_bounds(*decoded));
  const auto is_good = [&](auto change) {
    QuantizedMesh changed = *decoded;
    change(changed.bounds);
    return check_bounds(changed).has_value();
  };
  EXPECT_FALSE(is_good([](TileBounds& bounds) { bounds.centre[1] = std::nan(""); }));
  EXPECT_FALSE(is_good([](TileBounds& bounds) { bounds.sphere_radius *= 0.99; }));
  EXPECT_FALSE(is_good([](TileBounds& bounds) { bounds.sphere_centre[2] += 1e4; }));
  EXPECT_FALSE(is_good([](TileBounds& bounds) { bounds.occlusion_point[0] *= 0.5; }));
}

TEST(quantized_mesh, is_refused_wherever_it_is_cut) {
  const QuantizedMesh mesh = make_mesh(5, 7, 0.5);
  const auto bytes = encode(mesh);
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    const auto decoded = decode(std::span(bytes).first(n), mesh);
    ASSERT_FALSE(decoded) << n;
    EXPECT_TRUE(decoded.error().message.starts_with("a.terrain: ")) << decoded.error().message;
  }
}

TEST(quantized_mesh, gives_an_error_or_a_mesh_whatever_is_changed) {
  const QuantizedMesh mesh = make_mesh(5, 7, 0.5);
  const auto bytes = encode(mesh);
  for (std::size_t i = 0; i < bytes.size(); ++i)
    for (const int flip : {1, 0x80, 0xFF}) {
      auto changed = bytes;
      changed[i] ^= static_cast<std::byte>(flip);
      const auto decoded = decode(changed, mesh);
      if (!decoded) continue;
      for (const auto& triangle : decoded->triangles)
        for (const std::uint32_t v : triangle) ASSERT_LT(v, decoded->nodes.size());
      ASSERT_EQ(decoded->heights.size(), decoded->nodes.size());
    }
}

}  // namespace
}  // namespace lode::io

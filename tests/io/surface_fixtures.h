#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "lode/core/surface.h"
#include "lode/io/surface_file.h"

namespace lode::io {

/// A path in the tests' temporary directory that no other test program uses.
inline std::string temporary_path(std::string_view name) {
  return testing::TempDir() + "lode_surface_" + std::to_string(::getpid()) + "_" +
         std::string(name);
}

inline std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline void make_file(const std::string& path, std::string_view bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// Reads a file of these bytes, whose format the extension names.
inline Result<Surface> read_bytes(std::string_view extension, std::string_view bytes) {
  const std::string path = temporary_path("bytes") + std::string(extension);
  make_file(path, bytes);
  Result<Surface> surface = read_surface(path);
  ::unlink(path.c_str());
  return surface;
}

/// What the reader says against these bytes; empty when it accepts them.
inline std::string complaint_about(std::string_view extension, std::string_view bytes) {
  const Result<Surface> surface = read_bytes(extension, bytes);
  return surface ? "" : surface.error().message;
}

/// n × n vertices with normals and isovalues; coordinates use all bits of a float. The vertices
/// are in the order in which the triangles name them first, as STL gives them back.
inline Surface make_torus(std::uint32_t n) {
  constexpr double kTurn = 6.283185307179586;
  Surface torus;
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t k = 0; k < n; ++k) {
      const double u = kTurn * i / n;
      const double v = kTurn * k / n;
      const Vec3d normal{{std::cos(u) * std::cos(v), std::sin(u) * std::cos(v), std::sin(v)}};
      const Vec3d p = Vec3d{{std::cos(u), std::sin(u), 0}} * 3.1 + normal * 1.3;
      for (auto [out, in] : {std::pair{&torus.positions, &p}, std::pair{&torus.normals, &normal}})
        out->push_back({{static_cast<float>((*in)[0]), static_cast<float>((*in)[1]),
                         static_cast<float>((*in)[2])}});
      torus.isovalues.push_back(static_cast<float>(1000.1 + v));
    }
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t i1 = (i + 1) % n;
      const std::uint32_t k1 = (k + 1) % n;
      torus.triangles.push_back({i * n + k, i1 * n + k, i1 * n + k1});
      torus.triangles.push_back({i * n + k, i1 * n + k1, i * n + k1});
    }
  return torus;
}

inline Surface make_circle(std::uint32_t n) {
  Surface circle = make_torus(n);
  circle.positions.resize(n);
  circle.normals.clear();
  circle.isovalues.resize(n);
  circle.triangles.clear();
  for (std::uint32_t i = 0; i < n; ++i) circle.lines.push_back({i, (i + 1) % n});
  return circle;
}

inline void expect_same_surface(const Surface& a, const Surface& b) {
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.isovalues, b.isovalues);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.lines, b.lines);
}

inline void expect_written(const std::string& path, const Surface& surface,
                           const SurfaceWriteOptions& options = {}) {
  Progress progress;
  const Result<void> written = write_surface(path, surface, options, progress);
  ASSERT_TRUE(written) << written.error().message;
}

/// Writes, reads, and removes the file.
inline Surface written_and_read(const std::string& extension, const Surface& surface,
                                const SurfaceWriteOptions& options = {}) {
  const std::string path = temporary_path("round_trip") + extension;
  expect_written(path, surface, options);
  Result<Surface> read = read_surface(path);
  ::unlink(path.c_str());
  EXPECT_TRUE(read) << read.error().message;
  return read ? std::move(read).value() : Surface{};
}

}  // namespace lode::io

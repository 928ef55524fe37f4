#include "lode/io/surface_ply.h"

#include <limits>

#include "lode/io/surface_output.h"

namespace lode::io {
namespace {

constexpr std::size_t kFaceBytes = 1 + 3 * sizeof(std::uint32_t);

std::string ply_header(const Surface& surface, const SurfaceWriteOptions& options) {
  const char* coordinate = has_origin(surface) ? "double" : "float";
  const std::size_t n = surface.positions.size();
  const char* index = n > std::numeric_limits<std::int32_t>::max() ? "uint" : "int";
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  const auto add = [&]<typename... Args>(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(header), format, std::forward<Args>(args)...);
  };
  if (!options.comment.empty()) add("comment {}\n", to_one_line(options.comment));
  add("comment frame {}\n", name_of(options.frame));
  if (has_origin(surface))
    add("comment {} {} {} {}\n", kOriginNote, surface.origin[0], surface.origin[1],
        surface.origin[2]);
  add("element vertex {}\n", n);
  for (const char* name : {"x", "y", "z"}) add("property {} {}\n", coordinate, name);
  if (!surface.normals.empty())
    for (const char* name : {"nx", "ny", "nz"}) add("property float {}\n", name);
  if (!surface.isovalues.empty()) add("property float isovalue\n");
  if (surface.lines.empty())
    add("element face {}\nproperty list uchar {} vertex_indices\n", surface.triangles.size(),
        index);
  else
    add("element edge {}\nproperty {} vertex1\nproperty {} vertex2\n", surface.lines.size(), index,
        index);
  return header + "end_header\n";
}

std::size_t vertex_bytes(const Surface& surface) {
  return (has_origin(surface) ? sizeof(Vec3d) : sizeof(Vec3f)) +
         (surface.normals.empty() ? 0 : sizeof(Vec3f)) +
         (surface.isovalues.empty() ? 0 : sizeof(float));
}

/// Of all but the header.
std::uint64_t ply_bytes(const Surface& surface) {
  return surface.positions.size() * vertex_bytes(surface) + surface.triangles.size() * kFaceBytes +
         surface.lines.size() * sizeof(surface.lines[0]);
}

Result<void> write_vertex_records(SurfaceOutput& file, const Surface& surface) {
  const bool is_double = has_origin(surface);
  const bool has_normals = !surface.normals.empty();
  const bool has_isovalues = !surface.isovalues.empty();
  const auto fill = [&](std::size_t i, std::byte* out) {
    if (is_double)
      put(out, surface.world_position(static_cast<std::uint32_t>(i)));
    else
      put(out, surface.positions[i]);
    if (has_normals) put(out, surface.normals[i]);
    if (has_isovalues) put(out, surface.isovalues[i]);
  };
  return write_records(file, surface.positions.size(), vertex_bytes(surface), fill);
}

Result<void> write_face_records(SurfaceOutput& file, const Surface& surface) {
  const auto fill = [&](std::size_t i, std::byte* out) {
    put(out, std::uint8_t{3});
    put(out, surface.triangles[i]);
  };
  return write_records(file, surface.triangles.size(), kFaceBytes, fill);
}

}  // namespace

Result<void> write_ply(const std::string& path, const Surface& surface,
                       const SurfaceWriteOptions& options, Progress& progress) {
  LODE_TRY(SurfaceOutput file, SurfaceOutput::create(path, ply_bytes(surface), progress));
  LODE_CHECK(file.write(ply_header(surface, options)));
  LODE_CHECK(write_vertex_records(file, surface));
  LODE_CHECK(write_face_records(file, surface));
  LODE_CHECK(write_array(file, std::span(surface.lines)));
  return file.commit();
}

}  // namespace lode::io

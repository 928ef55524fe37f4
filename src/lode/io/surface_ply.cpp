#include "lode/io/surface_ply.h"

#include <limits>

#include "lode/io/surface_output.h"

namespace lode::io {
namespace {

std::size_t face_bytes(const Surface& surface) {
  return 1 + 3 * sizeof(std::uint32_t) + (surface.errors.empty() ? 0 : sizeof(float));
}

std::size_t line_bytes(const Surface& surface) {
  return 2 * sizeof(std::uint32_t) + (surface.errors.empty() ? 0 : sizeof(float));
}

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
  if (!surface.values.empty()) add("property double value\n");
  if (!surface.origins.empty())
    for (const char* name : {"x", "y", "z"}) add("property {} origin_{}\n", coordinate, name);
  if (surface.lines.empty())
    add("element face {}\nproperty list uchar {} vertex_indices\n", surface.triangles.size(),
        index);
  else
    add("element edge {}\nproperty {} vertex1\nproperty {} vertex2\n", surface.lines.size(), index,
        index);
  if (!surface.errors.empty()) add("property float error\n");
  return header + "end_header\n";
}

std::size_t vertex_bytes(const Surface& surface) {
  const std::size_t place_bytes = has_origin(surface) ? sizeof(Vec3d) : sizeof(Vec3f);
  return place_bytes + (surface.origins.empty() ? 0 : place_bytes) +
         (surface.normals.empty() ? 0 : sizeof(Vec3f)) +
         (surface.isovalues.empty() ? 0 : sizeof(float)) +
         (surface.values.empty() ? 0 : sizeof(double));
}

/// Of all but the header.
std::uint64_t ply_bytes(const Surface& surface) {
  return surface.positions.size() * vertex_bytes(surface) +
         surface.triangles.size() * face_bytes(surface) +
         surface.lines.size() * line_bytes(surface);
}

Result<void> write_vertex_records(SurfaceOutput& file, const Surface& surface) {
  const bool has_normals = !surface.normals.empty();
  const bool has_isovalues = !surface.isovalues.empty();
  const bool has_values = !surface.values.empty();
  const bool has_origins = !surface.origins.empty();
  const auto put_place = [&, is_double = has_origin(surface)](std::byte*& out, const Vec3f& place) {
    if (is_double)
      put(out, world_place(surface, place));
    else
      put(out, place);
  };
  const auto fill = [&](std::size_t i, std::byte* out) {
    put_place(out, surface.positions[i]);
    if (has_normals) put(out, surface.normals[i]);
    if (has_isovalues) put(out, surface.isovalues[i]);
    if (has_values) put(out, surface.values[i]);
    if (has_origins) put_place(out, surface.origins[i]);
  };
  return write_records(file, surface.positions.size(), vertex_bytes(surface), fill);
}

Result<void> write_face_records(SurfaceOutput& file, const Surface& surface) {
  const bool has_errors = !surface.errors.empty();
  const auto fill = [&](std::size_t i, std::byte* out) {
    put(out, std::uint8_t{3});
    put(out, surface.triangles[i]);
    if (has_errors) put(out, surface.errors[i]);
  };
  return write_records(file, surface.triangles.size(), face_bytes(surface), fill);
}

Result<void> write_line_records(SurfaceOutput& file, const Surface& surface) {
  if (surface.errors.empty()) return write_array(file, std::span(surface.lines));
  const auto fill = [&](std::size_t i, std::byte* out) {
    put(out, surface.lines[i]);
    put(out, surface.errors[i]);
  };
  return write_records(file, surface.lines.size(), line_bytes(surface), fill);
}

}  // namespace

Result<void> write_ply(const std::string& path, const Surface& surface,
                       const SurfaceWriteOptions& options, Progress& progress) {
  LODE_TRY(SurfaceOutput file, SurfaceOutput::create(path, ply_bytes(surface), progress));
  LODE_CHECK(file.write(ply_header(surface, options)));
  LODE_CHECK(write_vertex_records(file, surface));
  LODE_CHECK(write_face_records(file, surface));
  LODE_CHECK(write_line_records(file, surface));
  return file.commit();
}

}  // namespace lode::io

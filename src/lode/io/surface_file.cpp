#include "lode/io/surface_file.h"

#include <algorithm>
#include <array>
#include <new>
#include <string_view>
#include <utility>

#include "lode/core/out_of_memory.h"
#include "lode/io/surface_glb.h"
#include "lode/io/surface_obj.h"
#include "lode/io/surface_ply.h"
#include "lode/io/surface_ply_reader.h"
#include "lode/io/surface_stl.h"
#include "lode/io/surface_stream_parts.h"
#include "lode/io/surface_vtp.h"
#include "lode/io/surface_vtp_reader.h"

namespace lode::io {
namespace {

/// Formats of floats have no other places.
Result<PlacedSurface> read_placed_stl(const std::string& path) {
  LODE_TRY(Surface surface, read_stl(path));
  return PlacedSurface{std::move(surface)};
}

Result<PlacedSurface> read_placed_glb(const std::string& path) {
  LODE_TRY(Surface surface, read_glb(path));
  return PlacedSurface{std::move(surface)};
}

struct SurfaceFormat {
  std::string_view extension;
  bool holds_isovalues;
  bool holds_values;
  bool holds_lines;
  bool holds_places;
  Result<void> (*write)(const std::string&, const Surface&, const SurfaceWriteOptions&, Progress&);
  Result<PlacedSurface> (*read)(const std::string&);
  Result<std::unique_ptr<SurfaceStream>> (*stream)(const std::string&, std::uint64_t, Threads,
                                                   Progress&);
};

constexpr std::array kFormats{
    SurfaceFormat{".ply", true, true, true, true, write_ply, read_ply, stream_ply},
    SurfaceFormat{".stl", false, false, false, false, write_stl, read_placed_stl, stream_stl},
    SurfaceFormat{".obj", false, false, true, true, write_obj, read_obj, nullptr},
    SurfaceFormat{".vtp", true, true, true, true, write_vtp, read_vtp, stream_vtp},
    SurfaceFormat{".glb", true, false, true, false, write_glb, read_placed_glb, nullptr},
};

std::string extension_of(const std::string& path) {
  const std::size_t name = path.find_last_of('/') + 1;  // npos + 1 is 0: no directory.
  const std::size_t dot = path.rfind('.');
  if (dot == std::string::npos || dot < name) return "";
  std::string extension = path.substr(dot);
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

const SurfaceFormat* find_format(const std::string& path) {
  const std::string extension = extension_of(path);
  const auto found =
      std::find_if(kFormats.begin(), kFormats.end(),
                   [&](const SurfaceFormat& format) { return format.extension == extension; });
  return found == kFormats.end() ? nullptr : &*found;
}

}  // namespace

Result<void> check_surface_path(const std::string& path) {
  if (find_format(path) != nullptr) return {};
  const std::string extension = extension_of(path);
  return fail("{}: expected a surface file (.ply, .stl, .obj, .vtp or .glb), got {}", path,
              extension.empty() ? "no extension" : "extension " + extension);
}

bool can_hold_isovalues(const std::string& path) {
  const SurfaceFormat* format = find_format(path);
  return format != nullptr && format->holds_isovalues;
}

bool has_narrow_isovalues(const std::string& path) { return extension_of(path) == ".glb"; }

bool can_hold_values(const std::string& path) {
  const SurfaceFormat* format = find_format(path);
  return format != nullptr && format->holds_values;
}

bool can_hold_lines(const std::string& path) {
  const SurfaceFormat* format = find_format(path);
  return format != nullptr && format->holds_lines;
}

bool can_hold_places(const std::string& path) {
  const SurfaceFormat* format = find_format(path);
  return format != nullptr && format->holds_places;
}

Result<void> write_surface(const std::string& path, const Surface& surface,
                           const SurfaceWriteOptions& options, Progress& progress) try {
  LODE_EXPECTS(surface.triangles.empty() || surface.lines.empty());
  LODE_EXPECTS(options.places.empty() || options.places.size() == surface.positions.size());
  LODE_EXPECTS(surface.normals.empty() || surface.normals.size() == surface.positions.size());
  LODE_EXPECTS(surface.isovalues.empty() || surface.isovalues.size() == surface.positions.size());
  LODE_EXPECTS(surface.values.empty() || surface.values.size() == surface.positions.size());
  LODE_EXPECTS(surface.origins.empty() || surface.origins.size() == surface.positions.size());
  LODE_EXPECTS(surface.patches.empty() || surface.patch_marks.size() == surface.triangles.size());
  LODE_EXPECTS(surface.regions.empty() ||
               surface.regions.size() == surface.triangles.size() + surface.lines.size());
  LODE_EXPECTS(surface.errors.empty() ||
               surface.errors.size() == surface.triangles.size() + surface.lines.size());
  LODE_CHECK(check_surface_path(path));
  return find_format(path)->write(path, surface, options, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("write the surface", path);
}

bool can_stream(const std::string& path) {
  const SurfaceFormat* format = find_format(path);
  return format != nullptr && format->stream != nullptr;
}

Result<std::unique_ptr<SurfaceStream>> stream_surface(const std::string& path,
                                                      std::uint64_t memory_bytes, Threads threads,
                                                      Progress& progress) {
  LODE_CHECK(check_surface_path(path));
  LODE_EXPECTS(can_stream(path));
  return find_format(path)->stream(path, memory_bytes, threads, progress);
}

Result<PlacedSurface> read_placed_surface(const std::string& path) try {
  LODE_CHECK(check_surface_path(path));
  return find_format(path)->read(path);
} catch (const std::bad_alloc&) {
  return out_of_memory("read the surface", path);
}

Result<Surface> read_surface(const std::string& path) {
  LODE_TRY(PlacedSurface placed, read_placed_surface(path));
  return std::move(placed.surface);
}

}  // namespace lode::io

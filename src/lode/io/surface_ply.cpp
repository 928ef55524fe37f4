#include "lode/io/surface_ply.h"

#include <algorithm>
#include <limits>
#include <string_view>

#include "lode/io/waiting_stream.h"

namespace lode::io {
namespace {

/// Of a triangle or line, beside its corners.
std::size_t fact_bytes(const SurfaceLayout& layout) {
  return (layout.has_errors ? sizeof(float) : 0) + (layout.has_regions ? sizeof(double) : 0);
}

std::size_t face_bytes(const SurfaceLayout& layout) {
  return 1 + 3 * sizeof(std::uint32_t) + fact_bytes(layout);
}

std::size_t line_bytes(const SurfaceLayout& layout) {
  return 2 * sizeof(std::uint32_t) + fact_bytes(layout);
}

/// One word, and none that says something else of a vertex, here or in other programs.
std::string property_name(std::string name) {
  std::ranges::replace_if(
      name, [](unsigned char c) { return c <= ' ' || c == 0x7F; }, '_');
  constexpr std::string_view kOthers =
      " x y z nx ny nz u v s t texture_u texture_v r g b a red green blue alpha diffuse_red "
      "diffuse_green diffuse_blue diffuse_alpha quality confidence flags radius isovalue value "
      "origin_x origin_y origin_z ";
  const bool is_other = kOthers.find(" " + name + " ") != std::string_view::npos;
  return name.empty() || is_other ? "field_" + name : name;
}

/// Each once.
std::vector<std::string> property_names(const std::vector<std::string>& names) {
  std::vector<std::string> found;
  for (const std::string& name : names) {
    const std::string first = property_name(name);
    std::string next = first;
    for (int i = 2; std::ranges::find(found, next) != found.end(); ++i)
      next = fmt::format("{}_{}", first, i);
    found.push_back(next);
  }
  return found;
}

std::string ply_header(const SurfaceLayout& layout, const SurfaceWriteOptions& options) {
  const char* coordinate = layout.is_double() ? "double" : "float";
  const std::uint64_t n = layout.n_vertices;
  const char* index = n > std::numeric_limits<std::int32_t>::max() ? "uint" : "int";
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  const auto add = [&]<typename... Args>(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(header), format, std::forward<Args>(args)...);
  };
  if (!options.comment.empty()) add("comment {}\n", to_one_line(options.comment));
  add("comment frame {}\n", name_of(options.frame));
  if (layout.has_origin())
    add("comment {} {} {} {}\n", kOriginNote, layout.origin[0], layout.origin[1], layout.origin[2]);
  add("element vertex {}\n", n);
  for (const char* name : {"x", "y", "z"}) add("property {} {}\n", coordinate, name);
  if (layout.has_normals)
    for (const char* name : {"nx", "ny", "nz"}) add("property float {}\n", name);
  if (layout.has_isovalues) add("property double isovalue\n");
  if (layout.has_values) add("property double value\n");
  if (layout.has_origins)
    for (const char* name : {"x", "y", "z"}) add("property {} origin_{}\n", coordinate, name);
  for (const std::string& name : property_names(layout.attributes))
    add("property double {}\n", name);
  if (layout.n_lines == 0)
    add("element face {}\nproperty list uchar {} vertex_indices\n", layout.n_triangles, index);
  else
    add("element edge {}\nproperty {} vertex1\nproperty {} vertex2\n", layout.n_lines, index,
        index);
  if (layout.has_errors) add("property float error\n");
  // PLY has no integers of 64 bits.
  if (layout.has_regions) add("property double region\n");
  return header + "end_header\n";
}

std::size_t place_bytes(const SurfaceLayout& layout) {
  return layout.is_double() ? sizeof(Vec3d) : sizeof(Vec3f);
}

std::size_t vertex_bytes(const SurfaceLayout& layout) {
  const std::size_t place = place_bytes(layout);
  return place + (layout.has_origins ? place : 0) + (layout.has_normals ? sizeof(Vec3f) : 0) +
         (layout.has_isovalues ? sizeof(double) : 0) + (layout.has_values ? sizeof(double) : 0) +
         layout.attributes.size() * sizeof(double);
}

/// Of all but the header.
std::uint64_t ply_bytes(const SurfaceLayout& layout) {
  return layout.n_vertices * vertex_bytes(layout) + layout.n_triangles * face_bytes(layout) +
         layout.n_lines * line_bytes(layout);
}

/// The first n vertices; `places`: all or none.
template <typename Output>
Result<void> write_vertex_records(Output& file, const Surface& surface, std::size_t n,
                                  std::span<const Vec3d> places = {}) {
  const SurfaceLayout layout = SurfaceLayout::of(surface, places);
  const auto put_place = [&](std::byte*& out, const Vec3f& place) {
    if (layout.is_double())
      put(out, world_place(surface, place));
    else
      put(out, place);
  };
  const auto fill = [&](std::size_t i, std::byte* out) {
    if (layout.has_places)
      put(out, places[i]);
    else
      put_place(out, surface.positions[i]);
    if (layout.has_normals) put(out, surface.normals[i]);
    if (layout.has_isovalues) put(out, surface.isovalues[i]);
    if (layout.has_values) put(out, surface.values[i]);
    if (layout.has_origins) put_place(out, surface.origins[i]);
    for (const Attribute& attribute : surface.attributes) put(out, attribute.values[i]);
  };
  return write_records(file, n, vertex_bytes(layout), fill);
}

/// Triangles and lines; number(cell) gives them their corners' numbers in the file.
template <typename Output, typename Number>
Result<void> write_cell_records(Output& file, const Surface& surface, const Number& number) {
  const SurfaceLayout layout = SurfaceLayout::of(surface);
  const auto put_facts = [&](std::byte*& out, std::size_t i) {
    if (layout.has_errors) put(out, surface.errors[i]);
    if (layout.has_regions) put(out, static_cast<double>(surface.regions[i]));
  };
  const auto fill_face = [&](std::size_t i, std::byte* out) {
    put(out, std::uint8_t{3});
    put(out, number(surface.triangles[i]));
    put_facts(out, i);
  };
  const auto fill_line = [&](std::size_t i, std::byte* out) {
    put(out, number(surface.lines[i]));
    put_facts(out, i);
  };
  LODE_CHECK(write_records(file, surface.triangles.size(), face_bytes(layout), fill_face));
  return write_records(file, surface.lines.size(), line_bytes(layout), fill_line);
}

/// Vertices come before all cells: both wait.
class PlyStream : public WaitingStream {
 public:
  PlyStream(const std::string& path, std::uint64_t memory_bytes, Threads threads,
            Progress& progress)
      : WaitingStream(memory_bytes),
        path_(path),
        progress_(progress),
        vertices_(directory_of(path), threads),
        cells_(directory_of(path), threads) {}

  Result<void> finish(const SurfaceWriteOptions& options) override {
    LODE_TRY(SurfaceOutput file,
             SurfaceOutput::create(path_, ply_bytes(layout()), progress_, options.threads));
    LODE_CHECK(file.write(ply_header(layout(), options)));
    if (is_spooled()) {
      LODE_CHECK(copy(vertices_, file));
      LODE_CHECK(copy(cells_, file));
    }
    for (const SurfacePiece& piece : pieces())
      LODE_CHECK(write_vertex_records(file, piece.surface, piece.n_new()));
    for (const SurfacePiece& piece : pieces()) LODE_CHECK(write_cells(file, piece));
    return file.commit();
  }

 private:
  template <typename Output>
  static Result<void> write_cells(Output& output, const SurfacePiece& piece) {
    return write_cell_records(output, piece.surface,
                              [&](const auto& cell) { return numbered(piece, cell); });
  }
  Result<void> spool(const SurfacePiece& piece) override {
    LODE_CHECK(write_vertex_records(vertices_, piece.surface, piece.n_new()));
    return write_cells(cells_, piece);
  }
  void set_spooled_normal(const VertexNormal& n) override {
    vertices_.replace(n.vertex * std::uint64_t{vertex_bytes(layout())} + place_bytes(layout()),
                      std::as_bytes(std::span(&n.normal, 1)));
  }

  std::string path_;
  Progress& progress_;
  PatchedSpool vertices_;
  PatchedSpool cells_;
};

}  // namespace

Result<void> write_ply(const std::string& path, const Surface& surface,
                       const SurfaceWriteOptions& options, Progress& progress) {
  const SurfaceLayout layout = SurfaceLayout::of(surface, options.places);
  LODE_TRY(SurfaceOutput file,
           SurfaceOutput::create(path, ply_bytes(layout), progress, options.threads));
  LODE_CHECK(file.write(ply_header(layout, options)));
  LODE_CHECK(write_vertex_records(file, surface, surface.positions.size(), options.places));
  LODE_CHECK(write_cell_records(file, surface, [](const auto& cell) { return cell; }));
  return file.commit();
}

Result<std::unique_ptr<SurfaceStream>> stream_ply(const std::string& path,
                                                  std::uint64_t memory_bytes, Threads threads,
                                                  Progress& progress) {
  return std::unique_ptr<SurfaceStream>(
      std::make_unique<PlyStream>(path, memory_bytes, threads, progress));
}

}  // namespace lode::io

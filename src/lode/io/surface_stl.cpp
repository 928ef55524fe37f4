#include "lode/io/surface_stl.h"

#include <array>
#include <bit>
#include <cstring>
#include <limits>

#include "lode/io/surface_input.h"
#include "lode/io/surface_stream_parts.h"

namespace lode::io {
namespace {

constexpr std::size_t kStlHeaderBytes = 80;
constexpr std::size_t kCountEnd = kStlHeaderBytes + 4;
constexpr std::size_t kFacetBytes = 50;

Vec3f facet_normal(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const Vec3d p{{a[0], a[1], a[2]}};
  const Vec3d u = Vec3d{{b[0], b[1], b[2]}} - p;
  const Vec3d v = Vec3d{{c[0], c[1], c[2]}} - p;
  const Vec3d n = normalized(cross(u, v));
  return {{static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])}};
}

Error too_coarse(const std::string& path, const Vec3d& origin) {
  return fail(
      "{}: STL holds float32 coordinates only, too coarse for this surface near ({}, {}, {}); "
      "expected .ply, .obj, .vtp or .glb",
      path, origin[0], origin[1], origin[2]);
}

Error too_many(const std::string& path, std::uint64_t n_triangles) {
  return fail("{}: STL holds fewer than 2^32 triangles, and this surface has {}", path,
              n_triangles);
}

Result<void> check_can_hold(const std::string& path, const Surface& surface) {
  if (!surface.lines.empty())
    return fail(
        "{}: STL holds triangles only, and this surface is {} contour lines; expected .ply, "
        ".obj, .vtp or .glb",
        path, surface.lines.size());
  // An empty surface has no coordinates that could be too coarse.
  if (has_origin(surface) && !surface.is_empty()) return too_coarse(path, surface.origin);
  if (surface.triangles.size() > std::numeric_limits<std::uint32_t>::max())
    return too_many(path, surface.triangles.size());
  return {};
}

/// 80 bytes that do not start with "solid", which would make the file look like ASCII STL. What of
/// the comment does not fit is left out from a comma on: a number that is cut is another one.
std::string stl_header(const SurfaceWriteOptions& options) {
  std::string header = "binary STL";
  if (options.frame != Frame::unknown) header += fmt::format(", frame {}", name_of(options.frame));
  if (!options.comment.empty()) header += ", " + to_one_line(options.comment);
  if (header.size() > kStlHeaderBytes) header.resize(header.rfind(", ", kStlHeaderBytes));
  header.resize(kStlHeaderBytes, ' ');
  return header;
}

std::string count_bytes(std::uint32_t n) {
  std::string bytes(sizeof(n), '\0');
  std::memcpy(bytes.data(), &n, sizeof(n));
  return bytes;
}

/// The triangles as facets.
Result<void> write_facets(SurfaceOutput& file, const Surface& surface) {
  const auto fill = [&](std::size_t i, std::byte* out) {
    const auto [a, b, c] = surface.triangles[i];
    const std::array<Vec3f, 3> corners = {surface.positions[a], surface.positions[b],
                                          surface.positions[c]};
    put(out, facet_normal(corners[0], corners[1], corners[2]));
    put(out, corners);
    put(out, std::uint16_t{0});
  };
  return write_records(file, surface.triangles.size(), kFacetBytes, fill);
}

/// Facets go to the file as they come; how many, and what made them, is noted at its start last.
class StlStream : public SurfaceStream {
 public:
  StlStream(std::string path, SurfaceOutput file)
      : path_(std::move(path)), file_(std::move(file)) {}

  Result<void> add(SurfacePiece piece) override {
    LODE_CHECK(check_can_hold(path_, piece.surface));
    note(piece, layout_);
    if (layout_.n_triangles > std::numeric_limits<std::uint32_t>::max())
      return too_many(path_, layout_.n_triangles);
    return write_facets(file_, piece.surface);
  }
  void set_normals(std::span<const VertexNormal>) override {}
  [[nodiscard]] std::uint32_t n_vertices() const override {
    return static_cast<std::uint32_t>(layout_.n_vertices);
  }
  Result<void> finish(const SurfaceWriteOptions& options) override {
    LODE_CHECK(file_.write_at(
        0, stl_header(options) + count_bytes(static_cast<std::uint32_t>(layout_.n_triangles))));
    return file_.commit();
  }

 private:
  std::string path_;
  SurfaceOutput file_;
  SurfaceLayout layout_;
};

/// Numbers points in the order of first appearance; equal coordinates get equal numbers.
class PointNumbering {
 public:
  PointNumbering() : slots_(std::size_t{1} << 10, kFree) {}

  std::uint32_t number_of(Vec3f point) {
    for (std::size_t k = 0; k < 3; ++k) point[k] += 0.0F;  // -0 and 0 are equal.
    if (points_.size() * 2 >= slots_.size()) grow();
    std::uint32_t& slot = slots_[find(point)];
    if (slot == kFree) {
      slot = static_cast<std::uint32_t>(points_.size());
      points_.push_back(point);
    }
    return slot;
  }

  [[nodiscard]] std::vector<Vec3f> take_points() { return std::move(points_); }

 private:
  using Bits = std::array<std::uint32_t, 3>;
  static constexpr std::uint32_t kFree = ~std::uint32_t{0};

  /// The slot of a point: the one that holds it, or the free one where it belongs.
  [[nodiscard]] std::size_t find(const Vec3f& point) const {
    const Bits bits = std::bit_cast<Bits>(point);
    std::uint64_t hash = 0;
    for (const std::uint32_t word : bits) {
      hash = (hash ^ word) * 0x9e3779b97f4a7c15U;
      hash ^= hash >> 32;
    }
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = hash & mask;
    while (slots_[slot] != kFree && std::bit_cast<Bits>(points_[slots_[slot]]) != bits)
      slot = (slot + 1) & mask;
    return slot;
  }

  void grow() {
    slots_.assign(slots_.size() * 2, kFree);
    for (std::size_t i = 0; i < points_.size(); ++i)
      slots_[find(points_[i])] = static_cast<std::uint32_t>(i);
  }

  std::vector<std::uint32_t> slots_;
  std::vector<Vec3f> points_;
};

Result<Surface> read_binary(const std::string& path, std::span<const std::byte> bytes) {
  const std::size_t n = (bytes.size() - kCountEnd) / kFacetBytes;
  if (n > std::numeric_limits<std::uint32_t>::max() / 3)
    return fail("{}: expected at most 2^32 corners, got {} triangles", path, n);
  Surface surface;
  surface.triangles.resize(n);
  PointNumbering numbering;
  for (std::size_t i = 0; i < n; ++i) {
    std::array<Vec3f, 3> corners;
    std::memcpy(&corners, bytes.data() + kCountEnd + i * kFacetBytes + sizeof(Vec3f),
                sizeof(corners));
    for (std::size_t k = 0; k < 3; ++k) surface.triangles[i][k] = numbering.number_of(corners[k]);
  }
  surface.positions = numbering.take_points();
  LODE_CHECK(check_surface(path, surface));
  return surface;
}

Result<Surface> read_ascii(const std::string& path, std::string_view text) {
  Surface surface;
  PointNumbering numbering;
  std::vector<std::uint32_t> corners;
  bool is_finished = false;
  for (std::size_t n_lines = 1; !text.empty(); ++n_lines) {
    std::string_view line = next_line(text);
    const std::string_view keyword = next_word(line);
    if (!keyword.empty()) is_finished = keyword == "endsolid";
    if (keyword == "vertex") {
      Vec3f point;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::optional<float> value = to_float(next_word(line));
        if (!value) return fail("{}: line {}: expected three coordinates", path, n_lines);
        point[k] = *value;
      }
      corners.push_back(numbering.number_of(point));
    } else if (keyword == "endloop") {
      LODE_CHECK(append_polygon(path, corners, surface));
      corners.clear();
    }
  }
  if (!is_finished || !corners.empty())
    return fail("{}: expected \"endsolid\" at the end of an ASCII STL file; it is cut off", path);
  surface.positions = numbering.take_points();
  LODE_CHECK(check_surface(path, surface));
  return surface;
}

}  // namespace

Result<void> write_stl(const std::string& path, const Surface& surface,
                       const SurfaceWriteOptions& options, Progress& progress) {
  LODE_CHECK(check_can_hold(path, surface));
  LODE_TRY(SurfaceOutput file,
           SurfaceOutput::create(path, kCountEnd + kFacetBytes * surface.triangles.size(), progress,
                                 options.threads));
  LODE_CHECK(file.write(stl_header(options) +
                        count_bytes(static_cast<std::uint32_t>(surface.triangles.size()))));
  LODE_CHECK(write_facets(file, surface));
  return file.commit();
}

Result<std::unique_ptr<SurfaceStream>> stream_stl(const std::string& path,
                                                  std::uint64_t /*memory_bytes*/, Threads threads,
                                                  Progress& progress) {
  LODE_TRY(SurfaceOutput file, SurfaceOutput::create(path, 0, progress, threads));
  LODE_CHECK(file.write(std::string(kCountEnd, ' ')));
  return std::unique_ptr<SurfaceStream>(std::make_unique<StlStream>(path, std::move(file)));
}

Result<Surface> read_stl(const std::string& path) {
  LODE_TRY(const SurfaceBytes file, SurfaceBytes::load(path));
  const std::span<const std::byte> bytes = file.bytes();
  std::uint32_t n = 0;
  if (bytes.size() >= kCountEnd) std::memcpy(&n, bytes.data() + kStlHeaderBytes, sizeof(n));
  // The size decides first: many binary files start with "solid" too.
  if (bytes.size() >= kCountEnd && bytes.size() == kCountEnd + std::uint64_t{n} * kFacetBytes)
    return read_binary(path, bytes);
  if (file.text().starts_with("solid")) return read_ascii(path, file.text());
  return fail("{}: expected an STL file of {} bytes for its {} triangles, got {} bytes", path,
              kCountEnd + std::uint64_t{n} * kFacetBytes, n, bytes.size());
}

}  // namespace lode::io

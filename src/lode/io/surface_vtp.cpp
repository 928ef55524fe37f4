#include "lode/io/surface_vtp.h"

#include <limits>
#include <optional>

#include "lode/io/mesh_patches.h"
#include "lode/io/vector_arrays.h"
#include "lode/io/vtk_xml_output.h"
#include "lode/io/waiting_stream.h"

namespace lode::io {
namespace {

/// The arrays of a file in the order of their data. Unused ones are left out.
struct VtpLayout {
  std::optional<VtkXmlArray> values;
  std::vector<ArrayOfFields> more;      ///< Attributes, and vectors of them,
  std::vector<VtkXmlArray> attributes;  ///< likewise.
  std::optional<VtkXmlArray> isovalues;
  std::optional<VtkXmlArray> normals;
  std::optional<VtkXmlArray> origins;
  std::optional<VtkXmlArray> errors;
  std::optional<VtkXmlArray> regions;
  std::optional<VtkXmlArray> patches;
  VtkXmlArray points;
  VtkXmlArray connectivity;
  VtkXmlArray offsets;
};

std::size_t corners_per_cell(const SurfaceLayout& surface) { return surface.n_lines == 0 ? 3 : 2; }

bool needs_wide_indices(const SurfaceLayout& surface) {
  constexpr std::uint64_t kMax = std::numeric_limits<std::int32_t>::max();
  return surface.n_vertices > kMax || surface.n_corners() > kMax;
}

VtpLayout make_vtp_layout(const SurfaceLayout& surface, const SurfaceWriteOptions& options) {
  const bool is_double = surface.is_double();
  const char* coordinate = is_double ? "Float64" : "Float32";
  const std::uint64_t n = surface.n_vertices;
  const std::uint64_t point_bytes = n * (is_double ? sizeof(Vec3d) : sizeof(Vec3f));
  const std::uint64_t index_bytes = needs_wide_indices(surface) ? 8 : 4;
  const char* index = index_bytes == 8 ? "Int64" : "Int32";
  VtpLayout layout;
  if (surface.has_values)
    layout.values = {fmt::format(R"(type="Float64" Name="{}")", vtk_array_name(options.value_name)),
                     n * sizeof(double)};
  layout.more =
      arrays_of_fields(surface.has_values ? options.value_name : std::string(), surface.attributes);
  for (const ArrayOfFields& array : layout.more)
    layout.attributes.push_back(
        {fmt::format(R"(type="Float64" Name="{}"{})", vtk_array_name(array.name),
                     array.fields.size() > 1 ? R"( NumberOfComponents="3")" : ""),
         n * array.fields.size() * sizeof(double)});
  if (surface.has_isovalues)
    layout.isovalues = {R"(type="Float64" Name="isovalue")", n * sizeof(double)};
  if (surface.has_normals)
    layout.normals = {R"(type="Float32" Name="Normals" NumberOfComponents="3")", n * sizeof(Vec3f)};
  if (surface.has_origins)
    layout.origins = {fmt::format(R"(type="{}" Name="origin" NumberOfComponents="3")", coordinate),
                      point_bytes};
  if (surface.has_errors)
    layout.errors = {R"(type="Float32" Name="error")", surface.n_cells() * sizeof(float)};
  if (surface.has_regions)
    layout.regions = {R"(type="Int64" Name="RegionId")", surface.n_cells() * sizeof(std::int64_t)};
  if (!surface.patches.empty())
    layout.patches = {R"(type="Int64" Name="PatchId")", surface.n_cells() * sizeof(std::int64_t)};
  layout.points = {fmt::format(R"(type="{}" Name="Points" NumberOfComponents="3")", coordinate),
                   point_bytes};
  layout.connectivity = {fmt::format(R"(type="{}" Name="connectivity")", index),
                         surface.n_corners() * index_bytes};
  layout.offsets = {fmt::format(R"(type="{}" Name="offsets")", index),
                    surface.n_cells() * index_bytes};
  return layout;
}

std::uint64_t bytes_of(const std::optional<VtkXmlArray>& array) {
  return array ? array->n_bytes : 0;
}

/// Of the arrays, without the XML.
std::uint64_t vtp_bytes(const VtpLayout& layout) {
  std::uint64_t n = 0;
  for (const VtkXmlArray& array : layout.attributes) n += array.n_bytes;
  return n + bytes_of(layout.values) + bytes_of(layout.isovalues) + bytes_of(layout.normals) +
         bytes_of(layout.origins) + bytes_of(layout.errors) + bytes_of(layout.regions) +
         bytes_of(layout.patches) + layout.points.n_bytes + layout.connectivity.n_bytes +
         layout.offsets.n_bytes;
}

std::string vtp_head(const SurfaceLayout& surface, const SurfaceWriteOptions& options) {
  std::string xml = vtk_xml_head("PolyData", options.comment, options.frame);
  const std::string names = vtk_time(options.time) + vtk_region_names(surface.region_names) +
                            vtk_patch_names(surface.patches);
  const bool has_notes = surface.has_origin() || !names.empty();
  if (has_notes) xml += "<FieldData>\n";
  if (surface.has_origin())
    xml += fmt::format(
        "<DataArray type=\"Float64\" Name=\"{}\" NumberOfComponents=\"3\" "
        "NumberOfTuples=\"1\" format=\"ascii\">{} {} {}</DataArray>\n",
        kOriginNote, surface.origin[0], surface.origin[1], surface.origin[2]);
  xml += names;
  if (has_notes) xml += "</FieldData>\n";
  xml += fmt::format(
      "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"{}\" "
      "NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n",
      surface.n_vertices, surface.n_lines, surface.n_triangles);
  return xml;
}

std::string vtp_piece(const SurfaceLayout& surface, const SurfaceWriteOptions& options,
                      const VtpLayout& layout) {
  const char* cells = surface.n_lines == 0 ? "Polys" : "Lines";
  std::uint64_t offset = 0;
  std::string xml = "<PointData";
  if (layout.values)
    xml += fmt::format(" Scalars=\"{}\"", vtk_array_name(options.value_name));
  else if (layout.isovalues)
    xml += " Scalars=\"isovalue\"";
  if (layout.normals) xml += " Normals=\"Normals\"";
  xml += ">\n";
  for (const auto* array : {&layout.values, &layout.isovalues, &layout.normals, &layout.origins})
    if (*array) xml += describe_array(**array, offset);
  for (const VtkXmlArray& array : layout.attributes) xml += describe_array(array, offset);
  xml += "</PointData>\n";
  if (layout.errors || layout.regions || layout.patches) {
    xml += "<CellData>\n";
    for (const auto* array : {&layout.errors, &layout.regions, &layout.patches})
      if (*array) xml += describe_array(**array, offset);
    xml += "</CellData>\n";
  }
  xml += "<Points>\n" + describe_array(layout.points, offset) + "</Points>\n";
  xml += fmt::format("<{}>\n", cells) + describe_array(layout.connectivity, offset);
  xml += describe_array(layout.offsets, offset) + fmt::format("</{}>\n", cells);
  xml += "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
  return xml;
}

/// A size and an array, where there is one.
template <typename T>
Result<void> write_optional(SurfaceOutput& file, const std::optional<VtkXmlArray>& array,
                            const std::vector<T>& data) {
  if (!array) return {};
  LODE_CHECK(write_array_size(file, *array));
  return write_array(file, std::span(data));
}

/// As points are: in world units where these are doubles.
template <typename Output>
Result<void> write_places(Output& file, const Surface& surface, std::span<const Vec3f> places,
                          bool is_double) {
  if (!is_double) return write_array(file, places);
  const auto fill = [&](std::size_t i, std::byte* out) {
    put(out, world_place(surface, places[i]));
  };
  return write_records(file, places.size(), sizeof(Vec3d), fill);
}

/// 0 of triangles of no patch.
Result<void> write_patches(SurfaceOutput& file, const Surface& surface, const VtpLayout& layout) {
  if (!layout.patches) return {};
  LODE_CHECK(write_array_size(file, *layout.patches));
  return write_records(file, surface.patch_marks.size(), sizeof(std::int64_t),
                       [&](std::size_t i, std::byte* out) {
                         const std::uint32_t mark = surface.patch_marks[i];
                         put(out, mark == 0 ? std::int64_t{0} : surface.patches[mark - 1].id);
                       });
}

/// One field, or the components of a vector in turns.
Result<void> write_fields(SurfaceOutput& file, const ArrayOfFields& array, const Surface& surface) {
  const auto fields = fields_of(array, surface.values, surface.attributes);
  return write_records(file, fields.front().size(), fields.size() * sizeof(double),
                       [&](std::size_t i, std::byte* out) {
                         for (const std::span<const double> field : fields)
                           put(out, double{field[i]});
                       });
}

/// Attributes and points.
Result<void> write_point_arrays(SurfaceOutput& file, const Surface& surface,
                                std::span<const Vec3d> places, const VtpLayout& layout) {
  const bool is_double = SurfaceLayout::of(surface, places).is_double();
  LODE_CHECK(write_optional(file, layout.values, surface.values));
  LODE_CHECK(write_optional(file, layout.isovalues, surface.isovalues));
  LODE_CHECK(write_optional(file, layout.normals, surface.normals));
  if (layout.origins) {
    LODE_CHECK(write_array_size(file, *layout.origins));
    LODE_CHECK(write_places(file, surface, surface.origins, is_double));
  }
  for (std::size_t i = 0; i < layout.more.size(); ++i) {
    LODE_CHECK(write_array_size(file, layout.attributes[i]));
    LODE_CHECK(write_fields(file, layout.more[i], surface));
  }
  LODE_CHECK(write_optional(file, layout.errors, surface.errors));
  LODE_CHECK(write_optional(file, layout.regions, surface.regions));
  LODE_CHECK(write_patches(file, surface, layout));
  LODE_CHECK(write_array_size(file, layout.points));
  if (!places.empty()) return write_array(file, places);
  return write_places(file, surface, surface.positions, is_double);
}

/// Corners of the cells as T, which they may be already.
template <typename T>
Result<void> write_corners(SurfaceOutput& file, std::span<const std::uint32_t> corners) {
  if constexpr (sizeof(T) == sizeof(std::uint32_t))
    return write_array(file, corners);
  else
    return write_records(file, corners.size(), sizeof(T),
                         [&](std::size_t i, std::byte* out) { put(out, T{corners[i]}); });
}

template <typename Cell>
std::span<const std::uint32_t> corners_of(const std::vector<Cell>& cells) {
  if (cells.empty()) return {};
  return {cells.front().data(), cells.size() * cells.front().size()};
}

template <typename T>
Result<void> write_offsets(SurfaceOutput& file, const SurfaceLayout& surface,
                           const VtpLayout& layout) {
  const std::size_t n_corners = corners_per_cell(surface);
  LODE_CHECK(write_array_size(file, layout.offsets));
  return write_records(file, surface.n_cells(), sizeof(T), [&](std::size_t i, std::byte* out) {
    put(out, static_cast<T>((i + 1) * n_corners));
  });
}

/// Connectivity and offsets.
template <typename T>
Result<void> write_cell_arrays(SurfaceOutput& file, const Surface& surface,
                               const VtpLayout& layout) {
  LODE_CHECK(write_array_size(file, layout.connectivity));
  LODE_CHECK(write_corners<T>(file, corners_of(surface.triangles)));
  LODE_CHECK(write_corners<T>(file, corners_of(surface.lines)));
  return write_offsets<T>(file, SurfaceLayout::of(surface), layout);
}

constexpr std::string_view kVtpEnd = "\n</AppendedData>\n</VTKFile>\n";

/// Each array is in one place of the file: all wait.
class VtpStream : public WaitingStream {
 public:
  VtpStream(const std::string& path, std::uint64_t memory_bytes, Threads threads,
            Progress& progress)
      : WaitingStream(memory_bytes),
        path_(path),
        progress_(progress),
        normals_(directory_of(path), threads),
        points_(directory_of(path), threads),
        corners_(directory_of(path), threads) {}

  Result<void> finish(const SurfaceWriteOptions& options) override {
    const VtpLayout arrays = make_vtp_layout(layout(), options);
    LODE_TRY(SurfaceOutput file,
             SurfaceOutput::create(path_, vtp_bytes(arrays), progress_, options.threads));
    LODE_CHECK(file.write(vtp_head(layout(), options)));
    LODE_CHECK(file.write(vtp_piece(layout(), options, arrays)));
    LODE_CHECK(write_points(file, arrays));
    LODE_CHECK(needs_wide_indices(layout()) ? write_cells<std::int64_t>(file, arrays)
                                            : write_cells<std::int32_t>(file, arrays));
    LODE_CHECK(file.write(kVtpEnd));
    return file.commit();
  }

 private:
  template <typename Output>
  static Result<void> write_normals(Output& output, const SurfacePiece& piece) {
    return write_array(output, std::span(piece.surface.normals).first(piece.n_new()));
  }
  template <typename Output>
  static Result<void> write_positions(Output& output, const SurfacePiece& piece) {
    return write_places(output, piece.surface,
                        std::span(piece.surface.positions).first(piece.n_new()),
                        has_origin(piece.surface));
  }
  template <typename T, typename Output, typename Cell>
  static Result<void> write_numbered(Output& output, const SurfacePiece& piece,
                                     const std::vector<Cell>& cells) {
    constexpr std::size_t kBytes = std::tuple_size_v<Cell> * sizeof(T);
    return write_records(output, cells.size(), kBytes, [&](std::size_t i, std::byte* out) {
      for (const std::uint32_t vertex : numbered(piece, cells[i])) put(out, static_cast<T>(vertex));
    });
  }
  template <typename T, typename Output>
  static Result<void> write_corners_of(Output& output, const SurfacePiece& piece) {
    LODE_CHECK(write_numbered<T>(output, piece, piece.surface.triangles));
    return write_numbered<T>(output, piece, piece.surface.lines);
  }

  Result<void> spool(const SurfacePiece& piece) override {
    const std::size_t n = piece.n_new();
    if (layout().has_isovalues && n > 0)
      isovalues_.emplace_back(piece.surface.isovalues.front(), n);
    if (layout().has_normals) LODE_CHECK(write_normals(normals_, piece));
    LODE_CHECK(write_positions(points_, piece));
    return write_corners_of<std::uint32_t>(corners_, piece);
  }
  void set_spooled_normal(const VertexNormal& n) override {
    normals_.replace(n.vertex * std::uint64_t{sizeof(Vec3f)},
                     std::as_bytes(std::span(&n.normal, 1)));
  }

  Result<void> write_points(SurfaceOutput& file, const VtpLayout& arrays) {
    if (arrays.isovalues) LODE_CHECK(write_array_size(file, *arrays.isovalues));
    for (const auto& [isovalue, n] : isovalues_)
      LODE_CHECK(
          write_records(file, n, sizeof(double),
                        [value = isovalue](std::size_t, std::byte* out) { put(out, value); }));
    if (arrays.isovalues)
      for (const SurfacePiece& piece : pieces())
        LODE_CHECK(write_array(file, std::span(piece.surface.isovalues).first(piece.n_new())));
    if (arrays.normals) {
      LODE_CHECK(write_array_size(file, *arrays.normals));
      LODE_CHECK(copy(normals_, file));
      for (const SurfacePiece& piece : pieces()) LODE_CHECK(write_normals(file, piece));
    }
    LODE_CHECK(write_array_size(file, arrays.points));
    LODE_CHECK(copy(points_, file));
    for (const SurfacePiece& piece : pieces()) LODE_CHECK(write_positions(file, piece));
    return {};
  }
  template <typename T>
  Result<void> write_cells(SurfaceOutput& file, const VtpLayout& arrays) {
    LODE_CHECK(write_array_size(file, arrays.connectivity));
    LODE_CHECK(corners_.read(sizeof(std::uint32_t), [&](std::span<const std::byte> bytes) {
      std::vector<std::uint32_t> corners(bytes.size() / sizeof(std::uint32_t));
      std::memcpy(corners.data(), bytes.data(), bytes.size());
      return write_corners<T>(file, corners);
    }));
    for (const SurfacePiece& piece : pieces()) LODE_CHECK(write_corners_of<T>(file, piece));
    return write_offsets<T>(file, layout(), arrays);
  }

  std::string path_;
  Progress& progress_;
  std::vector<std::pair<double, std::size_t>> isovalues_;  ///< Spooled, of so many vertices each.
  PatchedSpool normals_;
  PatchedSpool points_;
  PatchedSpool corners_;
};

}  // namespace

Result<void> write_vtp(const std::string& path, const Surface& surface,
                       const SurfaceWriteOptions& options, Progress& progress) {
  const SurfaceLayout counts = SurfaceLayout::of(surface, options.places);
  const VtpLayout layout = make_vtp_layout(counts, options);
  LODE_TRY(SurfaceOutput file,
           SurfaceOutput::create(path, vtp_bytes(layout), progress, options.threads));
  LODE_CHECK(file.write(vtp_head(counts, options)));
  LODE_CHECK(file.write(vtp_piece(counts, options, layout)));
  LODE_CHECK(write_point_arrays(file, surface, options.places, layout));
  LODE_CHECK(needs_wide_indices(counts) ? write_cell_arrays<std::int64_t>(file, surface, layout)
                                        : write_cell_arrays<std::int32_t>(file, surface, layout));
  LODE_CHECK(file.write(kVtpEnd));
  return file.commit();
}

Result<std::unique_ptr<SurfaceStream>> stream_vtp(const std::string& path,
                                                  std::uint64_t memory_bytes, Threads threads,
                                                  Progress& progress) {
  return std::unique_ptr<SurfaceStream>(
      std::make_unique<VtpStream>(path, memory_bytes, threads, progress));
}

}  // namespace lode::io

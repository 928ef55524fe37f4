#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "lode/api/dataset.h"
#include "lode/api/file_build.h"
#include "lode/api/file_check.h"
#include "lode/api/isovalue_files.h"
#include "lode/api/mapped_lines.h"
#include "lode/api/mapped_terrain.h"
#include "lode/api/mesh_picture.h"
#include "lode/api/opened_terrain.h"
#include "lode/api/terrain.h"
#include "lode/api/terrain_comparison.h"
#include "lode/api/terrain_picture.h"
#include "lode/api/terrain_raster.h"
#include "lode/api/terrain_sight.h"
#include "lode/api/terrain_tiles.h"
#include "lode/api/terrain_tin.h"
#include "lode/api/tetra_dataset.h"
#include "lode/api/tile_verification.h"
#include "lode/core/vertical_unit.h"
#include "lode/io/child_program.h"
#include "lode/io/crs_map.h"
#include "lode/io/crs_metric.h"
#include "lode/io/height_reader.h"
#include "lode/io/mesh_file.h"
#include "lode/io/mesh_reader.h"
#include "lode/io/mesh_vtu.h"
#include "lode/io/network_vtp.h"
#include "lode/io/polygon_file.h"
#include "lode/io/surface_file.h"
#include "lode/io/tetrahedra.h"
#include "lode/io/vector_file.h"
#include "lode/io/volume_reader.h"
#include "lode/mappers/contour_levels.h"
#include "lode/render/camera_file.h"
#include "lode/render/camera_path.h"
#include "lode/render/surface_renderer.h"

namespace lode {

// The door's part of io, documented there. That of render is in this namespace already.
using io::AveragedField;
using io::AveragedRegion;
using io::ByteOrder;
using io::can_hold_isovalues;
using io::can_hold_lines;
using io::can_hold_places;
using io::can_hold_values;
using io::check_mesh_path;
using io::check_surface_path;
using io::check_target_crs;
using io::check_vector_path;
using io::ChildErrors;
using io::ChildProgram;
using io::ColumnType;
using io::ComponentChoice;
using io::describe_volume;
using io::FileDescription;
using io::find_program;
using io::has_depths;
using io::has_narrow_isovalues;
using io::HeightEncoding;
using io::HeightRaster;
using io::HeightReadOptions;
using io::is_geojson_path;
using io::is_geotiff_path;
using io::is_height_path;
using io::is_point_path;
using io::is_polygon_path;
using io::is_volume_path;
using io::LinearisedField;
using io::Magnitude;
using io::MagnitudeField;
using io::MeshReadOptions;
using io::MeshWriteOptions;
using io::Network;
using io::NonfiniteField;
using io::open_source_crs;
using io::open_target_crs;
using io::open_volume;
using io::PointCounts;
using io::PointReadOptions;
using io::QuadraticCells;
using io::RasterForm;
using io::RasterType;
using io::RawLayout;
using io::read_cell_mesh;
using io::read_heights;
using io::read_metric;
using io::ReadOptions;
using io::Resampling;
using io::SourceCrs;
using io::SurfaceWriteOptions;
using io::TargetCrs;
using io::TetrahedraOutcome;
using io::TetraOptions;
using io::TetraReport;
using io::to_tetrahedra;
using io::VectorColumn;
using io::VectorLayer;
using io::VectorShape;
using io::VectorValue;
using io::VectorWriter;
using io::vertical_name;
using io::VerticalOptions;
using io::VerticalOutcome;
using io::write_mesh;
using io::write_network_vtp;
using io::write_surface;
using io::write_vtu;

/// Whether `path` is to be opened as a .lode file: it is named so (any case), or starts as one.
[[nodiscard]] bool is_lode_path(const std::string& path);

/// Whether `path` is read as a mesh of cells: it is named .vtu, .vts, .msh, .mesh or .meshb, or is
/// a legacy .vtk file whose header says so.
[[nodiscard]] bool is_cell_mesh_path(const std::string& path);
/// Whether a path is a mesh of cells by its name, or a .lode file of the model tetra_mt.
[[nodiscard]] bool holds_tetrahedra(const std::string& path);

/// As io::read_surface; where a format without indices (STL) made one vertex of two with equal
/// coordinates, each fan of triangles has its own again.
[[nodiscard]] Result<Surface> read_surface(const std::string& path);
/// The same with coordinates in float64: io::read_placed_surface.
[[nodiscard]] Result<PlacedSurface> read_placed_surface(const std::string& path);

/// Extracts isosurfaces into a file, whole or not at all: piece by piece where comes_in_pieces()
/// and the format (.ply, .stl, .vtp) allow it, so that the surface may be larger than memory; the
/// same bytes come of both ways. `note(report)` is what the file says of itself. seconds.write:
/// what writing took in the end.
[[nodiscard]] Result<ExtractReport> extract_to_file(
    const Dataset& dataset, const ExtractOptions& options, const std::string& path,
    const std::function<SurfaceWriteOptions(const ExtractReport&)>& note, Progress& progress);

/// Opens a .lode file, or reads a foreign one and builds its hierarchy in memory, which costs the
/// time of a build; `options` is used by foreign files only.
[[nodiscard]] Result<Dataset> open_any(const std::string& path, const ReadOptions& options,
                                       Threads threads, Progress& progress);

/// Dataset::build() of the opened file `path`. Every failure but a cancellation names a file:
/// `path`, unless the reader has named one already.
[[nodiscard]] Result<Dataset> build_opened(const std::string& path, VolumeSource& source,
                                           const BuildOptions& options, Progress& progress);

/// build_file() of the opened file `path`, with failures named in the same way.
[[nodiscard]] Result<FileBuildReport> build_file_from(const std::string& path, VolumeSource& source,
                                                      const std::string& output,
                                                      const FileBuildOptions& options,
                                                      Progress& progress);

/// Writes a text file, whole or not at all; none once cancelled.
[[nodiscard]] Result<void> write_text(const std::string& path, std::string_view text,
                                      const Progress& progress);

/// Fails, naming `path`, unless a file can be made or replaced there. Leaves nothing behind; meant
/// to be asked before expensive work starts.
[[nodiscard]] Result<void> check_writable(const std::string& path);

}  // namespace lode

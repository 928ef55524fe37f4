#pragma once

#include <optional>
#include <span>
#include <string>

#include "lode/core/parallel.h"
#include "lode/core/placed_surface.h"
#include "lode/core/progress.h"
#include "lode/core/regular_grid.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/core/vec.h"

namespace lode::io {

struct SurfaceWriteOptions {
  std::string comment;           ///< One line for the file's header; what made it, and how.
  Frame frame = Frame::unknown;  ///< Named in the header where the format has comments.
  std::string value_name{};      ///< What VTP calls the values; empty: "value", as PLY does.
  std::optional<double> time{};  ///< Of all values, of a series; TimeValue in VTP.
  std::string node_name{};       ///< What GLB calls its node; empty: "isosurface".
  /// Metres of a unit of x, y and z, > 0: by how much GLB's node, whose unit is the metre, is
  /// larger than the positions in it. Other formats have no unit.
  Vec3d metres{{1, 1, 1}};
  /// Where vertices are, in the world and in float64, for formats that can_hold_places(); the
  /// others have positions and origin. Empty: all have.
  std::span<const Vec3d> places{};
  Threads threads{};  ///< The bytes are the same for any.
};

/// Writes a surface, whole or not at all, in the format that the extension names: .ply, .stl,
/// .obj, .vtp or .glb (any case). Normals are written everywhere but to STL, isovalues where
/// can_hold_isovalues() says so, values, origins and errors where can_hold_values() does,
/// and further attributes in .vtp and .ply. A surface
/// with an origin, or places in the options, is written with double coordinates (PLY, OBJ, VTP) or
/// with the origin as the node's translation (GLB), and, unless it is empty, refused by STL, which
/// has neither; STL also refuses lines. At least one of triangles and lines must be empty. Reports
/// the phase "writing"; cancelled until the file is in place, it leaves none.
[[nodiscard]] Result<void> write_surface(const std::string& path, const Surface& surface,
                                         const SurfaceWriteOptions& options, Progress& progress);

/// Reads a surface back: all that write_surface() writes, and usual files of other programs
/// (GLB: one mesh of one primitive only). Polygons become triangle fans, polylines segments; STL
/// corners with equal coordinates become one vertex. Coordinates that float32 cannot hold come
/// back relative to an origin: the one our writer noted, or the lower corner of the bounds.
/// Survives any bytes, in memory proportional to the file (compressed VTP: to its content).
[[nodiscard]] Result<Surface> read_surface(const std::string& path);

/// The same with the coordinates of a file of doubles, where positions do not have them exactly.
[[nodiscard]] Result<PlacedSurface> read_placed_surface(const std::string& path);

/// Whether the format that the extension names can hold coordinates in float64.
[[nodiscard]] bool can_hold_places(const std::string& path);

/// Whether the format that the extension names has a per-vertex attribute for isovalues.
[[nodiscard]] bool can_hold_isovalues(const std::string& path);
/// Whether these are float32.
[[nodiscard]] bool has_narrow_isovalues(const std::string& path);

/// Whether the format that the extension names can hold values per vertex and errors per cell.
[[nodiscard]] bool can_hold_values(const std::string& path);

/// Whether the format that the extension names can hold contour lines.
[[nodiscard]] bool can_hold_lines(const std::string& path);

/// Fails, listing the known extensions, unless `path` ends in one of them. Meant to be asked
/// before expensive work starts.
[[nodiscard]] Result<void> check_surface_path(const std::string& path);

}  // namespace lode::io

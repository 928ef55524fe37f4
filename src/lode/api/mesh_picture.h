#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lode/api/query.h"
#include "lode/core/mesh.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/mappers/section.h"
#include "lode/render/image.h"
#include "lode/render/surface_renderer.h"
#include "lode/render/transfer_function.h"

namespace lode {

/// What a picture of a mesh of tetrahedra shows, all of the same mesh, so that it fits together.
struct MeshPictureOptions {
  std::optional<TransferFunction> opacity;  ///< Direct volume rendering; unset: none.
  std::vector<double> isovalues;            ///< Opaque surfaces in it.
  std::vector<SectionPlane> sections;       ///< The same, coloured by value.
  bool has_wireframe = false;   ///< All edges of the mesh, as lines of render.line_width_px.
  bool has_points = false;      ///< All its vertices, as dots so wide.
  bool has_boundary = false;    ///< Opaque, coloured by value as sections are.
  double boundary_opacity = 0;  ///< 0..1; see VolumePicture.
  /// Place of a further field among the mesh's attributes: sections, boundary and isosurfaces have
  /// its colours. Unset: sections and boundary have those of the field.
  std::optional<std::size_t> color_attribute{};
  /// Of what is coloured by value, unless opacity has colours for the field: values of the darkest
  /// and lightest colour; what is beyond has these.
  Range colors{0, 1};
  /// The title of a legend of what is coloured by value, if anything is; empty: none.
  std::string legend;
  RenderOptions render;
};

struct MeshPictureReport {
  std::uint64_t n_triangles = 0;          ///< Of isosurfaces.
  std::uint64_t n_section_triangles = 0;  ///< Of sections.
  std::uint64_t n_boundary_triangles = 0;
  std::uint64_t n_lines = 0;    ///< Of the wireframe, and dots.
  std::vector<double> unmet{};  ///< Isovalues that no cell has.
  std::string legend_fault{};   ///< Why there is no legend.
  Camera camera;                ///< That was used.
  double seconds = 0;
};

/// A preset by its name, fitted to a range of values and the diagonal of the mesh's box, or else a
/// file of knots.
[[nodiscard]] Result<TransferFunction> to_transfer_function(const std::string& preset_or_path,
                                                            const Box3d& bounds,
                                                            const Range& range);

/// What of a mesh a picture needs, but for tolerance and budget: where it is not clear, all the
/// more accurate the more opaque, and what isosurfaces need; what the planes need of sections
/// alone; everywhere of both, and of a boundary that is coloured.
[[nodiscard]] Query query_of(const MeshPictureOptions& options);

/// Draws a mesh; see render_volume(). Without a camera a three-quarter view of all of it, whatever
/// is shown. Isosurfaces have render.color or distinct colours, unless they are coloured by value.
[[nodiscard]] Result<Image> draw_mesh(const SimplexMesh& mesh, const MeshPictureOptions& options,
                                      MeshPictureReport& report, Progress& progress);

}  // namespace lode

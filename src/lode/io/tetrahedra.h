#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"

namespace lode::io {

/// What becomes of quadratic cells: tetrahedra between all of their nodes (eight of a tetrahedron's
/// ten), or what becomes of the linear cell of their corners, as then of cells of any order.
enum class QuadraticCells { split, corners };

struct TetraOptions {
  /// "NAME": a scalar, or the magnitude of a vector; "NAME:2": a component, from 0; "NAME:mises":
  /// von Mises' scalar of a tensor of six components (xx, yy, zz first) or nine. A name is looked
  /// up among the points' fields, then the cells'. None: all of the points, or of the cells where
  /// points have none.
  std::vector<std::string> fields{};
  /// With fields: all others, too, of vectors with three components these, each a field.
  bool has_all = false;
  QuadraticCells quadratic = QuadraticCells::split;
  /// Of the cells, of whole numbers, whatever their type. None: the first of Material, MaterialId,
  /// RegionId, ObjectId, ElementBlockId, BlockId, ZoneId, gmsh:physical and medit:ref, in any case,
  /// with an s at the end or not, and with blanks, -, _ or #: "material_ids". Those of faces are
  /// patches of the boundary, unless there is a field PatchId; 0 is none.
  std::optional<std::string> region_field{};
  /// Numbers or names of the regions whose cells are taken; none: all.
  std::vector<std::string> only_regions{};
  /// Points become one that are so close (0: at one place) and whose fields, chosen or not, differ
  /// by no more than weld_values in any component; fields of whole numbers count only if chosen.
  /// None: all stay apart.
  std::optional<double> weld_distance{};
  double weld_values = 0;
};

/// What averaging over cells did to a field within a region.
struct AveragedRegion {
  std::int64_t id = 0;
  std::string name;     ///< Empty: it has none.
  double cell_min = 0;  ///< Of finite values at its cells,
  double cell_max = 0;
  double point_min = 0;  ///< and at their points, which other regions have a share in.
  double point_max = 0;
};

/// What averaging over cells did to a field.
struct AveragedField {
  std::string name;
  double cell_min = 0;  ///< Of finite values at cells that are in the mesh; 0 of none.
  double cell_max = 0;
  double point_min = 0;  ///< And at points.
  double point_max = 0;
  std::uint64_t n_nonfinite_cells = 0;
  std::uint64_t first_nonfinite = 0;  ///< Of the cells that were read, from 0.
  /// Where there are several and some have none of those: the regions that have some, and the rest.
  std::vector<std::int64_t> nonfinite_regions{};
  std::vector<std::int64_t> finite_regions{};
  /// Where there are several: those whose points have values beyond those of their cells.
  std::vector<AveragedRegion> regions{};
};

/// What of a field at nodes is left when cells are linearised, where that is less.
struct LinearisedField {
  std::string name;
  double node_min = 0;  ///< Of finite values at nodes that cells have,
  double node_max = 0;
  double corner_min = 0;  ///< and at those that are left.
  double corner_max = 0;
};

/// A field that is not a finite number everywhere.
struct NonfiniteField {
  std::string name;
  std::uint64_t n_values = 0;  ///< At vertices that are points of the file.
  std::uint64_t first = 0;     ///< The first of these, as the file numbers them, from 0.
};

/// What a mesh of cells had, and what became of it.
/// A field that is the magnitude of one of several components, as none of them was named.
struct MagnitudeField {
  std::string name;
  int n_components = 0;
};

struct TetraReport {
  std::uint64_t n_cells = 0;        ///< Three-dimensional ones.
  std::uint64_t n_lower_cells = 0;  ///< Left out: points, lines, and faces of no patch.
  std::uint64_t n_patch_cells = 0;  ///< Faces that mark the boundary,
  std::uint64_t n_patches = 0;      ///< and how many patches.
  std::uint64_t n_inner_faces = 0;  ///< Left out: of patches, but not on the boundary.
  std::uint64_t n_ghost_cells = 0;  ///< Left out when the file was read; and hidden ones.
  std::uint64_t n_hidden_cells = 0;
  std::uint64_t n_other_regions = 0;      ///< Left out: cells of regions that are not wanted.
  std::uint64_t n_welded_points = 0;      ///< Taken for another one.
  std::uint64_t n_weld_refusals = 0;      ///< Points kept apart because of their values.
  std::uint64_t n_unused_points = 0;      ///< Left out: in no tetrahedron, and not welded.
  std::uint64_t n_coincident_points = 0;  ///< At the place of another vertex, kept.
  std::uint64_t n_new_points = 0;         ///< Within polyhedra and quadratic cells.
  std::uint64_t n_quadratic = 0;          ///< Cells split between the nodes of edges' middles, too.
  std::uint64_t n_parted_faces = 0;  ///< Of these, that have other nodes than their neighbours.
  std::uint64_t n_reordered = 0;     ///< Quadratic cells whose nodes were in another order.
  // Of tetrahedra, after cells were split:
  std::uint64_t n_repeating = 0;      ///< Left out: a corner is there twice.
  std::uint64_t n_zero_volume = 0;    ///< Kept, for the mesh to conform.
  std::uint64_t n_left_handed = 0;    ///< Turned round: wound otherwise than their component is.
  std::uint64_t n_turned_wedges = 0;  ///< Turned round since wedges are wound unlike other cells.
  std::uint64_t n_inverted = 0;       ///< Kept, of negative volume: folded over others.
  std::uint64_t n_components = 0;     ///< Connected through faces.
  std::uint64_t n_boundary_faces = 0;
  std::vector<NonfiniteField> nonfinite;
  std::optional<double> time{};                ///< Of the values, where the file says it.
  std::vector<std::string> skipped_arrays;     ///< Left out: of points and cells, no numbers.
  std::vector<std::string> regions_not_taken;  ///< Fields named as such, and why they are none.
  std::vector<AveragedField> averaged;         ///< Fields of cells that became fields of points.
  std::vector<LinearisedField> linearised;     ///< Fields of points that lost peaks.
  std::vector<MagnitudeField> magnitudes;      ///< Of which all components together were taken.
};

struct TetrahedraOutcome {
  TetraMesh mesh;
  TetraReport report;
};

/// Makes tetrahedra of a valid mesh of cells. Quadrilateral faces are cut from their smallest point
/// id, so that cells that share one agree (Dompierre, Labbe, Vallet and Camarero, How to subdivide
/// pyramids, prisms and hexahedra into tetrahedra, 1999): 5 or 6 tetrahedra for a hexahedron or
/// voxel, 3 for a wedge, 2 for a pyramid; a polyhedron's round the mean of its corners, or where
/// that does not see all faces round another point that does (find_centre, value_at_centre); other
/// quadratic cells than tetrahedra likewise, round the middle of their parameters
/// (quadratic_cells.h). Fields of cells become means, weighted by volume, over the cells at a
/// point. Vertices keep the order of the points. Tetrahedra are turned round so that all of a
/// component are wound alike, and most of positive volume. Fails on other solid cells, on polyhedra
/// without such a point, on faces of more than two tetrahedra, on a field that is missing, and
/// where nothing solid is left.
[[nodiscard]] Result<TetrahedraOutcome> to_tetrahedra(CellMesh&& mesh, const TetraOptions& options);

}  // namespace lode::io

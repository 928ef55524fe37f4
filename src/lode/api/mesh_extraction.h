#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lode/api/dataset.h"
#include "lode/api/query.h"
#include "lode/core/mesh.h"
#include "lode/mappers/section.h"

namespace lode {

/// No mesh has more cells: 2^31. Queries that want more are refused, before memory is asked for.
inline constexpr std::uint64_t kMaxMeshCells = std::uint64_t{1} << 31;

struct MeshOptions {
  /// Foci, tolerances in field units and the budget. Without max_error it is 0 with a budget, else
  /// 0.5 % of the value range. max_error_outside holds everywhere outside the focus, be it one of
  /// values or of regions. Nothing is refined for the border's sake.
  Query query;
  /// Bytes that the hierarchy may take; 0: a quarter of the machine's memory. Of an opened file
  /// without holes no more is read than a focus or a budget needs, and then the mesh is among
  /// these bytes where they are given: half of them are for pages, half for what is made of them.
  std::uint64_t memory_limit = 0;
};

struct MeshReport {
  double max_error = 0;       ///< The tolerance asked for (or chosen), field units; or infinite.
  double achieved_error = 0;  ///< Proven bound of |F - F'| over the cells in focus.
  double largest_error = 0;   ///< The same over all cells.
  /// Of meshes of tetrahedra, with a tolerance of them: largest world error in focus, an estimate;
  /// and how large that appears in the query's view.
  std::optional<double> achieved_world_error{};
  std::optional<double> achieved_px{};
  std::uint64_t n_cells = 0;      ///< Of the mesh; of volumes what the budget counts.
  std::uint64_t n_cut_cells = 0;  ///< Of the cut, before it is clipped at the border.
  std::uint64_t n_vertices = 0;
  /// Simplices that holes remove in part, and nothing refined; of meshes of tetrahedra cells of the
  /// cut that a threshold leaves out.
  std::uint64_t n_left_out = 0;
  bool budget_met = true;  ///< False: even the unrefined base has more cells.
  bool memory_met = true;  ///< False: memory ended refinement first; see achieved_error.
  bool is_settled = true;  ///< False: a deadline did.
  double seconds = 0;
};

struct SectionOptions {
  SectionPlane plane;
  std::vector<double> isovalues;      ///< Lines of these values on the section; none: triangles.
  std::vector<Range> field_ranges;    ///< Accuracy matters where the field may be in one of them.
  std::optional<double> max_error{};  ///< As in MeshOptions.
  Budget budget{};
  std::uint64_t memory_limit = 0;  ///< As in MeshOptions.
};

struct SectionReport {
  double max_error = 0;
  double achieved_error = 0;  ///< Over the triangles, or over those that have a line, in focus.
  std::uint64_t n_triangles = 0;
  std::uint64_t n_lines = 0;
  std::uint64_t n_vertices = 0;
  std::uint64_t n_cut_cells = 0;
  std::uint64_t n_left_out = 0;  ///< Near the plane.
  std::vector<double> unmet{};   ///< Isovalues that the section has no line of.
  bool budget_met = true;
  bool memory_met = true;
  double seconds = 0;
};

// Dataset::extract_mesh(): the tetrahedra (triangles of 2D data) of a query's cut with values and
// errors, clipped exactly at the border, conforming; see SimplexMesh. O(cells), one thread.
//
// Dataset::extract_section(): the triangles in which a plane cuts the mesh of a query that is fine
// along the plane (see cut_section()), or with isovalues the lines on them. Fails for 2D data.

}  // namespace lode

#include "lode/io/tetrahedra.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <new>
#include <utility>

#include "lode/core/out_of_memory.h"
#include "lode/io/boundary_patches.h"
#include "lode/io/cell_types.h"
#include "lode/io/higher_order_cells.h"
#include "lode/io/polyhedron_centre.h"
#include "lode/io/polyhedron_faces.h"
#include "lode/io/quadratic_cells.h"
#include "lode/io/shared_nodes.h"
#include "lode/io/split_cells.h"
#include "lode/io/tetra_faces.h"
#include "lode/io/tetra_fields.h"
#include "lode/io/tetra_regions.h"
#include "lode/io/tetra_winding.h"
#include "lode/io/weld_points.h"

namespace lode::io {
namespace {

constexpr std::size_t kNTypes = 256;

/// Of types that are split whatever their number of nodes; Lagrange cells have other names by now.
bool can_split(std::uint8_t type) {
  switch (static_cast<CellType>(type)) {
    case CellType::tetrahedron:
    case CellType::voxel:
    case CellType::hexahedron:
    case CellType::wedge:
    case CellType::pyramid:
    case CellType::quadratic_tetrahedron:
    case CellType::quadratic_hexahedron:
    case CellType::triquadratic_hexahedron:
    case CellType::quadratic_wedge:
    case CellType::biquadratic_wedge:
    case CellType::quadratic_pyramid:
    case CellType::polyhedron: return true;
    default: return false;
  }
}

/// Counts solid and other cells. Fails where there are some that cannot be split, or none that can.
Result<void> check_types(const CellMesh& mesh, TetraReport& report) {
  std::array<std::uint64_t, kNTypes> refused{};
  std::uint64_t n_to_linearise = 0;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    const std::uint8_t type = mesh.types[cell];
    ++(is_solid(type) ? report.n_cells : report.n_lower_cells);
    report.n_quadratic += is_quadratic(mesh, cell) ? 1 : 0;
    if (!is_solid(type) || can_split(type) || quadratic_shape(mesh, cell)) continue;
    ++refused[type];
    n_to_linearise += can_linearise(mesh, cell) ? 1 : 0;
  }
  std::string others;
  for (std::size_t i = 0; i < kNTypes; ++i)
    if (refused[i] > 0)
      others += fmt::format("{}{} of type {} ({})", others.empty() ? "" : ", ", refused[i], i,
                            cell_kind(static_cast<std::uint8_t>(i))->name);
  if (!others.empty())
    return fail(
        "{}: expected tetrahedra, hexahedra, voxels, wedges and pyramids, linear or quadratic, or "
        "polyhedra, got {}{}",
        mesh.path, others,
        n_to_linearise == 0 ? ""
                            : fmt::format(": {} of them have a linear cell's corners, which "
                                          "--linearise corners takes instead",
                                          n_to_linearise));
  if (report.n_cells == 0)
    return fail("{}: expected cells with a volume, got none among {}", mesh.path, mesh.n_cells());
  return {};
}

/// Which points solid cells have.
std::vector<std::uint8_t> used_points(const CellMesh& mesh) {
  std::vector<std::uint8_t> is_used(mesh.points.size());
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    if (!is_solid(mesh.types[cell])) continue;
    for (const std::uint32_t corner : mesh.corners_of(cell)) is_used[corner] = 1;
    const auto faces = mesh.faces_of(cell);
    for (std::size_t at = 0; at < faces.size(); at += faces[at] + std::size_t{1})
      for (const std::uint32_t corner : faces.subspan(at + 1, faces[at])) is_used[corner] = 1;
  }
  return is_used;
}

void find_range(const std::vector<double>& values, const std::vector<std::uint8_t>& is_used,
                double& low, double& high) {
  low = std::numeric_limits<double>::infinity();
  high = -low;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (is_used[i] == 0 || !std::isfinite(values[i])) continue;
    low = std::min(low, values[i]);
    high = std::max(high, values[i]);
  }
}

/// Of fields of points, those whose range at corners is not that at all nodes.
void find_lost_peaks(const ChosenFields& chosen, const std::vector<std::uint8_t>& is_node,
                     const std::vector<std::uint8_t>& is_corner, TetraReport& report) {
  for (std::size_t f = 0; f < chosen.fields.size(); ++f) {
    if (chosen.is_of_cells[f] != 0) continue;
    LinearisedField field{chosen.fields[f].name};
    find_range(chosen.fields[f].values, is_node, field.node_min, field.node_max);
    find_range(chosen.fields[f].values, is_corner, field.corner_min, field.corner_max);
    if (field.corner_min > field.node_min || field.corner_max < field.node_max)
      report.linearised.push_back(std::move(field));
  }
}

/// What points to be welded must have alike: all that is measured, chosen or not, as other fields
/// may come to the same vertices later. Whole numbers, which may number the points, only if chosen.
std::vector<MeshField> fields_to_agree(const CellMesh& mesh, const ChosenFields& chosen) {
  std::vector<MeshField> fields;
  for (const MeshField& field : mesh.point_fields)
    if (is_floating(field.type)) fields.push_back(field);
  for (std::size_t i = 0; i < chosen.fields.size(); ++i)
    if (chosen.is_of_cells[i] == 0 && !is_floating(chosen.fields[i].type))
      fields.push_back(chosen.fields[i]);
  return fields;
}

/// Gives cells the points that others were welded to.
Result<void> weld(const TetraOptions& options, const ChosenFields& chosen, CellMesh& mesh,
                  TetraReport& report) {
  if (!options.weld_distance) return {};
  const WeldRule rule{.distance = *options.weld_distance, .values = options.weld_values};
  if (!(rule.distance >= 0 && std::isfinite(rule.distance) && rule.values >= 0))
    return fail(
        "{}: expected a distance and a difference of values from 0 for welding, got {} and {}",
        mesh.path, rule.distance, rule.values);
  const Weld result =
      weld_points(mesh.points, fields_to_agree(mesh, chosen), used_points(mesh), rule);
  for (std::uint32_t& corner : mesh.corners) corner = result.ids[corner];
  for (std::size_t at = 0; at < mesh.faces.size();) {
    const std::size_t end = at + 1 + mesh.faces[at];
    while (++at < end) mesh.faces[at] = result.ids[mesh.faces[at]];
  }
  report.n_welded_points = result.n_welded;
  report.n_weld_refusals = result.n_refused;
  return {};
}

/// Of a field at points, at a new vertex within a cell.
double value_within(const CellMesh& mesh, std::size_t cell, const Vec3d& place,
                    const std::vector<double>& values) {
  if (static_cast<CellType>(mesh.types[cell]) == CellType::polyhedron)
    return value_at_centre(mesh, distinct_corners(mesh, cell), place, values);
  return value_at_quadratic_centre(mesh, cell, place, values);
}

/// New vertices behind the points, within polyhedra and quadratic cells, with values of point
/// fields.
void add_centres(const SplitCells& split, CellMesh& mesh, ChosenFields& chosen) {
  if (split.centre_cells.empty()) return;
  for (std::size_t f = 0; f < chosen.fields.size(); ++f) {
    if (chosen.is_of_cells[f] != 0) continue;
    std::vector<double>& values = chosen.fields[f].values;
    std::vector<double> at_centres;
    at_centres.reserve(split.centres.size());
    for (std::size_t i = 0; i < split.centres.size(); ++i)
      at_centres.push_back(value_within(mesh, split.centre_cells[i], split.centres[i], values));
    values.insert(values.end(), at_centres.begin(), at_centres.end());
    chosen.fields[f].type = ScalarType::float64;
  }
  mesh.points.insert(mesh.points.end(), split.centres.begin(), split.centres.end());
}

void take_regions(const CellMesh& mesh, std::size_t regions, const SplitCells& split,
                  TetraMesh& result) {
  for (const std::uint32_t cell : split.cells)
    result.region_ids.push_back(static_cast<std::int64_t>(mesh.cell_fields[regions].values[cell]));
  std::vector<std::int64_t> by_tetrahedron = result.region_ids;
  std::sort(result.region_ids.begin(), result.region_ids.end());
  result.region_ids.erase(std::unique(result.region_ids.begin(), result.region_ids.end()),
                          result.region_ids.end());
  result.region_names = names_of_regions(mesh, regions, result.region_ids);
  if (result.region_ids.size() < 2) return;
  for (const std::int64_t id : by_tetrahedron)
    result.regions.push_back(static_cast<std::uint32_t>(
        std::lower_bound(result.region_ids.begin(), result.region_ids.end(), id) -
        result.region_ids.begin()));
}

/// By point: its place among those that tetrahedra have, or none.
constexpr std::uint32_t kLeftOut = std::numeric_limits<std::uint32_t>::max();

std::vector<std::uint32_t> vertices_of(std::size_t n_points, const SplitCells& split) {
  std::vector<std::uint32_t> vertices(n_points, kLeftOut);
  for (const Tetrahedron& t : split.tetrahedra)
    for (const std::uint32_t point : t) vertices[point] = 0;
  std::uint32_t n = 0;
  for (std::uint32_t& vertex : vertices)
    if (vertex != kLeftOut) vertex = n++;
  return vertices;
}

bool is_narrow(const Vec3d& p) {
  return std::all_of(p.v.begin(), p.v.end(), [](double x) {
    return std::abs(x) <= std::numeric_limits<float>::max() &&
           static_cast<double>(static_cast<float>(x)) == x;
  });
}

/// Leaves out points that no tetrahedron has. `n_given`: how many the file has.
void take_vertices(const CellMesh& mesh, std::size_t n_given, ChosenFields&& chosen,
                   SplitCells&& split, TetraMesh& result, TetraReport& report) {
  const std::vector<std::uint32_t> vertices = vertices_of(mesh.points.size(), split);
  for (std::size_t i = 0; i < vertices.size(); ++i)
    if (vertices[i] != kLeftOut) result.positions.push_back(mesh.points[i]);
  result.has_narrow_positions =
      std::all_of(result.positions.begin(), result.positions.end(), is_narrow);
  for (MeshField& field : chosen.fields) {
    NonfiniteField lacking{field.name};
    std::size_t to = 0;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      if (vertices[i] == kLeftOut) continue;
      const bool is_lacking = i < n_given && !std::isfinite(field.values[i]);
      if (is_lacking && lacking.n_values++ == 0) lacking.first = i;
      field.values[to++] = field.values[i];
    }
    field.values.resize(to);
    result.fields.push_back(std::move(field));
    if (lacking.n_values > 0) report.nonfinite.push_back(std::move(lacking));
  }
  result.tetrahedra = std::move(split.tetrahedra);
  for (Tetrahedron& t : result.tetrahedra)
    for (std::uint32_t& point : t) point = vertices[point];
  for (PatchFace& face : result.patch_faces)
    for (std::uint32_t& point : face.corners) point = vertices[point];
}

void count_vertices(std::size_t n_given, const TetraMesh& mesh, TetraReport& report) {
  report.n_unused_points =
      n_given + report.n_new_points - report.n_welded_points - mesh.positions.size();
  report.n_coincident_points = count_coincident(mesh.positions);
}

Result<TetrahedraOutcome> make_tetrahedra(CellMesh& mesh, const TetraOptions& options) {
  TetrahedraOutcome outcome;
  TetraReport& report = outcome.report;
  report.n_ghost_cells = mesh.n_ghost_cells;
  report.n_hidden_cells = mesh.n_hidden_cells;
  report.skipped_arrays = mesh.skipped_arrays;
  report.time = mesh.time;
  LODE_TRY(const std::size_t regions, find_regions(mesh, options));
  LODE_TRY(report.n_other_regions, keep_regions(options, regions, mesh));
  std::vector<std::uint8_t> is_node;
  if (options.quadratic == QuadraticCells::corners) {
    is_node = used_points(mesh);
    linearise(mesh);
  }
  name_lagrange_cells(mesh);
  report.n_reordered = order_middles(mesh);
  LODE_CHECK(check_types(mesh, report));
  LODE_TRY(ChosenFields chosen, choose_fields(mesh, options));
  report.magnitudes = chosen.magnitudes;
  if (!is_node.empty()) find_lost_peaks(chosen, is_node, used_points(mesh), report);
  if (!options.region_field) report.regions_not_taken = find_regions_not_taken(mesh, regions);
  const std::size_t n_given = mesh.points.size();
  LODE_CHECK(weld(options, chosen, mesh, report));
  LODE_TRY(report.n_parted_faces, check_shared_nodes(mesh));
  LODE_TRY(SplitCells split, split_cells(mesh));
  report.n_repeating = split.n_repeating;
  report.n_new_points = split.centre_cells.size();
  if (split.tetrahedra.empty())
    return fail("{}: expected cells of different corners, got {} that repeat some", mesh.path,
                split.n_repeating);
  add_centres(split, mesh, chosen);
  LODE_TRY(const TetraFaces faces, connect_faces(mesh.path, split, mesh.points.size()));
  report.n_components = faces.n_components;
  report.n_boundary_faces = faces.boundary.size();
  LODE_CHECK(take_patches(mesh, regions, faces, outcome.mesh, report));
  turn_round(mesh, mesh.points, faces, split, report);
  average_cells(mesh, regions, split, chosen, report);
  if (regions < mesh.cell_fields.size()) take_regions(mesh, regions, split, outcome.mesh);
  take_vertices(mesh, n_given, std::move(chosen), std::move(split), outcome.mesh, report);
  count_vertices(n_given, outcome.mesh, report);
  return outcome;
}

}  // namespace

Result<TetrahedraOutcome> to_tetrahedra(CellMesh&& mesh, const TetraOptions& options) {
  CellMesh own = std::move(mesh);
  try {
    return make_tetrahedra(own, options);
  } catch (const std::bad_alloc&) {
    return out_of_memory("make tetrahedra", own.path);
  }
}

}  // namespace lode::io

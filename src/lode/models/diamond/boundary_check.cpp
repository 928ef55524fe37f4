#include "lode/models/diamond/boundary_check.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "lode/mappers/surface_topology.h"
#include "lode/models/diamond/cell_neighbours.h"
#include "lode/models/diamond/cell_pieces.h"

namespace lode::diamond {
namespace {

constexpr std::size_t kEdgesPerReport = 65536;

/// Every part of the segment (or point) lies both in a present and in a removed cell.
bool is_on_holes(const FieldSamples& samples, const SurfaceCoordinates& coordinates,
                 std::span<const std::uint32_t> ends) {
  for (const std::uint32_t vertex : ends)
    if (coordinates.is_outside(vertex)) return false;
  bool is_on = true;
  const Vec3d& rounding = coordinates.rounding();
  const auto visit = [&](const Index3& cell, const Piece& piece) {
    is_on = is_on && find_near_cell(samples, cell, piece, rounding, CellState::removed) &&
            find_near_cell(samples, cell, piece, rounding, CellState::present);
  };
  visit_cells(coordinates.piece_of(ends), samples.grid().dims, visit);
  return is_on;
}

/// All of them in one plane of samples across an axis, within rounding.
bool are_in_lattice_plane(const SurfaceCoordinates& coordinates,
                          std::span<const std::uint32_t> ends) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double plane = std::round(coordinates[ends.front()][axis]);
    if (std::ranges::all_of(ends, [&](std::uint32_t vertex) {
          return std::abs(coordinates[vertex][axis] - plane) <= coordinates.rounding()[axis];
        }))
      return true;
  }
  return false;
}

bool is_in_boxes(const Surface& surface, const std::array<std::uint32_t, 2>& edge,
                 std::span<const Box3d> boxes) {
  const auto holds = [&](const Box3d& box) {
    bool is_in = true;
    for (const std::uint32_t vertex : edge) {
      const Vec3d p = surface.world_position(vertex);
      for (std::size_t i = 0; i < 3; ++i)
        is_in = is_in && box.lower[i] <= p[i] && p[i] <= box.upper[i];
    }
    return is_in;
  };
  return boxes.empty() || std::ranges::any_of(boxes, holds);
}

}  // namespace

Result<BoundaryReport> check_boundary(const FieldSamples& samples, const Surface& surface,
                                      const BoundaryOptions& options, Progress& progress) {
  const SurfaceCoordinates coordinates(samples.grid(), surface, options.clip, options.threads);
  const auto edges = find_boundary_edges(surface, options.threads);
  BoundaryReport report;
  for (const auto& edge : edges) {
    if (!is_in_boxes(surface, edge, options.boxes)) continue;
    if (report.n_edges++ % kEdgesPerReport == 0)
      progress.report("boundary",
                      static_cast<double>(report.n_edges) / static_cast<double>(edges.size()));
    if (progress.is_cancelled()) return cancelled_error();
    const auto ends = std::span(edge).first(edge[0] == edge[1] ? 1 : 2);
    if (coordinates.are_on_border(ends)) {
      ++report.n_on_border;
    } else if (coordinates.are_on_clip(ends)) {
      ++report.n_on_clip;
    } else if (is_on_holes(samples, coordinates, ends) ||
               (options.goes_along_planes && are_in_lattice_plane(coordinates, ends))) {
      ++report.n_on_holes;
    } else if (report.n_stray++ == 0) {
      report.first_stray = edge;
    }
  }
  return report;
}

bool PinchPlaces::contain(std::uint32_t vertex) const {
  const std::array point{vertex};
  return coordinates_.are_on_clip(point) || is_on_holes(samples_, coordinates_, point);
}

}  // namespace lode::diamond

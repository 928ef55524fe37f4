#include "lode/api/mapped_verification.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <vector>

#include "lode/api/mapped_errors.h"
#include "lode/core/out_of_memory.h"
#include "lode/delaunay/tin.h"
#include "lode/mappers/tin_edge_check.h"

namespace lode {
namespace {

using Places = std::vector<Vec<double, 2>>;

/// A surface's vertices, and the nodes of the terrain's lattice that are nearest to them.
struct MappedVertices {
  Places there;  ///< As the surface has them.
  std::vector<LatticePoint> nodes;
  std::vector<Vec3d> own;        ///< Where these are in the CRS of the terrain.
  std::uint64_t n_apart = 0;     ///< Vertices that are not where the other CRS has their nodes.
  double largest_distance = 0;   ///< Of the others from there, along x or y.
  std::string first_apart = {};  ///< Of those, in words.
};

Result<void> map_in_parts(const PlaceMap& map, Places& places, const char* what,
                          Progress& progress) {
  constexpr std::size_t kAtOnce = std::size_t{1} << 16;
  for (std::size_t first = 0; first < places.size(); first += kAtOnce) {
    if (progress.is_cancelled()) return cancelled_error();
    map.apply(std::span(places).subspan(first, std::min(kAtOnce, places.size() - first)));
    progress.report(what, static_cast<double>(first) / static_cast<double>(places.size()));
  }
  return {};
}

/// How far a vertex may be from where its sample is: coordinates have 53 bits, of which PROJ may
/// lose some on the way, or, of positions in floats, 24 from the surface's origin on.
double allowed_distance(const PlacedSurface& placed, const Vec3d& at) {
  const double size = std::max({1.0, std::abs(at[0]), std::abs(at[1])});
  double allowed = 0x1p-36 * size;
  if (placed.places.empty())
    allowed += 0x1p-23 * std::max(std::abs(at[0] - placed.surface.origin[0]),
                                  std::abs(at[1] - placed.surface.origin[1]));
  return allowed;
}

LatticePoint nearest_node(const HeightFrame& frame, const Vec<double, 2>& place) {
  const Vec<double, 2> at = frame.lattice(place[0], place[1]);
  const auto index = [](double value, std::int32_t n) {
    if (std::isnan(value)) return 0;
    return static_cast<std::int32_t>(std::lround(std::clamp(value, 0.0, n - 1.0)));
  };
  return {index(at[0], frame.n_columns), index(at[1], frame.n_rows)};
}

Result<MappedVertices> find_vertices(const HeightFrame& frame, const PlacedSurface& placed,
                                     const OtherCrs& other, Progress& progress) {
  const PlacedSurfaceView view{placed.surface, placed.places};
  const auto n = static_cast<std::uint32_t>(placed.surface.positions.size());
  MappedVertices found;
  found.there.reserve(n);
  for (std::uint32_t v = 0; v < n; ++v) {
    const Vec3d at = view.world_position(v);
    found.there.push_back({{at[0], at[1]}});
  }
  Places places = found.there;
  LODE_CHECK(map_in_parts(other.back, places, "mapping back", progress));
  found.nodes.reserve(n);
  for (Vec<double, 2>& place : places) {
    found.nodes.push_back(nearest_node(frame, place));
    place = frame.world(found.nodes.back().x, found.nodes.back().y);
  }
  found.own.reserve(n);
  for (std::uint32_t v = 0; v < n; ++v)
    found.own.push_back({{places[v][0], places[v][1], view.world_position(v)[2]}});
  LODE_CHECK(map_in_parts(other.there, places, "mapping", progress));
  for (std::uint32_t v = 0; v < n; ++v) {
    const Vec3d at = view.world_position(v);
    const double distance =
        std::max(std::abs(places[v][0] - at[0]), std::abs(places[v][1] - at[1]));
    if (distance <= allowed_distance(placed, at)) {
      found.largest_distance = std::max(found.largest_distance, distance);
    } else if (found.n_apart++ == 0) {
      found.first_apart = fmt::format("vertex {} at {:.12g}, {:.12g}", v, at[0], at[1]);
    }
  }
  return found;
}

VerifyReport::Check check_places(const MappedVertices& vertices, const OtherCrs& other) {
  const bool passed = vertices.n_apart == 0;
  return {.name = "vertices are where " + other.name + " has samples",
          .count = vertices.nodes.size(),
          .passed = passed,
          .detail =
              passed ? fmt::format("off by up to {:.2g}", vertices.largest_distance)
                     : fmt::format("{} are not, first {}", vertices.n_apart, vertices.first_apart)};
}

/// How far samples are from the surface in the other CRS.
Result<VerifyReport::Check> measure_there(const OpenedTerrain& opened, const PlacedSurface& placed,
                                          const MappedVertices& vertices, const OtherCrs& other,
                                          Threads threads, Progress& progress) {
  const HeightFrame& frame = opened.terrain.frame();
  delaunay::Tin tin;
  tin.vertices = vertices.nodes;
  tin.triangles = turning_left(placed.surface, frame);
  for (const Vec3d& at : vertices.own) tin.heights.push_back(at[2]);
  LODE_TRY(const MappedErrors errors, measure_mapped({tin, frame, vertices.there}, other.there,
                                                     *measured_samples(opened), threads, progress));
  std::string detail = fmt::format("up to {}, at {:.12g}, {:.12g} of the terrain's own CRS",
                                   errors.error, errors.worst[0], errors.worst[1]);
  if (errors.n_without > 0)
    detail += fmt::format("; {} samples in no triangle there", errors.n_without);
  return VerifyReport::Check{.name = "errors in " + other.name + " (measured)",
                             .count = errors.n_samples,
                             .detail = std::move(detail)};
}

}  // namespace

Result<VerifyReport> verify_mapped_terrain(const OpenedTerrain& opened, const PlacedSurface& placed,
                                           const TerrainVerifyOptions& options,
                                           const OtherCrs& other, Progress& progress) try {
  LODE_EXPECTS(opened.points || opened.grid);
  LODE_TRY(const MappedVertices vertices,
           find_vertices(opened.terrain.frame(), placed, other, progress));
  TerrainVerifyOptions own = options;
  own.places = vertices.own;
  LODE_TRY(VerifyReport report, opened.points
                                    ? verify_terrain(*opened.points, placed.surface, own, progress)
                                    : verify_terrain(*opened.grid, placed.surface, own, progress));
  report.checks.insert(report.checks.begin(), check_places(vertices, other));
  if (!report.passed()) {
    report.skip("errors in " + other.name, "the surface is not one of this terrain");
    return report;
  }
  LODE_TRY(const VerifyReport::Check there,
           measure_there(opened, placed, vertices, other, options.threads, progress));
  report.checks.push_back(there);
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("check the surface");
}

}  // namespace lode

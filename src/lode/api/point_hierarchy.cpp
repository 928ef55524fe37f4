#include "lode/api/point_hierarchy.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "lode/api/terrain_selection.h"
#include "lode/delaunay/lattice_side.h"
#include "lode/locate/tin_locator.h"
#include "lode/mappers/point_errors.h"
#include "lode/models/terrain/delaunay_selector/selector.h"
#include "lode/models/terrain/triangle_hierarchy/crowded.h"

namespace lode {

using triangle_hierarchy::Hierarchy;
using triangle_hierarchy::PointSurface;

namespace {

/// 2^bits times as many columns and rows.
HeightPoints fine_points(const HeightPoints& points, int bits) {
  HeightPoints fine = points;
  static_cast<HeightFrame&>(fine) = fine_frame(points, bits);
  for (LatticePoint& p : fine.nodes) p = {p.x << bits, p.y << bits};
  return fine;
}

/// The triangulation of all points, on the fine lattice, to hold vertices against.
class WholeSurface {
 public:
  /// `size`: the largest |height|.
  WholeSurface(delaunay::Tin tin, int bits, double size)
      : tin_(scaled(std::move(tin), bits)), locator_(tin_), rounding_(0x1p-48 * size) {}

  /// Whether it has this height there, but for rounding.
  [[nodiscard]] bool has(LatticePoint p, double height) const {
    const auto t = locator_.find(delaunay::to_point(p));
    if (!t) return false;
    const auto& corner = tin_.triangles[*t];
    long double sum = 0;
    std::int64_t area = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int64_t weight = delaunay::doubled_area(p, tin_.vertices[corner[(i + 1) % 3]],
                                                         tin_.vertices[corner[(i + 2) % 3]]);
      if (tin_.vertices[corner[i]] == p) return tin_.heights[corner[i]] == height;
      area += weight;
      sum += static_cast<long double>(weight) * static_cast<long double>(tin_.heights[corner[i]]);
    }
    return std::abs(sum / static_cast<long double>(area) - height) <= rounding_;
  }

 private:
  static delaunay::Tin scaled(delaunay::Tin tin, int bits) {
    for (LatticePoint& p : tin.vertices) p = {p.x << bits, p.y << bits};
    return tin;
  }

  delaunay::Tin tin_;
  TinLocator locator_;
  double rounding_;
};

double largest_height(const delaunay::Tin& tin) {
  const auto [lower, upper] = std::ranges::minmax(tin.heights);
  return std::max(std::abs(lower), std::abs(upper));
}

/// Of all levels, as one.
delaunay::Tin triangles_of(const Hierarchy& hierarchy) {
  delaunay::Tin tin;
  tin.vertices = hierarchy.vertices;
  tin.heights = hierarchy.heights;
  tin.triangles.reserve(hierarchy.triangles.size());
  tin.errors.reserve(hierarchy.triangles.size());
  for (const auto& triangle : hierarchy.triangles) {
    tin.triangles.push_back(triangle.corner);
    tin.errors.push_back(triangle.error);
  }
  return tin;
}

void check_on_surface(const Hierarchy& hierarchy, const PointSurface& all, VerifyReport& report) {
  const WholeSurface surface(all.tin(), hierarchy.bits, largest_height(all.tin()));
  std::uint64_t n_off = 0;
  for (std::size_t v = 0; v < hierarchy.vertices.size(); ++v)
    n_off += static_cast<std::uint64_t>(!surface.has(hierarchy.vertices[v], hierarchy.heights[v]));
  report.add("vertices are on the triangulation of all points", hierarchy.vertices.size(), n_off,
             n_off > 0 ? fmt::format("{} are not", n_off) : "");
}

/// What meshes of tolerances that vary count on.
void check_crowded(const Hierarchy& hierarchy, const PointSurface& all, VerifyReport& report) {
  const std::vector<std::uint32_t> crowded = find_crowded(hierarchy, all);
  const auto n_lost = static_cast<std::uint64_t>(std::ranges::count_if(
      crowded, [&](std::uint32_t t) { return !std::ranges::binary_search(hierarchy.crowded, t); }));
  report.add("triangles with points close beside them are known", hierarchy.refinements.size(),
             n_lost, n_lost > 0 ? fmt::format("{} are not", n_lost) : "");
}

}  // namespace

Result<std::unique_ptr<const PointSurface>> surface_of(const PointTerrain& terrain,
                                                       Progress& progress) {
  LODE_TRY(auto all,
           delaunay_selector::select_all_points(terrain.points, terrain.domain, progress));
  const auto& nodes = terrain.points.nodes;
  std::vector<std::array<LatticePoint, 3>> base;
  base.reserve(terrain.domain.triangles.size());
  for (const auto& [a, b, c] : terrain.domain.triangles)
    base.push_back({nodes[a], nodes[b], nodes[c]});
  return std::make_unique<const PointSurface>(terrain.points, std::move(all.tin), base);
}

Result<void> check_against_points(const Hierarchy& hierarchy, const PointTerrain& terrain,
                                  Threads threads, Progress& progress, VerifyReport& report) {
  LODE_TRY(const auto surface, surface_of(terrain, progress));
  if (surface->bits() != hierarchy.bits)
    return fail("expected nodes that are 1/{} of a step of the points apart, got 1/{}",
                surface->scale(), hierarchy.scale());
  check_on_surface(hierarchy, *surface, report);
  check_crowded(hierarchy, *surface, report);
  const HeightPoints fine = fine_points(terrain.points, hierarchy.bits);
  for (int level = 0; level < hierarchy.n_levels(); ++level) {
    const double tolerance = hierarchy.tolerances[static_cast<std::size_t>(level)];
    const delaunay::Tin tin = tin_of_level(hierarchy, level, delaunay::TinLinks::left_out);
    LODE_TRY(const VerifyReport checked,
             verify_fine_point_tin(terrain, fine, tin, tolerance, threads, progress));
    for (const VerifyReport::Check& check : checked.checks)
      report.add(fmt::format("within {}: {}", tolerance, check.name), check.count,
                 check.passed ? 0 : 1, check.detail);
  }
  LODE_TRY(const std::uint64_t n_beyond,
           count_understated_points(triangles_of(hierarchy), fine, threads, progress));
  report.add("triangles of all levels state their errors", hierarchy.triangles.size(), n_beyond,
             n_beyond > 0 ? fmt::format("{} have points that err by more", n_beyond) : "");
  return {};
}

}  // namespace lode

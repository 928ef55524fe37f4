#include "lode/api/terrain_features.h"

#include <algorithm>
#include <new>
#include <utility>

#include "lode/api/terrain_selection.h"
#include "lode/core/expects.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"

namespace lode {
namespace {

using terrain_features::CriticalPoint;
using terrain_features::FeatureLine;
using terrain_features::Features;
using terrain_features::LineKind;

/// By vertex.
std::vector<bool> find_outline(const delaunay::Tin& tin) {
  std::vector<bool> is_on_outline(tin.vertices.size());
  for (std::size_t t = 0; t < tin.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      if (tin.twins[t][i] != delaunay::kNoHalfEdge) continue;
      is_on_outline[tin.triangles[t][i]] = true;
      is_on_outline[tin.triangles[t][(i + 1) % 3]] = true;
    }
  return is_on_outline;
}

/// Where lines of a kind are cut, by vertex: at critical points, and where any of them ends. Each
/// vertex is left by one line of a kind at most, and passes by those that start there, so two of
/// them meet nowhere else.
std::vector<bool> find_junctions(const Features& features, LineKind kind, std::size_t n_vertices) {
  std::vector<bool> is_junction(n_vertices);
  for (const CriticalPoint& point : features.points) is_junction[point.vertex] = true;
  for (const FeatureLine& line : features.lines) {
    if (line.kind != kind) continue;
    is_junction[line.vertices.front()] = true;
    is_junction[line.vertices.back()] = true;
  }
  return is_junction;
}

class WorldFeatures {
 public:
  WorldFeatures(const delaunay::Tin& tin, const HeightFrame& frame, const Features& features)
      : tin_(tin), frame_(frame), features_(features) {}

  [[nodiscard]] TerrainFeatures make() const {
    TerrainFeatures made;
    made.all = features_.all;
    made.kept = features_.kept;
    made.euler_number = features_.euler_number;
    made.n_triangles = tin_.triangles.size();
    add_points(made);
    add_lines(made);
    return made;
  }

 private:
  [[nodiscard]] Vec3d place_of(std::uint32_t vertex) const {
    const delaunay::LatticePoint node = tin_.vertices[vertex];
    const Vec<double, 2> at = frame_.world(node.x, node.y);
    return {{at[0], at[1], tin_.heights[vertex]}};
  }
  void add_points(TerrainFeatures& made) const {
    const std::vector<bool> is_on_outline = find_outline(tin_);
    made.points.reserve(features_.points.size());
    for (const CriticalPoint& point : features_.points)
      made.points.push_back({point.kind, point.multiplicity, point.relief,
                             is_on_outline[point.vertex], place_of(point.vertex)});
  }
  /// Lines come by their passes' relief, so the first one over a stretch has the largest.
  void add_lines(TerrainFeatures& made) const {
    const std::size_t n = tin_.vertices.size();
    const std::vector<bool> ends_ridges = find_junctions(features_, LineKind::ridge, n);
    const std::vector<bool> ends_channels = find_junctions(features_, LineKind::channel, n);
    for (const FeatureLine& line : features_.lines) {
      const bool is_ridge = line.kind == LineKind::ridge;
      const std::vector<bool>& is_junction = is_ridge ? ends_ridges : ends_channels;
      const double relief = relief_of(line.vertices.front());
      for (std::size_t i = 0; i + 1 < line.vertices.size(); ++i) {
        const std::uint32_t v = line.vertices[i];
        if (i == 0 || is_junction[v]) made.lines.push_back({line.kind, relief, {place_of(v)}});
        made.lines.back().points.push_back(place_of(line.vertices[i + 1]));
      }
    }
    for (const TerrainFeatures::Line& line : made.lines) {
      ++(line.kind == LineKind::ridge ? made.n_ridges : made.n_channels);
      made.n_line_points += line.points.size();
    }
  }
  [[nodiscard]] double relief_of(std::uint32_t pass) const {
    const auto found = std::ranges::lower_bound(features_.points, pass, {}, &CriticalPoint::vertex);
    LODE_EXPECTS(found != features_.points.end() && found->vertex == pass);
    return found->relief;
  }

  const delaunay::Tin& tin_;
  const HeightFrame& frame_;
  const Features& features_;
};

}  // namespace

double default_relief(const HeightRange& range) {
  constexpr double kShare = 0.01;
  return std::max(0.0, kShare * (range.upper - range.lower));
}

Result<TerrainFeatures> find_terrain_features(const Terrain& terrain,
                                              std::optional<double> least_relief,
                                              Progress& progress) try {
  LODE_EXPECTS(!least_relief || *least_relief >= 0);
  const double wanted = least_relief ? *least_relief : default_relief(terrain.range());
  const Stopwatch select_watch;
  LODE_TRY(const SelectedTerrain selected, terrain.origin().select_all(progress));
  const double select_seconds = select_watch.seconds();
  const Stopwatch find_watch;
  LODE_TRY(const Features features,
           terrain_features::find_features(selected.tin, wanted, progress));
  if (progress.is_cancelled()) return cancelled_error();
  TerrainFeatures made = WorldFeatures(selected.tin, terrain.frame(), features).make();
  made.least_relief = wanted;
  made.select_seconds = select_seconds;
  made.find_seconds = find_watch.seconds();
  return made;
} catch (const std::bad_alloc&) {
  return out_of_memory("find features");
}

}  // namespace lode

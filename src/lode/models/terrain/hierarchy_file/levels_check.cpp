#include "lode/models/terrain/hierarchy_file/levels_check.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "lode/delaunay/triangle_error.h"
#include "lode/models/terrain/hierarchy_file/outline.h"
#include "lode/models/terrain/hierarchy_file/point_outline.h"

namespace lode::hierarchy_file {
namespace {

using triangle_hierarchy::Hierarchy;

/// An edge of a triangle, by its ends whatever their order.
struct Side {
  std::uint64_t ends;
  std::uint32_t half_edge;  ///< 4 times the triangle, and its edge.
  bool is_rising;           ///< From the smaller end.
};

class LevelLinker {
 public:
  LevelLinker(Hierarchy& hierarchy, double size) : h_(hierarchy), size_(size) {}

  Result<void> link(int level) {
    first_ = level > 0 ? h_.triangles_until[static_cast<std::size_t>(level) - 1] : 0;
    LODE_CHECK(find_sides(level));
    LODE_TRY(std::vector<OutlineEdge> edges, link_sides(level));
    const auto checked = h_.is_of_points ? check_point_outline(level, std::move(edges))
                                         : check_raster_outline(level, edges);
    if (!checked) return fail("level {}: {}", level, checked.error().message);
    return {};
  }

 private:
  Result<void> find_sides(int level) {
    // Errors are found, and compared with tolerances, up to half of this.
    const double tolerance = h_.tolerances[static_cast<std::size_t>(level)];
    const float most = delaunay::to_float_above(tolerance + 0x1p-47 * size_);
    sides_.clear();
    const std::uint32_t end = h_.triangles_until[static_cast<std::size_t>(level)];
    for (std::uint32_t t = 0; t < end; ++t) {
      if (!h_.is_in_level(t, level)) continue;
      const Hierarchy::Triangle& triangle = h_.triangles[t];
      if (triangle.error > most)
        return fail("level {}: expected triangles within {}, got one that says {}", level,
                    tolerance, triangle.error);
      for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t from = triangle.corner[i];
        const std::uint32_t to = triangle.corner[(i + 1) % 3];
        sides_.push_back(
            {std::uint64_t{std::min(from, to)} << 32 | std::max(from, to), 4 * t + i, from < to});
      }
    }
    std::ranges::sort(sides_, {}, &Side::ends);
    return {};
  }

  Result<void> check_raster_outline(int level, const std::vector<OutlineEdge>& edges) {
    std::vector<OutlinePart> parts;
    for (const auto& [from, to] : edges) {
      LODE_TRY(const OutlinePart part, outline_part(from, to, h_.scale()));
      parts.push_back(part);
    }
    LODE_TRY(std::vector<OutlinePart> outline, join_outline(std::move(parts)));
    if (level == 0) {
      if (!goes_round_once(outline))
        return fail("expected triangles that cover each place once, got some twice");
      outline_ = std::move(outline);
    } else if (outline != outline_) {
      return fail("expected the outline of level 0, got another");
    }
    return {};
  }

  Result<void> check_point_outline(int level, std::vector<OutlineEdge> edges) {
    std::vector<OutlineEdge> outline = join_edges(std::move(edges));
    if (level == 0) {
      LODE_CHECK(check_goes_round_once(outline));
      point_outline_ = std::move(outline);
    } else if (outline != point_outline_) {
      return fail("expected the outline of level 0, got another");
    }
    return {};
  }

  /// Returns those without another side.
  Result<std::vector<OutlineEdge>> link_sides(int level) {
    std::vector<OutlineEdge> edges;
    for (std::size_t i = 0; i < sides_.size();) {
      const Side& a = sides_[i];
      std::size_t n = 1;
      while (i + n < sides_.size() && sides_[i + n].ends == a.ends) ++n;
      if (n > 2 || (n == 2 && a.is_rising == sides_[i + 1].is_rising))
        return fail("level {}: expected edges with a triangle on each side, got {} at one", level,
                    n);
      if (n == 2) {
        set_twin(a.half_edge, sides_[i + 1].half_edge);
        set_twin(sides_[i + 1].half_edge, a.half_edge);
      } else {
        const auto& corner = h_.triangles[a.half_edge / 4].corner;
        edges.push_back(
            {h_.vertices[corner[a.half_edge % 4]], h_.vertices[corner[(a.half_edge % 4 + 1) % 3]]});
      }
      i += n;
    }
    return edges;
  }

  /// Of the level that made the triangle.
  void set_twin(std::uint32_t half_edge, std::uint32_t twin) {
    if (half_edge / 4 >= first_) h_.triangles[half_edge / 4].twin[half_edge % 4] = twin;
  }

  Hierarchy& h_;
  double size_;
  std::uint32_t first_ = 0;  ///< Triangle of the level.
  std::vector<Side> sides_;
  std::vector<OutlinePart> outline_;        ///< Of a raster.
  std::vector<OutlineEdge> point_outline_;  ///< Of points.
};

}  // namespace

Result<void> link_levels(Hierarchy& hierarchy, double size, Progress& progress) {
  LevelLinker linker(hierarchy, size);
  for (int level = 0; level < hierarchy.n_levels(); ++level) {
    if (progress.is_cancelled()) return cancelled_error();
    LODE_CHECK(linker.link(level));
  }
  return {};
}

}  // namespace lode::hierarchy_file

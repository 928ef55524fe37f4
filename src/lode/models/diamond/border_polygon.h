#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "lode/core/result.h"
#include "lode/core/vec.h"
#include "lode/delaunay/triangulation.h"

namespace lode::diamond {

/// A border plane: an axis and which of its two ends. Its number is its bit in
/// SurfaceCoordinates::border_planes().
struct BorderPlane {
  std::size_t axis;
  bool is_upper;

  explicit BorderPlane(std::size_t number) : axis(number / 2), is_upper(number % 2 == 1) {}
};
inline constexpr std::size_t kBorderPlanes = 6;

[[nodiscard]] constexpr std::size_t border_plane_number(std::size_t axis, bool is_upper) {
  return 2 * axis + (is_upper ? 1 : 0);
}

/// A sample on the domain's border polygon (a corner, for one), or a vertex of the surface on it.
struct BorderStop {
  std::uint32_t vertex = delaunay::kNone;  ///< kNone: a sample that is no vertex yet.
  Index3 sample;                           ///< For samples only.
  int balance = 0;                         ///< Edges in the plane that start here - that end here.
};

/// The border polygon of one plane, counter-clockwise as seen from outside: which parts of it, from
/// each stop to the next, are inside.
struct BorderPolygon {
  std::vector<BorderStop> stops;
  std::vector<bool> is_inside;
  bool is_known = false;

  /// An edge that ends here goes on along the border; one that starts here came along it.
  [[nodiscard]] Result<void> walk() {
    const auto turning = std::find_if(stops.begin(), stops.end(),
                                      [](const BorderStop& stop) { return stop.balance != 0; });
    if (turning == stops.end()) return {};
    is_inside.assign(stops.size(), false);
    const auto first = static_cast<std::size_t>(turning - stops.begin());
    bool state = turning->balance > 0;
    for (std::size_t n = 0; n < stops.size(); ++n) {
      const std::size_t i = (first + n) % stops.size();
      if (stops[i].balance != 0) {
        if (std::abs(stops[i].balance) != 1 || state != (stops[i].balance > 0))
          return fail("the surface's edges there do not alternate along an edge of the domain");
        state = !state;
      }
      is_inside[i] = state;
    }
    is_known = true;
    return {};
  }
  void set_all(bool state) {
    is_inside.assign(stops.size(), state);
    is_known = true;
  }
};

}  // namespace lode::diamond

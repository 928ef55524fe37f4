#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/place_polygon.h"

namespace lode {

/// Finds places in polygons. Const members are safe from many threads.
class PolygonLocator {
 public:
  /// Of finite places. O(corners): bands of y know which edges reach into them, four each or so.
  explicit PolygonLocator(std::span<const PlacePolygon> polygons);

  /// Whether a place is in any of the polygons or on the border of one, exactly. Looks at the edges
  /// of one band.
  [[nodiscard]] bool holds(const Vec<double, 2>& p) const;

 private:
  struct Edge {
    Vec<double, 2> a;
    Vec<double, 2> b;
    std::uint32_t polygon;
  };

  void add_edges(const PlacePolygon& polygon, std::uint32_t number);
  void sort_into_bands();
  [[nodiscard]] std::size_t band_of(double y) const;

  std::vector<Edge> edges_;  ///< Polygon by polygon.
  double lowest_ = 0;
  double highest_ = 0;
  std::size_t n_bands_ = 1;
  std::vector<std::size_t> first_;       ///< Per band, in `reaching_`; one more.
  std::vector<std::uint32_t> reaching_;  ///< Edges, in their order.
};

}  // namespace lode

#include "lode/models/terrain/tile_pyramid/tile_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace lode::tile_pyramid {
namespace {

/// In columns and rows of the raster.
struct Corner {
  double x = 0, y = 0, z = 0;
};

/// What a row has of a triangle.
struct Span {
  double x_low = std::numeric_limits<double>::infinity();
  double x_high = -std::numeric_limits<double>::infinity();
  double z_low = 0, z_high = 0;

  void add(double x, double z) {
    if (x < x_low) {
      x_low = x;
      z_low = z;
    }
    if (x > x_high) {
      x_high = x;
      z_high = z;
    }
  }
};

/// What samples may be off an edge by rounding, in columns and rows.
constexpr double kSlack = 1e-9;

void cut_edge(const Corner& a, const Corner& b, double y, Span& span) {
  const auto [low, high] = std::minmax(a.y, b.y);
  if (y < low - kSlack || y > high + kSlack) return;
  if (high - low <= kSlack) {
    span.add(a.x, a.z);
    span.add(b.x, b.z);
    return;
  }
  const double part = std::clamp((y - a.y) / (b.y - a.y), 0.0, 1.0);
  span.add(a.x + part * (b.x - a.x), a.z + part * (b.z - a.z));
}

/// One row of a triangle. Heights are mixed along it, so that they are between those of the edges
/// however thin the triangle is.
void measure_row(const Span& span, const RowStrip& strip, IndexRange columns, std::int64_t row,
                 WorstInTriangle& worst, int turn) {
  const double width = span.x_high - span.x_low;
  const double slope = width > 0 ? (span.z_high - span.z_low) / width : 0;
  const auto [lowest, highest] = std::minmax(span.z_low, span.z_high);
  for (std::int64_t column = columns.first; column <= columns.last; ++column) {
    const double z = strip.sample(column, row);
    const double way = span.z_low + slope * (static_cast<double>(column) - span.x_low);
    const double error = std::abs(z - std::clamp(way, lowest, highest));
    // False of a missing sample, too.
    if (error > worst.error) worst = {error, z, column, row, turn};
  }
}

/// Of whole numbers from a to b, with slack, those in `all`.
IndexRange whole_between(double a, double b, IndexRange all) {
  const auto low = static_cast<double>(all.first);
  const auto high = static_cast<double>(all.last);
  return {static_cast<std::int64_t>(std::ceil(std::clamp(a - kSlack, low, high + 1))),
          static_cast<std::int64_t>(std::floor(std::clamp(b + kSlack, low - 1, high)))};
}

void measure_triangle(const std::array<Corner, 3>& corners, const ExtendedRaster& raster,
                      const RowStrip& strip, IndexRange rows, int turn, WorstInTriangle& worst) {
  const auto [y_low, y_high] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
  const IndexRange held = whole_between(y_low, y_high, rows);
  for (std::int64_t row = held.first; row <= held.last; ++row) {
    Span span;
    for (std::size_t edge = 0; edge < 3; ++edge)
      cut_edge(corners[edge], corners[(edge + 1) % 3], static_cast<double>(row), span);
    const IndexRange columns = whole_between(span.x_low, span.x_high, {0, raster.n_columns() - 1});
    measure_row(span, strip, columns, row, worst, turn);
  }
}

}  // namespace

void measure(const TileMesh& mesh, const TileId& tile, const ExtendedRaster& raster,
             const RowStrip& strip, IndexRange rows, std::span<const std::uint32_t> triangles,
             std::span<WorstInTriangle> worst) {
  const double size = tile_size(tile.level);
  const double west = west_of(tile);
  const double south = south_of(tile);
  for (int turn = ExtendedRaster::kFirstTurn; turn <= ExtendedRaster::kLastTurn; ++turn) {
    if (raster.columns_between(west, west + size, turn, 0, 0).is_empty()) continue;
    const auto corner = [&](std::uint32_t v) {
      const TileVertex& vertex = mesh.vertices[v];
      return Corner{raster.column(west + size * vertex.node.x / kLastNode, turn),
                    raster.row(south + size * vertex.node.y / kLastNode), vertex.height};
    };
    for (const std::uint32_t t : triangles) {
      const auto& triangle = mesh.triangles[t];
      measure_triangle({corner(triangle[0]), corner(triangle[1]), corner(triangle[2])}, raster,
                       strip, rows, turn, worst[t]);
    }
  }
}

LatticePoint node_of(const TileId& tile, const ExtendedRaster& raster, std::int64_t column,
                     std::int64_t row, int turn) {
  const double size = tile_size(tile.level);
  const double x = (raster.longitude(static_cast<double>(column), turn) - west_of(tile)) / size;
  const double y = (raster.latitude(static_cast<double>(row)) - south_of(tile)) / size;
  return {static_cast<std::int32_t>(std::lround(x * kLastNode)),
          static_cast<std::int32_t>(std::lround(y * kLastNode))};
}

}  // namespace lode::tile_pyramid

#include "contour_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "to_crs.h"
#include "vector_output.h"

namespace lode::cli {
namespace {

std::string contour_comment(const TerrainAnswerer& answerer) {
  const TerrainReport& report = answerer.tin.report();
  const std::string& crs = written_crs(answerer.opened, answerer.target);
  return fmt::format("Lode {}: contours of {}, max_error {}, achieved_error {} at samples{}{}",
                     LODE_VERSION, name_of(answerer.opened.model), report.max_error,
                     report.achieved_error, answerer.target ? " of its source" : "",
                     crs.empty() ? "" : ", CRS " + crs);
}

/// Whole numbers below all coordinates, so that floats hold these as well as they can.
Vec3d origin_of(const TerrainContours& contours) {
  Place lower{{0, 0}};
  bool is_first = true;
  for (const TerrainContours::Line& line : contours.lines)
    for (const Place& at : line.points) {
      lower = is_first ? at : Place{{std::min(lower[0], at[0]), std::min(lower[1], at[1])}};
      is_first = false;
    }
  return {{std::floor(lower[0]), std::floor(lower[1]), 0}};
}

Result<PlacedSurface> to_line_surface(const TerrainContours& contours) {
  if (contours.n_points > std::numeric_limits<std::uint32_t>::max())
    return fail("expected at most 2^32 points for .vtp, got {}", contours.n_points);
  PlacedSurface placed;
  Surface& surface = placed.surface;
  surface.origin = origin_of(contours);
  for (const TerrainContours::Line& line : contours.lines) {
    const auto first = static_cast<std::uint32_t>(surface.positions.size());
    // A ring's last point is its first.
    const auto n = static_cast<std::uint32_t>(line.points.size() - (line.is_ring ? 1 : 0));
    for (std::uint32_t i = 0; i < n; ++i) {
      const Place& at = line.points[i];
      surface.positions.push_back(
          {{static_cast<float>(at[0] - surface.origin[0]),
            static_cast<float>(at[1] - surface.origin[1]), static_cast<float>(line.height)}});
      placed.places.push_back({{at[0], at[1], line.height}});
      surface.values.push_back(line.height);
      if (i + 1 < n)
        surface.lines.push_back({first + i, first + i + 1});
      else if (line.is_ring)
        surface.lines.push_back({first + i, first});
    }
  }
  return placed;
}

}  // namespace

Result<void> write_contours(const std::string& path, const TerrainAnswerer& answerer,
                            const TerrainContours& contours, Progress& progress) {
  if (is_vtp_path(path)) {
    LODE_TRY(const PlacedSurface placed, to_line_surface(contours));
    return write_surface(
        path, placed.surface,
        {.comment = contour_comment(answerer), .value_name = "height", .places = placed.places},
        progress);
  }
  LODE_TRY(VectorWriter writer,
           VectorWriter::create(path, {.name = "contours",
                                       .shape = VectorShape::lines,
                                       .columns = {{"height"}},
                                       .crs = written_crs(answerer.opened, answerer.target)}));
  return write_each(writer, contours.lines.size(), progress, [&](std::size_t i) {
    const TerrainContours::Line& line = contours.lines[i];
    return writer.add({&line.height, 1}, {&line.points, 1});
  });
}

Result<void> write_bands(const std::string& path, const TerrainAnswerer& answerer,
                         const TerrainBands& bands, Progress& progress) {
  LODE_TRY(VectorWriter writer,
           VectorWriter::create(path, {.name = "bands",
                                       .shape = VectorShape::polygons,
                                       .columns = {{"lower"}, {"upper"}},
                                       .crs = written_crs(answerer.opened, answerer.target)}));
  return write_each(writer, bands.polygons.size(), progress, [&](std::size_t i) {
    const TerrainBands::Polygon& polygon = bands.polygons[i];
    return writer.add(std::array{polygon.lower, polygon.upper}, polygon.rings);
  });
}

}  // namespace lode::cli

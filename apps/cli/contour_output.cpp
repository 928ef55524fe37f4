#include "contour_output.h"

#include <fmt/format.h>

#include <array>
#include <utility>

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

/// A ring's last place is its first.
Network to_network(const TerrainContours& contours) {
  Network network;
  network.places.reserve(contours.n_points);
  Network::Column heights{.name = "height", .values = {}};
  for (const TerrainContours::Line& line : contours.lines) {
    for (const Place& at : line.points) network.places.push_back({{at[0], at[1], line.height}});
    network.line_ends.push_back(network.places.size());
    heights.values.push_back(line.height);
  }
  network.columns = {std::move(heights)};
  return network;
}

}  // namespace

Result<void> write_contours(const std::string& path, const TerrainAnswerer& answerer,
                            const TerrainContours& contours, Progress& progress) {
  if (is_vtp_path(path))
    return write_network_vtp(path, to_network(contours), contour_comment(answerer), progress);
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

#include "neighbour_output.h"

#include <fmt/format.h>

#include <iterator>
#include <utility>

#include "lode/api/terrain_neighbours.h"
#include "outputs.h"
#include "to_crs.h"
#include "vector_output.h"

namespace lode::cli {
namespace {

std::string neighbour_csv(const TerrainAnswerer& answerer, const std::vector<Place>& places,
                          const std::vector<TerrainNeighbours>& answers) {
  std::string text =
      "place,x,y,ring,triangle,x1,y1,height1,x2,y2,height2,x3,y3,height3,bound,bound_kind,"
      "beside1,beside2,beside3\n";
  auto out = std::back_inserter(text);
  const char* kind = bound_kind_of(answerer.tin.report());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& at = places[i];
    if (answers[i].triangles.empty())
      fmt::format_to(out, "{},{},{},,,,,,,,,,,,,,,,\n", i + 1, at[0], at[1]);
    for (const TerrainTriangle& one : answers[i].triangles) {
      fmt::format_to(out, "{},{},{},{},{}", i + 1, at[0], at[1], one.ring, one.triangle);
      for (const Vec3d& p : one.corners) fmt::format_to(out, ",{},{},{}", p[0], p[1], p[2]);
      const auto beside = describe_beside(one);
      fmt::format_to(out, ",{},{},{},{},{}\n", one.bound, kind, beside[0], beside[1], beside[2]);
    }
  }
  return text;
}

VectorLayer to_layer(const std::string& crs) {
  return {.name = "triangles",
          .shape = VectorShape::polygons,
          .columns = {{"place", ColumnType::integer},
                      {"ring", ColumnType::integer},
                      {"triangle", ColumnType::integer},
                      {"height1"},
                      {"height2"},
                      {"height3"},
                      {"bound"},
                      {"bound_kind", ColumnType::text},
                      {"beside1", ColumnType::text},
                      {"beside2", ColumnType::text},
                      {"beside3", ColumnType::text}},
          .crs = crs};
}

Result<void> add_triangle(VectorWriter& writer, std::size_t place, const TerrainTriangle& one,
                          const char* kind) {
  const auto beside = describe_beside(one);
  const std::vector<VectorValue> values{static_cast<double>(place),
                                        static_cast<double>(one.ring),
                                        static_cast<double>(one.triangle),
                                        one.corners[0][2],
                                        one.corners[1][2],
                                        one.corners[2][2],
                                        one.bound,
                                        kind,
                                        beside[0],
                                        beside[1],
                                        beside[2]};
  VectorWriter::Points ring;
  for (const std::size_t i : {0U, 1U, 2U, 0U})
    ring.push_back({{one.corners[i][0], one.corners[i][1]}});
  return writer.add(values, {&ring, 1});
}

}  // namespace

std::array<std::string, 3> describe_beside(const TerrainTriangle& triangle) {
  std::array<std::string, 3> texts;
  for (const TerrainTriangle::Beside& one : triangle.beside)
    texts[one.edge] += fmt::format("{}{}:{}", texts[one.edge].empty() ? "" : " ", one.triangle,
                                   one.other_edge + 1);
  for (std::string& text : texts)
    if (text.empty()) text = "none";
  return texts;
}

Result<void> write_neighbours(const std::string& path, const TerrainAnswerer& answerer,
                              const std::vector<Place>& places,
                              const std::vector<TerrainNeighbours>& answers, Progress& progress) {
  if (check_extension(path, ".csv"))
    return write_text(path, neighbour_csv(answerer, places, answers), progress);
  std::vector<std::pair<std::size_t, const TerrainTriangle*>> triangles;
  for (std::size_t i = 0; i < answers.size(); ++i)
    for (const TerrainTriangle& one : answers[i].triangles) triangles.emplace_back(i + 1, &one);
  LODE_TRY(VectorWriter writer,
           VectorWriter::create(path, to_layer(written_crs(answerer.opened, {}))));
  return write_each(writer, triangles.size(), progress, [&](std::size_t i) {
    return add_triangle(writer, triangles[i].first, *triangles[i].second,
                        bound_kind_of(answerer.tin.report()));
  });
}

}  // namespace lode::cli

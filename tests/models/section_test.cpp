// Planes through volumes, also where they pass through samples and lie in the border.
#include "lode/mappers/surface_checks.h"
#include "tests/models/mesh_fixtures.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

/// The corners of the plane's part of the data's box, which may be oblique, in order.
std::vector<Vec3d> plane_polygon(const RegularGrid& grid, const SectionPlane& plane) {
  constexpr double kInPlane = 1e-7;
  const Vec3d normal = normalized(plane.normal);
  std::array<Vec3d, 8> corner;
  std::array<double, 8> distance{};
  for (std::size_t c = 0; c < 8; ++c) {
    Vec3d index;
    for (std::size_t i = 0; i < 3; ++i) index[i] = ((c >> i) & 1U) != 0 ? grid.dims[i] - 1 : 0;
    corner[c] = grid.to_world(index);
    distance[c] = dot(normal, corner[c] - plane.point);
  }
  std::vector<Vec3d> polygon;
  for (std::size_t c = 0; c < 8; ++c) {
    if (std::abs(distance[c]) <= kInPlane) polygon.push_back(corner[c]);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t d = c | (std::size_t{1} << i);
      if (d == c || std::abs(distance[c]) <= kInPlane || std::abs(distance[d]) <= kInPlane ||
          distance[c] * distance[d] > 0)
        continue;
      const double t = distance[c] / (distance[c] - distance[d]);
      polygon.push_back(corner[c] + (corner[d] - corner[c]) * t);
    }
  }
  Vec3d middle;
  for (const Vec3d& p : polygon) middle = middle + p * (1.0 / static_cast<double>(polygon.size()));
  if (polygon.empty()) return polygon;
  const Vec3d u = normalized(polygon[0] - middle);
  const Vec3d v = cross(normal, u);
  std::sort(polygon.begin(), polygon.end(), [&](const Vec3d& a, const Vec3d& b) {
    return std::atan2(dot(v, a - middle), dot(u, a - middle)) <
           std::atan2(dot(v, b - middle), dot(u, b - middle));
  });
  return polygon;
}

double area_of(const std::vector<Vec3d>& polygon) {
  Vec3d sum;
  for (std::size_t i = 2; i < polygon.size(); ++i)
    sum = sum + cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
  return length(sum) / 2;
}

/// The triangles' area; each must be turned to the normal.
double area_of(const Surface& section, const SectionPlane& plane) {
  double area = 0;
  for (const auto& t : section.triangles) {
    const Vec3d a = section.world_position(t[0]);
    const Vec3d n = cross(section.world_position(t[1]) - a, section.world_position(t[2]) - a);
    EXPECT_GT(dot(n, plane.normal), 0);
    area += length(n) / 2;
  }
  return area;
}

bool is_at_border(const RegularGrid& grid, const Vec3d& a, const Vec3d& b) {
  const Vec3d p = grid.to_index(a);
  const Vec3d q = grid.to_index(b);
  for (std::size_t i = 0; i < 3; ++i)
    for (const double end : {0.0, grid.dims[i] - 1.0})
      if (std::abs(p[i] - end) < 1e-3 && std::abs(q[i] - end) < 1e-3) return true;
  return false;
}

void expect_manifold_to_the_border(const Surface& section, const RegularGrid& grid) {
  const TopologyReport topology = check_topology(section, {});
  EXPECT_TRUE(topology.is_clean_manifold())
      << topology.non_manifold_edges.count << ' ' << topology.inconsistent_edges.count << ' '
      << topology.non_manifold_vertices.count << ' ' << topology.degenerate_simplices.count << ' '
      << topology.duplicate_vertices.count << ' ' << topology.isolated_vertices.count;
  EXPECT_EQ(topology.n_twins, 0U);
  EXPECT_EQ(topology.components.size(), 1U);
  EXPECT_EQ(topology.euler_number, 1);
  for (const auto& [a, b] : find_boundary_edges(section, {}))
    ASSERT_TRUE(is_at_border(grid, section.world_position(a), section.world_position(b)));
}

/// At random points of all triangles. Slack: coordinates of about 100 are rounded to 4e-6, on a
/// field that rises by at most 150 a step of 0.5.
void expect_values_within_errors(const Surface& section, const Volume& volume) {
  constexpr double kSlack = 5e-3;
  std::mt19937 random(1);
  ASSERT_EQ(section.errors.size(), section.triangles.size());
  for (std::size_t i = 0; i < section.triangles.size(); ++i) {
    const auto& t = section.triangles[i];
    double weights[3] = {double(random() % 100), double(random() % 100), 1};
    const double sum = weights[0] + weights[1] + weights[2];
    Vec3d p;
    double value = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      p = p + section.world_position(t[k]) * (weights[k] / sum);
      value += section.values[t[k]] * weights[k] / sum;
    }
    const double error = static_cast<double>(section.errors[i]);
    ASSERT_LE(std::abs(value - field_at(volume, p)), error + kSlack);
  }
}

SectionReport cut(const Dataset& dataset, const SectionOptions& options, Surface& section) {
  Progress progress;
  const auto report = dataset.extract_section(options, section, progress);
  EXPECT_TRUE(report) << report.error().message;
  return report ? report.value() : SectionReport{};
}

void expect_sound(const Volume& volume, const Dataset& dataset, const SectionPlane& plane,
                  double tolerance) {
  const RegularGrid& grid = volume.info.grid;
  Surface section;
  const SectionReport report = cut(dataset, {.plane = plane, .max_error = tolerance}, section);
  EXPECT_LE(report.achieved_error, tolerance);
  EXPECT_EQ(report.n_triangles, section.triangles.size());
  const double expected = area_of(plane_polygon(grid, plane));
  ASSERT_GT(expected, 0);
  EXPECT_NEAR(area_of(section, plane), expected, 1e-4 * expected);
  expect_manifold_to_the_border(section, grid);
  expect_values_within_errors(section, volume);
}

/// Through sample layers, the first and the last among them, and between; both ways.
std::vector<SectionPlane> planes_along_the_grid(const RegularGrid& grid) {
  std::vector<SectionPlane> planes;
  const Mat3 normals = cofactors(grid.index_to_world_matrix());
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const double share : {0.0, 0.5, 0.63, 1.0})
      for (const double sign : {-1.0, 1.0}) {
        Vec3d index{{0, 0, 0}};
        const double last = grid.dims[axis] - 1;
        index[axis] = share == 0.5 ? std::floor(last / 2) : share * last;
        planes.push_back({grid.to_world(index), normals.column(axis) * sign});
      }
  return planes;
}

std::vector<SectionPlane> oblique_planes(const RegularGrid& grid) {
  std::vector<SectionPlane> planes;
  Vec3d middle;
  for (std::size_t i = 0; i < 3; ++i) middle[i] = 0.5 * (grid.dims[i] - 1);
  for (const Vec3d& normal : {Vec3d{{1, 1, 1}}, Vec3d{{1, -1, 0}}, Vec3d{{0.2, 3, -1}},
                              Vec3d{{-1, 2, 0.001}}, Vec3d{{0, 1e-3, -1}}, Vec3d{{1, 1, -2}}})
    planes.push_back({grid.to_world(middle), normal});
  return planes;
}

TEST(section, is_the_planes_part_of_the_domain) {
  for (const Index3& dims : oracles::trials<std::vector<Index3>>(
           {{{11, 6, 9}}, {{17, 17, 17}}, {{20, 31, 14}}}, {{{11, 6, 9}}, {{17, 9, 17}}}))
    for (const RegularGrid& grid : {plain_grid(dims), awkward_grid(dims)}) {
      const Volume volume = noisy_volume(grid, 1);
      const Dataset dataset = dataset_of(volume);
      std::vector<SectionPlane> planes = planes_along_the_grid(grid);
      for (const SectionPlane& plane : oblique_planes(grid)) planes.push_back(plane);
      for (const SectionPlane& plane : planes)
        for (const double tolerance : {0.0, 6.0, 1e30}) {
          SCOPED_TRACE(fmt::format("dims {} {} {}, normal {} {} {}, point {} {} {}, tolerance {}",
                                   dims[0], dims[1], dims[2], plane.normal[0], plane.normal[1],
                                   plane.normal[2], plane.point[0], plane.point[1], plane.point[2],
                                   tolerance));
          expect_sound(volume, dataset, plane, tolerance);
        }
    }
}

TEST(section, through_a_layer_of_samples_has_their_values_and_nothing_else) {
  const Volume volume = noisy_volume(plain_grid({{12, 9, 10}}), 2);
  const Dataset dataset = dataset_of(volume);
  for (const std::int32_t layer : {0, 4, 9}) {
    Surface section;
    const SectionReport report =
        cut(dataset, {.plane = {{{0, 0, double(layer)}}, {{0, 0, 1}}}, .max_error = 0}, section);
    EXPECT_EQ(report.n_triangles, 2U * 11 * 8);
    EXPECT_EQ(report.n_vertices, 12U * 9);
    EXPECT_EQ(report.achieved_error, 0);
    for (std::uint32_t v = 0; v < section.positions.size(); ++v) {
      const Vec3d p = section.world_position(v);
      const Index3 at{{std::int32_t(p[0]), std::int32_t(p[1]), layer}};
      EXPECT_EQ(p, (Vec3d{{double(at[0]), double(at[1]), double(layer)}}));
      EXPECT_EQ(section.values[v], sample_at(volume, at));
    }
  }
}

TEST(section, beside_the_domain_is_empty) {
  const Dataset dataset = dataset_of(noisy_volume(plain_grid({{12, 9, 10}}), 2));
  Surface section;
  for (const double z : {-0.01, 9.01})
    EXPECT_EQ(cut(dataset, {.plane = {{{0, 0, z}}, {{0, 0, 1}}}}, section).n_triangles, 0U);
}

TEST(section, far_from_the_origin_is_as_sound) {
  RegularGrid grid = plain_grid({{20, 31, 14}});
  grid.origin = {{500000.5, 4649776.25, -3000}};
  grid.spacing = {{0.1, 0.1, 0.25}};
  const Volume volume = noisy_volume(grid, 7);
  const Dataset dataset = dataset_of(volume);
  std::vector<SectionPlane> planes = planes_along_the_grid(grid);
  for (const SectionPlane& plane : oblique_planes(grid)) planes.push_back(plane);
  for (const SectionPlane& plane : planes)
    for (const double tolerance : {0.0, 6.0, 1e30}) expect_sound(volume, dataset, plane, tolerance);
}

TEST(section, ends_at_holes) {
  for (std::uint32_t seed = 0; seed < 8; ++seed) {
    const Volume volume = holed_volume(plain_grid({{20, 15, 17}}), seed);
    const Dataset dataset = dataset_of(volume);
    std::vector<SectionPlane> planes = planes_along_the_grid(volume.info.grid);
    for (const SectionPlane& plane : oblique_planes(volume.info.grid)) planes.push_back(plane);
    for (const SectionPlane& plane : planes) {
      Surface section;
      const SectionReport report = cut(dataset, {.plane = plane, .max_error = 8}, section);
      EXPECT_EQ(report.n_left_out, 0U);
      EXPECT_LE(report.achieved_error, 8);
      EXPECT_LE(area_of(section, plane),
                area_of(plane_polygon(volume.info.grid, plane)) * (1 + 1e-4));
      EXPECT_TRUE(check_topology(section, {}).is_clean_manifold());
      for (std::size_t i = 0; i < section.triangles.size(); ++i) {
        Vec3d middle;
        double value = 0;
        for (const std::uint32_t v : section.triangles[i]) {
          middle = middle + section.world_position(v) * (1.0 / 3);
          value += section.values[v] / 3;
        }
        const double field = field_at(volume, middle);
        if (!std::isnan(field)) {  // not in a removed cell beside a face of the section
          ASSERT_LE(std::abs(value - field), static_cast<double>(section.errors[i]) + 5e-3);
        }
      }
    }
  }
}

TEST(section, isolines_lie_where_the_field_is_the_isovalue) {
  for (const RegularGrid& grid :
       {plain_grid({{20, 31, 14}}), awkward_grid({{20, 31, 14}}), plain_grid({{17, 17, 17}})}) {
    const Volume volume = noisy_volume(grid, 3);
    const Dataset dataset = dataset_of(volume);
    std::vector<SectionPlane> planes = planes_along_the_grid(grid);
    for (const SectionPlane& plane : oblique_planes(grid)) planes.push_back(plane);
    for (const SectionPlane& plane : planes)
      for (const double tolerance : {0.0, 5.0}) {
        Surface lines;
        const SectionReport report =
            cut(dataset, {.plane = plane, .isovalues = {60}, .max_error = tolerance}, lines);
        EXPECT_LE(report.achieved_error, tolerance);
        EXPECT_EQ(report.n_lines, lines.lines.size());
        EXPECT_TRUE(lines.triangles.empty());
        const TopologyReport topology = check_topology(lines, {});
        EXPECT_EQ(topology.non_manifold_vertices.count, 0U);
        EXPECT_EQ(topology.inconsistent_edges.count, 0U);
        for (const auto& end : find_boundary_edges(lines, {})) {
          const Vec3d p = lines.world_position(end[0]);
          ASSERT_TRUE(is_at_border(grid, p, p));
        }
        for (std::uint32_t v = 0; v < lines.positions.size(); ++v)
          ASSERT_NEAR(field_at(volume, lines.world_position(v)), 60, report.achieved_error + 0.02);
      }
  }
}

TEST(section, several_isovalues_are_told_apart) {
  const Dataset dataset = dataset_of(noisy_volume(plain_grid({{20, 31, 14}}), 3));
  Surface lines;
  const SectionReport report =
      cut(dataset, {.plane = {{{0, 0, 6}}, {{0, 0, 1}}}, .isovalues = {50, 70}}, lines);
  EXPECT_GT(report.n_lines, 0U);
  ASSERT_EQ(lines.isovalues.size(), lines.positions.size());
  ASSERT_EQ(lines.errors.size(), lines.lines.size());
  for (const auto& line : lines.lines)
    EXPECT_EQ(lines.isovalues[line[0]], lines.isovalues[line[1]]);
}

TEST(section, of_2d_data_is_refused) {
  const Dataset dataset = dataset_of(noisy_volume(plain_grid({{20, 31, 1}}), 3));
  Progress progress;
  Surface section;
  const auto report =
      dataset.extract_section({.plane = {{{0, 0, 0}}, {{1, 0, 0}}}}, section, progress);
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find("expected a volume"), std::string::npos);
}

}  // namespace
}  // namespace lode::test

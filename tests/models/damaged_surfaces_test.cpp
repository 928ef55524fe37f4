// What is done to simplified surfaces, and to those that are held to a bound alone, is found: no
// query repeats either of them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "lode/mappers/crossed_edge.h"
#include "lode/mappers/surface_topology.h"
#include "tests/models/built_dataset.h"
#include "tests/oracles/random.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

/// Sheets across the volume, on axes that are turned and mirrored, with noise on them.
Volume waves() {
  RegularGrid grid;
  grid.dims = {{30, 26, 22}};
  grid.spacing = {{0.5, 1, 0.75}};
  grid.origin = {{-3, 2, 10}};
  grid.direction = {{Vec3d{{0, 1, 0}}, Vec3d{{1, 0, 0}}, Vec3d{{0, 0, 1}}}};
  oracles::Random random(4);
  return oracles::volume_of<float>(grid, [&](const Index3& p) {
    return 100 * std::sin(0.6 * p[0] + 0.1 * p[1] - 0.05 * p[2]) + random.uniform(-4, 4);
  });
}

constexpr double kIsovalue = 20;

/// By vertex, the lowest of its piece.
std::vector<std::uint32_t> pieces_of(const Surface& surface) {
  std::vector<std::uint32_t> piece(surface.positions.size());
  std::iota(piece.begin(), piece.end(), 0U);
  for (bool has_changed = true; has_changed;) {
    has_changed = false;
    for (const auto& t : surface.triangles) {
      const std::uint32_t low = std::min({piece[t[0]], piece[t[1]], piece[t[2]]});
      for (const std::uint32_t v : t) {
        has_changed = has_changed || piece[v] != low;
        piece[v] = low;
      }
    }
  }
  return piece;
}

/// How many triangles each piece has, by its lowest vertex.
std::map<std::uint32_t, std::size_t> sizes_of(const Surface& surface) {
  const std::vector<std::uint32_t> piece = pieces_of(surface);
  std::map<std::uint32_t, std::size_t> sizes;
  for (const auto& t : surface.triangles) ++sizes[piece[t[0]]];
  return sizes;
}

Surface with_piece_turned(Surface surface, std::uint32_t which) {
  const std::vector<std::uint32_t> piece = pieces_of(surface);
  for (auto& t : surface.triangles)
    if (piece[t[0]] == which) std::swap(t[1], t[2]);
  return surface;
}

struct Way {
  const char* name;
  ExtractOptions options;
};

std::vector<Way> ways() {
  ExtractOptions plain{.isovalues = {kIsovalue}, .max_error = 0.0, .threads = {2}};
  ExtractOptions within = plain;
  within.simplify = Simplify::edges;
  within.simplify_distance = 0.4;
  ExtractOptions cubes = within;
  cubes.style = SurfaceStyle::cubes;
  cubes.style_distance = 0.2;
  ExtractOptions slivers = plain;
  slivers.simplify = Simplify::slivers;
  slivers.simplify_distance = 0.2;
  ExtractOptions band = plain;
  band.simplify = Simplify::edges;
  band.max_error = 12.0;
  return {{"distance", within}, {"cubes", cubes}, {"slivers", slivers}, {"band", band}};
}

class damaged_surfaces : public testing::Test {
 protected:
  [[nodiscard]] Surface extracted(const ExtractOptions& options) const {
    Progress progress;
    Surface surface;
    const auto report = dataset_.extract(options, surface, progress);
    EXPECT_TRUE(report) << report.error().message;
    return surface;
  }
  /// Names of the checks that fail.
  [[nodiscard]] std::string failed(const Surface& surface, const ExtractOptions& options) const {
    Progress progress;
    return failures_in(dataset_.verify_surface(surface, options, progress));
  }
  [[nodiscard]] std::string failed(const Surface& surface, const BoundOptions& options) const {
    Progress progress;
    return failures_in(dataset_.verify_bound(surface, options, progress));
  }
  static std::string failures_in(const Result<VerifyReport>& report) {
    EXPECT_TRUE(report) << report.error().message;
    std::string names;
    for (const auto& check : report->checks)
      if (!check.passed) names += check.name + ": " + check.detail + "\n";
    return names;
  }

  Dataset dataset_ = test::built_dataset(waves());
};

TEST_F(damaged_surfaces, that_are_not_pass) {
  for (const Way& one : ways())
    EXPECT_EQ(failed(extracted(one.options), one.options), "") << one.name;
}

/// Rims at holes go along planes of samples, and may cut their corners.
TEST_F(damaged_surfaces, that_are_not_pass_round_holes) {
  const Volume whole = waves();
  const RegularGrid& grid = whole.info.grid;
  dataset_ = test::built_dataset(oracles::volume_of<float>(grid, [&](const Index3& p) {
    const bool is_hole = std::hypot(p[0] - 14.0, p[1] - 12.5, p[2] - 11.2) < 6;
    const auto at = static_cast<std::size_t>((p[2] * grid.dims[1] + p[1]) * grid.dims[0] + p[0]);
    return is_hole ? std::nan("") : static_cast<double>(whole.as<float>()[at]);
  }));
  for (const Way& one : ways())
    EXPECT_EQ(failed(extracted(one.options), one.options), "") << one.name;
}

TEST_F(damaged_surfaces, end_where_a_triangle_is_torn_from_their_rims) {
  for (const Way& one : ways()) {
    SCOPED_TRACE(one.name);
    const Surface surface = extracted(one.options);
    const std::vector<std::uint32_t> piece = pieces_of(surface);
    std::map<std::uint32_t, std::size_t> sizes = sizes_of(surface);
    std::size_t n_torn = 0;
    for (const auto& edge : find_boundary_edges(surface, {})) {
      // Pieces that are gone as a whole may have been dropped.
      if (sizes[piece[edge[0]]] < 2 || n_torn > 4) continue;
      ++n_torn;
      Surface torn = surface;
      std::erase_if(torn.triangles, [&](const auto& t) {
        return std::ranges::count_if(
                   t, [&](std::uint32_t v) { return v == edge[0] || v == edge[1]; }) == 2;
      });
      ASSERT_LT(torn.triangles.size(), surface.triangles.size());
      EXPECT_NE(failed(torn, one.options).find("ends only at the border"), std::string::npos);
    }
    EXPECT_GT(n_torn, 4U);
  }
}

TEST_F(damaged_surfaces, end_where_a_vertex_is_pulled_from_their_rims) {
  for (const Way& one : ways()) {
    SCOPED_TRACE(one.name);
    const Surface surface = extracted(one.options);
    const Box3d all = waves().info.grid.world_bounds();
    const Vec3d middle = (all.lower + all.upper) * 0.5;
    for (const auto& edge : {find_boundary_edges(surface, {})[3]}) {
      Surface pulled = surface;
      const Vec3d from = pulled.world_position(edge[0]);
      pulled.positions[edge[0]] = narrowed(from + (middle - from) * 0.01 - pulled.origin);
      EXPECT_NE(failed(pulled, one.options).find("ends only at the border"), std::string::npos);
    }
  }
}

TEST_F(damaged_surfaces, face_another_way_where_a_piece_is_turned) {
  for (const Way& one : ways()) {
    SCOPED_TRACE(one.name);
    const Surface surface = extracted(one.options);
    std::size_t n_turned = 0;
    for (const auto& [piece, n] : sizes_of(surface)) {
      if (n < 2) continue;
      ++n_turned;
      EXPECT_NE(failed(with_piece_turned(surface, piece), one.options).find("on their sides"),
                std::string::npos)
          << n;
    }
    EXPECT_GT(n_turned, 2U);
  }
}

TEST_F(damaged_surfaces, held_to_a_bound_have_no_hole_and_no_piece_turned) {
  const ExtractOptions options{.isovalues = {kIsovalue}, .max_error = 8.0, .threads = {2}};
  const Surface surface = extracted(options);
  const Box3d box{{{0, 5, 13}}, {{15, 12, 22}}};
  for (const std::vector<Box3d>& boxes : {std::vector<Box3d>{}, {box}}) {
    const BoundOptions bound{.isovalue = kIsovalue, .error = 8, .boxes = boxes, .threads = {2}};
    EXPECT_EQ(failed(surface, bound), "");
    // All of it the other way round is a surface of another program.
    Surface turned = surface;
    for (auto& t : turned.triangles) std::swap(t[1], t[2]);
    EXPECT_EQ(failed(turned, bound), "");
    // A hole, inside the box and not at its rim.
    Surface torn = surface;
    const auto in_middle = [&](const auto& t) {
      const Vec3d p = surface.world_position(t[0]);
      return p[0] > 4 && p[0] < 11 && p[1] > 7 && p[1] < 10 && p[2] > 15 && p[2] < 20;
    };
    const auto hole = std::ranges::find_if(torn.triangles, in_middle);
    ASSERT_NE(hole, torn.triangles.end());
    torn.triangles.erase(hole);
    EXPECT_NE(failed(torn, bound).find("ends only at the border"), std::string::npos);
    std::size_t n_found = 0;
    for (const auto& [piece, n] : sizes_of(surface))
      if (n >= 60)
        n_found += failed(with_piece_turned(surface, piece), bound).find("on their sides") !=
                           std::string::npos
                       ? 1
                       : 0;
    EXPECT_GT(n_found, 0U);
    if (boxes.empty()) EXPECT_GT(n_found, 2U);
  }
}

}  // namespace
}  // namespace lode

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <mutex>
#include <numbers>
#include <set>
#include <tuple>

#include "lode/core/ellipsoid.h"
#include "lode/core/vec.h"
#include "lode/delaunay/lattice.h"
#include "lode/models/terrain/tile_pyramid/build.h"
#include "lode/models/terrain/tile_pyramid/extended_raster.h"
#include "lode/models/terrain/tile_pyramid/globe_lattice.h"
#include "tests/oracles/random.h"

namespace lode::tile_pyramid {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// Hills of a kilometre, and steps.
double hills(int x, int y) {
  return 500 * std::sin(0.21 * x + 0.07 * y) * std::cos(0.17 * y) + 40 * ((3 * x + 7 * y) % 5) +
         800;
}

class MadeRows final : public HeightRows {
 public:
  MadeRows(int n_columns, int n_rows, std::array<double, 6> to_world,
           const std::function<double(int, int)>& height) {
    frame_.n_columns = n_columns;
    frame_.n_rows = n_rows;
    frame_.to_world = to_world;
    for (int y = 0; y < n_rows; ++y)
      for (int x = 0; x < n_columns; ++x) heights_.push_back(height(x, y));
  }

  const HeightFrame& frame() const override { return frame_; }
  Result<void> read(std::int32_t first, std::int32_t n_rows, std::span<double> out) override {
    const std::size_t n = static_cast<std::size_t>(frame_.n_columns);
    EXPECT_LE(static_cast<std::size_t>(first + n_rows) * n, heights_.size());
    std::copy_n(heights_.begin() + first * frame_.n_columns, static_cast<std::size_t>(n_rows) * n,
                out.begin());
    return {};
  }
  [[nodiscard]] double height(int x, int y) const {
    return heights_[static_cast<std::size_t>(y * frame_.n_columns + x)];
  }

 private:
  HeightFrame frame_;
  std::vector<double> heights_;
};

struct OwnTile {
  TileId id;
  TileMesh mesh;
  LevelForm form;
  double error = 0;
};
using Key = std::tuple<int, std::int64_t, std::int64_t>;

struct Pyramid {
  std::map<Key, OwnTile> tiles;
  std::vector<LevelReport> levels;
};

Pyramid build(MadeRows& rows, TileBuildOptions options) {
  Pyramid pyramid;
  std::mutex mutex;
  Progress progress;
  auto levels = build_tiles(
      rows, options,
      [&](const FinishedTile& tile) -> Result<void> {
        const std::lock_guard lock(mutex);
        const Key key{tile.id.level, tile.id.x, tile.id.y};
        EXPECT_FALSE(pyramid.tiles.contains(key));
        pyramid.tiles[key] = {tile.id, tile.mesh, tile.form, tile.error};
        return {};
      },
      progress);
  EXPECT_TRUE(levels) << levels.error().message;
  if (levels) pyramid.levels = *std::move(levels);
  return pyramid;
}

/// Vertices on a side by their place along it.
std::map<std::int32_t, double> side_of(const OwnTile& tile, bool is_west_east, bool is_far) {
  std::map<std::int32_t, double> side;
  for (const TileVertex& vertex : tile.mesh.vertices) {
    const auto [x, y] = vertex.node;
    if ((is_west_east ? x : y) == (is_far ? kLastNode : 0))
      side[is_west_east ? y : x] = vertex.height;
  }
  return side;
}

void expect_sides_meet(const Pyramid& pyramid) {
  for (const auto& [key, tile] : pyramid.tiles) {
    const auto& [level, x, y] = key;
    if (const auto east = pyramid.tiles.find({level, wrapped_column(level, x + 1), y});
        east != pyramid.tiles.end())
      EXPECT_EQ(side_of(tile, true, true), side_of(east->second, true, false));
    if (const auto north = pyramid.tiles.find({level, x, y + 1}); north != pyramid.tiles.end())
      EXPECT_EQ(side_of(tile, false, true), side_of(north->second, false, false));
    if (level == 0) continue;
    const auto parent = pyramid.tiles.find({level - 1, x / 2, y / 2});
    ASSERT_NE(parent, pyramid.tiles.end());
    for (const bool is_west_east : {true, false}) {
      const std::int64_t across = is_west_east ? x : y;
      const std::int64_t along = is_west_east ? y : x;
      const auto own = side_of(tile, is_west_east, across % 2 != 0);
      for (const auto& [node, z] : side_of(parent->second, is_west_east, across % 2 != 0)) {
        const std::int64_t at = 2 * node - along % 2 * kLastNode;
        if (at < 0 || at > kLastNode) continue;
        const auto found = own.find(static_cast<std::int32_t>(at));
        ASSERT_NE(found, own.end()) << level << " " << x << " " << y;
        // Both are rounded from one height.
        EXPECT_LE(std::abs(found->second - z),
                  (tile.form.height_step + parent->second.form.height_step) / 2);
      }
    }
  }
}

/// Areas fill the square, and each edge within it has Delaunay triangles on both sides.
void expect_delaunay(const OwnTile& tile) {
  std::int64_t area = 0;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> opposite;
  const auto node = [&](std::uint32_t v) { return tile.mesh.vertices[v].node; };
  for (const auto& t : tile.mesh.triangles) {
    const std::int64_t own = delaunay::doubled_area(node(t[0]), node(t[1]), node(t[2]));
    EXPECT_GT(own, 0);
    area += own;
    for (std::size_t i = 0; i < 3; ++i) opposite[{t[i], t[(i + 1) % 3]}] = t[(i + 2) % 3];
  }
  EXPECT_EQ(area, 2 * std::int64_t{kLastNode} * kLastNode);
  for (const auto& [edge, apex] : opposite) {
    const auto other = opposite.find({edge.second, edge.first});
    if (other == opposite.end()) continue;
    EXPECT_FALSE(delaunay::is_in_circle(node(edge.first), node(edge.second), node(apex),
                                        node(other->second)));
  }
  for (const TileVertex& vertex : tile.mesh.vertices)
    EXPECT_EQ(std::fmod(vertex.height, tile.form.height_step), 0);
}

/// The largest error of a sample in a tile, in whatever triangle; -1 where none is in it.
struct WorstSample {
  double inside = -1;  ///< Of samples that are in a triangle for sure,
  double beside = -1;  ///< and of those that may be, by rounding.
};
WorstSample worst_in(const OwnTile& tile, const MadeRows& rows,
                     std::set<std::pair<int, int>>& seen) {
  const HeightFrame& frame = rows.frame();
  const double size = tile_size(tile.id.level);
  WorstSample worst;
  for (int turn = -2; turn <= 2; ++turn)
    for (int r = 0; r < frame.n_rows; ++r)
      for (int c = 0; c < frame.n_columns; ++c) {
        const auto place = frame.world(c, r);
        const double x = (place[0] + 360 * turn - west_of(tile.id)) / size * kLastNode;
        const double y = (place[1] - south_of(tile.id)) / size * kLastNode;
        constexpr double kSlack = 1e-6;
        if (x < -kSlack || x > kLastNode + kSlack || y < -kSlack || y > kLastNode + kSlack)
          continue;
        if (std::isnan(rows.height(c, r))) continue;
        bool is_held = false;
        for (const auto& t : tile.mesh.triangles) {
          const TileVertex& a = tile.mesh.vertices[t[0]];
          const TileVertex& b = tile.mesh.vertices[t[1]];
          const TileVertex& d = tile.mesh.vertices[t[2]];
          const double ux = b.node.x - a.node.x, uy = b.node.y - a.node.y;
          const double vx = d.node.x - a.node.x, vy = d.node.y - a.node.y;
          const double det = ux * vy - uy * vx;
          const double p = ((x - a.node.x) * vy - (y - a.node.y) * vx) / det;
          const double q = (ux * (y - a.node.y) - uy * (x - a.node.x)) / det;
          const double slack = kSlack * kLastNode / std::sqrt(det);
          if (p < -slack || q < -slack || p + q > 1 + slack) continue;
          is_held = true;
          const double z = a.height + p * (b.height - a.height) + q * (d.height - a.height);
          const double error = std::abs(z - rows.height(c, r));
          if (p >= 0 && q >= 0 && p + q <= 1) worst.inside = std::max(worst.inside, error);
          worst.beside = std::max(worst.beside, error);
        }
        EXPECT_TRUE(is_held) << c << ", " << r;
        seen.insert({c, r});
      }
  return worst;
}

void expect_true_errors(const Pyramid& pyramid, const MadeRows& rows) {
  std::size_t n_valid = 0;
  for (int r = 0; r < rows.frame().n_rows; ++r)
    for (int c = 0; c < rows.frame().n_columns; ++c)
      n_valid += std::isnan(rows.height(c, r)) ? 0 : 1;
  for (const LevelReport& report : pyramid.levels) {
    std::set<std::pair<int, int>> seen;
    double worst = 0;
    std::uint64_t n_beyond = 0;
    for (const auto& [key, tile] : pyramid.tiles) {
      if (std::get<0>(key) != report.range.level) continue;
      const WorstSample found = worst_in(tile, rows, seen);
      EXPECT_LE(found.inside, tile.error + 1e-6);
      EXPECT_GE(std::max(0.0, found.beside), tile.error - 1e-6);
      worst = std::max(worst, tile.error);
      n_beyond += tile.error > report.form.max_error ? 1 : 0;
    }
    EXPECT_EQ(worst, report.error);
    EXPECT_EQ(n_beyond, report.n_beyond);
    EXPECT_EQ(seen.size(), n_valid);
  }
}

/// `first_kept`: the first level that keeps its tolerance.
void expect_pyramid(MadeRows& rows, const TileBuildOptions& options, std::size_t first_kept = 0) {
  const Pyramid pyramid = build(rows, options);
  ASSERT_FALSE(pyramid.levels.empty());
  std::uint64_t n_tiles = 0;
  for (const LevelReport& level : pyramid.levels) n_tiles += level.range.n_tiles();
  EXPECT_EQ(n_tiles, pyramid.tiles.size());
  for (std::size_t level = first_kept; level < pyramid.levels.size(); ++level)
    EXPECT_EQ(pyramid.levels[level].n_beyond, 0) << level;
  EXPECT_TRUE(pyramid.tiles.contains({0, 0, 0}) && pyramid.tiles.contains({0, 1, 0}));
  for (const auto& [key, tile] : pyramid.tiles) expect_delaunay(tile);
  expect_sides_meet(pyramid);
  expect_true_errors(pyramid, rows);
}

TEST(tile_pyramid, keeps_tolerances_and_meets_itself) {
  MadeRows rows(37, 29, {10.13, 0.21, 0, 47.9, 0, -0.17}, hills);
  expect_pyramid(rows, {.max_error = 40, .max_level = 7});
}

TEST(tile_pyramid, keeps_tolerances_round_holes) {
  MadeRows rows(33, 31, {-3.03, 0.2, 0, -2.9, 0, 0.2}, [](int x, int y) {
    return (x - 15) * (x - 15) + (y - 9) * (y - 9) < 30 || (x == 3 && y == 3) ? kMissing
                                                                              : hills(x, y);
  });
  expect_pyramid(rows, {.max_error = 25, .max_level = 6, .fill = -120});
}

/// Every second corner is half a step high, but for rounding, which is another on each side.
TEST(tile_pyramid, meets_itself_at_corners_half_a_step_high) {
  MadeRows rows(12, 40000, {10.18125, 0.0025, 0, 49.99875, 0, -0.0025},
                [](int, int y) { return 64.0 * std::abs(y % 40 - 20); });
  const Pyramid pyramid = build(rows, {.max_error = 128});
  EXPECT_EQ(pyramid.levels.back().range.level, 9);
  expect_sides_meet(pyramid);
}

TEST(tile_pyramid, goes_round_the_world) {
  MadeRows rows(48, 25, {0, 7.5, 0, 90, 0, -7.5}, hills);
  expect_pyramid(rows, {.max_error = 60, .max_level = 2});
  // The first column again at the end.
  MadeRows closed(49, 24, {-180, 7.5, 0, 86.25, 0, -7.5},
                  [](int x, int y) { return hills(x % 48, y); });
  expect_pyramid(closed, {.max_error = 60, .max_level = 2});
}

TEST(tile_pyramid, may_cross_180_degrees) {
  MadeRows rows(31, 23, {176.2, 0.3, 0, 12, 0, -0.3}, hills);
  expect_pyramid(rows, {.max_error = 50, .max_level = 6});
  MadeRows wide(40, 9, {100, 8.5, 0, 30, 0, -8.5}, hills);
  expect_pyramid(wide, {.max_error = 90, .max_level = 2});
}

TEST(tile_pyramid, of_few_samples) {
  MadeRows one(1, 1, {7.4, 0.1, 0, 46.2, 0, -0.1}, [](int, int) { return 421.5; });
  expect_pyramid(one, {.max_error = 1, .max_level = 8});
  MadeRows row(9, 1, {7.4, 0.1, 0, 46.2, 0, -0.1}, hills);
  expect_pyramid(row, {.max_error = 5, .max_level = 8});
  MadeRows four(2, 2, {0, 0.1, 0, 0, 0, -0.1}, hills);
  expect_pyramid(four, {.max_error = 5, .max_level = 8});
  MadeRows none(3, 2, {0, 0.1, 0, 0, 0, -0.1}, [](int, int) { return kMissing; });
  expect_pyramid(none, {.max_error = 5, .max_level = 3});
}

TEST(tile_pyramid, is_flat_where_the_terrain_is) {
  MadeRows rows(64, 64, {20, 0.01, 0, 40, 0, -0.01}, [](int, int) { return 12.0; });
  const Pyramid pyramid = build(rows, {.max_error = 1, .max_level = 12, .fill = 12});
  for (const auto& [key, tile] : pyramid.tiles) {
    const int n = n_globe_cells(tile.id.level);
    EXPECT_GE(tile.mesh.triangles.size(), 2 * n * n);
    // Sides have what coarser levels have, too.
    EXPECT_LE(tile.mesh.triangles.size(), 2 * n * n + 4 * n) << tile.id.level;
    EXPECT_LE(tile.error, tile.form.height_step / 2);
  }
}

/// Metres, earth-centred: of a place in a tile.
Vec<double, 3> on_globe(const OwnTile& tile, double x, double y, double height) {
  constexpr double kDegree = std::numbers::pi / 180;
  const double size = tile_size(tile.id.level) * kDegree;
  const double longitude = west_of(tile.id) * kDegree + size * x / kLastNode;
  const double latitude = south_of(tile.id) * kDegree + size * y / kLastNode;
  const double f = 1 / kWgs84Ellipsoid.inverse_flattening;
  const double e2 = f * (2 - f);
  const double across =
      kWgs84Ellipsoid.semi_major / std::sqrt(1 - e2 * std::pow(std::sin(latitude), 2));
  return {(across + height) * std::cos(latitude) * std::cos(longitude),
          (across + height) * std::cos(latitude) * std::sin(longitude),
          (across * (1 - e2) + height) * std::sin(latitude)};
}

/// How far straight triangles are from what they stand for, at middles of edges and of triangles.
double largest_sag(const OwnTile& tile) {
  double sag = 0;
  for (const auto& t : tile.mesh.triangles)
    for (const std::array<double, 3>& part : {std::array{1 / 3.0, 1 / 3.0, 1 / 3.0},
                                              {0.5, 0.5, 0.0},
                                              {0.5, 0.0, 0.5},
                                              {0.0, 0.5, 0.5}}) {
      Vec<double, 3> chord{};
      double x = 0, y = 0, z = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& [node, height] = tile.mesh.vertices[t[k]];
        chord = chord + on_globe(tile, node.x, node.y, height) * part[k];
        x += part[k] * node.x;
        y += part[k] * node.y;
        z += part[k] * height;
      }
      sag = std::max(sag, length(chord - on_globe(tile, x, y, z)));
    }
  return sag;
}

TEST(tile_pyramid, is_round_where_the_globe_is) {
  // Flat and rough, on the equator and near a pole, and most of it the fill.
  for (const double latitude : {3.0, 48.0, 88.0})
    for (const double relief : {0.0, 1.0}) {
      MadeRows rows(20, 15, {20, 0.1, 0, latitude, 0, -0.1},
                    [&](int x, int y) { return relief * hills(x, y); });
      const Pyramid pyramid = build(rows, {.max_error = 30, .max_level = 10});
      for (const auto& [key, tile] : pyramid.tiles)
        EXPECT_LE(largest_sag(tile), std::ldexp(kLevelZeroError, -tile.id.level))
            << tile.id.level << ", " << tile.id.x << ", " << tile.id.y;
      expect_sides_meet(pyramid);
    }
}

TEST(tile_pyramid, tells_tiles_whose_lattice_is_too_coarse) {
  // Samples closer than nodes of the only level that there may be.
  MadeRows rows(16, 16, {20, 1e-4, 0, 40, 0, -1e-4},
                [](int x, int y) { return 300.0 * ((x + y) % 2); });
  const Pyramid pyramid = build(rows, {.max_error = 10, .max_level = 1});
  EXPECT_EQ(pyramid.levels[1].n_beyond, 1);
  EXPECT_GT(pyramid.levels[1].error, 10);
  expect_true_errors(pyramid, rows);
}

TEST(tile_pyramid, keeps_tolerances_at_cliffs) {
  // Many nodes to a sample, rough along the cliffs down to the fill.
  for (int trial = 0; trial < 12; ++trial) {
    oracles::Random random(static_cast<std::uint64_t>(trial));
    const double west = random.uniform(-170, 170);
    MadeRows rows(40, 30, {west, 0.00083, 0, 38.0004, 0, -0.00083},
                  [&](int x, int y) { return 2000 + 3 * x + 2 * y + random.uniform(0, 60); });
    const Pyramid pyramid = build(rows, {.max_error = 5, .max_level = 10, .fill = -9000});
    for (std::size_t level = 4; level < pyramid.levels.size(); ++level)
      EXPECT_EQ(pyramid.levels[level].n_beyond, 0) << trial << ", " << level;
  }
}

TEST(tile_pyramid, keeps_tolerances_of_levels_with_globe_nodes_at_cliffs) {
  MadeRows rows(60, 40, {-4.875, 0.25, 0, 49.875, 0, -0.25},
                [](int x, int) { return x < 20 ? 0.0 : 4000.0; });
  expect_pyramid(rows, {.max_error = 5});
}

TEST(tile_pyramid, may_end_at_levels_coarser_than_its_samples) {
  MadeRows rows(7, 700, {20, 0.05, 0, 40, 0, -0.05}, hills);
  expect_pyramid(rows, {.max_error = 300, .max_level = 1});
}

TEST(tile_pyramid, holds_high_terrain_of_little_relief) {
  MadeRows rows(20, 20, {20, 0.01, 0, 40, 0, -0.01},
                [](int x, int y) { return 1e6 + hills(x, y) / 1e4; });
  const Pyramid pyramid = build(rows, {.max_error = 0.01, .max_level = 9, .fill = 1e6});
  for (const auto& [key, tile] : pyramid.tiles)
    for (const TileVertex& vertex : tile.mesh.vertices)
      EXPECT_EQ(static_cast<double>(static_cast<float>(vertex.height)), vertex.height);
  expect_true_errors(pyramid, rows);
}

TEST(tile_pyramid, is_the_same_for_any_number_of_threads) {
  MadeRows rows(41, 27, {10.13, 0.21, 0, 47.9, 0, -0.17}, hills);
  const Pyramid one = build(rows, {.max_error = 20, .max_level = 6, .threads = {1}});
  const Pyramid many = build(rows, {.max_error = 20, .max_level = 6, .threads = {5}});
  ASSERT_EQ(one.tiles.size(), many.tiles.size());
  for (const auto& [key, tile] : one.tiles) {
    const OwnTile& other = many.tiles.at(key);
    EXPECT_EQ(tile.mesh.triangles, other.mesh.triangles);
    ASSERT_EQ(tile.mesh.vertices.size(), other.mesh.vertices.size());
    for (std::size_t v = 0; v < tile.mesh.vertices.size(); ++v) {
      EXPECT_EQ(tile.mesh.vertices[v].node, other.mesh.vertices[v].node);
      EXPECT_EQ(tile.mesh.vertices[v].height, other.mesh.vertices[v].height);
    }
  }
}

TEST(tile_pyramid, ends_when_cancelled_or_when_a_tile_fails) {
  MadeRows rows(41, 27, {10.13, 0.21, 0, 47.9, 0, -0.17}, hills);
  Progress stopped;
  stopped.cancel();
  const auto sink = [](const FinishedTile&) -> Result<void> { return {}; };
  EXPECT_FALSE(build_tiles(rows, {.max_error = 20}, sink, stopped));
  Progress progress;
  const auto failing = [](const FinishedTile& tile) -> Result<void> {
    if (tile.id.level == 3) return fail("no room");
    return {};
  };
  const auto failed = build_tiles(rows, {.max_error = 20}, failing, progress);
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().message, "no room");
}

std::string refusal_of(MadeRows& rows, const TileBuildOptions& options) {
  Progress progress;
  const auto levels = build_tiles(
      rows, options, [](const FinishedTile&) -> Result<void> { return {}; }, progress);
  return levels ? std::string() : levels.error().message;
}

TEST(tile_pyramid, refuses_heights_that_there_are_not) {
  for (const double z :
       {-3.4028234663852886e38, 1.7e308, 1.1e7, -std::numeric_limits<double>::infinity()}) {
    MadeRows rows(9, 7, {20, 0.1, 0, 40, 0, -0.1},
                  [&](int x, int y) { return x == 4 && y == 5 ? z : 100.0; });
    EXPECT_NE(refusal_of(rows, {.max_error = 5}).find("column 4 of row 5"), std::string::npos);
  }
}

TEST(tile_pyramid, ends_with_the_least_of_tolerances) {
  for (const double max_error : {5e-324, 1e-300, 1e-12}) {
    MadeRows rows(5, 4, {20, 0.1, 0, 40, 0, -0.1}, [](int x, int y) { return 1.0 + x * y / 7.0; });
    const Pyramid pyramid = build(rows, {.max_error = max_error, .max_level = 3});
    EXPECT_GT(pyramid.levels[3].form.height_step, 0);
    expect_true_errors(pyramid, rows);
  }
  MadeRows flat(5, 4, {20, 0.1, 0, 40, 0, -0.1}, [](int, int) { return 0.0; });
  EXPECT_GE(build(flat, {.max_error = 5e-324}).levels[0].form.height_step, 0x1p-30);
}

TEST(tile_pyramid, holds_rows_that_rounding_put_beyond_the_poles) {
  for (const double beyond : {0.0, 1e-12, 4e-4}) {
    MadeRows rows(8, 5, {0, 1, 0, 90 + beyond, 0, -45 - beyond / 2}, hills);
    const auto raster = ExtendedRaster::of(rows.frame(), 0);
    ASSERT_TRUE(raster);
    const IndexRange all = raster->rows_between(-90, 90, 0, 0);
    EXPECT_EQ(all.first, 0);
    EXPECT_EQ(all.last, 4);
  }
}

TEST(tile_pyramid, refuses_a_last_column_that_is_not_the_first_again) {
  for (const double other : {0.0, 1.0, kMissing}) {
    MadeRows rows(9, 5, {-180, 45, 0, 80, 0, -40},
                  [&](int x, int y) { return hills(x % 8, y) + (x == 8 && y == 3 ? other : 0); });
    const std::string refusal = refusal_of(rows, {.max_error = 50, .max_level = 1});
    EXPECT_EQ(refusal.find("row 3") != std::string::npos, other != 0) << refusal;
  }
}

TEST(tile_pyramid, refuses_millions_of_tiles_that_nobody_asked_for) {
  MadeRows rows(36, 2, {-170, 9, 0, 10, 0, -1e-8}, hills);
  EXPECT_NE(refusal_of(rows, {.max_error = 5}).find("--max-level"), std::string::npos);
  EXPECT_EQ(refusal_of(rows, {.max_error = 50, .max_level = 4}), "");
}

TEST(tile_pyramid, refuses_rasters_that_are_not_on_the_globe) {
  const auto refusal = [](const MadeRows& rows) {
    const auto raster = ExtendedRaster::of(rows.frame(), 0);
    return raster ? std::string() : raster.error().message;
  };
  EXPECT_NE(refusal({4, 4, {0, 1, 0.1, 0, 0, 1}, hills}), "");
  EXPECT_NE(refusal({4, 4, {0, 1, 0, 88, 0, 1}, hills}), "");
  EXPECT_NE(refusal({400, 4, {0, 1, 0, 8, 0, 1}, hills}), "");
  EXPECT_NE(refusal({4, 4, {361, 1, 0, 8, 0, 1}, hills}), "");
  EXPECT_EQ(refusal({361, 4, {0, 1, 0, 8, 0, 1}, hills}), "");
}

TEST(tile_pyramid, has_levels_that_clients_take_for_true) {
  const std::vector<double> errors = level_errors(10, 12);
  EXPECT_EQ(errors[12], 10);
  EXPECT_EQ(errors[11], 20);
  EXPECT_EQ(level_errors(1e9, 5)[5], kLevelZeroError / 32);
}

}  // namespace
}  // namespace lode::tile_pyramid

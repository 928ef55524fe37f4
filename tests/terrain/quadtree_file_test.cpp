#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <set>

#include "lode/api/built_terrain.h"
#include "lode/models/terrain/quadtree_file/file_layout.h"
#include "lode/models/terrain/quadtree_file/quadtree_file.h"
#include "lode/models/terrain/terrain_file/stored_raster.h"
#include "lode/store/reader.h"
#include "lode/store/writer.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/oracles/random.h"

namespace lode::quadtree_file {
namespace {

constexpr std::array kModels{TerrainModel::surface_quadtree, TerrainModel::quaternary_triangulation,
                             TerrainModel::restricted_quadtree,
                             TerrainModel::right_triangle_bisection};

double dunes(std::int32_t x, std::int32_t y) {
  return 30 * std::sin(0.4 * x + 0.1 * y) * std::cos(0.3 * y) + (x * 3 + y * 7) % 5 + 100;
}

template <typename T>
HeightGrid grid_with_a_hole() {
  HeightGrid grid = delaunay::test::make_grid<T>(29, 22, dunes);
  for (std::int32_t x = 11; x < 15; ++x) delaunay::test::set_missing(grid, x, 8);
  grid.to_world = {1000.5, 10, 0, 9e5, 0, -10};
  grid.vertical_unit = "metre";
  return grid;
}

class quadtree_file : public testing::Test {
 protected:
  ~quadtree_file() override {
    std::filesystem::remove(path_);
    std::filesystem::remove(other_);
  }

  BuiltTerrain saved(TerrainModel model, const HeightGrid& grid) {
    auto made = BuiltTerrain::build(
        grid, {.model = model, .levels = {20, 5, 1}, .sample_type = "float32"}, progress_);
    EXPECT_TRUE(made) << made.error().message;
    const auto size = made->save(path_, progress_);
    EXPECT_TRUE(size) << size.error().message;
    EXPECT_EQ(*size, std::filesystem::file_size(path_));
    return *std::move(made);
  }
  /// The file with blocks of a kind changed (metadata: 0), and checksums that are right.
  void rewrite(const std::function<void(std::uint32_t, std::vector<std::byte>&)>& change) {
    const auto reader = store::Reader::open(path_);
    ASSERT_TRUE(reader);
    std::vector<std::byte> metadata(reader->metadata().begin(), reader->metadata().end());
    change(0, metadata);
    auto writer = store::Writer::create(other_, reader->model(), metadata);
    ASSERT_TRUE(writer);
    for (std::size_t i = 0; i < reader->blocks().size(); ++i) {
      auto bytes = reader->read_block(i);
      ASSERT_TRUE(bytes);
      change(reader->blocks()[i].key.kind, *bytes);
      ASSERT_TRUE(
          writer->append(reader->blocks()[i].key, store::encode_block({.raw = *bytes, .size = 1})));
    }
    ASSERT_TRUE(writer->finish());
  }
  template <typename T>
  void rewrite_number(std::uint32_t kind, std::size_t at, T value) {
    rewrite([&](std::uint32_t of, std::vector<std::byte>& bytes) {
      if (of == kind && at + sizeof(T) <= bytes.size())
        std::memcpy(bytes.data() + at, &value, sizeof(T));
    });
  }

  Progress progress_;
  const std::string path_ =
      testing::TempDir() + "lode_quadtree_" + std::to_string(::getpid()) + ".lode";
  const std::string other_ =
      testing::TempDir() + "lode_quadtree_lie_" + std::to_string(::getpid()) + ".lode";
};

template <typename T>
void expect_round_trip(const std::function<BuiltTerrain(TerrainModel, const HeightGrid&)>& save,
                       const std::string& path) {
  Progress progress;
  const HeightGrid grid = grid_with_a_hole<T>();
  for (const TerrainModel model : kModels) {
    SCOPED_TRACE(name_of(model));
    const BuiltTerrain made = save(model, grid);
    const auto opened = BuiltTerrain::open(path, progress);
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_EQ(opened->model(), model);
    EXPECT_EQ(opened->frame().to_world, grid.to_world);
    const auto verified = opened->verify(grid, {2}, progress);
    ASSERT_TRUE(verified);
    EXPECT_TRUE(verified->passed());
    const auto alone = opened->verify_alone({2}, progress);
    ASSERT_TRUE(alone);
    EXPECT_TRUE(alone->passed());
    for (const double tolerance : {20.0, 3.0, 0.0}) {
      const auto a = extract_terrain(made.terrain(), {.max_error = tolerance}, progress);
      const auto b = extract_terrain(opened->terrain(), {.max_error = tolerance}, progress);
      ASSERT_TRUE(a && b);
      EXPECT_EQ(a->surface.triangles, b->surface.triangles);
      EXPECT_EQ(a->report.achieved_error, b->report.achieved_error);
      if (model != TerrainModel::surface_quadtree)
        EXPECT_LE(b->report.achieved_error, tolerance + 1e-9);
    }
  }
}

TEST_F(quadtree_file, has_all_that_was_saved) {
  const auto save = [&](TerrainModel model, const HeightGrid& grid) { return saved(model, grid); };
  expect_round_trip<std::int16_t>(save, path_);
  expect_round_trip<std::uint16_t>(save, path_);
  expect_round_trip<float>(save, path_);
  expect_round_trip<double>(save, path_);
}

double centimetres_at_1e9(std::int32_t x, std::int32_t y) {
  return 1e9 + std::round(300 * std::sin(0.3 * x) * std::cos(0.2 * y)) / 100;
}

/// verify() measures in 64 bits of mantissa from differences of heights; quadtree_errors_test holds
/// what it holds against whole numbers.
TEST_F(quadtree_file, keeps_tolerances_of_high_heights_and_says_so) {
  const HeightGrid grid = delaunay::test::make_grid<double>(57, 40, centimetres_at_1e9);
  for (const TerrainModel model : kModels) {
    SCOPED_TRACE(name_of(model));
    const auto made =
        BuiltTerrain::build(grid, {.model = model, .levels = {1, 0.1, 0.02}}, progress_);
    ASSERT_TRUE(made);
    ASSERT_TRUE(made->save(path_, progress_));
    const auto opened = BuiltTerrain::open(path_, progress_);
    ASSERT_TRUE(opened);
    const auto verified = opened->verify_alone({2}, progress_);
    ASSERT_TRUE(verified);
    EXPECT_TRUE(verified->passed());
    if (model == TerrainModel::surface_quadtree) continue;
    for (const double tolerance : {1.0, 0.1, 0.02, 0.0}) {
      const auto got = extract_terrain(opened->terrain(), {.max_error = tolerance}, progress_);
      ASSERT_TRUE(got);
      EXPECT_LE(got->report.achieved_error, tolerance);
      EXPECT_TRUE(got->report.is_within_error);
      if (has_gaps(model)) continue;
      const auto check = verify_terrain(
          grid, got->surface,
          {.max_error = got->report.achieved_error, .shape = TinShape::any, .places = got->places},
          progress_);
      ASSERT_TRUE(check);
      EXPECT_TRUE(check->passed()) << got->report.achieved_error;
    }
  }
}

/// Errors that are a little too small are found out, though heights are high.
TEST_F(quadtree_file, finds_errors_of_high_heights_that_are_too_small) {
  const HeightGrid grid = delaunay::test::make_grid<double>(57, 40, centimetres_at_1e9);
  for (const TerrainModel model :
       {TerrainModel::surface_quadtree, TerrainModel::quaternary_triangulation}) {
    SCOPED_TRACE(name_of(model));
    saved(model, grid);
    rewrite([&](std::uint32_t kind, std::vector<std::byte>& bytes) {
      if (kind != static_cast<std::uint32_t>(Column::error)) return;
      for (std::size_t at = 0; at < bytes.size(); at += sizeof(float)) {
        float error = 0;
        std::memcpy(&error, bytes.data() + at, sizeof(error));
        if (std::isfinite(error)) error *= 1 - 0x1p-20F;
        std::memcpy(bytes.data() + at, &error, sizeof(error));
      }
    });
    const auto opened = BuiltTerrain::open(other_, progress_);
    ASSERT_TRUE(opened) << opened.error().message;
    const auto verified = opened->verify_alone({2}, progress_);
    ASSERT_TRUE(verified);
    EXPECT_FALSE(verified->passed());
  }
}

/// Every tolerance has kept samples as vertices, in memory and from the file, and few others.
TEST_F(quadtree_file, keeps_samples) {
  const HeightGrid grid = grid_with_a_hole<float>();
  oracles::Random random(4);
  std::vector<LatticePoint> kept;
  for (std::int32_t y = 0; y < grid.n_rows; ++y)
    for (std::int32_t x = 0; x < grid.n_columns; ++x)
      if (random.below(15) == 0 && grid.has_height(x, y)) kept.push_back({x, y});
  ASSERT_GT(kept.size(), 8);
  for (const TerrainModel model : kModels) {
    SCOPED_TRACE(name_of(model));
    const auto plain = BuiltTerrain::build(grid, {.model = model, .levels = {200, 1}}, progress_);
    const auto made =
        BuiltTerrain::build(grid, {.model = model, .levels = {200, 1}, .kept = kept}, progress_);
    ASSERT_TRUE(plain && made);
    ASSERT_TRUE(made->save(path_, progress_));
    const auto opened = BuiltTerrain::open(path_, progress_);
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_EQ(opened->describe_source().n_kept, kept.size());
    for (const double tolerance : {200.0, 4.0, 0.0}) {
      const auto a = extract_terrain(made->terrain(), {.max_error = tolerance}, progress_);
      const auto b = extract_terrain(opened->terrain(), {.max_error = tolerance}, progress_);
      const auto c = extract_terrain(plain->terrain(), {.max_error = tolerance}, progress_);
      ASSERT_TRUE(a && b && c);
      EXPECT_EQ(a->surface.triangles, b->surface.triangles);
      EXPECT_GE(a->report.triangles, c->report.triangles);
      std::set<std::pair<double, double>> vertices;
      for (std::uint32_t v = 0; v < a->surface.positions.size(); ++v) {
        const Vec3d p = a->surface.world_position(v);
        vertices.insert({p[0], p[1]});
      }
      for (const LatticePoint p : kept) {
        const auto at = grid.world(p.x, p.y);
        EXPECT_TRUE(vertices.contains({at[0], at[1]})) << p.x << ", " << p.y;
      }
    }
    const auto verified = opened->verify(grid, {2}, progress_);
    ASSERT_TRUE(verified);
    EXPECT_TRUE(verified->passed());
    // At no tolerance at all, one more is a few squares more, not all of them.
    const auto coarse = extract_terrain(made->terrain(), {.max_error = 1e6}, progress_);
    ASSERT_TRUE(coarse);
    EXPECT_LT(coarse->report.triangles, 70 * kept.size());
  }
}

TEST_F(quadtree_file, varies_where_there_are_gaps_anyway_or_never) {
  const HeightGrid grid = grid_with_a_hole<float>();
  for (const TerrainModel model : kModels) {
    const BuiltTerrain made = saved(model, grid);
    TerrainFocus focus;
    focus.boxes = {{{{1000, 9e5 - 60}}, {{1060, 9e5}}}};
    focus.max_error_outside = 20;
    const auto varied =
        extract_terrain(made.terrain(), {.max_error = 1, .focus = focus}, progress_);
    const bool is_bisection = model == TerrainModel::right_triangle_bisection;
    ASSERT_EQ(varied.has_value(), has_gaps(model) || is_bisection);
    // What needs a surface is refused by those that are none.
    const auto tin = TerrainTin::select(made.terrain(), {.max_error = 1}, {}, progress_);
    EXPECT_EQ(tin.has_value(), !has_gaps(model));
    EXPECT_EQ(extract_terrain(made.terrain(), {.max_cells = 250}, progress_).has_value(),
              has_gaps(model) || is_bisection);
    if (!varied) continue;
    const auto fine = extract_terrain(made.terrain(), {.max_error = 1}, progress_);
    const auto coarse = extract_terrain(made.terrain(), {.max_error = 20}, progress_);
    ASSERT_TRUE(fine && coarse);
    EXPECT_LT(varied->report.triangles, fine->report.triangles);
    EXPECT_GT(varied->report.triangles, coarse->report.triangles);
  }
}

/// The triangles of a model with gaps within each of its errors, which are all tolerances that
/// make a difference, the least first.
std::vector<std::uint64_t> counts_by_tolerance(TerrainModel model, const HeightGrid& grid) {
  Progress progress;
  const auto squares = SurfaceQuadtree::build(grid, {1}, progress);
  const auto halves = QuaternaryTriangulation::build(grid, {1}, progress);
  EXPECT_TRUE(squares && halves);
  const bool is_of_squares = model == TerrainModel::surface_quadtree;
  std::set<float> tolerances{0};
  for (const auto& level : squares->errors())
    if (is_of_squares) tolerances.insert(level.begin(), level.end());
  for (const auto& level : halves->errors())
    for (const auto& pair : level)
      if (!is_of_squares) tolerances.insert(pair.begin(), pair.end());
  std::vector<std::uint64_t> counts;
  for (const float tolerance : tolerances)
    if (std::isfinite(tolerance))
      counts.push_back(is_of_squares ? 2 * squares->leaves(static_cast<double>(tolerance)).size()
                                     : halves->leaves(static_cast<double>(tolerance)).size());
  return counts;
}

TEST_F(quadtree_file, finds_the_finest_mesh_of_a_number_of_triangles) {
  const HeightGrid grid = grid_with_a_hole<float>();
  for (const TerrainModel model :
       {TerrainModel::surface_quadtree, TerrainModel::quaternary_triangulation}) {
    SCOPED_TRACE(name_of(model));
    const auto counts = counts_by_tolerance(model, grid);
    const auto made = BuiltTerrain::build(grid, {.model = model, .levels = {1}}, progress_);
    ASSERT_TRUE(made);
    const std::uint64_t least = counts.back();
    for (const std::uint64_t most : {least, least + 1, 2 * least, 2 * least + 51, counts.front()}) {
      const auto got = extract_terrain(made->terrain(), {.max_cells = most}, progress_);
      ASSERT_TRUE(got);
      EXPECT_TRUE(got->report.budget_met);
      const auto expected =
          std::ranges::find_if(counts, [&](std::uint64_t n) { return n <= most; });
      EXPECT_EQ(got->report.triangles, *expected) << most;
      // Not finer than a tolerance that is given, too.
      const auto both =
          extract_terrain(made->terrain(), {.max_error = 20, .max_cells = most}, progress_);
      const auto within = extract_terrain(made->terrain(), {.max_error = 20}, progress_);
      ASSERT_TRUE(both && within);
      EXPECT_EQ(both->report.triangles, std::min(*expected, within->report.triangles));
    }
    const auto fewer = extract_terrain(made->terrain(), {.max_cells = least - 1}, progress_);
    ASSERT_TRUE(fewer);
    EXPECT_FALSE(fewer->report.budget_met);
    EXPECT_EQ(fewer->report.triangles, least);
    TerrainFocus focus;
    focus.boxes = {{{{1000, 9e5 - 60}}, {{1060, 9e5}}}};
    EXPECT_FALSE(extract_terrain(made->terrain(), {.max_cells = 500, .focus = focus}, progress_));
  }
}

TEST_F(quadtree_file, lies_are_named_or_found_by_verification) {
  const HeightGrid grid = grid_with_a_hole<float>();
  const auto number = [](auto column) { return static_cast<std::uint32_t>(column); };
  const auto expect_refused = [&](const char* why) {
    const auto opened = open(other_, progress_);
    ASSERT_FALSE(opened) << why;
    EXPECT_NE(opened.error().message.find(other_), std::string::npos) << opened.error().message;
    EXPECT_NE(opened.error().message.find(why), std::string::npos) << opened.error().message;
  };
  saved(TerrainModel::surface_quadtree, grid);
  rewrite_number(0, 0, std::uint32_t{9});
  expect_refused("layout");
  rewrite_number(0, 4, std::int32_t{1 << 29});
  expect_refused("columns and rows");
  rewrite_number(0, 4, std::int32_t{30});
  expect_refused("bytes");
  rewrite_number(number(terrain_file::RasterColumn::height), 8, 1e9F);
  expect_refused("expected a height");
  rewrite_number(number(terrain_file::RasterColumn::is_valid), 0, std::uint8_t{0});
  expect_refused("without a height");
  rewrite_number(number(Column::error), 0, -1.0F);
  expect_refused("errors");
  rewrite_number(number(Column::error), 0, std::nanf(""));
  expect_refused("errors");
}

TEST_F(quadtree_file, lies_of_kept_samples_are_named) {
  const HeightGrid grid = grid_with_a_hole<float>();
  const auto kept = static_cast<std::uint32_t>(terrain_file::RasterColumn::kept);
  for (const TerrainModel model :
       {TerrainModel::restricted_quadtree, TerrainModel::right_triangle_bisection}) {
    const auto expect_refused = [&](const char* why) {
      const auto opened = BuiltTerrain::open(other_, progress_);
      ASSERT_FALSE(opened) << why;
      EXPECT_NE(opened.error().message.find(other_), std::string::npos) << opened.error().message;
      EXPECT_NE(opened.error().message.find(why), std::string::npos) << opened.error().message;
    };
    const auto keeping = BuiltTerrain::build(
        grid, {.model = model, .levels = {5}, .kept = {{3, 4}, {7, 4}, {2, 9}}}, progress_);
    ASSERT_TRUE(keeping && keeping->save(path_, progress_));
    rewrite_number(kept, 0, std::uint32_t{29});
    expect_refused("samples to keep");
    rewrite_number(kept, 0, std::uint32_t{8});
    expect_refused("samples to keep");
    rewrite_number(kept, 8, std::uint32_t{3});
    expect_refused("samples to keep");
    rewrite([&](std::uint32_t kind, std::vector<std::byte>& bytes) {
      const std::uint32_t many = 1U << 31;
      if (kind == 0) std::memcpy(bytes.data() + bytes.size() - 4, &many, 4);
    });
    expect_refused("samples to keep");
    rewrite([&](std::uint32_t kind, std::vector<std::byte>& bytes) {
      if (kind == 0) bytes.back() = bytes[bytes.size() - 2] = bytes[bytes.size() - 3] = {};
      if (kind == 0) bytes[bytes.size() - 4] = std::byte{5};
    });
    expect_refused("bytes");
  }
}

TEST_F(quadtree_file, errors_too_small_are_found) {
  const HeightGrid grid = grid_with_a_hole<float>();
  const auto number = [](Column column) { return static_cast<std::uint32_t>(column); };
  for (const TerrainModel model :
       {TerrainModel::surface_quadtree, TerrainModel::quaternary_triangulation}) {
    saved(model, grid);
    rewrite([&](std::uint32_t kind, std::vector<std::byte>& bytes) {
      if (kind != number(Column::error)) return;
      for (std::size_t at = 0; at + 4 <= bytes.size(); at += 4) {
        float error = 0;
        std::memcpy(&error, bytes.data() + at, 4);
        if (!std::isinf(error)) error /= 2;
        std::memcpy(bytes.data() + at, &error, 4);
      }
    });
    const auto opened = BuiltTerrain::open(other_, progress_);
    ASSERT_TRUE(opened) << opened.error().message;
    const auto report = opened->verify_alone({2}, progress_);
    ASSERT_TRUE(report);
    EXPECT_FALSE(report->passed());
  }
}

TEST_F(quadtree_file, ends_with_cells_whatever_errors_they_state) {
  const HeightGrid grid = grid_with_a_hole<float>();
  for (const TerrainModel model :
       {TerrainModel::surface_quadtree, TerrainModel::quaternary_triangulation}) {
    const BuiltTerrain made = saved(model, grid);
    rewrite([&](std::uint32_t kind, std::vector<std::byte>& bytes) {
      if (kind != static_cast<std::uint32_t>(Column::error)) return;
      for (std::size_t at = 0; at + 4 <= bytes.size(); at += 4) {
        float error = 0;
        std::memcpy(&error, bytes.data() + at, 4);
        if (!std::isinf(error)) error = 1e9F;
        std::memcpy(bytes.data() + at, &error, 4);
      }
    });
    const auto opened = BuiltTerrain::open(other_, progress_);
    ASSERT_TRUE(opened) << opened.error().message;
    const auto cells = extract_terrain(made.terrain(), {.max_error = 0}, progress_);
    const auto all = extract_terrain(opened->terrain(), {.max_error = 0}, progress_);
    ASSERT_TRUE(cells && all);
    EXPECT_EQ(all->surface.triangles, cells->surface.triangles);
  }
}

TEST_F(quadtree_file, never_crashes_on_random_bytes) {
  oracles::Random random(3);
  for (const TerrainModel model : kModels) {
    saved(model, grid_with_a_hole<std::int16_t>());
    for (int trial = 0; trial < 60; ++trial) {
      const std::size_t victim = random.below(4);
      rewrite([&](std::uint32_t kind, std::vector<std::byte>& bytes) {
        if (kind != victim || bytes.empty()) return;
        bytes[random.below(bytes.size())] ^= static_cast<std::byte>(1 + random.below(255));
        if (trial % 5 == 0) bytes.resize(1 + random.below(bytes.size()));
      });
      if (const auto opened = BuiltTerrain::open(other_, progress_))
        static_cast<void>(extract_terrain(opened->terrain(), {.max_error = 2}, progress_));
    }
  }
}

}  // namespace
}  // namespace lode::quadtree_file

// Live queries of files that nobody has loaded: pages come as they are wanted, and the surface is
// that of the model in memory.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "lode/api/focused_surface.h"
#include "lode/api/mesh_extraction.h"
#include "lode/api/session.h"
#include "lode/store/reader.h"
#include "tests/models/session_answers.h"
#include "tests/models/surface_cells.h"
#include "tests/oracles/analytic_fields.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

using oracles::trials;

class paged_model : public ::testing::Test {
 protected:
  paged_model()
      : directory_(std::filesystem::temp_directory_path() /
                   ("lode_paged_test_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(directory_);
  }
  ~paged_model() override { std::filesystem::remove_all(directory_); }

  Dataset build(const Volume& volume) {
    return Dataset::build(*make_memory_source(volume), {}, progress_).value();
  }
  std::string save(const Dataset& dataset) {
    const std::string path = (directory_ / "volume.lode").string();
    EXPECT_TRUE(dataset.save(path, {2}, progress_));
    return path;
  }
  /// Blobs of `scale`, a little of it noise.
  template <typename T>
  static Volume blobs(const Index3& dims, double scale, std::uint64_t seed) {
    RegularGrid grid;
    grid.dims = dims;
    grid.spacing = {{1, 0.7, 1.9}};
    oracles::Random random(seed);
    return oracles::volume_of<T>(grid, [&](const Index3& p) {
      const double wave = std::sin(0.13 * p[0]) * std::cos(0.17 * p[1] + 0.05 * p[2]);
      return scale * (0.5 + 0.33 * wave + (seed % 2 == 0 ? random.uniform(0, 0.02) : 0));
    });
  }
  static Query isosurface(double isovalue, double max_error) {
    Query query;
    query.isovalues = {isovalue};
    query.max_error = max_error;
    return query;
  }
  Surface extract(const Dataset& dataset, const Query& query) {
    Surface surface;
    const auto report = extract_focused(dataset, {.query = query}, surface, progress_);
    EXPECT_TRUE(report) << report.error().message;
    if (report) EXPECT_TRUE(report->standing.is_settled);
    return surface;
  }
  void expect_same(const Volume& volume, double scale) {
    const Dataset built = build(volume);
    const Dataset opened = Dataset::open(save(built), {2}).value();
    for (const double tolerance : {0.1, 0.0}) {
      SCOPED_TRACE(fmt::format("{} x {} x {}, tolerance {}", volume.info.grid.dims[0],
                               volume.info.grid.dims[1], volume.info.grid.dims[2], tolerance));
      const Query query = isosurface(0.6 * scale, tolerance * scale);
      const Surface expected = extract(built, query);
      const Surface surface = extract(opened, query);
      EXPECT_FALSE(expected.is_empty());
      EXPECT_EQ(surface.positions, expected.positions);
      EXPECT_EQ(surface.normals, expected.normals);
      EXPECT_EQ(surface.triangles, expected.triangles);
      EXPECT_EQ(surface.lines, expected.lines);
      Surface at_once;
      ASSERT_TRUE(built.extract({.isovalues = query.isovalues, .max_error = query.max_error},
                                at_once, progress_));
      EXPECT_TRUE(cells_of(surface) == cells_of(at_once));
    }
    expect_same_view(built, opened, 0.6 * scale);
  }
  /// From beside the data, one corner of it near.
  void expect_same_view(const Dataset& built, const Dataset& opened, double isovalue) {
    const Box3d bounds = built.describe().volume.grid.world_bounds();
    const Vec3d size = bounds.upper - bounds.lower;
    Query query = isosurface(isovalue, 0);
    query.max_error.reset();
    query.view = View{
        {.eye = bounds.lower - size * 0.1 - Vec3d{{5, 9, 7}}, .target = bounds.lower + size * 0.5},
        640,
        480};
    std::size_t n_last = std::numeric_limits<std::size_t>::max();
    for (const double pixels : {4.0, 30.0}) {
      query.max_error_px = pixels;
      const Surface expected = extract(built, query);
      const Surface surface = extract(opened, query);
      EXPECT_FALSE(expected.is_empty());
      EXPECT_EQ(surface.positions, expected.positions);
      EXPECT_EQ(surface.triangles, expected.triangles);
      EXPECT_EQ(surface.lines, expected.lines);
      EXPECT_LE(surface.positions.size(), n_last);
      n_last = surface.positions.size();
    }
  }

  std::filesystem::path directory_;
  Progress progress_;
};

TEST_F(paged_model, gives_the_surface_of_the_model_in_memory) {
  expect_same(blobs<std::uint8_t>(trials<Index3>({{130, 40, 67}}, {{130, 9, 67}}), 250, 1), 250);
  expect_same(blobs<std::uint8_t>(trials<Index3>({{66, 129, 35}}, {{66, 129, 7}}), 250, 2), 250);
  expect_same(blobs<std::uint16_t>(trials<Index3>({{64, 34, 128}}, {{9, 34, 128}}), 6e4, 3), 6e4);
  expect_same(blobs<std::int16_t>(trials<Index3>({{97, 33, 70}}, {{97, 9, 70}}), 3e4, 4), 3e4);
  expect_same(blobs<float>(trials<Index3>({{131, 66, 20}}, {{131, 66, 6}}), 1e3, 5), 1e3);
  expect_same(blobs<double>(trials<Index3>({{67, 68, 40}}, {{67, 68, 9}}), 1e-3, 6), 1e-3);
}

TEST_F(paged_model, gives_the_lines_of_2d_data) {
  expect_same(blobs<std::uint8_t>({{1100, 513, 1}}, 250, 1), 250);
  expect_same(blobs<float>({{600, 1, 1030}}, 1e3, 2), 1e3);
}

TEST_F(paged_model, keeps_budgets_whatever_page_comes_first) {
  const Dataset built =
      build(blobs<std::uint8_t>(trials<Index3>({{130, 140, 70}}, {{130, 80, 40}}), 250, 2));
  const Dataset opened = Dataset::open(save(built), {2}).value();
  for (const std::uint64_t max_cells : {10, 1000, 30000, 200000}) {
    Query query = isosurface(150, 0);
    query.budget.max_cells = max_cells;
    const Surface expected = extract(built, query);
    const Surface surface = extract(opened, query);
    EXPECT_EQ(surface.positions, expected.positions);
    EXPECT_EQ(surface.triangles, expected.triangles);
  }
}

TEST_F(paged_model, gives_the_meshes_of_the_model_in_memory) {
  const Dataset built =
      build(blobs<std::uint8_t>(trials<Index3>({{130, 140, 70}}, {{130, 80, 40}}), 250, 2));
  const std::string path = save(built);
  MeshOptions box{.query = isosurface(150, 2)};
  box.query.boxes = {{{{20, 10, 30}}, {{60, 50, 70}}}};
  MeshOptions range{.query = isosurface(150, 3)};
  range.query.isovalues.clear();
  range.query.field_ranges = {{140, 150}};
  MeshOptions budget{.query = isosurface(150, 0)};
  budget.query.budget.max_cells = 5000;
  MeshOptions few = budget;  // which the border makes several cuts of
  few.query.budget.max_cells = 400;
  for (const MeshOptions& options : {box, range, budget, few}) {
    const Dataset opened = Dataset::open(path, {2}).value();
    SimplexMesh expected;
    SimplexMesh mesh;
    const auto wanted = built.extract_mesh(options, expected, progress_);
    const auto report = opened.extract_mesh(options, mesh, progress_);
    ASSERT_TRUE(wanted && report) << (report ? "" : report.error().message);
    EXPECT_FALSE(mesh.is_empty());
    EXPECT_LE(mesh.n_cells(), options.query.budget.max_cells);
    EXPECT_TRUE(mesh.positions == expected.positions && mesh.values == expected.values);
    EXPECT_TRUE(mesh.tetrahedra == expected.tetrahedra && mesh.errors == expected.errors);
    EXPECT_EQ(report->achieved_error, wanted->achieved_error);
    EXPECT_TRUE(report->memory_met);
    EXPECT_LE(opened.reads().bytes, std::filesystem::file_size(path));
  }
}

TEST_F(paged_model, gives_the_sections_of_the_model_in_memory) {
  const Dataset built = build(blobs<float>({{130, 70, 80}}, 1e3, 2));
  const Dataset opened = Dataset::open(save(built), {2}).value();
  SectionOptions plane{
      .plane = {{{50, 20, 60}}, {{0.2, 0.3, 1}}}, .isovalues = {}, .field_ranges = {}};
  SectionOptions lines = plane;
  lines.isovalues = {600, 650};
  for (const SectionOptions& options : {plane, lines}) {
    Surface expected;
    Surface section;
    const auto wanted = built.extract_section(options, expected, progress_);
    const auto report = opened.extract_section(options, section, progress_);
    ASSERT_TRUE(wanted && report) << (report ? "" : report.error().message);
    EXPECT_FALSE(section.is_empty());
    EXPECT_TRUE(section.positions == expected.positions && section.values == expected.values);
    EXPECT_TRUE(section.triangles == expected.triangles && section.lines == expected.lines);
    EXPECT_TRUE(section.errors == expected.errors);
  }
}

TEST_F(paged_model, says_that_memory_ended_a_mesh) {
  const Dataset built = build(blobs<std::uint8_t>({{200, 180, 130}}, 250, 2));
  const Dataset opened = Dataset::open(save(built), {2}).value();
  MeshOptions options{.query = isosurface(150, 4), .memory_limit = 1'000'000};
  SimplexMesh mesh;
  const auto report = opened.extract_mesh(options, mesh, progress_);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_FALSE(report->memory_met);
  EXPECT_GT(report->achieved_error, 4);
  EXPECT_FALSE(mesh.is_empty());
}

TEST_F(paged_model, serves_several_sessions_at_once) {
  const Dataset built =
      build(blobs<std::uint8_t>(trials<Index3>({{130, 140, 70}}, {{130, 80, 40}}), 250, 2));
  const Dataset opened = Dataset::open(save(built), {2}).value();
  std::vector<Session> sessions;
  const std::vector<Query> queries{isosurface(150, 10), isosurface(120, 20), isosurface(180, 5)};
  for (const Query& query : queries)
    sessions.push_back(Session::open(opened, query, {.with_views = false}, progress_).value());
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const SurfaceMirror mirror = take_settled(sessions[i]);
    Surface expected;
    ASSERT_TRUE(
        built.extract({.isovalues = queries[i].isovalues, .max_error = queries[i].max_error},
                      expected, progress_));
    EXPECT_EQ(cells_of(mirror.to_surface()), cells_of(expected));
  }
}

TEST_F(paged_model, can_be_redirected_and_closed_while_pages_come) {
  const Dataset built = build(blobs<std::uint8_t>({{130, 140, 134}}, 250, 2));
  const std::string path = save(built);
  oracles::Random random(4);
  for (int trial = 0; trial < 20; ++trial) {
    const Dataset opened = Dataset::open(path, {2}).value();
    auto session =
        Session::open(opened, isosurface(150, 1), {.with_views = false}, progress_).value();
    for (int i = 0; i < 5; ++i) {
      std::this_thread::sleep_for(
          std::chrono::microseconds(static_cast<int>(random.uniform(0, 2000))));
      ASSERT_TRUE(session.set_query(isosurface(random.uniform(100, 200), random.uniform(0, 30))));
    }
  }
}

TEST_F(paged_model, names_the_block_that_cannot_be_read) {
  // No simplex reaches across the border, where even coarse surfaces are refined.
  const std::string path = save(build(blobs<std::uint8_t>({{129, 129, 65}}, 250, 2)));
  std::uint64_t offset = 0;
  {
    const auto reader = store::Reader::open(path).value();
    for (const auto& block : reader.blocks())
      if (block.key.level == 0 && block.key.position == Index3{{1, 1, 0}}) offset = block.offset;
  }
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(offset + 100));
  file.write("damaged", 7);
  file.close();

  const Dataset opened = Dataset::open(path, {2}).value();
  Surface surface;
  // Coarse answers need none of it.
  EXPECT_FALSE(extract(opened, isosurface(150, 50)).is_empty());
  const auto failed = extract_focused(opened, {.query = isosurface(150, 0)}, surface, progress_);
  ASSERT_FALSE(failed);
  EXPECT_NE(failed.error().message.find("position 1 1 0"), std::string::npos);
  EXPECT_NE(failed.error().message.find("checksum"), std::string::npos);

  auto session =
      Session::open(opened, isosurface(150, 0), {.with_views = false}, progress_).value();
  std::optional<Error> fault;
  const auto until = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  while (!fault && std::chrono::steady_clock::now() < until)
    if (const auto batch = session.take())
      fault = batch->fault;
    else
      std::this_thread::sleep_for(std::chrono::microseconds(200));
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->message, failed.error().message);

  // Another query does not need it: one batch of its answer at most is left to take, and no fault.
  const std::uint64_t number = session.set_query(isosurface(150, 50)).value();
  std::unique_ptr<SessionBatch> batch;
  while ((!batch || batch->query < number || !batch->standing.is_settled) &&
         std::chrono::steady_clock::now() < until)
    if (auto next = session.take()) batch = std::move(next);
  ASSERT_TRUE(batch && batch->query == number && batch->standing.is_settled);
  EXPECT_FALSE(batch->fault);
  std::size_t n_more = 0;
  for (int i = 0; i < 100; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    n_more += session.take() != nullptr ? 1 : 0;
  }
  EXPECT_LE(n_more, 1U);

  // What does not need it is answered all the same.
  Query elsewhere = isosurface(150, 0);
  elsewhere.boxes = {{{{0, 0, 0}}, {{20, 20, 50}}}};
  EXPECT_FALSE(extract(opened, elsewhere).is_empty());
}

TEST_F(paged_model, stops_when_cancelled) {
  const Dataset opened =
      Dataset::open(save(build(blobs<std::uint8_t>({{129, 129, 65}}, 250, 2))), {2}).value();
  Progress cancelled;
  cancelled.cancel();
  Surface surface;
  EXPECT_FALSE(extract_focused(opened, {.query = isosurface(150, 0)}, surface, cancelled));
  EXPECT_FALSE(extract(opened, isosurface(150, 20)).is_empty());
}

/// Which samples are holes. Of interlaced ones all are next to a hole, so that no cell is left in a
/// half of the volume whose other samples are finite.
struct Holes {
  const char* name;
  std::function<bool(const Index3&)> are_at;
};

const Holes kScattered{
    "scattered", [](const Index3& p) { return (p[0] * 31 + p[1] * 57 + p[2] * 101) % 1999 == 0; }};
const Holes kBall{"a ball", [](const Index3& p) {
                    const Index3 d = p - Index3{{40, 20, 20}};
                    return d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < 150;
                  }};
const Holes kInterlaced{"interlaced", [](const Index3& p) { return p[0] < 64 && p[1] % 2 == 1; }};
const Holes kBorder{"at the border", [](const Index3& p) { return p[0] > 110 || p[1] == 0; }};

Volume with_holes(Volume volume, const Holes& holes) {
  const Index3 dims = volume.info.grid.dims;
  std::size_t i = 0;
  Index3 p;
  for (p[2] = 0; p[2] < dims[2]; ++p[2])
    for (p[1] = 0; p[1] < dims[1]; ++p[1])
      for (p[0] = 0; p[0] < dims[0]; ++p[0], ++i) {
        if (!holes.are_at(p)) continue;
        if (volume.info.type == ScalarType::float32) {
          constexpr float kHole = std::numeric_limits<float>::quiet_NaN();
          std::memcpy(volume.samples.data() + i * sizeof(kHole), &kHole, sizeof(kHole));
        } else {
          volume.samples[i] = std::byte{0};
          volume.info.nodata = 0;
        }
      }
  return volume;
}

TEST_F(paged_model, gives_the_surface_between_holes) {
  for (const Holes& holes : {kScattered, kBall, kInterlaced, kBorder}) {
    SCOPED_TRACE(holes.name);
    const auto dims = trials<Index3>({{130, 40, 34}}, {{130, 36, 7}});
    expect_same(with_holes(blobs<float>(dims, 100, 1), holes), 100);
    const auto others = trials<Index3>({{70, 35, 66}}, {{70, 9, 35}});
    expect_same(with_holes(blobs<std::uint8_t>(others, 250, 2), holes), 250);
    const auto flat = trials<Index3>({{700, 130, 1}}, {{300, 70, 1}});
    expect_same(with_holes(blobs<float>(flat, 100, 2), holes), 100);
  }
}

TEST_F(paged_model, reads_little_of_a_file_with_holes) {
  const Dataset built = build(with_holes(blobs<float>({{193, 193, 193}}, 100, 1), kBall));
  const std::string path = save(built);
  const Dataset opened = Dataset::open(path, {2}).value();
  Query query = isosurface(60, 0);
  query.max_error_outside = 1000;
  query.balls = {{{{160, 120, 330}}, 5}};
  EXPECT_FALSE(extract(opened, query).is_empty());
  EXPECT_LT(opened.reads().bytes, std::filesystem::file_size(path) / 2);
}

TEST_F(paged_model, reads_little_of_a_file_for_a_view) {
  const std::string path = save(build(blobs<std::uint8_t>({{193, 193, 193}}, 250, 1)));
  const Dataset opened = Dataset::open(path, {2}).value();
  Query query = isosurface(150, 0);
  query.max_error.reset();
  query.max_error_px = 20;
  query.view = View{{.eye = {{-400, 50, 150}}, .target = {{90, 60, 180}}}, 640, 480};
  EXPECT_FALSE(extract(opened, query).is_empty());
  EXPECT_LT(opened.reads().bytes, std::filesystem::file_size(path) / 2);
}

}  // namespace
}  // namespace lode

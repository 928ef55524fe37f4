// Live queries of files under a memory limit: pages go, and with them what matters least.

#include <chrono>
#include <map>
#include <thread>

#include "lode/api/focused_surface.h"
#include "lode/api/mesh_extraction.h"
#include "lode/api/session.h"
#include "lode/models/diamond/paged_refinable.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"
#include "tests/models/session_answers.h"
#include "tests/models/stored_fixtures.h"
#include "tests/oracles/trials.h"

namespace lode::diamond {
namespace {

using oracles::trials;
using store::TestPath;

Volume bumpy(const Index3& dims) {
  RegularGrid grid;
  grid.dims = dims;
  return oracles::volume_of<std::uint8_t>(grid, [](const Index3& p) {
    return 125 + 60 * std::sin(0.09 * p[0]) * std::cos(0.08 * p[1]) + 50 * std::sin(0.07 * p[2]);
  });
}

/// A stored volume, opened page by page.
struct Paged {
  explicit Paged(const Volume& volume) : path("paged.lode") {
    test::save<3>(test::built<3>(volume), path.str());
    reader.emplace(store::Reader::open(path.str()).value());
    Progress progress;
    model = PagedModel<3>::open(*reader, read_metadata(*reader).value(), progress).value();
  }

  TestPath path;
  std::optional<store::Reader> reader;
  std::unique_ptr<PagedModel<3>> model;
};

/// Steps to the end; of what is held in between never more than the quota.
template <typename Nodes>
void finish(Engine<Nodes>& engine, Nodes& nodes) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  while (!engine.standing().is_settled) {
    ASSERT_LT(std::chrono::steady_clock::now(), until);
    ASSERT_LE(nodes.n_bytes(), nodes.n_room());
    if (!engine.step() && engine.standing().awaits_data)
      nodes.client().wait(std::chrono::steady_clock::now() + std::chrono::milliseconds(10));
  }
}

/// How the isosurface at 130 stands in the end, and its triangles.
std::pair<Standing, std::size_t> settle(const Paged& paged, std::uint64_t limit) {
  PagedRefinable<3> nodes(*paged.model);
  paged.model->set_memory_limit(limit);
  Engine<PagedRefinable<3>> engine(nodes);
  LiveIsosurface<3, PagedModel<3>> surface(nodes, 130, true);
  nodes.follow(&surface);
  engine.set_query(isovalue_demand(130, 0.8));
  finish(engine, nodes);
  return {engine.standing(), surface.n_cells()};
}

TEST(page_limit, is_kept_and_the_answer_is_as_good_as_it_allows) {
  const Paged paged(bumpy(trials<Index3>({{257, 257, 129}}, {{193, 193, 97}})));
  const std::uint64_t all = paged.model->n_bytes_of_all();
  double bound = std::numeric_limits<double>::infinity();
  std::size_t n_applied = 0;
  for (const std::uint64_t limit : {all / 3, all / 2, all}) {
    SCOPED_TRACE(limit);
    const auto [standing, n_cells] = settle(paged, limit);
    EXPECT_EQ(standing.memory_met, limit == all);
    EXPECT_LE(standing.error_bound, bound);
    EXPECT_GE(standing.n_applied, n_applied);
    EXPECT_GT(n_cells, 0U);
    bound = standing.error_bound;
    n_applied = standing.n_applied;
  }
  EXPECT_LE(bound, 0.8);
}

TEST(page_limit, moves_with_the_focus) {
  const Paged paged(bumpy({{257, 257, 129}}));
  const std::uint64_t all = paged.model->n_bytes_of_all();
  paged.model->set_memory_limit(all / 2);
  PagedRefinable<3> nodes(*paged.model);
  Engine<PagedRefinable<3>> engine(nodes);
  LiveIsosurface<3, PagedModel<3>> surface(nodes, 130, true);
  nodes.follow(&surface);
  for (const double x : {10.0, 200.0, 60.0, 240.0, 10.0}) {
    SCOPED_TRACE(x);
    Query query;
    query.isovalues = {130};
    query.max_error = 0.5;
    query.max_error_outside = 30;
    query.balls = {{{{x, 100, 70}}, 18}};
    ASSERT_TRUE(check_query(query));
    engine.set_query(to_demand(query));
    finish(engine, nodes);
    EXPECT_TRUE(engine.standing().memory_met) << "there is room for one region at a time";
    EXPECT_LE(engine.standing().error_bound, 30);
  }
}

/// Edges of one triangle lie at the data's border, or beyond it. Spacing is 1.
void expect_no_cracks(const Surface& surface, const Index3& dims) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> n_uses;
  for (const auto& t : surface.triangles)
    for (std::size_t i = 0; i < 3; ++i) ++n_uses[std::minmax(t[i], t[(i + 1) % 3])];
  const auto is_at_border = [&](std::uint32_t v) {
    for (std::size_t i = 0; i < 3; ++i) {
      const float x = surface.positions[v][i];
      if (x <= 0.01F || x >= static_cast<float>(dims[i] - 1) - 0.01F) return true;
    }
    return false;
  };
  std::size_t n_cracks = 0;
  for (const auto& [edge, n] : n_uses)
    n_cracks += n != 2 && !(is_at_border(edge.first) && is_at_border(edge.second)) ? 1 : 0;
  EXPECT_EQ(n_cracks, 0U);
}

TEST(page_limit, is_shared_by_sessions_and_leaves_a_consistent_surface) {
  Progress progress;
  const TestPath path("shared.lode");
  test::save<3>(test::built<3>(bumpy({{193, 193, 129}})), path.str());
  const Dataset opened = Dataset::open(path.str(), {2}).value();
  std::vector<Session> sessions;
  for (const double isovalue : {110.0, 130.0, 150.0}) {
    Query query;
    query.isovalues = {isovalue};
    query.max_error = 2;
    sessions.push_back(
        Session::open(opened, query, {.with_views = false, .memory_limit = 12'000'000}, progress)
            .value());
  }
  for (Session& session : sessions) {
    const SurfaceMirror mirror = take_settled(session);
    EXPECT_GT(mirror.n_cells(), 0U);
    expect_no_cracks(mirror.to_surface(), opened.describe().volume.grid.dims);
  }
}

TEST(page_limit, holds_pages_cut_and_what_is_made_of_it) {
  Progress progress;
  const TestPath path("whole.lode");
  test::save<3>(test::built<3>(bumpy({{193, 193, 129}})), path.str());
  const Dataset opened = Dataset::open(path.str(), {2}).value();
  FocusedOptions options;
  options.query.isovalues = {130};
  options.query.max_error = 0.5;
  Surface surface;
  const Standing free = extract_focused(opened, options, surface, progress).value().standing;
  EXPECT_TRUE(free.memory_met);
  for (const std::uint64_t limit : {2'000'000, 8'000'000}) {
    options.memory_limit = limit;
    const Standing standing = extract_focused(opened, options, surface, progress).value().standing;
    EXPECT_FALSE(standing.memory_met);
    EXPECT_TRUE(standing.budget_met) << "which nobody set";
    EXPECT_LE(standing.n_cells, limit / 2 / 80);
    EXPECT_GT(standing.error_bound, free.error_bound);
    EXPECT_GT(surface.triangles.size(), 0U);
    expect_no_cracks(surface, opened.describe().volume.grid.dims);
    SimplexMesh mesh;
    MeshOptions mesh_options;
    mesh_options.query = options.query;
    mesh_options.query.isovalues.clear();
    mesh_options.query.balls = {{{{90, 90, 60}}, 40}};
    mesh_options.memory_limit = limit;
    const MeshReport report = opened.extract_mesh(mesh_options, mesh, progress).value();
    EXPECT_FALSE(report.memory_met);
    EXPECT_LE(report.n_cut_cells, limit / 2 / 100);
    EXPECT_GT(report.n_cells, 0U);
  }
}

TEST(page_limit, is_kept_between_holes) {
  Volume volume = bumpy({{193, 193, 129}});
  volume.info.nodata = 128;  // next to the surface
  const Paged paged(volume);
  const std::uint64_t all = paged.model->n_bytes_of_all();
  double bound = std::numeric_limits<double>::infinity();
  for (const std::uint64_t limit : {all / 3, all}) {
    SCOPED_TRACE(limit);
    const auto [standing, n_cells] = settle(paged, limit);
    EXPECT_GT(n_cells, 0U);
    EXPECT_LE(standing.error_bound, bound);
    bound = standing.error_bound;
    EXPECT_EQ(std::isinf(bound), limit < all);
  }
  EXPECT_LE(bound, 0.8);
}

}  // namespace
}  // namespace lode::diamond

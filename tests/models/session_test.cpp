#include "lode/api/session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <thread>

#include "lode/api/live_query.h"
#include "tests/models/surface_cells.h"
#include "tests/oracles/analytic_fields.h"
#include "tests/oracles/random.h"

namespace lode {
namespace {

Dataset gaussians(std::int32_t n) {
  const Volume volume = oracles::sample(oracles::Field::gaussians40, n);
  const auto source = make_memory_source(volume);
  Progress progress;
  return Dataset::build(*source, {}, progress).value();
}

Query isosurface(double isovalue, double max_error) {
  Query query;
  query.isovalues = {isovalue};
  query.max_error = max_error;
  return query;
}

/// Takes batches until the answer of query `number` is there.
void take_answer(Session& session, std::uint64_t number, SurfaceMirror& mirror) {
  for (;;) {
    const auto batch = session.take();
    if (!batch) {
      std::this_thread::yield();
      continue;
    }
    mirror.apply(batch->change);
    ASSERT_LE(batch->query, number);
    if (batch->query == number && batch->standing.is_settled) return;
  }
}

void expect_extraction(const Dataset& dataset, const Query& query, const SurfaceMirror& mirror) {
  Surface expected;
  Progress progress;
  ASSERT_TRUE(dataset.extract({.isovalues = query.isovalues, .max_error = query.max_error},
                              expected, progress));
  EXPECT_EQ(cells_of(mirror.to_surface()), cells_of(expected));
}

/// A closed surface: each edge belongs to two triangles, once in each direction.
void expect_consistent(const SurfaceMirror& mirror) {
  std::map<std::array<std::uint32_t, 2>, int> edges;
  for (const auto& cell : mirror.cells()) {
    if (cell == SurfaceBatch::kRemoved) continue;
    for (std::size_t i = 0; i < 3; ++i) ++edges[{cell[i], cell[(i + 1) % 3]}];
  }
  for (const auto& [edge, n] : edges) {
    ASSERT_EQ(n, 1);
    ASSERT_TRUE(edges.contains({edge[1], edge[0]}));
  }
}

TEST(session, ends_with_the_extracted_surface) {
  const Dataset dataset = gaussians(65);
  Progress progress;
  const Query query = isosurface(1.0, 0.01);
  auto session = Session::open(dataset, query, {.with_views = false}, progress);
  ASSERT_TRUE(session) << session.error().message;
  SurfaceMirror mirror;
  take_answer(*session, 1, mirror);
  expect_extraction(dataset, query, mirror);
}

TEST(session, answers_whatever_it_is_asked_last) {
  const Dataset dataset = gaussians(65);
  Progress progress;
  auto session = Session::open(dataset, isosurface(1.0, 0.01), {.with_views = false}, progress);
  ASSERT_TRUE(session);
  oracles::Random random(1);
  SurfaceMirror mirror;
  for (int i = 0; i < 12; ++i) {
    Query query;
    std::uint64_t number = 0;
    bool is_answered = false;
    for (int changes = 0; changes < 4; ++changes) {
      query = isosurface(random.uniform(0.2, 2.5),
                         random.uniform(0, 1) < 0.2 ? 0.0 : random.uniform(0.003, 0.2));
      number = session->set_query(query).value();
      std::this_thread::sleep_for(
          std::chrono::microseconds(static_cast<int>(random.uniform(0, 3000))));
      is_answered = false;
      if (const auto batch = session->take()) {
        mirror.apply(batch->change);
        is_answered = batch->query == number && batch->standing.is_settled;
      }
    }
    if (!is_answered) take_answer(*session, number, mirror);
    expect_extraction(dataset, query, mirror);
  }
}

TEST(session, shows_a_consistent_surface_at_any_moment) {
  // 65 samples: no simplex reaches across the border, where a surface would end open.
  const Dataset dataset = gaussians(65);
  Progress progress;
  Query query = isosurface(2.2, 0.02);
  auto session = Session::open(dataset, query, {.with_views = false}, progress);
  ASSERT_TRUE(session);
  SurfaceMirror mirror;
  std::uint64_t number = 1;
  std::uint64_t last = 0;
  for (int i = 0; i < 150; ++i) {
    std::this_thread::sleep_for(std::chrono::microseconds(300));
    if (const auto batch = session->take()) {
      ASSERT_GE(batch->query, last);
      ASSERT_LE(batch->query, number);
      last = batch->query;
      mirror.apply(batch->change);
      expect_consistent(mirror);
    }
    if (i % 10 == 9) {
      query.isovalues = {2.2 + 0.05 * (i % 7)};
      query.max_error = 0.002 * (1 + i % 5);
      number = session->set_query(query).value();
    }
  }
}

TEST(session, shares_a_dataset_with_another) {
  const Dataset dataset = gaussians(65);
  Progress progress;
  const Query first = isosurface(1.0, 0.02);
  const Query second = isosurface(1.6, 0.005);
  auto a = Session::open(dataset, first, {}, progress);
  auto b = Session::open(dataset, second, {}, progress);
  ASSERT_TRUE(a && b);
  SurfaceMirror mirror_a;
  SurfaceMirror mirror_b;
  take_answer(*a, 1, mirror_a);
  take_answer(*b, 1, mirror_b);
  expect_extraction(dataset, first, mirror_a);
  expect_extraction(dataset, second, mirror_b);
}

TEST(session, refines_where_the_view_looks) {
  const Dataset dataset = gaussians(65);
  Progress progress;
  Query query;
  query.isovalues = {1.0};
  query.max_error_px = 1;
  query.view =
      View{{.eye = {{0, -4, 0}}, .target = {{0, 0, 0}}, .field_of_view_deg = 40}, 800, 600};
  auto session = Session::open(dataset, query, {}, progress);
  ASSERT_TRUE(session) << session.error().message;
  SurfaceMirror mirror;
  take_answer(*session, 1, mirror);
  const std::size_t n_whole = mirror.n_cells();
  query.view->camera.target = {{0, -8, 0}};  // turned away: nothing is in sight
  take_answer(*session, session->set_query(query).value(), mirror);
  EXPECT_LT(mirror.n_cells(), n_whole / 4);
  query.view->camera = {.eye = {{0.1, 0.05, 0}}, .target = {{0.3, 0.2, 0.1}}};  // inside the data
  take_answer(*session, session->set_query(query).value(), mirror);
  EXPECT_GT(mirror.n_cells(), 0U);
}

TEST(session, refuses_queries_it_cannot_answer) {
  const Dataset dataset = gaussians(17);
  Progress progress;
  EXPECT_FALSE(Session::open(dataset, Query{}, {}, progress));
  Query pixels = isosurface(1, 0.1);
  pixels.max_error_px = 1;
  EXPECT_FALSE(Session::open(dataset, pixels, {}, progress));
  auto session = Session::open(dataset, isosurface(1, 0.1), {.with_views = false}, progress);
  ASSERT_TRUE(session);
  EXPECT_FALSE(session->set_query(isosurface(1, -1)));
  Query two = isosurface(1, 0.1);
  two.isovalues.push_back(2);
  EXPECT_FALSE(session->set_query(two));
}

TEST(session, answers_isovalues_that_meet_nothing_with_an_empty_surface) {
  const Dataset dataset = gaussians(33);
  Progress progress;
  auto session = Session::open(dataset, isosurface(1, 0.01), {.with_views = false}, progress);
  ASSERT_TRUE(session);
  SurfaceMirror mirror;
  take_answer(*session, 1, mirror);
  EXPECT_GT(mirror.n_cells(), 0U);
  take_answer(*session, session->set_query(isosurface(1e6, 0.01)).value(), mirror);
  EXPECT_EQ(mirror.n_cells(), 0U);
}

TEST(session, keeps_showing_while_an_isovalue_is_dragged) {
  const Dataset dataset = gaussians(129);
  Progress progress;
  Query query = isosurface(1.0, 0.0);
  auto session = Session::open(dataset, query, {.with_views = false}, progress);
  ASSERT_TRUE(session);
  SurfaceMirror mirror;
  take_answer(*session, 1, mirror);
  std::set<std::uint64_t> shown;
  std::uint64_t number = 1;
  // No matter how long it takes, but it must not wait for the dragging to end.
  for (int i = 0; i < 1500 && shown.size() < 4; ++i) {
    query.isovalues = {1.0 + 0.001 * (i + 1)};
    number = session->set_query(query).value();
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    if (const auto batch = session->take()) {
      mirror.apply(batch->change);
      shown.insert(batch->query);
    }
  }
  EXPECT_EQ(shown.size(), 4U);
  query.max_error = 0.05;
  number = session->set_query(query).value();
  take_answer(*session, number, mirror);
  expect_extraction(dataset, query, mirror);
}

TEST(live_query, starts_over_with_another_isovalue) {
  const Dataset dataset = gaussians(65);
  Progress progress;
  auto live = open_live_query(dataset, {Normals::off, false}, progress);
  ASSERT_TRUE(live);
  SurfaceMirror mirror;
  for (const double isovalue : {1.0, 1.1, 2.0, 0.3, 500.0, 1.5}) {
    const Query query = isosurface(isovalue, 0.01);
    EXPECT_FALSE((*live)->keeps_surface(query));
    (*live)->set_query(query);
    EXPECT_TRUE((*live)->keeps_surface(query));
    while ((*live)->step()) {
    }
    SurfaceBatch batch;
    batch.starts_over = true;
    while (!(*live)->gather(500, batch)) {
    }
    mirror.apply(batch);
    expect_extraction(dataset, query, mirror);
  }
}

}  // namespace
}  // namespace lode

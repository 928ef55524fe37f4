// A dragged isovalue, in steps of 0.5 % of the range over a file: what is in the cache is not read
// again, and a cache that is too small costs reads but nothing else (of sessions
// page_limit_test.cpp shows that).

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <thread>

#include "lode/api/session.h"
#include "tests/models/session_answers.h"
#include "tests/models/stored_fixtures.h"

namespace lode::diamond {
namespace {

using store::TestPath;

constexpr Index3 kDims{{129, 129, 97}};
constexpr double kMaxError = 2;

Volume hilly() {
  RegularGrid grid;
  grid.dims = kDims;
  return oracles::volume_of<std::uint8_t>(grid, [](const Index3& p) {
    return 125 + 60 * std::sin(0.09 * p[0]) * std::cos(0.08 * p[1]) + 50 * std::sin(0.07 * p[2]);
  });
}

/// The file of hilly(), and a dataset in memory to compare with.
struct Dragged {
  Dragged() : path("dragged.lode") {
    Progress progress;
    test::save<3>(test::built<3>(hilly()), path.str());
    whole.emplace(Dataset::open(path.str(), {2}).value());
    EXPECT_TRUE(whole->load(progress));
    const DatasetInfo info = whole->describe();
    const double step = 0.005 * (info.range_max - info.range_min);
    for (int i = 0; i < 8; ++i) isovalues.push_back(110.5 + i * step);
  }

  [[nodiscard]] Dataset open() const { return Dataset::open(path.str(), {2}).value(); }
  [[nodiscard]] std::uint64_t n_blocks() const {
    return store::Reader::open(path.str()).value().blocks().size();
  }

  TestPath path;
  std::optional<Dataset> whole;
  std::vector<double> isovalues;
};

ExtractReport extract(const Dataset& dataset, double isovalue, std::uint64_t memory_limit,
                      Surface& surface) {
  Progress progress;
  auto report = dataset.extract({.isovalues = {isovalue},
                                 .max_error = kMaxError,
                                 .normals = Normals::off,
                                 .threads = {2},
                                 .memory_limit = memory_limit},
                                surface, progress);
  EXPECT_TRUE(report) << (report ? "" : report.error().message);
  return report.value();
}

/// Along all isovalues and back, each surface compared with the one from memory; returns the blocks
/// read on the way there and on the way back.
std::pair<std::uint64_t, std::uint64_t> drag(const Dragged& dragged, const Dataset& dataset,
                                             std::uint64_t memory_limit) {
  Surface surface;
  Surface expected;
  std::array<std::uint64_t, 2> n_blocks{};
  std::vector<double> isovalues = dragged.isovalues;
  for (std::uint64_t& n : n_blocks) {
    for (const double isovalue : isovalues) {
      n += extract(dataset, isovalue, memory_limit, surface).blocks_read;
      extract(*dragged.whole, isovalue, 0, expected);
      EXPECT_FALSE(surface.is_empty());
      EXPECT_TRUE(surface.positions == expected.positions) << isovalue;
      EXPECT_TRUE(surface.triangles == expected.triangles) << isovalue;
    }
    std::reverse(isovalues.begin(), isovalues.end());
  }
  return {n_blocks[0], n_blocks[1]};
}

TEST(dragged_isovalue, reads_no_block_twice_while_it_is_in_the_cache) {
  const Dragged dragged;
  const Dataset dataset = dragged.open();
  Surface surface;
  const std::uint64_t n_first = extract(dataset, dragged.isovalues.front(), 0, surface).blocks_read;
  EXPECT_GT(n_first, 0U);
  const auto [there, back] = drag(dragged, dataset, 0);
  EXPECT_EQ(back, 0U);
  EXPECT_LE(dataset.reads().blocks, dragged.n_blocks());
  // Neighbours share nearly all of what they touch.
  EXPECT_LT(there, n_first);
  // Each in a dataset of its own: what would be read without a cache.
  std::uint64_t n_alone = 0;
  for (const double isovalue : dragged.isovalues)
    n_alone += extract(dragged.open(), isovalue, 0, surface).blocks_read;
  EXPECT_GT(n_alone, 5 * (n_first + there)) << n_first << " first, then " << there;
  // All in one extraction read what dragging reads.
  Progress progress;
  const auto together = dragged.open().extract(
      {.isovalues = dragged.isovalues, .max_error = kMaxError, .threads = {2}}, surface, progress);
  ASSERT_TRUE(together);
  EXPECT_EQ(together->blocks_read, n_first + there);
}

TEST(dragged_isovalue, is_right_with_a_cache_that_is_too_small) {
  const Dragged dragged;
  const Dataset dataset = dragged.open();
  constexpr std::uint64_t kSmall = 7'000'000;  // an eighth of it keeps blocks
  const auto [there, back] = drag(dragged, dataset, kSmall);
  EXPECT_GT(there, 0U);
  EXPECT_GT(back, 0U) << "the limit is no limit";
}

/// Waits for the answer to a query.
Standing settle(Session& session, std::uint64_t query, SurfaceMirror& mirror) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  while (std::chrono::steady_clock::now() < until) {
    const auto batch = session.take();
    if (!batch) {
      std::this_thread::yield();
      continue;
    }
    EXPECT_FALSE(batch->fault);
    mirror.apply(batch->change);
    if (batch->query == query && batch->standing.is_settled) return batch->standing;
  }
  ADD_FAILURE() << "no answer came";
  return {};
}

/// What dragging through one session there and back reads, and the sizes of its surfaces.
struct SessionDrag {
  std::array<std::uint64_t, 2> n_blocks{};
  std::vector<std::size_t> n_cells;
  bool has_met_memory = true;
};

SessionDrag drag_session(const Dragged& dragged, const Dataset& dataset) {
  Progress progress;
  Query query;
  query.isovalues = {dragged.isovalues.front()};
  query.max_error = kMaxError;
  auto session =
      Session::open(dataset, query, {.normals = Normals::off, .with_views = false}, progress);
  EXPECT_TRUE(session);
  SurfaceMirror mirror;
  settle(*session, 1, mirror);
  SessionDrag result;
  std::vector<double> isovalues = dragged.isovalues;
  std::uint64_t n_before = 0;
  for (std::uint64_t& n : result.n_blocks) {
    for (const double isovalue : isovalues) {
      query.isovalues = {isovalue};
      const Standing standing = settle(*session, session->set_query(query).value(), mirror);
      result.has_met_memory = result.has_met_memory && standing.memory_met;
      result.n_cells.push_back(mirror.n_cells());
    }
    n = dataset.reads().blocks - n_before;
    n_before += n;
    std::reverse(isovalues.begin(), isovalues.end());
  }
  return result;
}

TEST(dragged_isovalue, of_a_session_reads_no_block_twice_while_it_is_in_the_cache) {
  const Dragged dragged;
  const Dataset dataset = dragged.open();
  const SessionDrag session = drag_session(dragged, dataset);
  EXPECT_TRUE(session.has_met_memory);
  EXPECT_GT(session.n_blocks[0], 0U);
  EXPECT_LE(session.n_blocks[0], dragged.n_blocks());
  EXPECT_EQ(session.n_blocks[1], 0U);
  for (std::size_t i = 0, n = session.n_cells.size(); i < n; ++i)
    EXPECT_EQ(session.n_cells[i], session.n_cells[n - 1 - i]);
}

}  // namespace
}  // namespace lode::diamond

// A session over a file whose pages are read as it goes, while calls fail: it answers, or says why
// not, and never ends the program.
#include <chrono>
#include <cmath>
#include <optional>
#include <thread>

#include "lode/api/session.h"
#include "tests/faults/fault_scratch.h"
#include "tests/faults/fault_storm.h"
#include "tests/oracles/analytic_fields.h"

namespace lode::test {
namespace {

using fault_session = FaultTest;

Query query_of(double isovalue) {
  Query query;
  query.isovalues = {isovalue};
  query.max_error = 0.6;
  return query;
}

/// Takes batches until the answer to the newest query is there, or the reason why it never will be.
Result<void> take_answer(Session& session, std::uint64_t number, std::uint64_t& n_cells) {
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < patience) {
    const auto batch = session.take();
    if (!batch) {
      std::this_thread::sleep_for(std::chrono::microseconds(100));
      continue;
    }
    if (batch->fault) return std::move(*batch->fault);
    if (batch->query != number || !batch->standing.is_settled) continue;
    n_cells = batch->standing.n_cells;
    return {};
  }
  return fail("no answer came");
}

TEST_F(fault_session, over_a_file_answers_or_says_why_not) {
  const FaultScratch scratch("field.lode");
  Progress progress;
  {
    const Volume volume = oracles::sample(oracles::Field::gaussians40, {{150, 5, 5}});
    const auto source = make_memory_source(volume);
    ASSERT_TRUE(Dataset::build(*source, {}, progress)->save(scratch.output(), {}, progress));
  }
  std::uint64_t n_cells = 0;
  std::optional<std::uint64_t> expected;
  Operation operation;
  operation.files = {scratch.output()};
  const Query first = query_of(0.3);
  const Query second = query_of(0.4);
  operation.run = [&]() -> Result<void> {
    LODE_TRY(const auto dataset, Dataset::open(scratch.output(), {1}));
    LODE_TRY(auto session, Session::open(dataset, first, {.with_views = false}, progress));
    auto answer = take_answer(session, 1, n_cells);
    if (!answer) return answer;  // to copy the error would take memory
    LODE_TRY(const std::uint64_t number, session.set_query(second));
    return take_answer(session, number, n_cells);
  };
  operation.expect_done = [&] {
    if (!expected) expected = n_cells;
    EXPECT_EQ(n_cells, *expected);
  };
  expect_survives_all(operation);
}

/// Data that come late change nothing of a surface that is not there; the answer is told all the
/// same.
TEST_F(fault_session, over_a_file_tells_of_an_answer_that_changes_nothing) {
  const FaultScratch scratch("field.lode");
  Progress progress;
  const Volume volume = oracles::sample(oracles::Field::gaussians40, {{150, 5, 5}});
  const auto source = make_memory_source(volume);
  ASSERT_TRUE(Dataset::build(*source, {}, progress)->save(scratch.output(), {}, progress));
  const auto dataset = Dataset::open(scratch.output(), {1});
  ASSERT_TRUE(dataset);
  // Above all samples, but within ranges, which are rounded outward.
  Query query = query_of(std::nextafter(dataset->describe().range_max, 1e30));
  query.max_error = 0;
  begin_faults({Fault::late_read, 0, true});
  std::uint64_t n_cells = 0;
  auto session = Session::open(*dataset, query, {.with_views = false}, progress);
  const Result<void> answer =
      session ? take_answer(*session, 1, n_cells) : Result<void>(session.error());
  EXPECT_GT(end_faults().n_failed, 0);
  EXPECT_TRUE(answer) << answer.error().message;
}

TEST_F(fault_session, that_has_ended_refuses_queries) {
  const Volume volume = oracles::sample(oracles::Field::gaussians40, 33);
  const auto source = make_memory_source(volume);
  Progress progress;
  const auto dataset = Dataset::build(*source, {}, progress);
  ASSERT_TRUE(dataset);
  auto session = Session::open(*dataset, query_of(0.3), {.with_views = false}, progress);
  ASSERT_TRUE(session) << session.error().message;
  std::uint64_t n_cells = 0;
  ASSERT_TRUE(take_answer(*session, 1, n_cells));
  // An answer may be there before memory ends; another query then asks for more of it.
  Result<void> answer = Result<void>();
  for (int i = 0; i < 1000 && answer; ++i) {
    const auto number = session->set_query(query_of(i % 2 == 0 ? 0.4 : 0.3));
    // It may have ended right after its last answer.
    if (!number) answer = fail("not enough memory: {}", number.error().message);
    if (!number) break;
    begin_faults({Fault::memory, 0, true});
    answer = take_answer(*session, *number, n_cells);
    end_faults();
  }
  ASSERT_FALSE(answer) << "no query takes memory";
  EXPECT_NE(answer.error().message.find("memory"), std::string::npos) << answer.error().message;
  const auto refused = session->set_query(query_of(0.3));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("the session has ended"), std::string::npos);
}

}  // namespace
}  // namespace lode::test

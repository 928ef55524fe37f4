// Loops that several threads share.
#include "lode/core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

namespace lode {
namespace {

/// How often each index came.
std::vector<int> counts(std::size_t n, int threads, std::size_t grain) {
  std::vector<int> n_calls(n);
  parallel_for(n, {threads}, grain, [&](std::size_t i, int) { ++n_calls[i]; });
  return n_calls;
}

TEST(parallel_loop, calls_each_index_once) {
  for (const std::size_t n : {0U, 1U, 2U, 3U, 7U, 64U, 1000U, 30011U})
    for (const int threads : {0, 1, 2, 3, 9, 40})
      for (const std::size_t grain : {1U, 2U, 5U, 999U, 40000U})
        ASSERT_EQ(counts(n, threads, grain), std::vector<int>(n, 1))
            << n << ", threads " << threads << ", grain " << grain;
}

TEST(parallel_loop, has_every_worker_once_at_a_time) {
  for (const int threads : {2, 3, 12}) {
    std::vector<std::atomic<bool>> is_at_work(static_cast<std::size_t>(threads));
    std::atomic<int> n_wrong = 0;
    parallel_for(2000, {threads}, 1, [&](std::size_t i, int worker) {
      if (worker < 0 || worker >= threads) {
        ++n_wrong;
        return;
      }
      auto& mine = is_at_work[static_cast<std::size_t>(worker)];
      n_wrong += mine.exchange(true) ? 1 : 0;
      if (i % 16 == 0) std::this_thread::yield();
      mine = false;
    });
    EXPECT_EQ(n_wrong, 0);
  }
}

/// What is called inside of a body must not take up work of the loop around it.
TEST(parallel_loop, has_no_worker_twice_where_loops_are_nested) {
  for (const int round : {1, 2, 3})
    for (const int threads : {2, 3, 5}) {
      std::vector<std::atomic<bool>> is_at_work(static_cast<std::size_t>(threads));
      std::atomic<int> n_wrong = 0;
      std::atomic<int> n_inner = 0;
      parallel_for(100, {threads}, 1, [&](std::size_t, int worker) {
        auto& mine = is_at_work[static_cast<std::size_t>(worker)];
        n_wrong += mine.exchange(true) ? 1 : 0;
        parallel_for(20, {threads}, 1, [&](std::size_t i, int) {
          if (i % 4 == 0) std::this_thread::yield();
          ++n_inner;
        });
        mine = false;
      });
      EXPECT_EQ(n_wrong, 0) << "round " << round;
      EXPECT_EQ(n_inner, 2000);
    }
}

TEST(parallel_loop, is_there_for_several_threads_at_once) {
  std::vector<std::vector<int>> n_calls(6);
  std::vector<std::thread> callers;
  for (std::size_t c = 0; c < n_calls.size(); ++c)
    callers.emplace_back([&n_calls, c] {
      for (int round = 0; round < 50; ++round)
        n_calls[c] = counts(300, 2 + static_cast<int>(c % 3), 7);
    });
  for (std::thread& caller : callers) caller.join();
  for (const auto& calls : n_calls) EXPECT_EQ(calls, std::vector<int>(300, 1));
}

TEST(parallel_loop, passes_an_exception_on_and_leaves_out_most_of_the_rest) {
  for (const int threads : {1, 2, 7}) {
    std::atomic<std::size_t> n_calls = 0;
    const auto run = [&] {
      parallel_for(1'000'000, {threads}, 1, [&](std::size_t i, int) {
        ++n_calls;
        if (i == 10) throw std::runtime_error("the tenth");
      });
    };
    EXPECT_THROW(run(), std::runtime_error);
    EXPECT_LT(n_calls, 1'000'000U);
  }
  EXPECT_EQ(counts(100, 3, 1), std::vector<int>(100, 1));
}

TEST(parallel_loop, may_be_inside_another_and_run_from_many_threads) {
  std::atomic<std::size_t> n_calls = 0;
  const auto nested = [&] {
    parallel_for(40, {3}, 1, [&](std::size_t, int) {
      parallel_for(50, {2}, 3, [&](std::size_t, int) { ++n_calls; });
    });
  };
  std::vector<std::thread> callers;
  for (int i = 0; i < 6; ++i) callers.emplace_back(nested);
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(n_calls, 6U * 40 * 50);
}

}  // namespace
}  // namespace lode

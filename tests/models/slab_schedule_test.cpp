#include "lode/models/diamond/slab_schedule.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <stdexcept>
#include <thread>
#include <tuple>
#include <vector>

namespace lode::diamond {
namespace {

using Step = SlabSchedule::Step;
using Task = SlabSchedule::Task;

/// Notes what is done, and that nothing is done before what it needs.
class Recorder {
 public:
  explicit Recorder(std::size_t n) : n_(n), found_(n), counted_(n), written_(n) {}

  bool place(std::size_t slab, std::size_t n_with_room) {
    EXPECT_EQ(slab, n_placed_.load());
    EXPECT_TRUE(counted_[slab]);
    n_placed_ = slab + 1;
    return slab < n_with_room;
  }
  void run(const Task& task) {
    const std::size_t next = std::min(task.slab + 1, n_ - 1);
    switch (task.step) {
      case Step::find: EXPECT_FALSE(found_[task.slab].exchange(true)); break;
      case Step::count:
        EXPECT_TRUE(found_[task.slab] && found_[next]);
        EXPECT_FALSE(counted_[task.slab].exchange(true));
        break;
      case Step::write:
        EXPECT_GT(n_placed_.load(), next);
        EXPECT_FALSE(written_[task.slab].exchange(true));
        break;
    }
  }
  [[nodiscard]] std::size_t n_written() const {
    return static_cast<std::size_t>(std::count(written_.begin(), written_.end(), true));
  }

 private:
  std::size_t n_;
  std::vector<std::atomic<bool>> found_, counted_, written_;
  std::atomic<std::size_t> n_placed_{0};
};

void work_on_threads(SlabSchedule& schedule, int n_threads,
                     const std::function<void(const Task&)>& body) {
  std::vector<std::thread> threads;
  for (int i = 1; i < n_threads; ++i) threads.emplace_back([&] { schedule.work(body); });
  schedule.work(body);
  for (std::thread& thread : threads) thread.join();
}

class slab_schedule : public testing::TestWithParam<std::tuple<std::size_t, int>> {};

TEST_P(slab_schedule, does_all_once_and_in_order) {
  const auto [n, n_threads] = GetParam();
  for (const std::size_t n_with_room : {n, std::size_t{0}, n / 2}) {
    Recorder recorder(n);
    SlabSchedule schedule(n, [&](std::size_t slab) { return recorder.place(slab, n_with_room); });
    const auto body = [&](const Task& task) { recorder.run(task); };
    work_on_threads(schedule, n_threads, body);
    EXPECT_EQ(recorder.n_written(), n_with_room);
    EXPECT_EQ(schedule.is_complete(), n_with_room == n);
    schedule.make_room();
    work_on_threads(schedule, n_threads, body);
    EXPECT_EQ(recorder.n_written(), n);
    EXPECT_TRUE(schedule.is_complete());
  }
}

INSTANTIATE_TEST_SUITE_P(sizes, slab_schedule,
                         testing::Combine(testing::Values(1, 2, 3, 65), testing::Values(1, 2, 5)));

TEST(slab_schedule_failure, ends_for_all_threads) {
  for (const Step step : {Step::find, Step::count, Step::write}) {
    SlabSchedule schedule(20, [](std::size_t) { return true; });
    std::atomic<int> n_failed{0};
    const auto work = [&] {
      try {
        schedule.work([&](const Task& task) {
          if (task.step == step && task.slab == 7) throw std::runtime_error("no memory");
        });
      } catch (const std::runtime_error&) {
        ++n_failed;
      }
    };
    std::thread other(work);
    work();
    other.join();
    EXPECT_EQ(n_failed, 1);
    EXPECT_FALSE(schedule.is_complete());
  }
}

TEST(slab_schedule_alone, writes_a_slab_before_it_finds_one_far_ahead) {
  std::size_t n_found = 0;
  std::size_t n_written = 0;
  SlabSchedule schedule(100, [](std::size_t) { return true; });
  schedule.work([&](const Task& task) {
    n_found += task.step == Step::find ? 1 : 0;
    n_written += task.step == Step::write ? 1 : 0;
    EXPECT_LE(n_found, n_written + 3);
  });
}

}  // namespace
}  // namespace lode::diamond

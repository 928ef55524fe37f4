#include "lode/core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace lode {
namespace {

#ifdef __SANITIZE_THREAD__
/// The same for the thread sanitizer, which would take oneTBB for racing: that is not instrumented.
void run_on_plain_threads(std::size_t n, int workers, std::size_t grain,
                          const std::function<void(std::size_t i, int worker)>& body) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&](int worker) {
    try {
      for (std::size_t begin; (begin = next.fetch_add(grain)) < n;)
        for (std::size_t i = begin; i < std::min(n, begin + grain); ++i) body(i, worker);
    } catch (...) {
      const std::lock_guard lock(failure_mutex);
      failure = std::current_exception();
    }
  };
  std::vector<std::thread> threads;
  for (int worker = 1; worker < workers; ++worker) threads.emplace_back(work, worker);
  work(0);
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}
#endif

}  // namespace

int n_workers(Threads threads) {
  if (threads.count > 0) return threads.count;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void parallel_for(std::size_t n, Threads threads, std::size_t grain,
                  const std::function<void(std::size_t i, int worker)>& body) {
  const int workers = n_workers(threads);
  if (workers == 1 || n <= std::max<std::size_t>(grain, 1)) {
    for (std::size_t i = 0; i < n; ++i) body(i, 0);
    return;
  }
#ifdef __SANITIZE_THREAD__
  run_on_plain_threads(n, workers, std::max<std::size_t>(grain, 1), body);
#else
  // More threads than cores are given where they are asked for, without oneTBB's warning.
  std::optional<tbb::global_control> limit;
  if (workers > n_workers({}))
    limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(workers));
  tbb::task_arena arena(workers);
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, n, std::max<std::size_t>(grain, 1)),
        [&](const tbb::blocked_range<std::size_t>& range) {
          const int worker = tbb::this_task_arena::current_thread_index();
          for (std::size_t i = range.begin(); i != range.end(); ++i) body(i, worker);
        },
        tbb::simple_partitioner());
  });
#endif
}

}  // namespace lode

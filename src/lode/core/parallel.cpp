#include "lode/core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace lode {
namespace {

/// What the first body to throw has thrown. oneTBB would carry it too, but ends the program where
/// it has no memory to do so, as is likely after std::bad_alloc.
class FirstException {
 public:
  /// Inside a handler.
  void note() noexcept {
    const std::lock_guard lock(mutex_);
    if (!exception_) exception_ = std::current_exception();
  }
  void rethrow() const {
    if (exception_) std::rethrow_exception(exception_);
  }

 private:
  std::mutex mutex_;
  std::exception_ptr exception_;
};

#ifdef __SANITIZE_THREAD__
/// The same for the thread sanitizer, which would take oneTBB for racing: that is not instrumented.
void run_on_plain_threads(std::size_t n, int workers, std::size_t grain,
                          const std::function<void(std::size_t i, int worker)>& body) {
  std::atomic<std::size_t> next{0};
  FirstException failure;
  const auto work = [&](int worker) {
    try {
      for (std::size_t begin; (begin = next.fetch_add(grain)) < n;)
        for (std::size_t i = begin; i < std::min(n, begin + grain); ++i) body(i, worker);
    } catch (...) {
      failure.note();
    }
  };
  std::vector<std::thread> threads;
  for (int worker = 1; worker < workers; ++worker) threads.emplace_back(work, worker);
  work(0);
  for (std::thread& thread : threads) thread.join();
  failure.rethrow();
}
#else
/// Arenas are kept from call to call: threads stay in one for a while after its work is done, and
/// are there when there is more, where those of a new one have to be woken first. Each is used by
/// one call at a time: what is called inside of another has its own, so that no thread takes up the
/// outer one's work while it waits.
class ArenaPool {
 public:
  /// Takes an arena for so many threads, and gives it back in the end.
  class Lease {
   public:
    Lease(ArenaPool& pool, int workers)
        : pool_(pool), workers_(workers), arena_(pool.take(workers)) {}
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    ~Lease() { pool_.give(workers_, std::move(arena_)); }
    [[nodiscard]] tbb::task_arena& arena() { return *arena_; }

   private:
    ArenaPool& pool_;
    int workers_;
    std::unique_ptr<tbb::task_arena> arena_;
  };

  /// Of the program; it stays to the very end, as other threads may.
  static ArenaPool& get() {
    static ArenaPool& pool = *new ArenaPool;
    return pool;
  }

 private:
  struct Free {
    int workers;
    std::unique_ptr<tbb::task_arena> arena;
  };
  static constexpr std::size_t kMostFree = 8;

  std::unique_ptr<tbb::task_arena> take(int workers) {
    {
      const std::lock_guard lock(mutex_);
      for (Free& free : free_)
        if (free.workers == workers) {
          std::unique_ptr<tbb::task_arena> arena = std::move(free.arena);
          free_.erase(free_.begin() + (&free - free_.data()));
          return arena;
        }
    }
    return std::make_unique<tbb::task_arena>(workers);
  }
  void give(int workers, std::unique_ptr<tbb::task_arena> arena) noexcept {
    const std::lock_guard lock(mutex_);
    if (free_.size() == kMostFree) free_.erase(free_.begin());  // that nobody has asked for longest
    free_.push_back({workers, std::move(arena)});
  }

  ArenaPool() { free_.reserve(kMostFree); }  // so that giving back cannot fail

  std::mutex mutex_;
  std::vector<Free> free_;
};
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
  FirstException failure;
  tbb::task_group_context context;
  const auto run_range = [&](const tbb::blocked_range<std::size_t>& range) {
    const int worker = tbb::this_task_arena::current_thread_index();
    try {
      for (std::size_t i = range.begin(); i != range.end(); ++i) body(i, worker);
    } catch (...) {
      failure.note();
      context.cancel_group_execution();
    }
  };
  ArenaPool::Lease lease(ArenaPool::get(), workers);
  lease.arena().execute([&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, std::max<std::size_t>(grain, 1)),
                      run_range, tbb::simple_partitioner(), context);
  });
  failure.rethrow();
#endif
}

}  // namespace lode

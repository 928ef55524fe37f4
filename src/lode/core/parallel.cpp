// Loops shared among threads that wait asleep. Where the machine has other work, a scheduler whose
// waiting threads spin takes the time of those it waits for: with oneTBB two runs of a test of many
// short loops, side by side on two cores, took 40 s each, and take 7 s now; alone 6.8 s, now 4 s.
#include "lode/core/parallel.h"

#include <pthread.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace lode {
namespace {

/// What the first body to throw has thrown.
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

/// Chunks [begin, end) that one worker has before it: it takes them from the front, others their
/// rear half. No chunk is ever in two of these, so that no value of one comes twice.
class alignas(64) Share {
 public:
  void set(std::uint32_t begin, std::uint32_t end) { range_ = pack(begin, end); }
  [[nodiscard]] bool is_empty() const { return begin_of(range_) == end_of(range_); }
  bool take_first(std::uint32_t& chunk) {
    std::uint64_t range = range_;
    do {
      chunk = begin_of(range);
      if (chunk == end_of(range)) return false;
    } while (!range_.compare_exchange_weak(range, pack(chunk + 1, end_of(range))));
    return true;
  }
  /// Moves the rear half of what is here, rounded up, to `thief`, which is empty.
  bool give_half(Share& thief) {
    std::uint64_t range = range_;
    std::uint32_t middle;
    do {
      if (begin_of(range) == end_of(range)) return false;
      middle = begin_of(range) + (end_of(range) - begin_of(range)) / 2;
    } while (!range_.compare_exchange_weak(range, pack(begin_of(range), middle)));
    thief.set(middle, end_of(range));
    return true;
  }

 private:
  static std::uint64_t pack(std::uint32_t begin, std::uint32_t end) {
    return std::uint64_t{end} << 32 | begin;
  }
  static std::uint32_t begin_of(std::uint64_t range) { return static_cast<std::uint32_t>(range); }
  static std::uint32_t end_of(std::uint64_t range) {
    return static_cast<std::uint32_t>(range >> 32);
  }

  std::atomic<std::uint64_t> range_{0};
};

/// One call of parallel_for: lives on the stack of its caller, who is worker 0.
class Loop {
 public:
  Loop(std::size_t n, int workers, std::size_t grain,
       const std::function<void(std::size_t i, int worker)>& body)
      : n_(n), grain_(std::max(grain, n / kMostChunks + 1)), body_(body), n_workers_(workers) {
    if (workers > static_cast<int>(few_.size())) many_ = std::vector<Share>(as_size(workers));
    share(0).set(0, static_cast<std::uint32_t>((n + grain_ - 1) / grain_));
  }
  void work(int worker) noexcept {
    try {
      do
        for (std::uint32_t chunk; !is_cancelled_ && share(worker).take_first(chunk);) {
          const std::size_t begin = chunk * grain_;
          const std::size_t end = std::min(n_, begin + grain_);
          for (std::size_t i = begin; i < end; ++i) body_(i, worker);
        }
      while (!is_cancelled_ && find_more(worker));
    } catch (...) {
      failure_.note();
      is_cancelled_ = true;
    }
  }
  [[nodiscard]] bool has_work() const {
    if (is_cancelled_) return false;
    for (int worker = 0; worker < n_workers_; ++worker)
      if (!share(worker).is_empty()) return true;
    return false;
  }
  [[nodiscard]] int n_workers() const { return n_workers_; }
  void rethrow() const { failure_.rethrow(); }

  // The crew's, guarded by its mutex.
  Loop* next = nullptr;
  int n_joined = 1;   ///< Worker numbers that are given away.
  int n_helpers = 0;  ///< At work, the caller not counted.
  std::condition_variable is_left;

 private:
  static constexpr std::size_t kMostChunks = std::size_t{1} << 31;

  static std::size_t as_size(int n) { return static_cast<std::size_t>(n); }
  Share& share(int worker) {
    return many_.empty() ? few_[as_size(worker)] : many_[as_size(worker)];
  }
  [[nodiscard]] const Share& share(int worker) const {
    return many_.empty() ? few_[as_size(worker)] : many_[as_size(worker)];
  }
  bool find_more(int worker) {
    for (int i = 1; i < n_workers_; ++i)
      if (share((worker + i) % n_workers_).give_half(share(worker))) return true;
    return false;
  }

  std::size_t n_;
  std::size_t grain_;
  const std::function<void(std::size_t i, int worker)>& body_;
  int n_workers_;
  std::array<Share, 8> few_;
  std::vector<Share> many_;
  FirstException failure_;
  std::atomic<bool> is_cancelled_{false};
};

/// The threads that help, for as long as the program runs. A caller never waits for help, only for
/// what helpers have begun, so that nested loops end too.
class Crew {
 public:
  void run(Loop& loop) {
    offer(loop);
    loop.work(0);
    retire(loop);
    loop.rethrow();
  }

 private:
  void offer(Loop& loop) {
    const std::lock_guard lock(mutex_);
    hire(loop.n_workers() - 1);
    loop.next = loops_;
    loops_ = &loop;
    if (n_asleep_ > 0) is_offered_.notify_one();
  }
  void retire(Loop& loop) {
    std::unique_lock lock(mutex_);
    Loop** at = &loops_;
    while (*at != &loop) at = &(*at)->next;
    *at = loop.next;
    loop.is_left.wait(lock, [&] { return loop.n_helpers == 0; });
  }
  void hire(int n) {
    try {
      for (; n_helpers_ < n; ++n_helpers_) std::thread([this] { help(); }).detach();
    } catch (const std::exception&) {
      // Fewer do.
    }
  }
  Loop* find_loop() {
    for (Loop* loop = loops_; loop != nullptr; loop = loop->next)
      if (loop->n_joined < loop->n_workers() && loop->has_work()) return loop;
    return nullptr;
  }
  [[noreturn]] void help() {
    std::unique_lock lock(mutex_);
    while (true) {
      Loop* loop = find_loop();
      if (loop == nullptr) {
        ++n_asleep_;
        is_offered_.wait(lock);
        --n_asleep_;
        continue;
      }
      const int worker = loop->n_joined++;
      ++loop->n_helpers;
      // Each wakes the next: waking takes time, which the caller is to spend on its loop.
      if (n_asleep_ > 0 && find_loop() != nullptr) is_offered_.notify_one();
      lock.unlock();
      loop->work(worker);
      lock.lock();
      if (--loop->n_helpers == 0) loop->is_left.notify_one();
    }
  }

  std::mutex mutex_;
  std::condition_variable is_offered_;
  Loop* loops_ = nullptr;
  int n_helpers_ = 0;
  int n_asleep_ = 0;
};

/// Never destroyed: its threads run until the program ends. After a fork another, as that leaves
/// the threads behind, one of them perhaps with the mutex.
std::atomic<Crew*>& crew() {
  static std::atomic<Crew*> current = [] {
    ::pthread_atfork(nullptr, nullptr, [] { crew() = new Crew; });
    return new Crew;
  }();
  return current;
}

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
  Loop loop(n, workers, std::max<std::size_t>(grain, 1), body);
  crew().load()->run(loop);
}

}  // namespace lode

#include "lode/api/session.h"

#include <atomic>
#include <chrono>
#include <new>
#include <system_error>
#include <thread>
#include <utility>

#include "lode/api/live_query.h"
#include "lode/core/out_of_memory.h"

namespace lode {
namespace {

struct NumberedQuery {
  std::uint64_t number = 0;
  Query query;
};

/// One place for one thing that one thread leaves and another takes; the newest wins.
template <typename T>
class Mailbox {
 public:
  Mailbox() = default;
  Mailbox(const Mailbox&) = delete;
  Mailbox& operator=(const Mailbox&) = delete;
  ~Mailbox() { delete thing_.load(std::memory_order_acquire); }

  /// What was there before comes back.
  std::unique_ptr<T> put(std::unique_ptr<T> thing) {
    return std::unique_ptr<T>(thing_.exchange(thing.release(), std::memory_order_acq_rel));
  }
  std::unique_ptr<T> take() { return put(nullptr); }
  [[nodiscard]] bool has_mail() const { return thing_.load(std::memory_order_relaxed) != nullptr; }

 private:
  std::atomic<T*> thing_{nullptr};
};

}  // namespace

class Session::Impl {
 public:
  Impl(std::unique_ptr<LiveQuery> live, bool has_views, const Query& query)
      : has_views_(has_views), live_(std::move(live)) {
    farewell_->fault = out_of_memory("refine the surface any further");
    send(query);
    live_->on_data([this] { wake(); });
    try {
      thread_ = std::thread([this] { run(); });
    } catch (...) {
      live_->on_data({});
      throw;
    }
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    must_stop_.store(true, std::memory_order_release);
    live_->on_data({});
    wake();
    thread_.join();
  }

  Result<std::uint64_t> set_query(const Query& query) {
    LODE_CHECK(check_live_query(query, has_views_));
    if (has_ended_.load(std::memory_order_acquire))
      return fail("the session has ended: there was not enough memory");
    return send(query);
  }
  std::unique_ptr<SessionBatch> take() { return batches_.take(); }

 private:
  using Clock = std::chrono::steady_clock;
  /// A batch is begun when this long has passed since the last one, or the answer is there.
  static constexpr std::chrono::milliseconds kBetweenBatches{4};
  static constexpr std::size_t kChangesPerStep = 4096;
  static constexpr int kStepsPerLook = 64;  ///< At the clock.

  std::uint64_t send(const Query& query) {
    const std::uint64_t number = ++n_queries_;
    queries_.put(std::make_unique<NumberedQuery>(NumberedQuery{number, query}));
    wake();
    return number;
  }
  void wake() {
    n_wakes_.fetch_add(1, std::memory_order_release);
    n_wakes_.notify_one();
  }

  /// A step that found no memory leaves engine and surface somewhere in between: it is the last.
  void run() noexcept {
    try {
      refine();
    } catch (const std::bad_alloc&) {
      has_ended_.store(true, std::memory_order_release);
      // Nothing new here takes memory. A batch that was not taken is the last to change anything.
      auto last = batches_.take();
      auto fault = std::move(farewell_->fault);
      if (!last) last = std::move(farewell_);
      last->fault = std::move(fault);
      batches_.put(std::move(last));
    }
  }

  void refine() {
    while (!must_stop_.load(std::memory_order_acquire)) {
      const std::uint32_t n_wakes = n_wakes_.load(std::memory_order_acquire);
      if (queries_.has_mail()) accept();
      if (batch_)
        gather();
      else if (!advance())
        n_wakes_.wait(n_wakes, std::memory_order_acquire);
    }
  }

  /// A batch that is being gathered goes on for the old query, unless the surface starts again.
  void accept() {
    const auto query = queries_.take();
    if (!live_->keeps_surface(query->query)) {
      batch_.reset();
      ++generation_;
      starts_over_ = true;
    }
    number_ = query->number;
    live_->set_query(query->query);
    must_publish_ = true;
  }

  /// False if there is nothing to do.
  bool advance() {
    const bool has_moved = live_->step();
    if (!has_moved && !has_news()) return false;
    if (has_moved && ++n_steps_ % kStepsPerLook != 0) return true;
    const bool is_due = Clock::now() - last_batch_ >= between_;
    if (has_moved && !(is_due && live_->n_changed() > 0)) return true;
    must_publish_ = has_moved;  // once more when the answer is there
    begin_batch();
    return true;
  }

  [[nodiscard]] static bool says_the_same(Standing a, const Standing& b) {
    a.n_steps = b.n_steps;
    return a == b;
  }
  /// What the last batch of this query does not say. Data that came late may have changed nothing
  /// but that the answer is there.
  [[nodiscard]] bool has_news() const {
    return must_publish_ || live_->n_changed() > 0 || (!has_told_ && live_->fault()) ||
           !says_the_same(live_->standing(), told_);
  }

  void begin_batch() {
    // What the reader has not taken it gets with this one.
    if (const auto missed = batches_.take(); missed && missed->generation == generation_) {
      live_->take_back(missed->change);
      starts_over_ = starts_over_ || missed->change.starts_over;
    }
    batch_ = std::make_unique<SessionBatch>();
    batch_->query = number_;
    batch_->generation = generation_;
    batch_->change.starts_over = std::exchange(starts_over_, false);
    batch_->standing = live_->standing();
    told_ = batch_->standing;
    batch_->fault = live_->fault();
    has_told_ = batch_->fault.has_value();
    gathering_ = Clock::now();
  }

  void gather() {
    if (!live_->gather(kChangesPerStep, batch_->change)) return;
    batches_.put(std::move(batch_));
    last_batch_ = Clock::now();
    between_ = std::max<Clock::duration>(kBetweenBatches, 4 * (last_batch_ - gathering_));
  }

  const bool has_views_;
  const std::unique_ptr<LiveQuery> live_;  // the thread's alone from here on
  std::unique_ptr<SessionBatch> batch_;    ///< Being gathered.
  std::unique_ptr<SessionBatch> farewell_ = std::make_unique<SessionBatch>();  ///< See run().
  std::uint64_t number_ = 0;
  std::uint64_t generation_ = 0;
  bool starts_over_ = false;   ///< No batch has said so yet that was taken, or can be.
  bool must_publish_ = false;  ///< The newest query has not been answered by a batch yet.
  Standing told_;              ///< By the last batch.
  bool has_told_ = false;      ///< A batch has said that data will not come.
  std::uint64_t n_steps_ = 0;
  Clock::time_point last_batch_;
  Clock::time_point gathering_;
  Clock::duration between_ = kBetweenBatches;

  std::uint64_t n_queries_ = 0;  // the caller's
  Mailbox<NumberedQuery> queries_;
  Mailbox<SessionBatch> batches_;
  std::atomic<std::uint32_t> n_wakes_{0};
  std::atomic<bool> must_stop_{false};
  std::atomic<bool> has_ended_{false};
  std::thread thread_;
};

Session::Session(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;
Session::~Session() = default;

Result<Session> Session::open(const Dataset& dataset, const Query& query,
                              const SessionOptions& options, Progress& progress) try {
  LODE_CHECK(check_live_query(query, options.with_views));
  LODE_TRY(auto live, open_live_query(dataset,
                                      {.normals = options.normals,
                                       .with_views = options.with_views,
                                       .memory_limit = options.memory_limit},
                                      progress));
  return Session(std::make_unique<Impl>(std::move(live), options.with_views, query));
} catch (const std::bad_alloc&) {
  return out_of_memory("open a session");
} catch (const std::system_error& error) {
  return fail("a session's thread cannot be started: {}", error.what());
}

Result<std::uint64_t> Session::set_query(const Query& query) try {
  return impl_->set_query(query);
} catch (const std::bad_alloc&) {
  return out_of_memory("set the query");
}
std::unique_ptr<SessionBatch> Session::take() { return impl_->take(); }

}  // namespace lode

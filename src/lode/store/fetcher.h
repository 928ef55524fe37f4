#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <vector>

namespace lode::store {

/// Fetches numbered pages on a thread of its own, for several clients: each in turn gets what it
/// wants most. A page is fetched once, whoever asks, unless it goes again.
class Fetcher {
 public:
  using Page = std::uint32_t;
  using Clock = std::chrono::steady_clock;

  /// Asks for pages, and forgets what it asked for when it goes. One thread's.
  class Client {
   public:
    explicit Client(Fetcher& fetcher);
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;
    ~Client();

    /// The larger `demand`, the sooner; of several for one page the largest counts. Nothing happens
    /// if it has been fetched. Throws std::bad_alloc, also where no thread can be started.
    void want(Page page, float demand);
    void forget();
    /// The pages that were fetched since the last call, in that order, whoever asked for them.
    void add_fetched(std::vector<Page>& out);
    [[nodiscard]] bool has_fetched() const {
      return fetcher_.n_fetched_.load(std::memory_order_acquire) != n_seen_;
    }
    /// Until has_fetched(), or a moment.
    void wait(Clock::time_point until);
    /// Calls `wake` on the fetching thread after every page, and when another client comes or goes;
    /// null: no more, also if it runs now.
    void on_fetched(std::function<void()> wake);

   private:
    friend class Fetcher;

    Fetcher& fetcher_;
    std::unordered_map<Page, float> wanted_;  // this and the next by fetcher_.mutex_
    std::function<void()> wake_;
    std::size_t n_seen_ = 0;
  };

  /// `fetch` is called once for each page that is wanted, on one thread, and may not throw.
  Fetcher(std::size_t n_pages, std::function<void(Page)> fetch);
  Fetcher(const Fetcher&) = delete;
  Fetcher& operator=(const Fetcher&) = delete;
  /// Waits for the page being fetched; the clients must have gone.
  ~Fetcher();

  /// For `fetch`: a page that was fetched is going, before it has gone; or has stayed after all.
  void leaves(Page page);
  void stays(Page page);
  [[nodiscard]] std::size_t n_clients() const { return n_clients_; }

 private:
  void start();
  void run();
  [[nodiscard]] bool next(Page& page);
  void note(Page page);
  void drop_seen();
  void count_clients();

  const std::function<void(Page)> fetch_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Client*> clients_;
  std::atomic<std::size_t> n_clients_{0};
  std::size_t turn_ = 0;                   ///< Of the clients.
  std::vector<bool> is_fetched_;           ///< By page.
  std::vector<Page> fetched_;              ///< In that order, behind
  std::size_t n_dropped_ = 0;              ///< so many that all clients have seen;
  std::atomic<std::size_t> n_fetched_{0};  ///< how many with them, some of them again.
  bool must_stop_ = false;
  std::thread thread_;  ///< Begins with the first request.
};

}  // namespace lode::store

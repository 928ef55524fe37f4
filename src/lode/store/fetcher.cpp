#include "lode/store/fetcher.h"

#include <algorithm>
#include <new>
#include <system_error>
#include <utility>

namespace lode::store {

Fetcher::Client::Client(Fetcher& fetcher) : fetcher_(fetcher) {
  const std::lock_guard lock(fetcher_.mutex_);
  fetcher_.clients_.push_back(this);
  n_seen_ = fetcher_.n_fetched_;
  fetcher_.count_clients();
}

Fetcher::Client::~Client() {
  const std::lock_guard lock(fetcher_.mutex_);
  std::erase(fetcher_.clients_, this);
  fetcher_.count_clients();
}

void Fetcher::Client::want(Page page, float demand) {
  {
    const std::lock_guard lock(fetcher_.mutex_);
    if (fetcher_.is_fetched_[page]) return;
    float& known = wanted_.try_emplace(page, demand).first->second;
    known = std::max(known, demand);
    fetcher_.start();
  }
  fetcher_.changed_.notify_all();
}

void Fetcher::Client::forget() {
  const std::lock_guard lock(fetcher_.mutex_);
  wanted_.clear();
}

void Fetcher::Client::add_fetched(std::vector<Page>& out) {
  const std::lock_guard lock(fetcher_.mutex_);
  const auto first = static_cast<std::ptrdiff_t>(n_seen_ - fetcher_.n_dropped_);
  out.insert(out.end(), fetcher_.fetched_.begin() + first, fetcher_.fetched_.end());
  n_seen_ = fetcher_.n_fetched_;
}

void Fetcher::Client::wait(Clock::time_point until) {
  std::unique_lock lock(fetcher_.mutex_);
  fetcher_.changed_.wait_until(lock, until, [this] { return has_fetched(); });
}

void Fetcher::Client::on_fetched(std::function<void()> wake) {
  const std::lock_guard lock(fetcher_.mutex_);
  wake_ = std::move(wake);
}

Fetcher::Fetcher(std::size_t n_pages, std::function<void(Page)> fetch)
    : fetch_(std::move(fetch)), is_fetched_(n_pages) {
  fetched_.reserve(n_pages);  // its thread takes no memory
}

Fetcher::~Fetcher() {
  {
    const std::lock_guard lock(mutex_);
    must_stop_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

/// Where the machine has no thread left, it has nothing left to work with.
void Fetcher::start() {
  if (thread_.joinable()) return;
  try {
    thread_ = std::thread([this] { run(); });
  } catch (const std::system_error&) {
    throw std::bad_alloc();
  }
}

/// What the next client that wants anything wants most. Some thousand pages at most are wanted at
/// once, and to fetch one takes longer than to look at them.
bool Fetcher::next(Page& page) {
  for (std::size_t i = 0; i < clients_.size(); ++i) {
    turn_ = (turn_ + 1) % clients_.size();
    const auto& wanted = clients_[turn_]->wanted_;
    if (wanted.empty()) continue;
    const auto most =
        std::max_element(wanted.begin(), wanted.end(), [](const auto& a, const auto& b) {
          return a.second != b.second ? a.second < b.second : a.first > b.first;
        });
    page = most->first;
    return true;
  }
  return false;
}

void Fetcher::count_clients() {
  n_clients_ = clients_.size();
  for (const Client* client : clients_)
    if (client->wake_) client->wake_();
}

void Fetcher::leaves(Page page) {
  const std::lock_guard lock(mutex_);
  is_fetched_[page] = false;
}

void Fetcher::stays(Page page) {
  const std::lock_guard lock(mutex_);
  note(page);
}

/// What all clients have seen, so that pages that come again and again take no more memory.
void Fetcher::drop_seen() {
  std::size_t n_seen = n_fetched_;
  for (const Client* client : clients_) n_seen = std::min(n_seen, client->n_seen_);
  fetched_.erase(fetched_.begin(),
                 fetched_.begin() + static_cast<std::ptrdiff_t>(n_seen - n_dropped_));
  n_dropped_ = n_seen;
}

void Fetcher::note(Page page) {
  is_fetched_[page] = true;
  if (fetched_.size() == fetched_.capacity()) drop_seen();
  fetched_.push_back(page);
  for (Client* client : clients_) client->wanted_.erase(page);
  n_fetched_.store(n_dropped_ + fetched_.size(), std::memory_order_release);
  for (const Client* client : clients_)
    if (client->wake_) client->wake_();
}

void Fetcher::run() {
  std::unique_lock lock(mutex_);
  while (!must_stop_) {
    Page page = 0;
    if (!next(page)) {
      changed_.wait(lock);
      continue;
    }
    lock.unlock();
    fetch_(page);
    lock.lock();
    note(page);
    changed_.notify_all();
  }
}

}  // namespace lode::store

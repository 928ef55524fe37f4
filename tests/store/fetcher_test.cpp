#include "lode/store/fetcher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <future>

namespace lode::store {
namespace {

using Page = Fetcher::Page;
using namespace std::chrono_literals;

/// Waits for n more pages.
std::vector<Page> next_pages(Fetcher::Client& client, std::size_t n) {
  std::vector<Page> pages;
  while (pages.size() < n) {
    client.wait(Fetcher::Clock::now() + 10s);
    EXPECT_TRUE(client.has_fetched());
    client.add_fetched(pages);
  }
  return pages;
}

TEST(fetcher, fetches_what_is_wanted_most_first_and_once) {
  std::promise<void> begun;
  std::promise<void> gate;
  std::vector<Page> fetched;
  Fetcher fetcher(100, [&](Page page) {
    if (page == 7) {
      begun.set_value();
      gate.get_future().wait();
    }
    fetched.push_back(page);
  });
  Fetcher::Client client(fetcher);
  client.want(7, 1.0F);
  begun.get_future().wait();
  client.want(3, 0.5F);
  client.want(9, 0.1F);
  client.want(4, 2.0F);
  client.want(9, 3.0F);  // the larger one counts
  client.want(9, 0.2F);
  gate.set_value();
  EXPECT_EQ(next_pages(client, 4), (std::vector<Page>{7, 9, 4, 3}));
  client.want(4, 5.0F);
  client.want(11, 1.0F);
  EXPECT_EQ(next_pages(client, 1), (std::vector<Page>{11}));
  EXPECT_EQ(fetched, (std::vector<Page>{7, 9, 4, 3, 11}));
}

TEST(fetcher, serves_its_clients_by_turns) {
  std::promise<void> gate;
  auto opened = gate.get_future().share();
  std::vector<Page> fetched;
  Fetcher fetcher(100, [&](Page page) {
    opened.wait();
    fetched.push_back(page);
  });
  Fetcher::Client greedy(fetcher);
  Fetcher::Client modest(fetcher);
  for (Page page = 0; page < 10; ++page) greedy.want(page, 100.0F);
  modest.want(50, 0.1F);
  modest.want(51, 0.1F);
  gate.set_value();
  next_pages(modest, 12);
  const auto place = std::find(fetched.begin(), fetched.end(), 51U) - fetched.begin();
  EXPECT_LE(place, 4);
}

TEST(fetcher, forgets_what_nobody_wants_any_more) {
  std::promise<void> gate;
  auto opened = gate.get_future().share();
  std::atomic<int> n_fetched{0};
  Fetcher fetcher(100, [&](Page) {
    opened.wait();
    ++n_fetched;
  });
  Fetcher::Client client(fetcher);
  {
    Fetcher::Client leaves(fetcher);
    for (Page page = 0; page < 10; ++page) leaves.want(page, 1.0F);
    for (Page page = 20; page < 30; ++page) client.want(page, 1.0F);
    client.forget();
  }
  gate.set_value();
  client.want(40, 1.0F);
  std::vector<Page> pages;
  while (std::find(pages.begin(), pages.end(), 40U) == pages.end()) {
    client.wait(Fetcher::Clock::now() + 10s);
    client.add_fetched(pages);
  }
  EXPECT_LE(n_fetched, 2);  // what was being fetched, and 40
}

TEST(fetcher, wakes_its_clients_until_told_not_to) {
  Fetcher fetcher(100, [](Page) {});
  Fetcher::Client client(fetcher);
  std::atomic<int> n_wakes{0};
  client.on_fetched([&] { ++n_wakes; });
  client.want(1, 1.0F);
  client.want(2, 1.0F);
  next_pages(client, 2);
  client.on_fetched({});
  EXPECT_EQ(n_wakes, 2);
  client.want(3, 1.0F);
  next_pages(client, 1);
  EXPECT_EQ(n_wakes, 2);
}

}  // namespace
}  // namespace lode::store

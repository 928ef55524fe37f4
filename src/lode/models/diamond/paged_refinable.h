#pragma once

#include <algorithm>
#include <unordered_map>
#include <unordered_set>

#include "lode/core/inline_list.h"
#include "lode/models/diamond/live_isosurface.h"
#include "lode/models/diamond/paged_model.h"

namespace lode::diamond {

extern template class Refinable<2, PagedModel<2>>;
extern template class Refinable<3, PagedModel<3>>;
extern template class LiveIsosurface<2, PagedModel<2>>;
extern template class LiveIsosurface<3, PagedModel<3>>;

/// A hierarchy whose pages come when the engine asks for them, with an isosurface that follows it.
template <int D>
class PagedRefinable : public LiveRefinable<D, PagedModel<D>> {
 public:
  using Worlds = typename Refinable<D, PagedModel<D>>::Worlds;

  explicit PagedRefinable(const PagedModel<D>& model, Worlds worlds = Worlds::none)
      : LiveRefinable<D, PagedModel<D>>(model, worlds), client_(model.fetcher()) {}
  PagedRefinable(const PagedRefinable&) = delete;
  PagedRefinable& operator=(const PagedRefinable&) = delete;
  ~PagedRefinable() { let_all_go(); }

  /// Pages that have room, but are not there, are counted as if they were: they have been promised.
  Held hold(NodeId id) {
    Held held;
    std::size_t n = 0;
    const auto pages = pages_of(id);
    for (; n < pages.size() && held.state == Held::State::held; ++n) held = hold_page(pages[n]);
    if (held.state == Held::State::held) return held;
    for (std::size_t i = 0; i + 1 < n; ++i) let_page_go(pages[i]);
    return held;
  }
  void let_go(NodeId id) {
    for (const std::uint32_t page : pages_of(id)) let_page_go(page);
  }
  /// When the nodes that held pages are forgotten all at once.
  void let_all_go() {
    for (const auto& [page, n] : n_uses_) this->model().pages().let_go(page);
    n_uses_.clear();
    promised_.clear();
    n_bytes_ = 0;
  }

  void request(std::uint32_t page, float demand) {
    requested_.insert(page);
    client_.want(page, demand);
  }
  void forget_requests() {
    for (const auto& [page, has_come] : promised_) n_bytes_ -= this->model().n_bytes(page);
    promised_.clear();
    requested_.clear();
    client_.forget();
  }
  /// Why a page that was asked for will not come.
  [[nodiscard]] std::optional<Error> fault() const { return this->model().fault_of(requested_); }
  [[nodiscard]] bool has_arrivals() const { return client_.has_fetched(); }
  void take_arrivals(std::vector<std::uint32_t>& out) {
    const std::size_t n_before = out.size();
    client_.add_fetched(out);
    for (std::size_t i = n_before; i < out.size(); ++i)
      if (const auto promise = promised_.find(out[i]); promise != promised_.end())
        promise->second = true;
  }
  bool drop_unclaimed() {
    return 0 < std::erase_if(promised_, [&](const auto& promise) {
             if (promise.second) n_bytes_ -= this->model().n_bytes(promise.first);
             return promise.second;
           });
  }

  [[nodiscard]] std::uint64_t n_room() const { return this->model().quota(); }
  [[nodiscard]] bool may_be_full() const { return this->model().n_bytes_of_all() > n_room(); }
  [[nodiscard]] bool is_over() const { return n_bytes_ > n_room(); }
  [[nodiscard]] std::uint64_t n_free() const { return n_room() - std::min(n_room(), n_bytes_); }
  /// Held or promised.
  [[nodiscard]] std::uint64_t n_bytes() const { return n_bytes_; }

  [[nodiscard]] store::Fetcher::Client& client() { return client_; }

 private:
  using Pages = InlineList<std::uint32_t, 2 * power(2, D)>;

  [[nodiscard]] Pages pages_of(NodeId id) const {
    Pages pages;
    this->model().for_each_page(diamond_of<D>(id),
                                [&](std::uint32_t page) { pages.push_back(page); });
    return pages;
  }

  Held hold_page(std::uint32_t page) {
    if (const auto use = n_uses_.find(page); use != n_uses_.end()) {
      ++use->second;
      return {};
    }
    const std::uint64_t size = this->model().n_bytes(page);
    const bool was_promised = promised_.contains(page);
    if (!was_promised && n_free() < size) return {Held::State::full, page};
    // Memory is taken before the page is: where there is none, nothing is held that nobody knows
    // of.
    const auto use = n_uses_.emplace(page, 1).first;
    if (this->model().pages().hold(page)) {
      if (promised_.erase(page) == 0) n_bytes_ += size;
      return {};
    }
    n_uses_.erase(use);
    if (promised_.emplace(page, false).second) n_bytes_ += size;
    return {Held::State::absent, page};
  }
  void let_page_go(std::uint32_t page) {
    const auto use = n_uses_.find(page);
    if (--use->second > 0) return;
    n_uses_.erase(use);
    n_bytes_ -= this->model().n_bytes(page);
    this->model().pages().let_go(page);
  }

  store::Fetcher::Client client_;
  std::unordered_set<std::uint32_t> requested_;
  std::unordered_map<std::uint32_t, std::uint32_t> n_uses_;  ///< Of pages that are held, by nodes.
  std::unordered_map<std::uint32_t, bool> promised_;         ///< And whether they have come.
  std::uint64_t n_bytes_ = 0;                                ///< Of pages held or promised.
};

static_assert(PagedRefinableModel<PagedRefinable<2>> && PagedRefinableModel<PagedRefinable<3>>);

}  // namespace lode::diamond

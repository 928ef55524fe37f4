#pragma once

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
  explicit PagedRefinable(const PagedModel<D>& model)
      : LiveRefinable<D, PagedModel<D>>(model), client_(model.fetcher()) {}

  [[nodiscard]] std::optional<std::uint32_t> missing(NodeId id) const {
    return this->model().missing(diamond_of<D>(id));
  }
  void request(std::uint32_t page, float demand) {
    requested_.push_back(page);
    client_.want(page, demand);
  }
  void forget_requests() {
    requested_.clear();
    client_.forget();
  }
  /// Why a page that was asked for will not come.
  [[nodiscard]] std::optional<Error> fault() const { return this->model().fault_of(requested_); }
  [[nodiscard]] bool has_arrivals() const { return client_.has_fetched(); }
  void take_arrivals(std::vector<std::uint32_t>& out) { client_.add_fetched(out); }

  [[nodiscard]] store::Fetcher::Client& client() { return client_; }

 private:
  store::Fetcher::Client client_;
  std::vector<std::uint32_t> requested_;
};

static_assert(PagedRefinableModel<PagedRefinable<2>> && PagedRefinableModel<PagedRefinable<3>>);

}  // namespace lode::diamond

#include "lode/models/terrain/insertions/open_pages.h"

#include <algorithm>
#include <utility>

namespace lode::insertions {

OpenPage::OpenPage(PageNodes nodes, const LatticeBox& box) : nodes_(std::move(nodes)), box_(box) {
  // About two nodes a square, were they spread evenly.
  const std::int64_t n_wanted =
      std::max<std::int64_t>(1, static_cast<std::int64_t>(nodes_.points.size()) / 2);
  const auto squares = [&](std::int32_t low, std::int32_t high) {
    return std::int64_t{(high - low) >> bits_} + 1;
  };
  while (squares(box.lower.x, box.upper.x) * squares(box.lower.y, box.upper.y) > n_wanted) ++bits_;
  const Square last = square_of(box.upper);
  n_columns_ = last.x + 1;
  first_.assign(std::size_t{n_columns_} * (last.y + 1) + 1, 0);
  const auto number = [&](delaunay::LatticePoint p) {
    const Square square = square_of(p);
    return square.y * n_columns_ + square.x;
  };
  for (const delaunay::LatticePoint& p : nodes_.points) ++first_[number(p) + 1];
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  order_.resize(nodes_.points.size());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t i = 0; i < order_.size(); ++i) order_[next[number(nodes_.points[i])]++] = i;
}

Result<const OpenPage*> OpenPages::page(std::uint32_t page) {
  std::unique_ptr<OpenPage>& slot = pages_[page];
  if (!slot) {
    LODE_TRY(PageNodes nodes, file_.read_nodes(page));
    const PageEntry& entry = file_.pages()[page];
    slot = std::make_unique<OpenPage>(std::move(nodes), LatticeBox{entry.lower, entry.upper});
  }
  return static_cast<const OpenPage*>(slot.get());
}

Result<const OpenPage*> OpenPages::page_with_errors(std::uint32_t page) {
  LODE_TRY(const OpenPage* const opened, this->page(page));
  if (!opened->has_errors) {
    LODE_TRY(pages_[page]->errors, file_.read_errors(page));
    pages_[page]->has_errors = true;
  }
  return opened;
}

}  // namespace lode::insertions

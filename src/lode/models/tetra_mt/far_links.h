#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/tetra_mt/node_page.h"
#include "lode/models/tetra_mt/number_models.h"

namespace lode::tetra_mt {

struct FarModels {
  static constexpr std::size_t kSizes = kPageBits + 1;

  NumberModel n_pages;
  WideModel page_gaps;
  NumberModel counts;
  std::array<NumberModel, kSizes> offset_gaps;  ///< By how many bits their number has.
  std::array<std::array<NumberModel, 3>, 3> ranks;
  std::array<std::array<NumberModel, kSizes>, 3> steps;
};

/// Codes a page's links to others: first which vertices of which pages there are, then each link as
/// one of these.
template <typename Coder>
class FarLinks {
 public:
  /// Who links, which each has models of its own.
  enum Kind : std::uint8_t { child, parent, target };

  FarLinks(Coder& coder, FarModels& models, const PageShape& shape, std::uint32_t number,
           const std::string& what)
      : coder_(coder), models_(models), shape_(shape), number_(number), what_(what) {}

  /// `given`: vertices of other pages, for a writer. Fails where there are more than `most`.
  Result<void> code_table(std::vector<std::uint32_t> given, std::size_t most) {
    if (!Coder::kReads) take(std::move(given));
    pages_.resize(models_.n_pages.code(coder_, static_cast<std::uint32_t>(pages_.size())));
    if (pages_.size() > most)
      return fail("{}: expected up to {} pages, got {}", what_, most, pages_.size());
    std::uint64_t from = 0;
    std::size_t n = 0;
    for (Page& page : pages_) {
      const std::uint64_t gap = models_.page_gaps.code(coder_, page.number - from);
      if (gap >= n_all_pages() - from || from + gap == number_)
        return fail("{}: expected numbers of {} pages but {}, that ascend, got {} after {}", what_,
                    n_all_pages(), number_, gap, from);
      page.number = static_cast<std::uint32_t>(from + gap);
      from = page.number + std::uint64_t{1};
      LODE_CHECK(code_offsets(page));
      n += page.offsets.size();
      if (n > most) return fail("{}: expected up to {} far links, got {}", what_, most, n);
    }
    recent_.resize(pages_.size());
    for (std::uint32_t i = 0; i < recent_.size(); ++i) recent_[i] = i;
    for (const Page& page : pages_)
      for (const std::uint16_t offset : page.offsets)
        vertices_.push_back(vertices_of(shape_, page.number).first + offset);
    std::ranges::sort(vertices_);
    return {};
  }
  /// Those of the table, ascending.
  [[nodiscard]] std::span<const std::uint32_t> vertices() const { return vertices_; }

  /// A link to a vertex of the table. `order`: how many of its list were before.
  Result<std::uint32_t> code(Kind kind, std::uint32_t order, std::uint32_t given) {
    std::uint32_t rank = 0;
    std::uint32_t offset = 0;
    if (!Coder::kReads) {
      const std::uint32_t number = page_of(shape_, given);
      while (pages_[recent_[rank]].number != number) ++rank;
      offset = given - vertices_of(shape_, number).first;
    }
    rank = models_.ranks[kind][std::min(order, 2U)].code(coder_, rank);
    if (rank >= recent_.size())
      return fail("{}: expected one of {} pages, got {}", what_, recent_.size(), rank);
    std::rotate(recent_.begin(), recent_.begin() + rank, recent_.begin() + rank + 1);
    Page& page = pages_[recent_[0]];
    LODE_CHECK(code_place(kind, page, offset));
    return vertices_of(shape_, page.number).first + page.offsets[page.last];
  }

 private:
  struct Page {
    std::uint32_t number = 0;
    std::uint32_t last = 0;  ///< Place of the offset that was linked to last.
    std::vector<std::uint16_t> offsets{};
  };

  [[nodiscard]] std::uint32_t n_all_pages() const { return shape_.n_vertex_pages(); }
  void take(std::vector<std::uint32_t> vertices) {
    std::ranges::sort(vertices, {},
                      [&](std::uint32_t v) { return std::pair(page_of(shape_, v), v); });
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    for (const std::uint32_t v : vertices) {
      const std::uint32_t number = page_of(shape_, v);
      if (pages_.empty() || pages_.back().number != number) pages_.push_back({.number = number});
      pages_.back().offsets.push_back(
          static_cast<std::uint16_t>(v - vertices_of(shape_, number).first));
    }
  }
  Result<void> code_offsets(Page& page) {
    const std::uint32_t n_there = vertices_of(shape_, page.number).n;
    const std::uint32_t n =
        models_.counts.code(coder_, static_cast<std::uint32_t>(page.offsets.size()) - 1) + 1;
    if (n > n_there)
      return fail("{}: expected up to {} vertices of a page, got {}", what_, n_there, n);
    page.offsets.resize(n);
    NumberModel& gaps = models_.offset_gaps[static_cast<std::size_t>(std::bit_width(n)) - 1];
    std::uint32_t from = 0;
    for (std::uint16_t& offset : page.offsets) {
      from += gaps.code(coder_, offset - from);
      if (from >= n_there)
        return fail("{}: expected one of {} vertices, got {}", what_, n_there, from);
      offset = static_cast<std::uint16_t>(from++);
    }
    return {};
  }
  Result<void> code_place(Kind kind, Page& page, std::uint32_t offset) {
    const auto n = static_cast<std::uint32_t>(page.offsets.size());
    if (n == 1) return {};
    const auto place = std::ranges::lower_bound(page.offsets, offset) - page.offsets.begin();
    const auto step = static_cast<std::int32_t>(place) - static_cast<std::int32_t>(page.last);
    NumberModel& model = models_.steps[kind][static_cast<std::size_t>(std::bit_width(n)) - 1];
    page.last += static_cast<std::uint32_t>(unfolded(model.code(coder_, folded(step))));
    if (page.last < n) return {};
    return fail("{}: expected one of {} places, got {}", what_, n, page.last);
  }

  Coder& coder_;
  FarModels& models_;
  const PageShape& shape_;
  std::uint32_t number_;
  const std::string& what_;
  std::vector<Page> pages_;
  std::vector<std::uint32_t> vertices_;
  std::vector<std::uint32_t> recent_;  ///< Places in pages_, that which was linked to last first.
};

}  // namespace lode::tetra_mt

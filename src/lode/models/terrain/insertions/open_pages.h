#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/terrain/insertions/history_file.h"

namespace lode::insertions {

/// The nodes of a page, with squares to look for them in.
class OpenPage {
 public:
  OpenPage(PageNodes nodes, const LatticeBox& box);

  [[nodiscard]] const PageNodes& nodes() const { return nodes_; }
  /// visit(i) for each node in squares that meet a box, not in order.
  template <typename Visit>
  void for_each_near(const LatticeBox& box, const Visit& visit) const {
    if (!box.meets(box_)) return;
    const auto [x0, y0] =
        square_of({std::max(box.lower.x, box_.lower.x), std::max(box.lower.y, box_.lower.y)});
    const auto [x1, y1] =
        square_of({std::min(box.upper.x, box_.upper.x), std::min(box.upper.y, box_.upper.y)});
    for (std::uint32_t y = y0; y <= y1; ++y)
      for (std::uint32_t k = first_[y * n_columns_ + x0]; k < first_[y * n_columns_ + x1 + 1]; ++k)
        visit(order_[k]);
  }

  std::vector<float> errors;  ///< Read when they are wanted; by triangle that the nodes make.
  bool has_errors = false;

 private:
  struct Square {
    std::uint32_t x;
    std::uint32_t y;
  };
  [[nodiscard]] Square square_of(delaunay::LatticePoint p) const {
    return {static_cast<std::uint32_t>(p.x - box_.lower.x) >> bits_,
            static_cast<std::uint32_t>(p.y - box_.lower.y) >> bits_};
  }

  PageNodes nodes_;
  LatticeBox box_;
  int bits_ = 0;  ///< Squares are so many powers of two wide.
  std::uint32_t n_columns_ = 1;
  std::vector<std::uint32_t> first_;  ///< By square, and one more.
  std::vector<std::uint32_t> order_;  ///< Nodes, square by square.
};

/// Pages of a file that one question has read.
class OpenPages {
 public:
  /// The file must outlive it.
  explicit OpenPages(const HistoryFile& file) : file_(file), pages_(file.pages().size()) {}

  [[nodiscard]] const HistoryFile& file() const { return file_; }
  /// Reads it unless it is there.
  [[nodiscard]] Result<const OpenPage*> page(std::uint32_t page);
  /// With errors, too.
  [[nodiscard]] Result<const OpenPage*> page_with_errors(std::uint32_t page);

 private:
  const HistoryFile& file_;
  std::vector<std::unique_ptr<OpenPage>> pages_;
};

}  // namespace lode::insertions

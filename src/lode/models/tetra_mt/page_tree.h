#pragma once

#include <cstdint>
#include <vector>

#include "lode/models/tetra_mt/node_page.h"

namespace lode::tetra_mt {

/// Which nodes of its page each of a page's discovers, and an order in which those come before it:
/// what nodes state is nested along discovery.
struct PageTree {
  Lists<std::uint16_t> found;          ///< By node, places in the page.
  std::vector<std::uint8_t> n_others;  ///< By node: how many more, in other pages.
  std::vector<std::uint16_t> order;    ///< Not of all where this is no tree.

  /// `number`: of the page.
  [[nodiscard]] static PageTree of(const PageContent& content, std::uint32_t number);
  [[nodiscard]] static PageTree of(const NodePage& page, std::uint32_t number, std::uint32_t n);

  [[nodiscard]] std::uint32_t n_nodes() const {
    return static_cast<std::uint32_t>(n_others.size());
  }

 private:
  void add(std::uint32_t child, std::uint32_t number, std::uint32_t n);
  void find_order();
};

}  // namespace lode::tetra_mt

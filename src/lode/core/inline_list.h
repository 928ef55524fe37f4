#pragma once

#include <array>
#include <cstddef>

#include "lode/core/expects.h"

namespace lode {

/// Up to N items held in place: a result that is small by nature and costs no allocation.
template <typename T, std::size_t N>
class InlineList {
 public:
  void push_back(const T& item) {
    LODE_EXPECTS(size_ < N);
    items_[size_++] = item;
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return items_[i]; }
  [[nodiscard]] T& operator[](std::size_t i) { return items_[i]; }
  [[nodiscard]] const T* begin() const { return items_.data(); }
  [[nodiscard]] const T* end() const { return items_.data() + size_; }

 private:
  std::array<T, N> items_{};
  std::size_t size_ = 0;
};

}  // namespace lode

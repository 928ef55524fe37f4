#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace lode {

/// An array that grows without moving what is there, so that growing never takes long.
template <typename T>
class PagedArray {
 public:
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] T& operator[](std::size_t i) { return pages_[i / kPageSize][i % kPageSize]; }
  [[nodiscard]] const T& operator[](std::size_t i) const {
    return pages_[i / kPageSize][i % kPageSize];
  }
  void add() {
    if (size_ == pages_.size() * kPageSize) pages_.push_back(std::make_unique<T[]>(kPageSize));
    ++size_;
  }

 private:
  static constexpr std::size_t kPageSize = 4096;

  std::vector<std::unique_ptr<T[]>> pages_;
  std::size_t size_ = 0;
};

}  // namespace lode

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace lode::bisection {

using SampleCorners = std::array<std::uint32_t, 3>;

/// A bit for each sample, by its index.
class SampleMarks {
 public:
  explicit SampleMarks(std::int64_t n) : words_(static_cast<std::size_t>(n) / 64 + 1, 0) {}

  void add(std::int64_t i) {
    words_[static_cast<std::size_t>(i) / 64] |= std::uint64_t{1} << (i % 64);
  }
  [[nodiscard]] const std::vector<std::uint64_t>& words() const { return words_; }
  [[nodiscard]] std::uint64_t* data() { return words_.data(); }

 private:
  std::vector<std::uint64_t> words_;
};

/// Numbers marked samples by rising indices, and puts these numbers for the indices that triangles
/// have for corners, all of which are marked. Returns the indices by number.
[[nodiscard]] std::vector<std::uint32_t> number_samples(const SampleMarks& marks,
                                                        std::vector<SampleCorners>& triangles);

}  // namespace lode::bisection

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

/// Triangles between samples, and the samples that are corners of some.
struct SampleMesh {
  /// Indices of samples, or once these are numbered by rising indices, their numbers.
  std::vector<SampleCorners> triangles;
  std::vector<float> errors;  ///< Of the nodes that were not refined, or 0.
  SampleMarks marks;
  std::vector<std::uint32_t> n_before;  ///< Marks before each of their words, once counted,
  std::uint32_t n_samples = 0;          ///< and all.
};

/// Counts the marks.
void count_samples(SampleMesh& mesh);
/// The same, and puts numbers for the indices that triangles have for corners, all of which are
/// marked.
void number_samples(SampleMesh& mesh);

}  // namespace lode::bisection

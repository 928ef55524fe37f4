#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/expects.h"
#include "lode/models/diamond/selection.h"

namespace lode::diamond {

/// Isovalues, finite, ascending, each once. Values of ranks r <= s have the isovalues number
/// r .. s - 1 between them.
class IsovalueList {
 public:
  explicit IsovalueList(std::span<const double> ascending)
      : isovalues_(ascending.begin(), ascending.end()) {
    for (std::size_t i = 1; i < isovalues_.size(); ++i)
      LODE_EXPECTS(isovalues_[i - 1] < isovalues_[i]);
    if (isovalues_.empty()) return;
    const double width = isovalues_.back() - isovalues_.front();
    const std::size_t n_buckets = kBucketsEach * isovalues_.size();
    const double scale = static_cast<double>(n_buckets - 1) / width;
    if (width > 0 && std::isfinite(width) && std::isfinite(scale)) scale_ = scale;
    first_in_.resize(n_buckets);
    std::size_t i = 0;
    for (std::size_t bucket = 0; bucket < n_buckets; ++bucket) {
      while (i < isovalues_.size() && bucket_of(isovalues_[i]) < bucket) ++i;
      first_in_[bucket] = static_cast<std::uint32_t>(i);
    }
  }

  /// In any order.
  [[nodiscard]] static IsovalueList of(std::span<const double> isovalues) {
    std::vector<double> ascending(isovalues.begin(), isovalues.end());
    std::sort(ascending.begin(), ascending.end());
    return IsovalueList(ascending);
  }

  [[nodiscard]] std::size_t size() const { return isovalues_.size(); }
  [[nodiscard]] double operator[](std::size_t i) const { return isovalues_[i]; }
  /// At most n of them, from number `first` on.
  [[nodiscard]] IsovalueList part(std::size_t first, std::size_t n) const {
    return IsovalueList(std::span(isovalues_).subspan(first, std::min(n, size() - first)));
  }
  /// How many are at most `value`; none for NaN.
  [[nodiscard]] std::size_t rank(double value) const {
    if (isovalues_.empty() || !(value >= isovalues_.front())) return 0;
    if (value >= isovalues_.back()) return isovalues_.size();
    std::size_t rank = first_in_[bucket_of(value)];
    while (isovalues_[rank] <= value) ++rank;
    return rank;
  }

 private:
  /// Buckets of equal widths, so that most hold one isovalue or none. Rounding keeps the order of
  /// values, so what lies in lower buckets is lower.
  static constexpr std::size_t kBucketsEach = 4;
  [[nodiscard]] std::size_t bucket_of(double value) const {
    if (scale_ == 0) return 0;
    return static_cast<std::size_t>((value - isovalues_.front()) * scale_);
  }

  std::vector<double> isovalues_;
  double scale_ = 0;                     ///< Of too wide or too narrow ones: all are in one bucket.
  std::vector<std::uint32_t> first_in_;  ///< By bucket: how many isovalues lie in lower ones.
};

/// Selection by many isovalues at once. Whether an error is above the tolerance does not depend on
/// the isovalue, so all of them have their surfaces in the leaves of one cut: what this refines is
/// what Selection refines for any of them, and each one's active leaves are those that it crosses.
template <int D, typename Field = Model<D>>
class ManySelection : public ToleranceSelection<D, Field> {
 public:
  /// `wanted`, of all of them: may be null; must outlive it.
  ManySelection(const Field& model, const IsovalueList& isovalues, double tolerance,
                const NodeSet<D>* wanted = nullptr)
      : ToleranceSelection<D, Field>(model, tolerance), isovalues_(isovalues), wanted_(wanted) {
    const double reference = model.range_reference();
    below_.reserve(isovalues.size());
    above_.reserve(isovalues.size());
    for (std::size_t i = 0; i < isovalues.size(); ++i) {
      const RelativeIsovalue relative = RelativeIsovalue::of(isovalues[i], reference);
      below_.push_back(relative.below);
      above_.push_back(relative.above);
    }
  }

  /// For a node of level >= 1, or of level 0 and tier 0.
  [[nodiscard]] bool is_active(int level, std::size_t at) const {
    const NodeLevel& nodes = this->model().levels[as_size(level)];
    const auto first =
        std::upper_bound(above_.begin(), above_.end(), static_cast<double>(nodes.low[at]));
    return first != above_.end() && below_[static_cast<std::size_t>(first - above_.begin())] <=
                                        static_cast<double>(nodes.high[at]);
  }
  [[nodiscard]] bool has_wanted() const { return wanted_ != nullptr; }
  [[nodiscard]] bool is_wanted(const Index<D>& centre) const {
    return wanted_ != nullptr && wanted_->contains(centre);
  }
  /// Values of one rank have no surface between them.
  [[nodiscard]] std::size_t side(double value) const { return isovalues_.rank(value); }
  [[nodiscard]] bool is_clear(double low, double high) const {
    return low <= high && isovalues_.rank(low) == isovalues_.rank(high);  // neither is NaN
  }

 private:
  const IsovalueList& isovalues_;
  const NodeSet<D>* wanted_;
  std::vector<double> below_;  ///< As RelativeIsovalue.
  std::vector<double> above_;
};

/// By isovalue, how many cells and vertices its surface has; kept as differences from one isovalue
/// to the next, so that what many isovalues cross is added in two places.
class CrossingSums {
 public:
  explicit CrossingSums(std::size_t n_isovalues) : sums_(n_isovalues + 1) {}

  void add_cells(std::size_t from, std::int64_t n) { sums_[from].cells += n; }
  void add_vertices(std::size_t from, std::int64_t n) { sums_[from].vertices += n; }
  /// One vertex for each isovalue between the ends of an edge.
  void add_edge(std::size_t low, std::size_t high) {
    ++sums_[low].vertices;
    --sums_[high].vertices;
  }
  /// One triangle, two and one between the four values of a tetrahedron, ascending.
  void add_simplex(const std::array<std::size_t, 4>& rank) {
    ++sums_[rank[0]].cells;
    ++sums_[rank[1]].cells;
    --sums_[rank[2]].cells;
    --sums_[rank[3]].cells;
  }
  /// One line between the lowest and the highest value of a triangle.
  void add_simplex(const std::array<std::size_t, 3>& rank) {
    ++sums_[rank[0]].cells;
    --sums_[rank[2]].cells;
  }
  /// Adds those of others, of isovalues from number `first` on.
  void add(const CrossingSums& other, std::size_t first = 0) {
    for (std::size_t i = 0; i < other.sums_.size(); ++i) {
      sums_[first + i].cells += other.sums_[i].cells;
      sums_[first + i].vertices += other.sums_[i].vertices;
    }
  }

  struct Counts {
    std::int64_t cells = 0;
    std::int64_t vertices = 0;
  };
  /// Of each isovalue.
  [[nodiscard]] std::vector<Counts> totals() const {
    std::vector<Counts> totals(sums_.size() - 1);
    Counts sum;
    for (std::size_t i = 0; i < totals.size(); ++i) {
      sum.cells += sums_[i].cells;
      sum.vertices += sums_[i].vertices;
      totals[i] = sum;
    }
    return totals;
  }

 private:
  std::vector<Counts> sums_;
};

}  // namespace lode::diamond

#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace lode::io {

/// Samples lower .. upper - 1 along an axis.
struct IndexRange {
  std::int32_t lower = 0;
  std::int32_t upper = 0;

  [[nodiscard]] std::int32_t size() const { return upper > lower ? upper - lower : 0; }
  friend bool operator==(const IndexRange&, const IndexRange&) = default;
};

/// What parts read of one axis where a source decodes whole units.
struct AxisReads {
  std::vector<IndexRange> parts;  ///< With their border layers, ascending; they may overlap.
  std::int32_t unit = 1;          ///< Samples of a unit, which begin at multiples of it.
  double stored_share = 1;        ///< Bytes that a source reads for a byte of a unit's samples.
};

/// Along one axis: which samples of units that several parts read are kept in a spool when they are
/// first decoded. For each such unit what moves the fewest bytes is chosen: all parts decode it
/// again; or one part does, its owner, and the others read the samples they want of it from the
/// spool, written once and read by each; or none does.
class BorderPlan {
 public:
  /// A part of a range, ascending: from the source, or all inside one of kept().
  struct Run {
    static constexpr int kFromSource = -1;
    IndexRange range;
    int kept = kFromSource;
  };

  BorderPlan() = default;
  explicit BorderPlan(const AxisReads& reads);

  /// Ascending, apart from each other.
  [[nodiscard]] std::span<const IndexRange> kept() const { return kept_; }
  [[nodiscard]] bool keeps(std::int32_t i) const;
  /// Where part number `part` finds what it reads.
  [[nodiscard]] std::vector<Run> runs_of(IndexRange range, int part) const;

 private:
  void plan_unit(const AxisReads& reads, IndexRange unit);

  std::vector<IndexRange> kept_;
  std::vector<int> owners_;  ///< Of each kept range's unit: the part that decodes it, or kNone.
};

}  // namespace lode::io

#pragma once

#include <vector>

#include "lode/models/diamond/file_parts.h"
#include "lode/models/diamond/known_nodes.h"

namespace lode::diamond {

/// The samples of a damaged file, the lost ones filled from coarser ones.
template <int D>
class SalvagedSamples {
 public:
  /// What became of the lost samples of a block.
  struct Filled {
    std::uint64_t n_lost = 0;
    std::uint64_t n_holes = 0;  ///< Of them, filled with holes.
    double max_error = 0;       ///< Largest bound of what filling changed, where both have values.
  };

  /// Blocks that are damaged, or that contradict the metadata or each other, are appended to
  /// `lost`. Fails where whole blocks have more holes than the metadata know of, and on cancel.
  [[nodiscard]] static Result<SalvagedSamples> load(const store::Reader& reader,
                                                    const Metadata& metadata, Threads threads,
                                                    Progress& progress,
                                                    std::vector<LostRegion<D>>& lost);

  /// Of the data, x fastest, in their storage type; those that are lost are indeterminate before
  /// fill().
  [[nodiscard]] const std::byte* all() const { return field_.samples.data(); }
  [[nodiscard]] std::uint64_t n_lost() const { return n_lost_; }
  /// How many of those that are lost were holes.
  [[nodiscard]] std::uint64_t n_lost_holes() const { return n_lost_holes_; }

  /// Fills the lost samples, coarse levels first, and says for each of load()'s lost blocks what
  /// came of it. Fails on cancel.
  [[nodiscard]] Result<std::vector<Filled>> fill(const KnownNodes<D>& nodes,
                                                 std::span<const LostRegion<D>> lost,
                                                 Threads threads, Progress& progress);

 private:
  using Facts = typename KnownNodes<D>::Facts;
  /// A sample as far as filling may look at it.
  struct Known {
    Index<D> place;
    double value = 0;
    double error = 0;        ///< How far the original may be from it.
    bool has_value = false;  ///< Else it is a hole, or not filled yet.
    bool is_hole = false;
    bool is_original = false;
  };
  /// A fill, and how far the original may be from it.
  struct Fill {
    double value = 0;
    double error = 0;
    bool is_hole = false;
  };

  [[nodiscard]] Result<void> check_samples(const store::Reader& reader, const Region<D>& r,
                                           std::span<const std::byte> bytes) const;
  void mark_lost(const Region<D>& r);
  void use_beyond(const store::Reader& reader, const Region<D>& r,
                  std::span<const std::byte> beyond, std::vector<LostRegion<D>>& lost);
  [[nodiscard]] Result<void> count(const store::Reader& reader);

  void fill_tier(const KnownNodes<D>& nodes, const Region<D>& r, int tier, Filled& filled);
  [[nodiscard]] Fill fill_of(const KnownNodes<D>& nodes, const Index<D>& p) const;
  [[nodiscard]] Fill between(const Index<D>& p, const Known& a, const Known& b,
                             const Facts& facts) const;
  [[nodiscard]] Fill in_range(double value, const Facts& facts) const;
  [[nodiscard]] Fill hole() const;
  [[nodiscard]] Known known(const Index<D>& end, const Diamond<D>& node) const;
  [[nodiscard]] double to_sample(double value, const Facts& facts) const;
  void put(std::size_t at, const Fill& fill);

  FlatField<D> field_;
  /// How far the originals may be from the samples: 0 where a sample is the original, more than 0
  /// where it was filled, kNotFilled before. Empty: nothing is lost.
  std::vector<float> errors_;
  std::uint64_t n_lost_ = 0;
  std::uint64_t n_lost_holes_ = 0;
};

extern template class SalvagedSamples<2>;
extern template class SalvagedSamples<3>;

}  // namespace lode::diamond

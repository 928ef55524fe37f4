#pragma once

#include <vector>

#include "lode/core/parallel.h"
#include "lode/models/diamond/lattice_field.h"

namespace lode::diamond {

/// Finds a field's range, holes and removed cells while its samples come by, slice after slice.
template <int D>
class FieldScan {
 public:
  /// Of a volume's samples in their storage type.
  explicit FieldScan(const VolumeInfo& info);

  /// Whole slices, x fastest, those that follow the ones before: lattice coordinate D-1 from
  /// `begin` on to before `end`.
  void put(std::int32_t begin, std::int32_t end, const std::byte* values, Threads threads);

  /// After the last slice.
  [[nodiscard]] FieldStats stats() const;

 private:
  /// Only types and nodata: nothing of its samples is here.
  struct Nothing : LatticeField<D, Nothing> {};

  [[nodiscard]] std::uint64_t count_removed(const std::uint8_t* slice,
                                            const std::uint8_t* next) const;

  Nothing field_;
  Index<D> slice_dims_;         ///< The last one is 1.
  std::size_t slice_size_ = 0;  ///< Samples.
  bool can_have_holes_ = false;
  double min_ = 0;
  double max_ = 0;
  bool is_empty_ = true;
  std::uint64_t n_holes_ = 0;
  std::uint64_t n_removed_ = 0;
  bool has_last_ = false;
  std::uint64_t n_holes_in_last_ = 0;
  std::vector<std::uint8_t>
      holes_;  ///< Of the last slice before, then of those that came; 1: hole.
};

extern template class FieldScan<2>;
extern template class FieldScan<3>;

}  // namespace lode::diamond

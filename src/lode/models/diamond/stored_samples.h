#pragma once

#include "lode/models/diamond/coarse_field.h"
#include "lode/store/block_cache.h"

namespace lode::diamond {

/// Single samples of a file's field, each from its block: for the few questions that coarse
/// simplices ask of fine samples.
template <int D>
class StoredSamples {
 public:
  StoredSamples(const CoarseField<D>& field, store::BlockCache& blocks)
      : field_(field), blocks_(blocks) {}

  /// That at a point of the data, holes as they are.
  [[nodiscard]] Result<double> at(const Index<D>& p) const;
  /// Whether holes remove an unrefined simplex, as LatticeField::is_removed() says.
  [[nodiscard]] Result<bool> is_removed(const Simplex<D>& s) const;

 private:
  const CoarseField<D>& field_;
  store::BlockCache& blocks_;
};

extern template class StoredSamples<2>;
extern template class StoredSamples<3>;

}  // namespace lode::diamond

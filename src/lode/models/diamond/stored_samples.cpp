#include "lode/models/diamond/stored_samples.h"

#include <bit>

#include "lode/models/diamond/read_region.h"

namespace lode::diamond {

template <int D>
Result<double> StoredSamples<D>::at(const Index<D>& p) const {
  std::uint32_t bits = 0;
  for (const std::int32_t x : p.v) bits |= static_cast<std::uint32_t>(x);
  const int level = bits == 0 ? field_.shape.n_levels : std::countr_zero(bits);
  if (field_.is_needed() && level >= kKeptLevel) return field_.value(p);
  const int coarsest = field_.shape.n_levels - 1;
  const int stored = std::min(level, coarsest);
  const Index<D> dims = sample_dims<D>(field_.shape, stored);
  const Index<D> n = block_counts<D>(dims);
  Index<D> q = p;
  Index<D> position;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    q[i] >>= stored;
    position[i] = std::min(q[i] / kBlockEdge<D>, n[i] - 1);
  }
  const Region<D> r = region_at<D>(dims, stored, position, stored == coarsest);
  const std::size_t size = field_.sample_size();
  LODE_TRY(const std::size_t block, find_region<D>(blocks_.reader(), r, Kind::samples, size));
  LODE_TRY(const auto bytes, blocks_.block(block));
  return visit_storage_type(field_.storage, [&]<typename T>() {
    T sample;
    std::memcpy(&sample, bytes->data() + place_in<D>(r, q) * sizeof(T), sizeof(T));
    return static_cast<double>(sample);
  });
}

template <int D>
Result<bool> StoredSamples<D>::is_removed(const Simplex<D>& s) const {
  const auto cell = field_.cell_inside(s);
  if (!cell) return false;
  for (int corner = 0; corner < (1 << D); ++corner) {
    Index<D> p = *cell;
    for (int i = 0; i < D; ++i) p[as_size(i)] += (corner >> i) & 1;
    LODE_TRY(const double sample, at(p));
    if (field_.is_hole(sample)) return true;
  }
  return false;
}

template class StoredSamples<2>;
template class StoredSamples<3>;

}  // namespace lode::diamond

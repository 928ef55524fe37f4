#include "lode/models/tetra_mt/live_tetrahedra.h"

#include <utility>

namespace lode::tetra_mt {
namespace {

std::vector<std::uint32_t> count_corners(std::uint32_t n_own,
                                         std::span<const Tetrahedron> tetrahedra) {
  std::vector<std::uint32_t> counts(n_own, 0);
  for (const Tetrahedron& t : tetrahedra)
    for (const std::uint32_t v : t)
      if (v < n_own) ++counts[v];
  return counts;
}

}  // namespace

LiveTetrahedra::LiveTetrahedra(std::uint32_t n_own, std::uint32_t outside,
                               std::vector<Tetrahedron> tetrahedra)
    : n_own_(n_own),
      outside_(outside),
      tetrahedra_(std::move(tetrahedra)),
      stars_(count_corners(n_own, tetrahedra_)) {
  for (std::uint32_t i = 0; i < tetrahedra_.size(); ++i)
    for (const std::uint32_t v : tetrahedra_[i])
      if (v < n_own_) stars_.add(v, i);
}

std::uint32_t LiveTetrahedra::collapse(std::uint32_t removed, std::uint32_t kept) {
  std::uint32_t n_gone = 0;
  for (const std::uint32_t slot : stars_.of(removed)) {
    Tetrahedron& t = tetrahedra_[slot];
    bool has_kept = false;
    bool is_outer = false;
    for (const std::uint32_t v : t) {
      has_kept = has_kept || v == kept;
      is_outer = is_outer || v == outside_;
    }
    if (!has_kept) {
      for (std::uint32_t& v : t)
        if (v == removed) v = kept;
      continue;
    }
    for (const std::uint32_t v : t)
      if (v != removed && v != outside_) stars_.remove(v, slot);
    t[0] = kNone;
    if (!is_outer) ++n_gone;
  }
  // Adding may move lists.
  const std::size_t n = stars_.of(removed).size();
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t slot = stars_.of(removed)[i];
    if (!is_gone(slot)) stars_.add(kept, slot);
  }
  stars_.end(removed);
  return n_gone;
}

}  // namespace lode::tetra_mt

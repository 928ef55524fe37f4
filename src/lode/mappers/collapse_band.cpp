// Whether a collapse stays in the band.
#include "lode/mappers/collapse_block.h"

namespace lode::simplification {

Vec3d BlockSimplifier::find_in_band(std::uint32_t v) const {
  return limits_.band->own_coordinates(widened(stored_position(v)));
}

/// Of the triangles that it makes some points are in the band, and no sample outside it is in what
/// the star sweeps: by the vertex that is kept going to the new place first, then by the other one.
bool BlockSimplifier::keeps_to_band(std::uint32_t kept, std::uint32_t removed,
                                    const Star& star_of_removed, const Vec3f& position) const {
  const SurfaceBand& band = *limits_.band;
  const bool stays = position == this->position(kept);
  const Vec3d to = stays ? in_band_[kept] : band.own_coordinates(widened(centre_ + position));
  // So near the border it would be taken to be on it, where only vertices of the data are.
  const bool is_new = !stays && !(position == this->position(removed));
  if (is_new && band.border_planes(to) != 0) return false;
  const auto sweeps_nothing = [&](const Star& star, const Vec3d& from, std::uint32_t but) {
    for (const Spoke& spoke : star.all())
      if (spoke.a != but && spoke.b != but &&
          band.may_hold_fixed({from, to, in_band_[spoke.a], in_band_[spoke.b]}))
        return false;
    return true;
  };
  if (!stays && !sweeps_nothing(other_star_, in_band_[kept], kNone)) return false;
  if (!sweeps_nothing(star_of_removed, in_band_[removed], kept)) return false;
  std::array<std::array<Vec3d, 2>, kMaxStar> fan;
  for (std::uint32_t i = 0; i < n_new_; ++i)
    fan[i] = {in_band_[new_triangles_[i].a], in_band_[new_triangles_[i].b]};
  return band.seems_within(to, {fan.data(), n_new_});
}

}  // namespace lode::simplification

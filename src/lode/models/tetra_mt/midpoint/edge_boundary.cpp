// How far the boundary, and what lies between regions, moves where it bends.
#include <algorithm>
#include <bit>
#include <limits>

#include "lode/models/tetra_mt/midpoint/edge_collapser.h"
#include "lode/models/tetra_mt/patch_deviation.h"

namespace lode::tetra_mt::midpoint {
namespace {

constexpr double kTooFar = std::numeric_limits<double>::infinity();

}  // namespace

/// The vertices round a disc of faces, from the other end of the edge on; none where faces are no
/// disc, or the edge is not in it.
void EdgeCollapser::find_ring(const Star& star, const Interfaces& interfaces, int kept,
                              std::vector<std::uint32_t>& ring) const {
  ring.clear();
  if (interfaces.kind != Interfaces::Kind::sheet || !goes_along(interfaces, kept)) return;
  std::uint64_t beside = interfaces.beside[static_cast<std::size_t>(kept)];
  if (star.is_on_boundary()) beside &= ~(std::uint64_t{1} << star.outside);
  if (beside == 0) return;
  const InterfaceWalk disc = walk(interfaces, kept, std::countr_zero(beside));
  for (std::size_t i = 0; i < static_cast<std::size_t>(disc.n); ++i) {
    if (disc.places[i] == star.outside) return ring.clear();
    ring.push_back(star.link[disc.places[i]]);
  }
}

/// Of one end that goes to the other, in the mesh's unit.
double EdgeCollapser::deviation_of_end(const Star& star, const Interfaces& interfaces, int kept,
                                       double limit) {
  find_ring(star, interfaces, kept, ring_);
  if (ring_.size() < 3) return kTooFar;
  Patch patch{.ring = {}, .n = static_cast<int>(ring_.size()), .is_closed = true};
  for (std::size_t i = 0; i < ring_.size(); ++i)
    patch.ring[i] = (positions_[ring_[i]] - positions_[star.vertex]) * scale_;
  return sheet_deviation(patch, limit * scale_) / scale_;
}

/// Of both ends that go to their middle: the discs round them make one, the other way round the
/// second.
double EdgeCollapser::deviation_of_middle(int place, double limit) {
  find_ring(star_, interfaces_, place, ring_);
  find_ring(other_, other_interfaces_, place_in_other_, other_ring_);
  if (ring_.size() < 3 || other_ring_.size() < 3) return kTooFar;
  if (other_ring_[1] != ring_.back()) std::reverse(other_ring_.begin() + 1, other_ring_.end());
  if (other_ring_[1] != ring_.back() || other_ring_.back() != ring_[1]) return kTooFar;
  const auto at = [&](std::uint32_t vertex) {
    return (positions_[vertex] - positions_[star_.vertex]) * scale_;
  };
  const PositionCode middle = merged(state_.codes[global(star_.vertex)],
                                     state_.codes[global(other_.vertex)], Place::middle);
  patch_.first = at(star_.vertex);
  patch_.second = at(other_.vertex);
  patch_.middle = (state_.scales.position(middle) - positions_[star_.vertex]) * scale_;
  patch_.first_ring.clear();
  patch_.second_ring.clear();
  for (std::size_t i = 1; i < ring_.size(); ++i) patch_.first_ring.push_back(at(ring_[i]));
  for (std::size_t i = 1; i < other_ring_.size(); ++i)
    patch_.second_ring.push_back(at(other_ring_[i]));
  return edge_patch_deviation(patch_, limit * scale_) / scale_;
}

/// The middle, unless that is too far; then the end that moves less.
EdgeCollapser::Rule EdgeCollapser::bent_rule_of(int place, double limit) {
  const double middle = deviation_of_middle(place, limit);
  if (middle <= limit) return {Place::middle, middle};
  const double to_first = deviation_of_end(other_, other_interfaces_, place_in_other_, limit);
  const double to_second = deviation_of_end(star_, interfaces_, place, limit);
  return to_first <= to_second ? Rule{Place::first, to_first} : Rule{Place::second, to_second};
}

/// Of faces that come, by the tetrahedra beside them that stay.
void EdgeCollapser::note_deviations(int place) {
  const auto note = [&](const Star& star, const Interfaces& interfaces, int kept) {
    for (int i = 0; i < interfaces.n_faces; ++i)
      for (const std::uint8_t t : interfaces.faces[static_cast<std::size_t>(i)].triangles)
        if (!star.has(t, kept)) {
          double& there = state_.deviations[slots_[star.slots[t]]];
          there = std::max(there, rule_.moved);
        }
  };
  note(star_, interfaces_, place);
  note(other_, other_interfaces_, place_in_other_);
}

}  // namespace lode::tetra_mt::midpoint

#include "lode/mappers/collapse_proof.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>

#include "lode/core/expects.h"
#include "lode/mappers/collapse_crossings.h"

namespace lode::simplification {
namespace {

std::uint32_t later(std::uint32_t a, std::uint32_t b) {
  if (a == kNone) return b;
  return b == kNone ? a : std::max(a, b);
}

}  // namespace

/// Original triangles whose proofs may have been about what is no more: of which a corner is
/// attached to a changed triangle, or to a neighbour of one, where they looked round it. Those that
/// failed, wherever they are attached, and to begin with those of which a corner has collapsed
/// since all was proven, so that they may not have been looked at.
std::vector<std::uint32_t> CollapseProof::to_recheck(std::span<const std::uint32_t> live,
                                                     std::span<const std::uint32_t> changed) {
  std::vector<Nearness> nearness(mesh_.triangles.size(), Nearness::none);
  std::vector<std::uint32_t> near(changed.begin(), changed.end());
  for (const std::uint32_t t : changed) nearness[t] = Nearness::changed;
  for (const std::uint32_t t : changed)
    for (const std::uint32_t v : mesh_.triangles[t].v)
      stars_.for_each_around(v, [&](std::uint32_t s) {
        if (nearness[s] != Nearness::none) return;
        nearness[s] = Nearness::beside;
        near.push_back(s);
      });
  const bool are_few = has_begun_ && near.size() * 4 < live.size();
  const std::vector<std::uint32_t> found =
      are_few ? original_of_few(near, nearness) : original_of_many(nearness);
  has_begun_ = true;
  std::erase_if(far_, [this](std::uint32_t t) { return !is_changed(t); });  // back on the surface
  std::vector<std::uint32_t> all;
  all.reserve(found.size() + far_.size());
  std::ranges::set_union(found, far_, std::back_inserter(all));
  return all;
}

/// Whether an original triangle is no more, or has a corner that collapses moved.
bool CollapseProof::is_changed(std::uint32_t triangle) const {
  return mesh_.triangles[triangle].is_dead() || stars_.maker(triangle) != kNone;
}

std::vector<std::uint32_t> CollapseProof::original_of_few(std::span<const std::uint32_t> near,
                                                          std::span<const Nearness> nearness) {
  const Surroundings around = distance_.surroundings(options_.threads);
  std::vector<std::uint8_t> is_asked(original_.triangles.size(), 0);
  parallel_for(near.size(), options_.threads, 64, [&](std::size_t i, int) {
    for (std::uint32_t p = mesh_.triangles[near[i]].points; p != kNone; p = mesh_.next_point[p])
      for (const std::uint32_t t : around.of(p))
        if (concerns(t, nearness[near[i]]) && is_changed(t))
          std::atomic_ref(is_asked[t]).store(1, std::memory_order_relaxed);
  });
  return numbers_where(is_asked.size(), options_.threads,
                       [&](std::uint32_t t) { return is_asked[t] != 0; });
}

std::vector<std::uint32_t> CollapseProof::original_of_many(
    std::span<const Nearness> nearness) const {
  return numbers_where(original_.triangles.size(), options_.threads, [&](std::uint32_t t) {
    return is_changed(t) && std::ranges::any_of(original_.triangles[t], [&](std::uint32_t v) {
             const bool is_new = mesh_.last[v] != kNone && mesh_.last[v] >= first_;
             return concerns(t, nearness[mesh_.attached_to[v]]) || (is_new && !has_begun_);
           });
  });
}

/// Whether an original triangle's proof has to do with one that its corner is attached to.
bool CollapseProof::concerns(std::uint32_t triangle, Nearness nearness) const {
  if (nearness == Nearness::beside) return !has_begun_ || distance_.looked_around(triangle);
  return nearness == Nearness::changed;
}

/// Adds collapses whose triangles are not proven near, to `bad`.
void CollapseProof::find_far(std::span<const std::uint32_t> made,
                             std::span<const std::uint32_t> to_prove_near,
                             std::vector<std::uint32_t>& bad) {
  const DistanceReport to = distance_.to_original(made, options_.threads);
  for (const std::uint32_t t : to.failing) bad.push_back(stars_.maker(t));
  const DistanceReport from = distance_.from_original(to_prove_near, options_.threads);
  for (const std::uint32_t t : from.failing) {
    // Of what its corners are attached to, or else what took it away, at one of its corners.
    std::uint32_t maker = kNone;
    for (const std::uint32_t v : original_.triangles[t])
      maker = later(maker, stars_.maker(mesh_.attached_to[v]));
    if (maker == kNone)
      for (const std::uint32_t v : original_.triangles[t]) maker = later(maker, mesh_.last[v]);
    LODE_EXPECTS(maker != kNone);  // it is changed
    bad.push_back(maker);
  }
  far_ = from.failing;
  proven_distance_ = std::max({proven_distance_, to.proven, from.proven});
}

/// The same of those that leave the band.
void CollapseProof::find_beyond(std::span<const std::uint32_t> made,
                                std::vector<std::uint32_t>& bad) {
  const SurfaceBand& band = *options_.band;
  std::vector<double> deviations(made.size());
  parallel_for(made.size(), options_.threads, 256, [&](std::size_t i, int) {
    if (progress_.is_cancelled()) return;
    std::array<Vec3d, 3> triangle;
    for (std::size_t k = 0; k < 3; ++k)
      triangle[k] = band.own_coordinates(widened(mesh_.positions[mesh_.triangles[made[i]].v[k]]));
    deviations[i] = band.largest_deviation(triangle);
  });
  for (std::size_t i = 0; i < made.size(); ++i)
    if (deviations[i] <= band.limit())
      proven_error_ = std::max(proven_error_, deviations[i]);
    else
      bad.push_back(stars_.maker(made[i]));
}

Result<std::vector<std::uint32_t>> CollapseProof::find_bad(std::span<const std::uint32_t> live,
                                                           std::span<const std::uint32_t> changed) {
  std::vector<std::uint32_t> bad;
  LODE_TRY(const auto crossings, find_crossings(mesh_, live, changed, options_.threads, progress_));
  for (const auto& [s, t] : crossings) {
    const std::uint32_t maker = later(stars_.maker(s), stars_.maker(t));
    if (maker != kNone)
      bad.push_back(maker);
    else
      meets_itself_already_ = true;
  }
  std::vector<std::uint32_t> made;  // original ones need no proof
  for (const std::uint32_t t : changed)
    if (stars_.maker(t) != kNone) made.push_back(t);
  if (std::isfinite(options_.max_distance)) find_far(made, to_recheck(live, changed), bad);
  if (options_.band != nullptr) find_beyond(made, bad);
  if (progress_.is_cancelled()) return cancelled_error();
  sort_unique(bad);
  std::reverse(bad.begin(), bad.end());
  return bad;
}

}  // namespace lode::simplification

// What a collapse does, once it is chosen.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "lode/models/tetra_mt/block_collapser.h"
#include "lode/models/tetra_mt/fan_distance.h"

namespace lode::tetra_mt {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Weights of samples that are outside, and not by rounding of doubles alone.
constexpr double kLeftOutside = -1e-4;

}  // namespace

/// False, and nothing done, where rounding leaves open what covers a sample.
bool BlockCollapser::collapse(const Choice& choice) {
  const int place = choice.kept;  // to which the fan goes
  if (is_by_quadrics()) gather_samples();
  if (!cover_samples(place)) return false;
  for (int i = 0; i < star_.n_triangles; ++i) {
    const std::uint32_t slot = star_.slots[static_cast<std::size_t>(i)];
    samples_[slot] = kNone;
    corner_sets_[slot] = {};
    has_changed_[slot] = 1;
  }
  const std::size_t n = state_.n_fields;
  for (std::size_t s = 0; s < covered_.samples.size(); ++s) {
    const std::uint32_t sample = covered_.samples[s];
    const Cover& cover = covers_[s];
    const std::uint32_t slot = star_.slots[cover.lane];
    state_.sample_corners[sample] = corners_round(
        weights_of_corners(live_.corners(slot), star_, cover.lane, cover.weights), cover.least);
    corner_sets_[slot].add(state_.sample_corners[sample]);
    std::uint32_t& first = samples_[slot];
    state_.next_sample[sample] = first;
    first = sample;
    for (std::size_t f = 0; f < n; ++f)
      state_.errors_of(sample)[f] = static_cast<float>(new_errors_[s * n + f] * state_.scales[f]);
    if (covered_.space_unit > 0)
      for (std::size_t f = 0; f < n; ++f)
        state_.distances_of(sample)[f] = fan_.distance(covered_, s, f, cover.lane);
  }
  note_facts(place);
  note_star();
  note_deviations(place, choice.moved);
  move_boundary(place);
  const std::uint32_t kept = star_.link[static_cast<std::size_t>(place)];
  if (is_by_quadrics())
    for (std::size_t f = 0; f < n; ++f)
      state_.quadrics_of(global(kept))[f].add(state_.quadrics_of(global(star_.vertex))[f]);
  n_gone_ += live_.collapse(star_.vertex, kept);
  state_.is_there[global(star_.vertex)] = 0;
  collapses_.push_back({global(star_.vertex), global(kept)});
  return true;
}

/// Finds which tetrahedra of the fan cover the samples, and with which errors.
bool BlockCollapser::cover_samples(int place) {
  covers_.clear();
  new_errors_.clear();
  for (std::size_t s = 0; s < covered_.samples.size(); ++s) {
    auto cover = find_cover(place, covered_, s);
    if (!cover) return false;
    if (rules_.boundary_tolerance > 0 && cover->least < 0) clamp_weights(cover->weights);
    covers_.push_back(*cover);
    for (std::size_t f = 0; f < state_.n_fields; ++f) {
      const double error = error_of(*cover, place, covered_.samples[s], f);
      if (!std::isfinite(error)) return false;
      new_errors_.push_back(error);
    }
  }
  return true;
}

/// By one lane. Weights are of the triangle's corners; products of lengths bound what they lose,
/// and sums of coordinates bound those.
BlockCollapser::Cover BlockCollapser::cover_by(std::size_t lane, int kept,
                                               std::uint32_t sample) const {
  const Vec3d at = link_[static_cast<std::size_t>(kept)];
  const auto& t = star_.triangles[lane];
  const Vec3d a = link_[t[0]] - at;
  const Vec3d b = link_[t[1]] - at;
  const Vec3d c = link_[t[2]] - at;
  const Vec3d d = (state_.mesh.positions[sample] - positions_[star_.vertex]) * scale_ - at;
  const Vec3d bc = cross(b, c);
  const double inverse = 1 / dot(bc, a);
  Cover cover{.lane = lane,
              .weights = {dot(bc, d) * inverse, dot(cross(c, a), d) * inverse,
                          dot(cross(a, b), d) * inverse}};
  const auto& w = cover.weights;
  cover.least = std::min({w[0], w[1], w[2], 1 - (w[0] + w[1] + w[2])});
  const auto size = [](const Vec3d& v) { return std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]); };
  const double sizes = size(b) * size(c) + size(a) * (size(b) + size(c));
  cover.rounding = 0x1p-48 * (1 + sizes * size(d) * inverse);
  return cover;
}

/// The lane that floats found, unless doubles say that the sample lies outside: then the best one.
/// None where even doubles do not tell.
std::optional<BlockCollapser::Cover> BlockCollapser::find_cover(int kept,
                                                                const StarSamples& samples,
                                                                std::size_t sample) const {
  constexpr double kInside = -1e-9;
  std::optional<Cover> best;
  double least = -kInfinity;
  const auto look_at = [&](std::size_t lane) {
    if (fan_.gaps[lane] != 0) return;
    const Cover here = cover_by(lane, kept, samples.samples[sample]);
    if (!(here.least > least)) return;
    least = here.least;
    best = here;
  };
  const std::size_t found = find_lane(fan_, lanes_.n, samples, sample);
  const auto n = static_cast<std::size_t>(star_.n_triangles);
  if (found < n) look_at(found);
  for (std::size_t lane = 0; lane < n && !(least >= kInside); ++lane) look_at(lane);
  return best;
}

/// The largest |F - F'| at any point of the lane's tetrahedron.
double BlockCollapser::hull_error_of(const Cover& cover, int kept, std::uint32_t sample,
                                     std::size_t field) const {
  const double own = state_.value(sample, field);
  const auto error_at = [&](std::size_t place) {
    return std::abs(own - values_[star_.link[place] * state_.n_fields + field]);
  };
  double largest = error_at(static_cast<std::size_t>(kept));
  for (const std::uint8_t corner : star_.triangles[cover.lane])
    largest = std::max(largest, error_at(corner));
  return largest;
}

/// F - F' in the field's unit, larger than it is by what doubles may round. Of a sample that
/// rounding, or what the boundary moved, has left outside of all: no less than at any of the
/// corners, as in a sliver beside it F' may be any of their values.
double BlockCollapser::error_of(const Cover& cover, int kept, std::uint32_t sample,
                                std::size_t field) const {
  const auto value = [&](std::size_t place) {
    return values_[star_.link[place] * state_.n_fields + field];
  };
  const double at_kept = value(static_cast<std::size_t>(kept));
  double made = 0;
  double size = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double rise = value(star_.triangles[cover.lane][k]) - at_kept;
    made += cover.weights[k] * rise;
    size = std::max(size, std::abs(rise));
  }
  double error = state_.value(sample, field) - at_kept - made;
  if (rules_.boundary_tolerance == 0 && cover.least < kLeftOutside)
    error =
        std::copysign(std::max(std::abs(error), hull_error_of(cover, kept, sample, field)), error);
  return error == 0 ? 0 : error + std::copysign(size * cover.rounding, error);
}

/// Of the samples, in the mesh's unit.
double BlockCollapser::world_error_of(int kept, std::size_t field) const {
  const std::size_t n = state_.n_fields;
  const auto value = [&](std::uint32_t vertex) { return values_[vertex * n + field]; };
  std::array<double, Star::kMaxLink> values{};
  for (int i = 0; i < star_.n_link; ++i)
    if (i != star_.outside) {
      const auto at = static_cast<std::size_t>(i);
      values[at] = value(star_.link[at]);
    }
  const auto place = static_cast<std::size_t>(kept);
  const ValuedFan fan{star_, fan_, link_, link_[place], values, values[place]};
  const auto sample_at = [&](std::size_t s) {
    const std::uint32_t sample = covered_.samples[s];
    const Vec3d p = (state_.mesh.positions[sample] - positions_[star_.vertex]) * scale_;
    return FanSample{covers_[s].lane, state_.same_values(sample, field), p};
  };
  return largest_distance(fan, covered_.samples.size(), sample_at) / scale_;
}

void BlockCollapser::note_facts(int kept) {
  const std::size_t n = state_.n_fields;
  for (std::size_t f = 0; f < n; ++f) {
    CollapseFacts facts{0, kInfinity, -kInfinity};
    const auto widen = [&](double value) {
      facts.low = std::min(facts.low, value);
      facts.high = std::max(facts.high, value);
    };
    for (std::size_t s = 0; s < covered_.samples.size(); ++s) {
      facts.error = std::max(facts.error, std::abs(new_errors_[s * n + f]));
      widen(state_.value(covered_.samples[s], f));
    }
    for (int i = 0; i < star_.n_link; ++i)
      if (i != star_.outside) widen(values_[star_.link[static_cast<std::size_t>(i)] * n + f]);
    if (rules_.has_world_errors) facts.world_error = world_error_of(kept, f);
    facts_.push_back(facts);
  }
  note_held_samples(kept);
}

/// Of a sample that no tetrahedron of the star covers, the best lane of those that hold it.
std::optional<BlockCollapser::Cover> BlockCollapser::find_holder(int kept, std::uint32_t sample) {
  const Vec3d p = (state_.mesh.positions[sample] - positions_[star_.vertex]) * scale_;
  one_beside_.samples.assign(1, sample);
  one_beside_.x.assign(1, static_cast<float>(p[0]));
  one_beside_.y.assign(1, static_cast<float>(p[1]));
  one_beside_.z.assign(1, static_cast<float>(p[2]));
  auto cover = find_cover(kept, one_beside_, 0);
  return cover && cover->least >= -kHeld - cover->rounding ? cover : std::nullopt;
}

/// What is covered by others but lies in faces, edges or vertices of the fan counts, too.
void BlockCollapser::note_held_samples(int kept) {
  const auto link = std::span(star_.link).first(static_cast<std::size_t>(star_.n_link));
  const auto sets_of = [&](std::uint32_t slot) { return corner_sets_[slot]; };
  beside_.visit(std::span(&star_.vertex, 1), link, sets_of,
                [&](std::uint32_t slot, unsigned others) {
                  for (std::uint32_t s = samples_[slot]; s != kNone; s = state_.next_sample[s])
                    if ((state_.sample_corners[s] & others) == 0) note_held(kept, s);
                });
}

void BlockCollapser::note_held(int kept, std::uint32_t sample) {
  const auto holder = find_holder(kept, sample);
  if (!holder) return;
  const std::span<CollapseFacts> facts = std::span(facts_).last(state_.n_fields);
  for (std::size_t f = 0; f < state_.n_fields; ++f)
    widen_by(state_.value(sample, f), error_of(*holder, kept, sample, f), facts[f]);
}

/// And whose its tetrahedra are from now on.
void BlockCollapser::note_star() {
  const std::size_t first = stars_.children.size();
  for (int i = 0; i < star_.n_link; ++i)
    stars_.link.push_back(global(star_.link[static_cast<std::size_t>(i)]));
  for (int i = 0; i < star_.n_triangles; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const std::uint32_t slot = star_.slots[at];
    stars_.triangles.push_back(star_.triangles[at]);
    if (!state_.labels.empty()) stars_.labels.push_back(state_.labels[slots_[slot]]);
    const std::uint32_t maker = std::exchange(makers_[slot], global(star_.vertex));
    if (maker == kNone) {
      stars_.makers.push_back(CollapseStars::kReference);
      continue;
    }
    const auto begin = stars_.children.begin() + static_cast<std::ptrdiff_t>(first);
    const auto place = std::find(begin, stars_.children.end(), maker) - begin;
    if (first + static_cast<std::size_t>(place) == stars_.children.size())
      stars_.children.push_back(maker);
    stars_.makers.push_back(static_cast<std::uint8_t>(place));
  }
  stars_.sizes.push_back({static_cast<std::uint8_t>(star_.n_link),
                          static_cast<std::uint8_t>(star_.n_triangles),
                          static_cast<std::uint8_t>(stars_.children.size() - first)});
}

void BlockCollapser::write_back() {
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (has_changed_[i] == 0) continue;
    Tetrahedron& to = state_.tetrahedra[slots_[i]];
    const Tetrahedron& from = live_.corners(static_cast<std::uint32_t>(i));
    if (from[0] == kNone) {
      to[0] = kNone;
      continue;
    }
    for (std::size_t k = 0; k < 4; ++k) to[k] = global(from[k]);
    state_.first_sample[slots_[i]] = samples_[i];
    state_.makers[slots_[i]] = makers_[i];
    state_.corner_sets[slots_[i]] = corner_sets_[i];
  }
}

}  // namespace lode::tetra_mt

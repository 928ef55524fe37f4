// What the collapse of an edge does, once it is chosen.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "lode/core/expects.h"
#include "lode/models/tetra_mt/fan_distance.h"
#include "lode/models/tetra_mt/midpoint/edge_collapser.h"

namespace lode::tetra_mt::midpoint {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

}  // namespace

/// False, and nothing done, where rounding leaves open what covers a sample.
bool EdgeCollapser::collapse(const Choice& choice) {
  if (is_by_quadrics()) gather_own_samples();
  if (!look_at_one_edge(choice.place)) return false;
  const auto rule = rule_of(choice.place);
  if (!rule) return false;
  rule_ = *rule;
  if (!keeps_regions(choice.place) || !make_fan_at(choice.place) || !cover_samples()) return false;
  const std::uint32_t other = star_.link[static_cast<std::size_t>(choice.place)];
  note_deviations(choice.place);
  change(choice.place);
  state_.keys[global(other)] = std::numeric_limits<float>::infinity();
  queue_.remove(other);
  return true;
}

/// What was chosen before, when the fields were others: only where the values come from is found
/// anew.
bool EdgeCollapser::repeat(const EdgeCollapse& given) {
  LODE_EXPECTS(!is_by_quadrics() && given.kept < live_.n_own());
  if (!gatherer_.gather(given.kept, star_)) return false;
  const auto end = star_.link.begin() + star_.n_link;
  const auto found = std::find(star_.link.begin(), end, given.removed);
  if (found == end || given.removed == live_.outside()) return false;
  const auto place = static_cast<int>(found - star_.link.begin());
  look_at_star();
  if (!look_at_one_edge(place)) return false;
  rule_ = {given.position, 0};
  take_value_places(given.position);
  if (!make_fan_at(place) || !cover_samples()) return false;
  change(place);
  return true;
}

/// Expects the star of one end, and nothing of the edge but which it is.
bool EdgeCollapser::look_at_one_edge(int place) {
  for (int i = 0; i < star_.n_link; ++i)
    link_places_[star_.link[static_cast<std::size_t>(i)]] = static_cast<std::uint8_t>(i);
  const bool is_known = look_at_edge(place);
  for (int i = 0; i < star_.n_link; ++i)
    link_places_[star_.link[static_cast<std::size_t>(i)]] = kNoPlace;
  return is_known;
}

/// Stars stay in the order of slots: of lanes that cover a sample alike the first one takes it, so
/// that repeat() finds what collapse() did.
void EdgeCollapser::change(int place) {
  const std::uint32_t other = star_.link[static_cast<std::size_t>(place)];
  note_facts();
  move_samples();
  make_vertex(other);
  n_gone_ += live_.collapse(other, star_.vertex);
  live_.sort_star(star_.vertex);
  for (std::uint64_t ring = star_.adjacent[static_cast<std::size_t>(place)]; ring != 0;
       ring &= ring - 1)
    if (const int at = std::countr_zero(ring); at != star_.outside)
      live_.sort_star(star_.link[static_cast<std::size_t>(at)]);
  state_.is_there[global(other)] = 0;
  collapses_.push_back({global(star_.vertex), global(other), rule_.position});
}

/// By one lane. Weights are of the triangle's corners; products of lengths bound what they lose.
EdgeCollapser::Cover EdgeCollapser::cover_by(std::size_t lane, std::uint32_t sample) const {
  const auto& t = edge_.triangles[lane];
  const Vec3d a = link_[t[0]] - at_;
  const Vec3d b = link_[t[1]] - at_;
  const Vec3d c = link_[t[2]] - at_;
  const Vec3d d = (state_.mesh.positions[sample] - positions_[star_.vertex]) * scale_ - at_;
  const Vec3d bc = cross(b, c);
  const double volume = dot(bc, a);
  Cover cover{
      .lane = lane,
      .weights = {dot(bc, d) / volume, dot(cross(c, a), d) / volume, dot(cross(a, b), d) / volume}};
  const auto& w = cover.weights;
  cover.least = std::min({w[0], w[1], w[2], 1 - (w[0] + w[1] + w[2])});
  const double sizes = length(b) * length(c) + length(c) * length(a) + length(a) * length(b);
  cover.rounding = 0x1p-48 * (1 + sizes * length(d) / volume);
  return cover;
}

/// The lane that floats found, unless doubles say that the sample lies outside: then the best one.
/// None where even doubles do not tell.
std::optional<EdgeCollapser::Cover> EdgeCollapser::find_cover(const StarSamples& samples,
                                                              std::size_t sample) const {
  constexpr double kInside = -1e-9;
  std::optional<Cover> best;
  double least = -kUnbounded;
  const auto look_at = [&](std::size_t lane) {
    if (fan_.gaps[lane] != 0) return;
    const Cover here = cover_by(lane, samples.samples[sample]);
    if (!(here.least > least)) return;
    least = here.least;
    best = here;
  };
  const std::size_t found = find_lane(fan_, lanes_.n, samples, sample);
  const auto n = static_cast<std::size_t>(edge_.n_triangles);
  if (found < n) look_at(found);
  for (std::size_t lane = 0; lane < n && !(least >= kInside); ++lane) look_at(lane);
  return best;
}

/// F - F' in the field's unit, larger than it is by what doubles may round.
double EdgeCollapser::error_of(const Cover& cover, std::uint32_t sample, std::size_t field) const {
  const double at_new = value_[field].value;
  double made = 0;
  double size = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t corner = edge_.link[edge_.triangles[cover.lane][k]];
    const double rise = values_[corner * state_.n_fields + field] - at_new;
    made += cover.weights[k] * rise;
    size = std::max(size, std::abs(rise));
  }
  const double error = state_.sample(sample, field) - at_new - made;
  return error == 0 ? 0 : error + std::copysign(size * cover.rounding, error);
}

/// Finds which tetrahedra of the fan cover the samples, and with which errors.
bool EdgeCollapser::cover_samples() {
  covers_.clear();
  new_errors_.clear();
  for (std::size_t s = 0; s < covered_.samples.size(); ++s) {
    auto cover = find_cover(covered_, s);
    if (!cover) return false;
    if (state_.boundary_tolerance > 0 && cover->least < 0) clamp_weights(cover->weights);
    covers_.push_back(*cover);
    for (std::size_t f = 0; f < state_.n_fields; ++f) {
      new_errors_.push_back(error_of(*cover, covered_.samples[s], f));
      if (!std::isfinite(new_errors_.back())) return false;
    }
  }
  return true;
}

void EdgeCollapser::move_samples() {
  for (const Star* star : {&star_, &other_})
    for (int i = 0; i < star->n_triangles; ++i) {
      const std::uint32_t slot = star->slots[static_cast<std::size_t>(i)];
      samples_[slot] = kNone;
      corner_sets_[slot] = {};
      has_changed_[slot] = 1;
    }
  for (std::size_t s = 0; s < covered_.samples.size(); ++s) {
    const std::uint32_t sample = covered_.samples[s];
    const Cover& cover = covers_[s];
    const std::uint32_t slot = edge_.slots[cover.lane];
    state_.sample_corners[sample] = corners_round(
        weights_of_corners(live_.corners(slot), edge_, cover.lane, cover.weights), cover.least);
    corner_sets_[slot].add(state_.sample_corners[sample]);
    std::uint32_t& first = samples_[slot];
    state_.next_sample[sample] = first;
    first = sample;
    for (std::size_t f = 0; f < state_.n_fields; ++f)
      state_.errors_of(sample)[f] =
          static_cast<float>(new_errors_[s * state_.n_fields + f] * state_.value_units[f]);
    for (std::size_t f = 0; is_by_space() && f < state_.n_fields; ++f)
      state_.distances_of(sample)[f] = fan_.distance(covered_, s, f, cover.lane);
  }
}

/// Both ends are in the edge's link or among the samples, but for the star's vertex.
void EdgeCollapser::note_facts() {
  for (std::size_t f = 0; f < state_.n_fields; ++f) note_facts(f);
  note_held_samples();
}

/// Of the samples, in the mesh's unit.
double EdgeCollapser::world_error_of(std::size_t field) const {
  const std::size_t n = state_.n_fields;
  std::array<double, Star::kMaxLink> values{};
  for (int i = 0; i < edge_.n_link; ++i)
    if (i != edge_.outside) {
      const auto at = static_cast<std::size_t>(i);
      values[at] = values_[edge_.link[at] * n + field];
    }
  const ValuedFan fan{edge_, fan_, link_, at_, values, value_[field].value};
  const auto sample_at = [&](std::size_t s) {
    const std::uint32_t sample = covered_.samples[s];
    const Vec3d p = (state_.mesh.positions[sample] - positions_[star_.vertex]) * scale_;
    return FanSample{covers_[s].lane, state_.same_values(sample, field), p};
  };
  return largest_distance(fan, covered_.samples.size(), sample_at) / scale_;
}

void EdgeCollapser::note_facts(std::size_t field) {
  const std::size_t n = state_.n_fields;
  const double own = values_[star_.vertex * n + field];
  const double made = value_[field].value;
  EdgeFacts facts{0, std::min(own, made), std::max(own, made), value_[field].place};
  const auto widen = [&](double value) {
    facts.low = std::min(facts.low, value);
    facts.high = std::max(facts.high, value);
  };
  for (std::size_t s = 0; s < covered_.samples.size(); ++s) {
    facts.error = std::max(facts.error, std::abs(new_errors_[s * n + field]));
    widen(state_.sample(covered_.samples[s], field));
  }
  for (int i = 0; i < edge_.n_link; ++i)
    if (i != edge_.outside) widen(values_[edge_.link[static_cast<std::size_t>(i)] * n + field]);
  if (state_.has_world_errors) facts.world_error = world_error_of(field);
  facts_.push_back(facts);
}

/// Of a sample that no tetrahedron of either star covers, the best lane of those that hold it.
std::optional<EdgeCollapser::Cover> EdgeCollapser::find_holder(std::uint32_t sample) {
  const Vec3d p = (state_.mesh.positions[sample] - positions_[star_.vertex]) * scale_;
  one_beside_.samples.assign(1, sample);
  one_beside_.x.assign(1, static_cast<float>(p[0]));
  one_beside_.y.assign(1, static_cast<float>(p[1]));
  one_beside_.z.assign(1, static_cast<float>(p[2]));
  auto cover = find_cover(one_beside_, 0);
  return cover && cover->least >= -kHeld - cover->rounding ? cover : std::nullopt;
}

/// What is covered by others but lies in faces, edges or vertices of the fan counts, too.
void EdgeCollapser::note_held_samples() {
  const std::array<std::uint32_t, 2> ends{star_.vertex, other_.vertex};
  const auto link = std::span(edge_.link).first(static_cast<std::size_t>(edge_.n_link));
  const auto sets_of = [&](std::uint32_t slot) { return corner_sets_[slot]; };
  beside_.visit(ends, link, sets_of, [&](std::uint32_t slot, unsigned others) {
    for (std::uint32_t s = samples_[slot]; s != kNone; s = state_.next_sample[s])
      if ((state_.sample_corners[s] & others) == 0) note_held(s);
  });
}

void EdgeCollapser::note_held(std::uint32_t sample) {
  const auto holder = find_holder(sample);
  if (!holder) return;
  const std::span<EdgeFacts> facts = std::span(facts_).last(state_.n_fields);
  for (std::size_t f = 0; f < state_.n_fields; ++f)
    widen_by(state_.sample(sample, f), error_of(*holder, sample, f), facts[f]);
}

void EdgeCollapser::make_vertex(std::uint32_t other) {
  const std::uint32_t slot = global(star_.vertex);
  state_.codes[slot] = code_;
  state_.positions[slot] = positions_[star_.vertex] = state_.scales.position(code_);
  const std::size_t n = state_.n_fields;
  for (std::size_t f = 0; f < n; ++f) {
    state_.value_codes[slot * n + f] = value_[f].code;
    state_.values[slot * n + f] = values_[star_.vertex * n + f] = value_[f].value;
  }
  if (is_by_quadrics())
    for (std::size_t f = 0; f < n; ++f)
      state_.quadrics_of(slot)[f].add(state_.quadrics_of(global(other))[f]);
  state_.is_reference[slot] = 0;
  state_.is_reference[global(other)] = 0;
}

}  // namespace lode::tetra_mt::midpoint

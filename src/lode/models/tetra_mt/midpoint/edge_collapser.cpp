#include "lode/models/tetra_mt/midpoint/edge_collapser.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace lode::tetra_mt::midpoint {
namespace {

constexpr float kNever = std::numeric_limits<float>::infinity();
/// What is beside a collapse is looked at again at so much of its key.
constexpr float kDiscount = 0.7F;

/// Numbers vertices: own ones first, then those beside them, the one outside last.
std::vector<std::uint32_t> number_vertices(const State& state, std::span<const std::uint32_t> own,
                                           std::span<const std::uint32_t> slots,
                                           std::vector<std::uint32_t>& places) {
  std::vector<std::uint32_t> vertices(own.begin(), own.end());
  for (const std::uint32_t slot : slots)
    for (const std::uint32_t v : state.tetrahedra[slot]) places[v] = kNone;
  for (std::uint32_t i = 0; i < own.size(); ++i) places[own[i]] = i;
  for (const std::uint32_t slot : slots)
    for (const std::uint32_t v : state.tetrahedra[slot])
      if (places[v] == kNone && v != state.outside) {
        places[v] = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back(v);
      }
  places[state.outside] = static_cast<std::uint32_t>(vertices.size());
  vertices.push_back(state.outside);
  return vertices;
}

std::vector<Tetrahedron> numbered(const State& state, std::span<const std::uint32_t> slots,
                                  std::span<const std::uint32_t> places) {
  std::vector<Tetrahedron> local(slots.size());
  for (std::size_t i = 0; i < slots.size(); ++i)
    for (std::size_t k = 0; k < 4; ++k) local[i][k] = places[state.tetrahedra[slots[i]][k]];
  return local;
}

}  // namespace

EdgeCollapser::EdgeCollapser(State& state, std::span<const std::uint32_t> vertices,
                             std::span<const std::uint32_t> slots,
                             std::vector<std::uint32_t>& places)
    : state_(state),
      vertices_(number_vertices(state, vertices, slots, places)),
      slots_(slots.begin(), slots.end()),
      live_(static_cast<std::uint32_t>(vertices.size()),
            static_cast<std::uint32_t>(vertices_.size() - 1), numbered(state, slots, places)),
      gatherer_(live_),
      beside_(live_),
      queue_(static_cast<std::uint32_t>(vertices.size())),
      has_changed_(slots.size(), 0),
      link_places_(vertices_.size(), kNoPlace) {
  for (std::size_t i = 0; i + 1 < vertices_.size(); ++i) {
    positions_.push_back(state.positions[vertices_[i]]);
    for (std::size_t f = 0; f < state.n_fields; ++f)
      values_.push_back(state.values[vertices_[i] * state.n_fields + f]);
  }
  for (const std::uint32_t slot : slots) {
    samples_.push_back(state.first_sample[slot]);
    corner_sets_.push_back(state.corner_sets[slot]);
  }
  covered_.n_fields = state.n_fields;
  fan_.kept_value.resize(state.n_fields);
  fan_.gradients.resize(state.n_fields);
  value_.resize(state.n_fields);
}

void EdgeCollapser::find_locked(std::size_t n) {
  for (std::uint32_t v = 0; v < n; ++v)
    state_.is_locked[global(v)] =
        gatherer_.gather(v, star_) && StarGatherer::is_manifold(star_) ? 0 : 1;
}

void EdgeCollapser::find_keys(std::size_t n) {
  for (std::uint32_t v = 0; v < n; ++v) {
    float& key = state_.keys[global(v)];
    key = kNever;
    if (state_.is_locked[global(v)] != 0 || !gatherer_.gather(v, star_)) continue;
    find_choices();
    for (const Choice& choice : choices_) key = std::min(key, choice.increase);
  }
}

void EdgeCollapser::run(float limit, std::uint64_t n_cells) {
  for (std::uint32_t v = 0; v < live_.n_own(); ++v)
    if (state_.is_locked[global(v)] == 0 && state_.keys[global(v)] < limit)
      queue_.set(v, state_.keys[global(v)]);
  while (n_gone_ < n_cells) {
    const std::uint32_t vertex = queue_.pop();
    if (vertex == kNone) break;
    const float key = queue_.key(vertex);
    if (!gatherer_.gather(vertex, star_)) {
      state_.keys[global(vertex)] = kNever;
      continue;
    }
    if (!is_inner(star_)) continue;  // its key stays, for blocks in which it is one
    find_choices();
    if (collapse_best(key, limit)) look_again_beside(key, limit);
  }
}

/// Whether nothing but own vertices is beside the one whose star that is.
bool EdgeCollapser::is_inner(const Star& star) const {
  for (int i = 0; i < star.n_link; ++i)
    if (i != star.outside && star.link[static_cast<std::size_t>(i)] >= live_.n_own()) return false;
  return true;
}

bool EdgeCollapser::owns_edge_to(std::uint32_t other) const {
  return other < live_.n_own() && global(other) > global(star_.vertex) &&
         state_.is_locked[global(other)] == 0;
}

/// Where the new one comes, and its values.
void EdgeCollapser::find_vertex(int place) {
  const std::uint32_t first = global(star_.vertex);
  const std::uint32_t second = global(star_.link[static_cast<std::size_t>(place)]);
  const std::size_t n_fields = state_.n_fields;
  code_ = merged(state_.codes[first], state_.codes[second], rule_.position);
  at_ = (state_.scales.position(code_) - positions_[star_.vertex]) * scale_;
  for (std::size_t f = 0; f < n_fields; ++f) {
    NewValue& made = value_[f];
    made.code = merged(state_.value_codes[first * n_fields + f],
                       state_.value_codes[second * n_fields + f], made.place);
    made.value = state_.field_scales[f].value(made.code);
    fan_.kept_value[f] = static_cast<float>((made.value - values_[star_.vertex * n_fields + f]) *
                                            state_.value_units[f]);
  }
}

/// False where a tetrahedron that comes would be flat or turned round.
bool EdgeCollapser::make_fan_at(int place) {
  find_vertex(place);
  lanes_.fill(edge_, link_, covered_.link_values, state_.n_fields);
  std::size_t n_flat = lanes_.n - static_cast<std::size_t>(edge_.n_triangles);
  if (edge_.outside >= 0)
    for (int i = 0; i < edge_.n_triangles; ++i) n_flat += edge_.has(i, edge_.outside) ? 1 : 0;
  return make_fan(lanes_, at_, n_flat, fan_);
}

std::optional<EdgeCollapser::Choice> EdgeCollapser::choice_of(int place, double least) {
  if (!look_at_edge(place)) return {};
  const auto rule = rule_of(place);
  if (!rule) return {};
  rule_ = *rule;
  if (!make_fan_at(place)) return {};
  const double gone = std::max(1, n_cells_beside(place));
  const double before = covered_.cost;
  const double error = cost_of(fan_, lanes_.n, covered_, least * gone + before);
  return Choice{place, static_cast<float>(std::max(error - before, 0.0) / gone), is_inner(other_)};
}

void EdgeCollapser::find_choices() {
  choices_.clear();
  look_at_star();
  for (int i = 0; i < star_.n_link; ++i)
    link_places_[star_.link[static_cast<std::size_t>(i)]] = static_cast<std::uint8_t>(i);
  double least = std::numeric_limits<double>::infinity();
  for (int place = 0; place < star_.n_link; ++place) {
    if (place == star_.outside || !owns_edge_to(star_.link[static_cast<std::size_t>(place)]))
      continue;
    const auto choice = is_by_quadrics() ? choice_by_quadrics(place) : choice_of(place, least);
    if (!choice) continue;
    least = std::min(least, static_cast<double>(choice->increase));
    choices_.push_back(*choice);
  }
  for (int i = 0; i < star_.n_link; ++i)
    link_places_[star_.link[static_cast<std::size_t>(i)]] = kNoPlace;
}

/// The best one that leaves a manifold, unless it is worse than others wait with, or its other end
/// is not of the block: then the vertex waits, too.
bool EdgeCollapser::collapse_best(float key, float limit) {
  float& known = state_.keys[global(star_.vertex)];
  for (known = kNever; !choices_.empty(); choices_.pop_back()) {
    const auto best = std::ranges::min_element(choices_, {}, &Choice::increase);
    if (best->increase >= limit || (best->increase > key && !queue_.is_least(best->increase))) {
      known = best->increase;
      if (known < limit) queue_.set(star_.vertex, known);
      return false;
    }
    if (!best->is_inner) {
      known = best->increase;
      return false;
    }
    if (gatherer_.may_collapse(star_, best->place, kMaxLink) && collapse(*best)) return true;
    *best = choices_.back();
  }
  return false;
}

/// `edge_` is what was round both ends.
void EdgeCollapser::look_again_beside(float key, float limit) {
  for (int i = 0; i < edge_.n_link; ++i) {
    const std::uint32_t v = edge_.link[static_cast<std::size_t>(i)];
    if (i == edge_.outside || live_.star(v).empty() || state_.is_locked[global(v)] != 0) continue;
    float& known = state_.keys[global(v)];
    // A collapse changes one quadric: what others wait with is found anew when they come up.
    if (is_by_quadrics() && known != kNever) continue;
    known = known == kNever ? key : known * kDiscount;
    if (known < limit) queue_.set(v, known);
  }
  state_.keys[global(star_.vertex)] = key;
  queue_.set(star_.vertex, key);
}

void EdgeCollapser::write_back() {
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
    state_.corner_sets[slots_[i]] = corner_sets_[i];
  }
}

}  // namespace lode::tetra_mt::midpoint

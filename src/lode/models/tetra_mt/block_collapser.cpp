#include "lode/models/tetra_mt/block_collapser.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace lode::tetra_mt {
namespace {

constexpr float kNever = std::numeric_limits<float>::infinity();

/// Numbers vertices: own ones first, then those beside them, the one outside last.
std::vector<std::uint32_t> number_vertices(const BuildState& state,
                                           std::span<const std::uint32_t> own,
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

std::vector<Tetrahedron> local_tetrahedra(const BuildState& state,
                                          std::span<const std::uint32_t> slots,
                                          std::span<const std::uint32_t> places) {
  std::vector<Tetrahedron> local(slots.size());
  for (std::size_t i = 0; i < slots.size(); ++i)
    for (std::size_t k = 0; k < 4; ++k) local[i][k] = places[state.tetrahedra[slots[i]][k]];
  return local;
}

}  // namespace

BlockCollapser::BlockCollapser(BuildState& state, std::span<const std::uint32_t> vertices,
                               std::span<const std::uint32_t> slots,
                               std::vector<std::uint32_t>& places, const CollapseRules& rules)
    : state_(state),
      rules_(rules),
      vertices_(number_vertices(state, vertices, slots, places)),
      slots_(slots.begin(), slots.end()),
      live_(static_cast<std::uint32_t>(vertices.size()),
            static_cast<std::uint32_t>(vertices_.size() - 1),
            local_tetrahedra(state, slots, places)),
      gatherer_(live_),
      beside_(live_),
      queue_(static_cast<std::uint32_t>(vertices.size())),
      is_inner_(vertices.size(), 1),
      has_changed_(slots.size(), 0) {
  positions_.reserve(vertices_.size());
  values_.reserve(vertices_.size() * state.n_fields);
  for (std::size_t i = 0; i + 1 < vertices_.size(); ++i) {
    positions_.push_back(state.mesh.positions[vertices_[i]]);
    for (std::size_t f = 0; f < state.n_fields; ++f)
      values_.push_back(state.value(vertices_[i], f));
  }
  samples_.reserve(slots.size());
  makers_.reserve(slots.size());
  corner_sets_.reserve(slots.size());
  for (const std::uint32_t slot : slots) {
    samples_.push_back(state.first_sample[slot]);
    makers_.push_back(state.makers[slot]);
    corner_sets_.push_back(state.corner_sets[slot]);
  }
  find_inner();
  covered_.n_fields = state.n_fields;
  fan_.kept_value.resize(state.n_fields);
  fan_.gradients.resize(state.n_fields);
}

void BlockCollapser::find_keys() {
  for (std::uint32_t v = 0; v < live_.n_own(); ++v) {
    float& key = state_.keys[global(v)];
    key = kNever;
    if (!gatherer_.gather(v, star_) || !StarGatherer::is_manifold(star_)) {
      state_.is_locked[global(v)] = 1;
      continue;
    }
    if (rules_.keeps_extrema) state_.stays[global(v)] = is_extremum() ? 1 : 0;
    if (is_by_quadrics()) find_quadrics();
    find_choices();
    for (const Choice& choice : choices_) key = std::min(key, choice.increase);
  }
}

void BlockCollapser::run(float limit, std::uint64_t n_cells) {
  for (std::uint32_t v = 0; v < live_.n_own(); ++v)
    if (may_go(v) && state_.keys[global(v)] < limit) queue_.set(v, state_.keys[global(v)]);
  while (n_gone_ < n_cells) {
    const std::uint32_t vertex = queue_.pop();
    if (vertex == kNone) break;
    const float key = queue_.key(vertex);
    if (!gatherer_.gather(vertex, star_)) {
      state_.keys[global(vertex)] = kNever;
      continue;
    }
    find_choices();
    if (collapse_best(key, limit)) look_again_beside(key, limit);
  }
}

/// Those beside which are none but own vertices, and the one outside. As no others go, the
/// tetrahedra that have other vertices stay as they are, and so does what that says.
void BlockCollapser::find_inner() {
  for (std::uint32_t slot = 0; slot < live_.n_slots(); ++slot) {
    const Tetrahedron& t = live_.corners(slot);
    const auto is_own = [&](std::uint32_t v) { return v < live_.n_own(); };
    if (std::ranges::all_of(t, [&](std::uint32_t v) { return is_own(v) || v == live_.outside(); }))
      continue;
    for (const std::uint32_t v : t)
      if (is_own(v)) is_inner_[v] = 0;
  }
}

/// In the mesh as it is: where it is none, what is beside it has values from which to which its own
/// lies, and the range stays.
bool BlockCollapser::is_extremum() const {
  if (!state_.stays.empty() && state_.stays[global(star_.vertex)] != 0) return true;
  const std::size_t n = state_.n_fields;
  for (std::size_t f = 0; f < n; ++f) {
    const double own = values_[star_.vertex * n + f];
    bool has_lower = false;
    bool has_higher = false;
    for (int i = 0; i < star_.n_link; ++i) {
      if (i == star_.outside) continue;
      const double other = values_[star_.link[static_cast<std::size_t>(i)] * n + f];
      has_lower = has_lower || other <= own;
      has_higher = has_higher || other >= own;
    }
    if (!has_lower || !has_higher) return true;
  }
  return false;
}

void BlockCollapser::gather_link() {
  const Vec3d& centre = positions_[star_.vertex];
  double largest = 0;
  for (int i = 0; i < star_.n_link; ++i) {
    if (i == star_.outside) continue;
    const auto at = static_cast<std::size_t>(i);
    link_[at] = positions_[star_.link[at]] - centre;
    for (const double x : link_[at].v) largest = std::max(largest, std::abs(x));
  }
  scale_ = largest > 0 ? std::ldexp(1.0, -std::ilogb(largest)) : 1;
  for (Vec3d& p : std::span(link_).first(static_cast<std::size_t>(star_.n_link))) p = p * scale_;
}

/// Tetrahedra at the edge, without those to the vertex outside.
int BlockCollapser::n_cells_beside(int kept) const {
  const std::uint64_t around = star_.adjacent[static_cast<std::size_t>(kept)];
  const bool is_outer = star_.outside >= 0 && (around >> star_.outside & 1) != 0;
  return std::popcount(around) - (is_outer ? 2 : 0);
}

bool BlockCollapser::make_fan_to(int kept) {
  if (!has_lanes_) fill_lanes();
  const auto at = static_cast<std::size_t>(kept);
  std::size_t n_flat = lanes_.n - static_cast<std::size_t>(star_.n_triangles) +
                       static_cast<std::size_t>(n_cells_beside(kept));
  if (star_.outside >= 0)
    n_flat += static_cast<std::size_t>(
        std::popcount(star_.adjacent[static_cast<std::size_t>(star_.outside)]));
  for (std::size_t f = 0; f < state_.n_fields; ++f)
    fan_.kept_value[f] = covered_.link_values[at * state_.n_fields + f];
  return make_fan(lanes_, link_[at], n_flat, fan_);
}

void BlockCollapser::fill_lanes() {
  gather_link_values();
  lanes_.fill(star_, link_, covered_.link_values, state_.n_fields);
  has_lanes_ = true;
}

/// As it is covered now.
double BlockCollapser::cost_of_sample(std::uint32_t sample) const {
  const bool is_by_space = rules_.order == CollapseOrder::space_error;
  double cost = 0;
  for (const float error : is_by_space ? state_.distances_of(sample) : state_.errors_of(sample))
    cost += cost_of(static_cast<double>(error));
  return cost;
}

void BlockCollapser::gather_samples() {
  auto& samples = covered_.samples;
  samples.clear();
  samples.push_back(global(star_.vertex));
  for (int i = 0; i < star_.n_triangles; ++i)
    for (std::uint32_t s = samples_[star_.slots[static_cast<std::size_t>(i)]]; s != kNone;
         s = state_.next_sample[s])
      samples.push_back(s);
  const std::size_t n = samples.size();
  const std::size_t n_fields = state_.n_fields;
  covered_.x.resize(n);
  covered_.y.resize(n);
  covered_.z.resize(n);
  covered_.values.resize(n * n_fields);
  covered_.cost = 0;
  covered_.space_unit = rules_.order == CollapseOrder::space_error
                            ? static_cast<float>(1 / (scale_ * state_.size))
                            : 0;
  const Vec3d centre = positions_[star_.vertex];
  const double* const own = values_.data() + star_.vertex * n_fields;
  for (std::size_t s = 0; s < n; ++s) {
    const Vec3d p = (state_.mesh.positions[samples[s]] - centre) * scale_;
    covered_.x[s] = static_cast<float>(p[0]);
    covered_.y[s] = static_cast<float>(p[1]);
    covered_.z[s] = static_cast<float>(p[2]);
    for (std::size_t f = 0; f < n_fields; ++f)
      covered_.values[s * n_fields + f] =
          static_cast<float>((state_.value(samples[s], f) - own[f]) * state_.scales[f]);
    if (!is_by_quadrics()) covered_.cost += cost_of_sample(samples[s]);
  }
}

void BlockCollapser::gather_link_values() {
  const std::size_t n_fields = state_.n_fields;
  const double* const own = values_.data() + star_.vertex * n_fields;
  covered_.link_values.resize(static_cast<std::size_t>(star_.n_link) * n_fields);
  for (int i = 0; i < star_.n_link; ++i) {
    if (i == star_.outside) continue;
    const auto at = static_cast<std::size_t>(i);
    for (std::size_t f = 0; f < n_fields; ++f)
      covered_.link_values[at * n_fields + f] =
          static_cast<float>((values_[star_.link[at] * n_fields + f] - own[f]) * state_.scales[f]);
  }
}

/// What choices are made from; false where interfaces let it go nowhere.
bool BlockCollapser::look_at_star() {
  find_interfaces_of(star_, interfaces_);
  if (interfaces_.kind == Interfaces::Kind::corner) return false;
  deviation_ = 0;
  if (interfaces_.kind != Interfaces::Kind::none)
    for (int i = 0; i < star_.n_triangles; ++i) deviation_ = std::max(deviation_, deviation(i));
  gather_link();
  gather_boundary();
  has_lanes_ = false;
  return true;
}

/// Of the reference's tetrahedra round the vertex, by their volumes.
void BlockCollapser::find_quadrics() {
  gather_link();
  const double unit = 1 / (scale_ * state_.size);  // link_ in shares of the mesh's size
  const Vec3d centre = (1 / state_.size) * (positions_[star_.vertex] - state_.centre);
  for (int i = 0; i < star_.n_triangles; ++i) {
    if (star_.is_on_boundary() && star_.has(i, star_.outside)) continue;
    const auto& t = star_.triangles[static_cast<std::size_t>(i)];
    const std::array<Vec3d, 3> at{unit * link_[t[0]], unit * link_[t[1]], unit * link_[t[2]]};
    const std::array<Vec3d, 3> rows{cross(at[1], at[2]), cross(at[2], at[0]), cross(at[0], at[1])};
    const double volume = dot(rows[0], at[0]);
    for (std::size_t f = 0; f < state_.n_fields; ++f) {
      const double own = state_.scales[f] * values_[star_.vertex * state_.n_fields + f];
      Vec3d gradient;
      for (std::size_t k = 0; k < 3; ++k) {
        const double value = state_.scales[f] * values_[star_.link[t[k]] * state_.n_fields + f];
        gradient = gradient + ((value - own) / volume) * rows[k];
      }
      const double slope = dot(gradient, gradient);
      if (!std::isfinite(slope)) continue;  // without volume
      state_.quadrics_of(global(star_.vertex))[f].add_linear(gradient, own - dot(gradient, centre),
                                                             std::abs(volume));
    }
  }
}

void BlockCollapser::find_choices() {
  choices_.clear();
  if (is_extremum() || !look_at_star()) return;
  if (is_by_quadrics())
    find_choices_by_quadrics();
  else
    find_choices_by_samples();
}

/// Whatever tetrahedra would come: most of these choices are never looked at again.
void BlockCollapser::find_choices_by_quadrics() {
  const std::span<const FieldQuadric> own = state_.quadrics_of(global(star_.vertex));
  const double unit = 1 / state_.size;
  for (int kept = 0; kept < star_.n_link; ++kept) {
    if (kept == star_.outside) continue;
    const float moved = moved_by(kept);
    if (moved == kNever) continue;
    const std::uint32_t other = star_.link[static_cast<std::size_t>(kept)];
    const Vec3d at = unit * (positions_[other] - state_.centre);
    double sum = 0;
    for (std::size_t f = 0; f < state_.n_fields; ++f)
      sum += std::max(own[f].at(at, state_.scales[f] * values_[other * state_.n_fields + f]), 0.0);
    choices_.push_back({kept, static_cast<float>(sum / std::max(1, n_cells_beside(kept))), moved});
  }
}

void BlockCollapser::find_choices_by_samples() {
  gather_samples();
  double least = std::numeric_limits<double>::infinity();
  for (int kept = 0; kept < star_.n_link; ++kept) {
    if (kept == star_.outside) continue;
    const float moved = moved_by(kept);
    if (moved == kNever) continue;
    if (!make_fan_to(kept)) continue;
    const double gone = std::max(1, n_cells_beside(kept));
    const double error = cost_of(fan_, lanes_.n, covered_, least * gone + covered_.cost);
    const double increase = std::max(error - covered_.cost, 0.0) / gone;
    least = std::min(least, increase);
    choices_.push_back({kept, static_cast<float>(increase), moved});
  }
}

/// Leaves the fan to it. Most that quadrics choose would turn tetrahedra round, so that comes
/// first.
bool BlockCollapser::may_collapse_to(int kept) {
  const bool is_first = is_by_quadrics();
  return (!is_first || make_fan_to(kept)) && gatherer_.may_collapse(star_, kept, rules_.max_link) &&
         (is_first || make_fan_to(kept)) && keeps_regions(kept);
}

/// The best one that leaves a manifold, unless it is worse than others wait with: then the vertex
/// waits, too.
bool BlockCollapser::collapse_best(float key, float limit) {
  float& known = state_.keys[global(star_.vertex)];
  for (known = kNever; !choices_.empty(); choices_.pop_back()) {
    const auto best = std::ranges::min_element(choices_, {}, &Choice::increase);
    if (best->increase >= limit || (best->increase > key && !queue_.is_least(best->increase))) {
      known = best->increase;
      if (known < limit) queue_.set(star_.vertex, known);
      return false;
    }
    if (may_collapse_to(best->kept) && collapse(*best)) return true;
    *best = choices_.back();
  }
  return false;
}

void BlockCollapser::look_again_beside(float key, float limit) {
  for (int i = 0; i < star_.n_link; ++i) {
    if (i == star_.outside) continue;
    const std::uint32_t v = star_.link[static_cast<std::size_t>(i)];
    if (state_.is_locked[global(v)] != 0) continue;
    float& known = state_.keys[global(v)];
    if (is_by_quadrics() && known != kNever) continue;
    known = known == kNever ? key : known * rules_.discount;
    if (known < limit && is_inner_[v] != 0) queue_.set(v, known);
  }
}

}  // namespace lode::tetra_mt

// What is at a vertex, and round both ends of an edge.
#include <algorithm>
#include <bit>
#include <cmath>

#include "lode/models/tetra_mt/midpoint/edge_collapser.h"

namespace lode::tetra_mt::midpoint {
namespace {

constexpr int kNowhere = -1;

}  // namespace

/// What all edges of a vertex have in common.
void EdgeCollapser::look_at_star() {
  find_interfaces_of(star_, interfaces_);
  find_extrema(star_, extrema_);
  double largest = 0;
  for (int i = 0; i < star_.n_link; ++i) {
    if (i == star_.outside) continue;
    const Vec3d way =
        positions_[star_.link[static_cast<std::size_t>(i)]] - positions_[star_.vertex];
    for (const double x : way.v) largest = std::max(largest, std::abs(x));
  }
  scale_ = largest > 0 ? std::ldexp(1.0, -std::ilogb(largest)) : 1;
  covered_.link_values.assign(Star::kMaxLink * state_.n_fields, 0);
  for (int i = 0; i < star_.n_link; ++i)
    if (i != star_.outside) add_link_vertex(i, star_.link[static_cast<std::size_t>(i)]);
  edge_.vertex = star_.vertex;
  std::copy_n(star_.link.begin(), star_.n_link, edge_.link.begin());
  covered_.space_unit = is_by_space() ? static_cast<float>(1 / (scale_ * state_.size)) : 0;
  if (!is_by_quadrics()) gather_own_samples();
}

void EdgeCollapser::gather_own_samples() {
  covered_.samples.clear();
  covered_.cost = 0;
  if (state_.is_reference[global(star_.vertex)] != 0) add_sample(global(star_.vertex));
  for (int i = 0; i < star_.n_triangles; ++i)
    add_samples_of(star_.slots[static_cast<std::size_t>(i)]);
  n_own_samples_ = covered_.samples.size();
  own_cost_ = covered_.cost;
}

void EdgeCollapser::add_link_vertex(int at, std::uint32_t vertex) {
  const auto i = static_cast<std::size_t>(at);
  link_[i] = (positions_[vertex] - positions_[star_.vertex]) * scale_;
  const std::size_t n = state_.n_fields;
  for (std::size_t f = 0; f < n; ++f)
    covered_.link_values[i * n + f] = static_cast<float>(
        (values_[vertex * n + f] - values_[star_.vertex * n + f]) * state_.value_units[f]);
}

void EdgeCollapser::add_sample(std::uint32_t sample) {
  const std::size_t at = covered_.samples.size();
  covered_.samples.push_back(sample);
  if (covered_.x.size() <= at) {
    covered_.x.resize(2 * at + 1);
    covered_.y.resize(2 * at + 1);
    covered_.z.resize(2 * at + 1);
    covered_.values.resize((2 * at + 1) * state_.n_fields);
  }
  const Vec3d p = (state_.mesh.positions[sample] - positions_[star_.vertex]) * scale_;
  covered_.x[at] = static_cast<float>(p[0]);
  covered_.y[at] = static_cast<float>(p[1]);
  covered_.z[at] = static_cast<float>(p[2]);
  const std::size_t n = state_.n_fields;
  for (std::size_t f = 0; f < n; ++f)
    covered_.values[at * n + f] = static_cast<float>(
        (state_.sample(sample, f) - values_[star_.vertex * n + f]) * state_.value_units[f]);
  if (is_by_quadrics()) return;
  for (const float error : is_by_space() ? state_.distances_of(sample) : state_.errors_of(sample))
    covered_.cost += cost_of(static_cast<double>(error));
}

void EdgeCollapser::add_samples_of(std::uint32_t slot) {
  for (std::uint32_t s = samples_[slot]; s != kNone; s = state_.next_sample[s]) add_sample(s);
}

/// The other end's link after the star's. Expects link_places_ of the star.
bool EdgeCollapser::join_links() {
  edge_.n_link = star_.n_link;
  edge_.outside = star_.outside;
  for (int j = 0; j < other_.n_link; ++j) {
    const std::uint32_t v = other_.link[static_cast<std::size_t>(j)];
    int& at = joined_[static_cast<std::size_t>(j)];
    at = kNowhere;
    if (j == place_in_other_) continue;
    if (link_places_[v] != kNoPlace) {
      at = link_places_[v];
    } else {
      if (edge_.n_link == Star::kMaxLink) return false;
      at = edge_.n_link++;
      edge_.link[static_cast<std::size_t>(at)] = v;
      if (v == live_.outside())
        edge_.outside = at;
      else
        add_link_vertex(at, v);
    }
  }
  return true;
}

/// Those across from either end without the other.
void EdgeCollapser::join_triangles(int place) {
  std::size_t n = 0;
  for (int i = 0; i < star_.n_triangles; ++i) {
    if (star_.has(i, place)) continue;
    const auto at = static_cast<std::size_t>(i);
    edge_.triangles[n] = star_.triangles[at];
    edge_.slots[n++] = star_.slots[at];
  }
  for (int i = 0; i < other_.n_triangles && n < Star::kMaxTriangles; ++i) {
    if (other_.has(i, place_in_other_)) continue;
    const auto at = static_cast<std::size_t>(i);
    for (std::size_t k = 0; k < 3; ++k)
      edge_.triangles[n][k] = static_cast<std::uint8_t>(joined_[other_.triangles[at][k]]);
    edge_.slots[n++] = other_.slots[at];
    add_samples_of(other_.slots[at]);
  }
  edge_.n_triangles = static_cast<int>(n);
}

/// What is at the other end; false where it is too much.
bool EdgeCollapser::look_at_other(int place) {
  if (!gatherer_.gather(star_.link[static_cast<std::size_t>(place)], other_)) return false;
  place_in_other_ = 0;
  while (other_.link[static_cast<std::size_t>(place_in_other_)] != star_.vertex) ++place_in_other_;
  find_interfaces_of(other_, other_interfaces_);
  find_extrema(other_, other_extrema_);
  return true;
}

/// What choices are made from, and what a collapse needs; false where it is too much.
bool EdgeCollapser::look_at_edge(int place) {
  const std::uint32_t end = star_.link[static_cast<std::size_t>(place)];
  if (!look_at_other(place) || !join_links()) return false;
  covered_.samples.resize(n_own_samples_);
  covered_.cost = own_cost_;
  if (state_.is_reference[global(end)] != 0) add_sample(global(end));
  join_triangles(place);
  return edge_.n_triangles < Star::kMaxTriangles;
}

/// Tetrahedra at the edge, without those to the vertex outside.
int EdgeCollapser::n_cells_beside(int place) const {
  const std::uint64_t around = star_.adjacent[static_cast<std::size_t>(place)];
  const bool is_outer = star_.outside >= 0 && (around >> star_.outside & 1) != 0;
  return std::popcount(around) - (is_outer ? 2 : 0);
}

}  // namespace lode::tetra_mt::midpoint

#include "lode/models/tetra_mt/midpoint/state.h"

#include <algorithm>
#include <cmath>

#include "lode/models/tetra_mt/face_labels.h"

namespace lode::tetra_mt::midpoint {
namespace {

/// As for half edges: roundings of float32 positions, and a share of the mesh's size.
constexpr double kStepRoundings = 4;
constexpr double kRoundings = 64;
constexpr double kSizeShare = 1e-6;

}  // namespace

State::State(const TetraMesh& reference, CollapseOrder collapse_order, double tolerance)
    : mesh(reference),
      order(collapse_order),
      boundary_tolerance(tolerance),
      scales(reference),
      n_fields(reference.fields.size()),
      outside(static_cast<std::uint32_t>(reference.positions.size())),
      tetrahedra(reference.tetrahedra),
      next_sample(outside, kNone),
      sample_corners(outside, kAllCorners),
      positions(reference.positions),
      is_reference(outside, 1),
      errors(n_fields * outside, 0),
      keys(outside, 0),
      is_there(outside, 1),
      is_locked(outside, 0),
      distances(order == CollapseOrder::space_error ? errors.size() : 0, 0),
      quadrics(order == CollapseOrder::quadric ? errors.size() : 0),
      n_cells(tetrahedra.size()) {
  take_fields();
  if (positions.empty()) return;
  codes.reserve(outside);
  Vec3d lower = positions[0];
  Vec3d upper = lower;
  for (const Vec3d& p : positions) {
    codes.push_back(scales.code(p));
    for (std::size_t i = 0; i < 3; ++i) {
      lower[i] = std::min(lower[i], p[i]);
      upper[i] = std::max(upper[i], p[i]);
    }
  }
  Vec3d farthest;
  Vec3d steps;
  for (std::size_t i = 0; i < 3; ++i) {
    farthest[i] = std::max(std::abs(lower[i]), std::abs(upper[i]));
    steps[i] = scales.axes()[i].step();
  }
  const double rounding =
      length(steps) + (mesh.has_narrow_positions ? 0x1p-24 * length(farthest) : 0);
  centre = 0.5 * (lower + upper);
  if (const double diagonal = length(upper - lower); diagonal > 0) size = diagonal;
  step_limit = kStepRoundings * rounding;
  deviation_limit =
      std::max({tolerance, kRoundings * rounding, kSizeShare * length(upper - lower)});
}

void State::take_fields() {
  for (const MeshField& field : mesh.fields) {
    field_scales.push_back(scale_of(field.values));
    const auto [low, high] = std::ranges::minmax_element(field.values);
    const double range = field.values.empty() ? 0 : *high - *low;
    value_units.push_back(range > 0 ? 1 / range : 0);
  }
  values.reserve(n_fields * outside);
  value_codes.reserve(n_fields * outside);
  for (std::uint32_t v = 0; v < outside; ++v)
    for (std::size_t f = 0; f < n_fields; ++f) {
      values.push_back(sample(v, f));
      value_codes.push_back(field_scales[f].code(values.back()));
    }
}

Result<void> State::close(Threads threads) {
  LODE_CHECK(close_boundary(outside, tetrahedra, threads));
  first_sample.assign(tetrahedra.size(), kNone);
  corner_sets.assign(tetrahedra.size(), {});
  deviations.assign(tetrahedra.size(), 0);
  labels = labels_of(mesh, tetrahedra);
  return {};
}

double State::volume() const {
  double six_volumes = 0;
  for (std::size_t slot = 0; slot < mesh.tetrahedra.size(); ++slot) {
    const Tetrahedron& t = tetrahedra[slot];
    if (t[0] == kNone) continue;
    const Vec3d& at = positions[t[0]];
    six_volumes += dot(cross(positions[t[1]] - at, positions[t[2]] - at), positions[t[3]] - at);
  }
  return six_volumes / 6;
}

}  // namespace lode::tetra_mt::midpoint

#include "lode/models/tetra_mt/build_state.h"

#include <algorithm>
#include <cmath>

#include "lode/models/tetra_mt/face_labels.h"

namespace lode::tetra_mt {
namespace {

/// Roundings of positions, each of half a unit in the last place of a float32: those in a step that
/// count as none, and those that all steps may add up to.
constexpr double kStepRoundings = 4;
constexpr double kRoundings = 64;
/// And of the mesh's size.
constexpr double kSizeShare = 1e-6;

}  // namespace

BuildState::BuildState(const TetraMesh& reference, CollapseOrder order)
    : mesh(reference),
      outside(static_cast<std::uint32_t>(reference.positions.size())),
      tetrahedra(reference.tetrahedra),
      next_sample(outside, kNone),
      sample_corners(outside, kAllCorners),
      n_fields(reference.fields.size()),
      errors(n_fields * outside, 0),
      distances(order == CollapseOrder::space_error ? errors.size() : 0, 0),
      quadrics(order == CollapseOrder::quadric ? errors.size() : 0),
      keys(outside, 0),
      is_there(outside, 1),
      is_locked(outside, 0),
      n_cells(tetrahedra.size()) {
  for (const MeshField& field : reference.fields) {
    const auto [low, high] = std::ranges::minmax_element(field.values);
    const double range = field.values.empty() ? 0 : *high - *low;
    scales.push_back(range > 0 ? 1 / range : 0);
  }
}

Result<void> BuildState::close(Threads threads) {
  LODE_CHECK(close_boundary(outside, tetrahedra, threads));
  first_sample.assign(tetrahedra.size(), kNone);
  corner_sets.assign(tetrahedra.size(), {});
  deviations.assign(tetrahedra.size(), 0);
  makers.assign(tetrahedra.size(), kNone);
  labels = labels_of(mesh, tetrahedra);
  return {};
}

void BuildState::set_limits(double tolerance) {
  if (mesh.positions.empty()) return;
  Vec3d lower = mesh.positions[0];
  Vec3d upper = lower;
  for (const Vec3d& p : mesh.positions)
    for (std::size_t i = 0; i < 3; ++i) {
      lower[i] = std::min(lower[i], p[i]);
      upper[i] = std::max(upper[i], p[i]);
    }
  Vec3d farthest;
  for (std::size_t i = 0; i < 3; ++i)
    farthest[i] = std::max(std::abs(lower[i]), std::abs(upper[i]));
  centre = 0.5 * (lower + upper);
  if (const double diagonal = length(upper - lower); diagonal > 0) size = diagonal;
  const double rounding = mesh.has_narrow_positions ? 0x1p-24 * length(farthest) : 0;
  limits.step = std::max(tolerance, kStepRoundings * rounding);
  limits.total = std::max({tolerance, kRoundings * rounding, kSizeShare * length(upper - lower)});
  if (tolerance > 0) follow_boundary();
}

void BuildState::follow_boundary() {
  first_on_boundary.assign(tetrahedra.size(), kNone);
  next_on_boundary.assign(outside, kNone);
  boundary_edges.assign(outside, 0);
  for (std::size_t slot = mesh.tetrahedra.size(); slot < tetrahedra.size(); ++slot)
    for (const std::uint32_t a : tetrahedra[slot])
      for (const std::uint32_t b : tetrahedra[slot])
        if (a != outside && b != outside)
          boundary_edges[a] = std::max(
              boundary_edges[a], static_cast<float>(length(mesh.positions[b] - mesh.positions[a])));
}

double BuildState::volume() const {
  double six_volumes = 0;
  for (std::size_t slot = mesh.tetrahedra.size(); slot < tetrahedra.size(); ++slot) {
    const Tetrahedron& t = tetrahedra[slot];
    if (t[0] == kNone) continue;
    const auto place = static_cast<std::size_t>(std::ranges::find(t, outside) - t.begin());
    const auto face = others(t, place);
    const Vec3d& apex = mesh.positions[0];
    six_volumes += dot(cross(mesh.positions[face[0]] - apex, mesh.positions[face[1]] - apex),
                       mesh.positions[face[2]] - apex);
  }
  return -six_volumes / 6;
}

}  // namespace lode::tetra_mt

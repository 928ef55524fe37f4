// Midpoints with several fields: errors, extrema and orders of all of them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"
#include "lode/refine/one_shot.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/tetra/mesh_checks.h"
#include "tests/tetra/midpoint_checks.h"
#include "tests/tetra/midpoint_fixtures.h"

namespace lode::tetra_mt::midpoint {
namespace {

using oracles::Cut;
using oracles::noise_mesh;

/// What cells of a cut state of a field where a point is: the most of those that it is in, or on.
double stated_at(const Built& b, const MidpointCut& cut, const test::Tetrahedra& cells,
                 const Vec3d& p, std::size_t field) {
  constexpr double kOutside = 1e-5;
  double most = 0;
  for (const auto& t : cells) {
    bool is_near = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto at = [&](std::uint32_t v) { return b.vertices.positions[v][axis]; };
      const auto [low, high] = std::ranges::minmax(t, {}, at);
      is_near = is_near && at(low) - kOutside <= p[axis] && p[axis] <= at(high) + kOutside;
    }
    const std::uint32_t last = std::ranges::max(t);
    if (!is_near || b.hierarchy.is_leaf(last)) continue;
    if (test::locate(b.vertices, {t}, p, 0).least_weight < -kOutside) continue;
    const NodeId maker{last - b.hierarchy.n_vertices};
    most = std::max(most, static_cast<double>(cut.facts(maker, field).error));
  }
  return most;
}

/// Cuts of a tolerance of each field, whose errors hold for it, and those that cells state for all.
TEST(midpoint, has_errors_of_all_fields_that_a_search_finds) {
  const TetraMesh mesh = test::with_fields(noise_mesh(7, Cut::in_five, 3));
  const Built b = built(mesh, 60);
  const std::size_t n_fields = mesh.fields.size();
  std::vector<TetraMesh> vertices;
  for (std::size_t f = 0; f < n_fields; ++f) vertices.push_back(all_vertices(b.hierarchy, f));
  std::size_t n_coarse = 0;
  for (std::size_t measured = 0; measured < n_fields; ++measured) {
    const auto [low, high] = std::ranges::minmax(b.reference.fields[measured].values);
    for (const double share : {1.0, 0.1, 0.0}) {
      const double tolerance = share * (high - low);
      MidpointCut cut(b.forest, measured);
      static_cast<void>(
          one_shot(cut, Demand([=](const NodeFacts& facts) { return facts.error - tolerance; })));
      const auto cells = cut.cells();
      n_coarse += cells.size() < b.reference.tetrahedra.size() / 2 ? 1 : 0;
      for (std::size_t f = 0; f < n_fields; ++f) {
        const std::vector<double>& values = b.reference.fields[f].values;
        const auto [least, most] = std::ranges::minmax(values);
        for (std::uint32_t v = 0; v < values.size(); ++v) {
          const Vec3d& p = b.reference.positions[v];
          const double there = test::locate(vertices[f], cells, p, 0).value;
          const double stated = stated_at(b, cut, cells, p, f);
          // What is within kOutside of a cell may count for it; and the search itself rounds.
          EXPECT_LE(std::abs(there - values[v]),
                    stated + 1e-4 * (most - least) + 0x1p-50 * std::abs(values[v]));
          if (f == measured) EXPECT_LE(stated, tolerance);
        }
      }
    }
  }
  EXPECT_GE(n_coarse, n_fields);
}

TEST(midpoint, keeps_extrema_and_ranges_of_all_fields) {
  const TetraMesh mesh = test::with_fields(noise_mesh(9, Cut::in_six, 4));
  const Built b = built(mesh, 0);
  for (std::size_t f = 0; f < mesh.fields.size(); ++f) {
    const MidpointCut cut(b.forest, f);
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const auto& t : cut.cells())
      for (const std::uint32_t v : t) {
        low = std::min(low, cut.value(v));
        high = std::max(high, cut.value(v));
      }
    const auto [least, most] = std::ranges::minmax(mesh.fields[f].values);
    EXPECT_NEAR(low, least, 0x1p-29 * (most - least));
    EXPECT_NEAR(high, most, 0x1p-29 * (most - least));
  }
}

/// Of fields that are the same no one counts more, and others do not change what is there.
TEST(midpoint, orders_collapses_by_all_fields) {
  const TetraMesh one = noise_mesh(10, Cut::in_five, 3);
  TetraMesh twice = one;
  twice.fields.push_back(twice.fields[0]);
  for (double& value : twice.fields[1].values) value = 3 - 1024 * value;
  const EdgeCollapses a = collapsed(one, 150);
  const EdgeCollapses c = collapsed(twice, 150);
  // Rounding of the second may turn a choice here and there.
  EXPECT_NEAR(static_cast<double>(a.n_base_cells), static_cast<double>(c.n_base_cells), 15);
  const auto square = [](const EdgeCollapses& of, std::size_t n, std::size_t f) {
    double sum = 0;
    for (std::size_t i = f; i < of.errors.size(); i += n)
      sum += static_cast<double>(of.errors[i]) * static_cast<double>(of.errors[i]);
    return sum;
  };
  EXPECT_NEAR(square(c, 2, 0), square(c, 2, 1), 1e-3 * square(c, 2, 0));
  TetraMesh waves = test::with_fields(one);
  waves.fields.resize(2);
  const EdgeCollapses both = collapsed(waves, 150);
  TetraMesh alone = waves;
  alone.fields.erase(alone.fields.begin());
  const EdgeCollapses own = collapsed(alone, 150);
  EXPECT_LT(square(a, 1, 0), square(both, 2, 0));
  EXPECT_LT(square(own, 1, 0), square(both, 2, 1));
  // Far better than where the order does not look at it: smooth waves by the noise's order.
  EXPECT_LT(square(both, 2, 1), 8 * square(own, 1, 0));
}

}  // namespace
}  // namespace lode::tetra_mt::midpoint

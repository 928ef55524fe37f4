// What a cell states is true of every sample that it holds, in faces, edges and vertices, too: held
// against a search of its own, in meshes whose regions meet where no whole numbers lie.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lode/api/tetra_cut_source.h"
#include "lode/models/tetra_mt/half_edge.h"
#include "lode/models/tetra_mt/hierarchy.h"
#include "lode/models/tetra_mt/measured_fields.h"
#include "lode/models/tetra_mt/packed_hierarchy.h"
#include "tests/oracles/random.h"
#include "tests/tetra/midpoint_fixtures.h"
#include "tests/tetra/region_meshes.h"

namespace lode {
namespace {

using tetra_mt::PackedHierarchy;
using tetra_mt::midpoint::Forest;

/// A point seen by a tetrahedron.
struct Weights {
  std::array<double, 4> of_corners{};
  double rounding = 0;

  [[nodiscard]] double least() const { return std::ranges::min(of_corners); }
};

double volume(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  return dot(cross(b - a, c - a), d - a);
}

Weights weights_of(const Vec3d& p, const std::array<Vec3d, 4>& t) {
  const double all = volume(t[0], t[1], t[2], t[3]);
  double reach = 0;
  for (const Vec3d& corner : t)
    reach = std::max({reach, length(corner - t[0]), length(corner - p)});
  return {{volume(p, t[1], t[2], t[3]) / all, volume(t[0], p, t[2], t[3]) / all,
           volume(t[0], t[1], p, t[3]) / all, volume(t[0], t[1], t[2], p) / all},
          1e-15 * reach * reach * reach / std::abs(all)};
}

/// Cells by the boxes of a grid over [0, 1]^3 that they may reach into.
class Buckets {
 public:
  Buckets(const std::vector<Vec3d>& positions, const TetraCells& cells)
      : lists_(kSide * kSide * kSide) {
    for (std::uint32_t cell = 0; cell < cells.corners.size(); ++cell) {
      Vec3d lower{{1, 1, 1}};
      Vec3d upper;
      for (const std::uint32_t v : cells.corners[cell])
        for (std::size_t i = 0; i < 3; ++i) {
          lower[i] = std::min(lower[i], positions[v][i] - kReach);
          upper[i] = std::max(upper[i], positions[v][i] + kReach);
        }
      for (std::size_t x = step(lower[0]); x <= step(upper[0]); ++x)
        for (std::size_t y = step(lower[1]); y <= step(upper[1]); ++y)
          for (std::size_t z = step(lower[2]); z <= step(upper[2]); ++z)
            lists_[(x * kSide + y) * kSide + z].push_back(cell);
    }
  }
  [[nodiscard]] const std::vector<std::uint32_t>& at(const Vec3d& p) const {
    return lists_[(step(p[0]) * kSide + step(p[1])) * kSide + step(p[2])];
  }

 private:
  static constexpr std::size_t kSide = 12;
  static constexpr double kReach = 1e-7;

  static std::size_t step(double x) {
    return static_cast<std::size_t>(std::clamp(x, 0.0, 0.9999) * kSide);
  }

  std::vector<std::vector<std::uint32_t>> lists_;
};

struct Findings {
  std::size_t n_holders = 0;  ///< Pairs of a sample and a cell that holds it.
  std::size_t n_shared = 0;   ///< Of them those of samples that others hold, too.
  std::size_t n_above = 0;    ///< |F - F'| above what the cell states.
  std::size_t n_out_of_range = 0;
  double most_above = 0;
};

/// Every sample of the cut, in every cell that holds it or misses it by a rounding.
void look_at(const TetraVertices& vertices, const TetraCells& cells, Findings& found) {
  constexpr double kSlack = 1e-9;
  const Buckets buckets(vertices.positions, cells);
  std::vector<bool> is_there(vertices.positions.size(), false);
  for (const auto& t : cells.corners)
    for (const std::uint32_t v : t) is_there[v] = true;
  for (const std::uint32_t sample : vertices.samples) {
    if (is_there[sample]) continue;
    const double value = vertices.values[sample];
    std::size_t n = 0;
    for (const std::uint32_t cell : buckets.at(vertices.positions[sample])) {
      std::array<Vec3d, 4> corners;
      std::array<double, 4> rises{};
      for (std::size_t k = 0; k < 4; ++k) {
        corners[k] = vertices.positions[cells.corners[cell][k]];
        rises[k] = vertices.values[cells.corners[cell][k]] - value;
      }
      const Weights weights = weights_of(vertices.positions[sample], corners);
      if (!(weights.least() >= -kSlack)) continue;
      ++n;
      double error = 0;
      for (std::size_t k = 0; k < 4; ++k) error += weights.of_corners[k] * rises[k];
      const auto [low, high] = std::ranges::minmax(rises);
      const double slack = 4 * (kSlack + weights.rounding) * (high - low);
      const StatedFacts& stated = cells.stated[cell];
      const double above = std::abs(error) - stated.error;
      found.n_above += above > slack ? 1 : 0;
      found.most_above = std::max(found.most_above, above);
      found.n_out_of_range += stated.range.low <= value && value <= stated.range.high ? 0 : 1;
    }
    found.n_holders += n;
    found.n_shared += n > 1 ? n : 0;
  }
}

/// Cuts of tolerances, and of nodes at random.
Findings findings_of(const TetraCutSource& source, const std::function<void(TetraCells&)>& state) {
  Findings found;
  auto vertices = source.vertices();
  EXPECT_TRUE(vertices);
  EXPECT_TRUE(source.take_values(0, *vertices));
  const auto look = [&](TetraCells cells) {
    state(cells);
    look_at(*vertices, cells, found);
  };
  Progress progress;
  const double base_error = source.info().fields[0].base_error;
  for (const double share : {1.0, 0.5, 0.3, 0.1, 0.03}) {
    auto refined =
        source.refined(0, share < 1 ? std::optional(share * base_error) : std::nullopt, progress);
    EXPECT_TRUE(refined) << refined.error().message;
    look(std::move(refined->cells));
  }
  const auto n_nodes = static_cast<std::uint32_t>(source.info().n_nodes);
  for (const std::uint32_t n : {n_nodes / 100, n_nodes / 20, n_nodes / 6}) {
    auto cells = source.random(n, n);
    EXPECT_TRUE(cells);
    look(std::move(*cells));
  }
  return found;
}

Findings findings_of(const TetraCutSource& source) {
  return findings_of(source, [&](TetraCells& cells) { EXPECT_TRUE(source.state(0, cells)); });
}

void expect_true(const Findings& found, const std::string& what) {
  EXPECT_GT(found.n_shared, 100U) << what;
  EXPECT_EQ(found.n_above, 0U) << what << ": by up to " << found.most_above << ", of "
                               << found.n_holders;
  EXPECT_EQ(found.n_out_of_range, 0U) << what << ", of " << found.n_holders;
}

/// Regions in blocks of cells of a grid of n an axis, and values of waves, or of noise.
TetraMesh mesh_of(int n, std::uint32_t n_regions, int block, std::uint64_t seed) {
  TetraMesh mesh = test::random_regions(n, n_regions, block, seed);
  mesh.has_narrow_positions = false;
  if (seed % 3 == 0) return mesh;
  oracles::Random random(seed);
  const double a = random.uniform(3, 8);
  const double b = random.uniform(3, 8);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3d& p = mesh.positions[v];
    mesh.fields[0].values[v] = std::sin(a * p[0]) * std::cos(b * p[1]) + p[2] * p[2];
  }
  return mesh;
}

/// Thirds, sevenths, elevenths: 31 bits hold none of them.
std::vector<TetraMesh> meshes() {
  std::vector<TetraMesh> all;
  std::uint64_t seed = 0;
  for (const int n : {6, 7, 9, 11, 12, 14})
    for (const int block : {n / 3, (n + 1) / 2}) {
      ++seed;
      all.push_back(mesh_of(n, 2 + static_cast<std::uint32_t>(seed % 4), block, seed));
    }
  return all;
}

std::uint64_t base_cells_of(const TetraMesh& mesh) { return mesh.tetrahedra.size() / 50; }

tetra_mt::Hierarchy half_edges_of(const TetraMesh& mesh) {
  Progress progress;
  const auto collapses = tetra_mt::collapse_half_edges(
      mesh, {.base_cells = base_cells_of(mesh), .rules = {}, .threads = {2}}, progress);
  EXPECT_TRUE(collapses);
  auto hierarchy = tetra_mt::make_hierarchy(mesh, *collapses, {2});
  EXPECT_TRUE(hierarchy);
  return std::move(*hierarchy);
}

PackedHierarchy packed(const tetra_mt::Hierarchy& hierarchy, const TetraMesh& mesh) {
  return PackedHierarchy::pack(hierarchy, mesh.tetrahedra.size(), {2});
}

TEST(held_samples, of_midpoints_are_within_what_each_cell_states) {
  const std::vector<TetraMesh> all = meshes();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Forest forest(test::midpoints_of(all[i], base_cells_of(all[i])));
    expect_true(findings_of(*source_of(forest)), "mesh " + std::to_string(i));
  }
}

TEST(held_samples, of_half_edges_are_within_what_each_cell_states) {
  const std::vector<TetraMesh> all = meshes();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const PackedHierarchy hierarchy = packed(half_edges_of(all[i]), all[i]);
    expect_true(findings_of(*source_of(hierarchy)), "mesh " + std::to_string(i));
  }
}

TEST(held_samples, of_fields_attached_to_half_edges_are_within_what_each_cell_states) {
  for (const std::size_t i : {0U, 5U, 10U}) {
    const TetraMesh mesh = meshes()[i];
    const tetra_mt::Hierarchy made = half_edges_of(mesh);
    const PackedHierarchy hierarchy = packed(made, mesh);
    Progress progress;
    const auto fields = measure_fields(hierarchy, made.mesh_vertices, mesh, progress);
    ASSERT_TRUE(fields) << fields.error().message;
    const tetra_mt::NumberedField& field = fields->front();
    const auto state = [&](TetraCells& cells) {
      cells.stated.assign(cells.makers.size(), {});
      for (std::size_t k = 0; k < cells.makers.size(); ++k) {
        if (cells.makers[k] == tetra_mt::kNone) continue;
        const auto& facts = field.facts[cells.makers[k]];
        cells.stated[k] = {static_cast<double>(facts.error),
                           {field.range_reference + static_cast<double>(facts.low),
                            field.range_reference + static_cast<double>(facts.high)}};
      }
    };
    expect_true(findings_of(*source_of(hierarchy), state), "mesh " + std::to_string(i));
  }
}

TEST(held_samples, of_meshes_without_regions_are_within_what_each_cell_states) {
  for (const auto cut : {oracles::Cut::in_five, oracles::Cut::in_six}) {
    const TetraMesh mesh = oracles::noise_mesh(12, cut, 5);
    const Forest forest(test::midpoints_of(mesh, base_cells_of(mesh)));
    expect_true(findings_of(*source_of(forest)), "midpoints");
    const PackedHierarchy hierarchy = packed(half_edges_of(mesh), mesh);
    expect_true(findings_of(*source_of(hierarchy)), "half edges");
  }
}

}  // namespace
}  // namespace lode

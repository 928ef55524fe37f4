#pragma once

// The model of tetrahedral meshes as the contract tests see it.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lode/models/tetra_mt/half_edge.h"
#include "lode/models/tetra_mt/persist.h"
#include "lode/models/tetra_mt/tetra_cut.h"
#include "lode/refine/cut.h"
#include "tests/contract/mesh.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::test {

class TetraContract {
 public:
  static constexpr int kDimension = 3;
  /// A node may be needed that has less error than any that needs it.
  static constexpr bool kIsNestedAlongParents = false;

  static TetraContract make(std::uint32_t seed, Threads threads) {
    Progress progress;
    const TetraMesh mesh = holed_cube(seed);
    const auto collapses = tetra_mt::collapse_half_edges(
        mesh, {.base_cells = 60, .rules = {}, .threads = threads}, progress);
    auto hierarchy = tetra_mt::make_hierarchy(mesh, *collapses, threads);
    auto packed = tetra_mt::PackedHierarchy::pack(*hierarchy, mesh.tetrahedra.size(), threads);
    return {std::make_shared<const tetra_mt::Hierarchy>(std::move(*hierarchy)), std::move(packed)};
  }

  Result<void> save(const std::string& path) const {
    Progress progress;
    const auto gradients = [&](std::size_t) {
      return std::vector<std::uint32_t>(hierarchy_->positions.size());
    };
    LODE_CHECK(
        tetra_mt::save(*hierarchy_, packed_->head().n_cells, gradients, path, {2}, progress));
    return {};
  }
  /// With all pages, so that whatever is wrong with the file is found here.
  static Result<TetraContract> open(const std::string& path) {
    LODE_TRY(auto opened, tetra_mt::open(path));
    for (std::uint32_t node = 0; node < opened.hierarchy.head().shape.n_nodes; ++node) {
      static_cast<void>(opened.hierarchy.links(node));
      static_cast<void>(opened.hierarchy.facts(node, kField));
    }
    LODE_CHECK(opened.hierarchy.check());
    return TetraContract({}, std::move(opened.hierarchy));
  }

  [[nodiscard]] tetra_mt::TetraCut refinable() const {
    return tetra_mt::TetraCut(*packed_, kField);
  }

  /// The mesh of the cut that the model stands at.
  [[nodiscard]] Mesh mesh(const tetra_mt::TetraCut& opened, const Cut& /*cut*/) const {
    Mesh mesh{kDimension, {}};
    for (const auto& t : opened.cells()) {
      Mesh::Cell cell;
      for (const std::uint32_t v : t) cell.push_back(vertex(v));
      mesh.cells.push_back(cell);
    }
    return mesh;
  }

  /// Whether a face may belong to one cell only: it lies on a side of the cube, or of the cavity.
  [[nodiscard]] static bool may_end_at(const std::vector<MeshVertex>& face) {
    const auto all = [&](const auto& holds) {
      return std::all_of(face.begin(), face.end(), holds);
    };
    const bool is_at_cavity = all([](const MeshVertex& v) {
      return std::all_of(v.position.begin(), v.position.end(),
                         [](double x) { return x >= kCavityBegin && x <= kCavityEnd; });
    });
    for (std::size_t i = 0; i < 3; ++i) {
      const auto is_at = [&](double x) {
        return all([&](const MeshVertex& v) { return v.position[i] == x; });
      };
      if (is_at(0) || is_at(kEnd)) return true;
      if (is_at_cavity && (is_at(kCavityBegin) || is_at(kCavityEnd))) return true;
    }
    return false;
  }

  /// The vertices of the reference mesh.
  [[nodiscard]] std::vector<MeshVertex> samples() const {
    std::vector<MeshVertex> result;
    for (std::uint32_t v = 0; v < packed_->head().n_vertices(); ++v) result.push_back(vertex(v));
    return result;
  }

  /// Noise from 0 to 125 in a cube with a cavity, behind another field.
  static TetraMesh holed_cube(std::uint32_t seed) {
    TetraMesh mesh = oracles::noise_mesh(kSteps + 1, oracles::Cut::in_five, seed);
    for (Vec3d& p : mesh.positions)
      for (double& x : p.v) x = std::round(x * kSteps) * kStep;
    mesh.has_narrow_positions = true;
    auto& values = mesh.fields[0].values;
    const auto [low, high] = std::ranges::minmax(values);
    for (double& value : values) value = (value - low) / (high - low) * 125;
    std::erase_if(mesh.tetrahedra, [&](const auto& t) {
      for (std::size_t i = 0; i < 3; ++i) {
        double middle = 0;
        for (const std::uint32_t v : t) middle += mesh.positions[v][i] / 4;
        if (middle < kCavityBegin || middle > kCavityEnd) return false;
      }
      return true;
    });
    mesh.fields.insert(mesh.fields.begin(), mesh.fields[0]);
    for (double& value : mesh.fields[0].values) value = std::sin(value / 9);
    mesh.fields[0].name = "other";
    return mesh;
  }

 private:
  static constexpr std::size_t kField = 1;
  static constexpr int kSteps = 6;
  static constexpr double kStep = 3;
  static constexpr double kEnd = kSteps * kStep;
  static constexpr double kCavityBegin = 2 * kStep;
  static constexpr double kCavityEnd = 4 * kStep;

  TetraContract(std::shared_ptr<const tetra_mt::Hierarchy> hierarchy,
                tetra_mt::PackedHierarchy packed)
      : hierarchy_(std::move(hierarchy)),
        packed_(std::make_unique<const tetra_mt::PackedHierarchy>(std::move(packed))) {}

  [[nodiscard]] MeshVertex vertex(std::uint32_t v) const {
    return {packed_->position(v).v, packed_->value(v, kField)};
  }

  std::shared_ptr<const tetra_mt::Hierarchy> hierarchy_;  ///< None of a file's.
  std::unique_ptr<const tetra_mt::PackedHierarchy> packed_;
};

}  // namespace lode::test

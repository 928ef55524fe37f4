#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>

#include "lode/core/tetra_mesh.h"
#include "tests/tetra/mesh_checks.h"

namespace lode::test {

/// What is counted of a complex, of whatever dimension.
struct Topology {
  int euler = 0;         ///< Euler characteristic.
  int n_components = 0;  ///< Joined by anything.
  int n_pieces = 0;      ///< Joined by simplices of one dimension less than the largest.
  int n_ends =
      0;  ///< Of curves: vertices of other than two edges. Of sheets: components of such edges.

  friend bool operator==(const Topology&, const Topology&) = default;
};

/// All that regions are told apart by: what each is, what lies between each two (kOutside is one,
/// and less by as much each patch of the boundary is its own), all faces between regions together,
/// and the curves in which these, or patches, meet.
struct Regions {
  static constexpr std::uint32_t kOutside = 0xFFFFFFFFU;

  std::map<std::uint32_t, Topology> solids;
  std::map<std::uint32_t, double> volumes;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Topology> sheets;
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> areas;
  Topology all_sheets;
  Topology curves;
};

/// By corners, ascending: one more than a patch's place. Of other faces 0.
using PatchMarks = std::map<std::vector<std::uint32_t>, std::uint32_t>;

/// By brute force, of tetrahedra with a region each, and the patches of their boundary.
[[nodiscard]] Regions describe_regions(const TetraMesh& mesh, const Tetrahedra& tetrahedra,
                                       std::span<const std::uint32_t> regions,
                                       const PatchMarks& patches = {});

/// The same regions, topologically, of volumes and areas that differ by no more than a share.
void expect_same_regions(const Regions& a, const Regions& b, double share);

}  // namespace lode::test

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/tetra_mt/packed_hierarchy.h"

namespace lode::tetra_mt {

/// What was looked at, how much of that is wrong, and the first that is.
struct StructureFinding {
  std::uint64_t n_checked = 0;
  std::uint64_t n_wrong = 0;
  std::string first;

  void add(bool is_right, const std::string& what) {
    ++n_checked;
    if (!is_right && n_wrong++ == 0) first = what;
  }
};

/// Of a hierarchy's nodes.
struct StructureFindings {
  StructureFinding discovery;  ///< Each is discovered once, from those without parents on.
  StructureFinding links;      ///< Its parents have it as a child, and its children as a parent.
  StructureFinding nesting;    ///< Error, range and box hold those of all that it discovers.
  /// All applied in a random order give as many cells as are said, and undone in another the base.
  StructureFinding refinement;
  /// Of several regions: its mask has those that it and all that it discovers bring, and no others.
  StructureFinding regions;

  [[nodiscard]] bool is_sound() const {
    return discovery.n_wrong + links.n_wrong + nesting.n_wrong + refinement.n_wrong +
               regions.n_wrong ==
           0;
  }
};

/// The same for the same cells, in whatever order and with whatever corner first.
[[nodiscard]] std::vector<Tetrahedron> sorted_cells(std::vector<Tetrahedron> cells);

/// Looks at every node. Where links do not fit together nothing is applied. Fails where pages
/// cannot be loaded, or when cancelled. About 4 microseconds a node, on one thread.
[[nodiscard]] Result<StructureFindings> check_structure(const PackedHierarchy& hierarchy,
                                                        std::uint64_t seed, Progress& progress);

}  // namespace lode::tetra_mt

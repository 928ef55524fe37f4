#pragma once

#include <string>

#include "bench/papers/table.h"
#include "bench/papers/tetra_data.h"
#include "lode/core/result.h"

namespace lode::bench {

/// What the text of Cignoni, De Floriani, Magillo, Puppo, Scopigno (2004) says beside its tables:
/// how much a hierarchy takes (sections 5 and 9), and meshes that are fine about two isosurfaces
/// (figure 7), in a box that is moved (figures 8 and 9) and along a plane (figure 10).
class TetraProse {
 public:
  /// Fails where a file cannot be written or read.
  [[nodiscard]] Result<void> add(const TetraData& data);
  [[nodiscard]] Result<void> publish(const std::string& directory) const;

 private:
  [[nodiscard]] Result<void> add_storage(const TetraData& data);
  void add_places(const TetraData& data);

  Table storage_{"tetra_storage",
                 "Storage, bytes a vertex: the mesh with its neighbours (32 a tetrahedron, 16 a "
                 "vertex), hierarchies in memory, and files",
                 {{"data", "data set"},
                  {"mesh", "mesh with neighbours"},
                  {"node", "a node in memory, half edges"},
                  {"memory", "with the base, a vertex"},
                  {"smaller", "times smaller"},
                  {"file", "file"},
                  {"bare", "without gradients and the mesh's numbers"},
                  {"midpoints", "midpoints: file"}},
                 {}};
  Table places_{"tetra_places",
                "Meshes that are fine in places, one thread: from the base, and then moved",
                {{"data", "data set"},
                 {"query", "query"},
                 {"error", "error, % of the range"},
                 {"tetrahedra", "tetrahedra"},
                 {"share", "% of them"},
                 {"reached", "error reached, %"},
                 {"updates", "updates"},
                 {"ms", "ms"},
                 {"moved", "moved: updates"},
                 {"moved_ms", "ms"}},
                {}};
};

}  // namespace lode::bench

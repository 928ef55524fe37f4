#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "lode/models/diamond/lattice_field.h"
#include "lode/models/diamond/node_set.h"

namespace lode {
template <int D>
struct StitchPart;
}

namespace lode::diamond {

/// Regions of either side of an isovalue (samples that edges of the mesh of full resolution join)
/// without a sample farther from it than a persistence. A cut's surface that has them all can do
/// without the pieces round them: it then is that of a field which has these samples on the other
/// side, and is within the persistence, too. docs/models/diamond3d.md, "The topology kept".
struct WeakRegions {
  std::optional<NodeSet<3>> samples;  ///< On the other side; nothing: none are.
  std::uint64_t n = 0;                ///< How many regions fewer there are.
};

/// Of each isovalue that has some.
using WeakSamples = std::map<double, NodeSet<3>>;

/// Takes those of a part's vertices, and their triangles, away that are on edges of which just one
/// end is such a sample: all of the pieces round the regions.
void leave_out(const NodeSet<3>& samples, const AxisMap<3>& axes, StitchPart<3>& part);

}  // namespace lode::diamond

#include "lode/mappers/surface_near.h"

namespace lode {

std::vector<Facet> facets_of(const Surface& surface) {
  std::vector<Facet> facets(surface.triangles.size());
  for (std::size_t t = 0; t < facets.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i)
      facets[t].corner[i] = surface.positions[surface.triangles[t][i]];
  return facets;
}

}  // namespace lode

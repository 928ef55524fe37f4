// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), section 8: data structures for Delaunay pyramids.
#include "lode/models/terrain/delaunay_pyramid/pyramid.h"

#include <algorithm>
#include <numeric>

#include "lode/delaunay/tin_links.h"
#include "lode/delaunay/triangle_error.h"
#include "lode/mappers/tin_quality.h"
#include "lode/models/terrain/insertions/extract.h"

namespace lode::delaunay_pyramid {

std::uint64_t PyramidHead::n_all_links() const {
  return std::accumulate(n_links.begin(), n_links.end(), std::uint64_t{0});
}

std::uint64_t PyramidHead::n_all_kept() const {
  return std::accumulate(n_kept.begin(), n_kept.end(), std::uint64_t{0});
}

float PyramidHead::most_stated(std::size_t level) const {
  return delaunay::to_coarse_above(delaunay::to_float_above(tolerances[level]));
}

PyramidBytes PyramidHead::bytes() const {
  constexpr std::uint64_t kCorners = 3 * sizeof(std::uint32_t);
  const std::uint64_t n = n_all_kept();
  PyramidBytes bytes;
  bytes.vertices = vertices_until.back() * (sizeof(delaunay::LatticePoint) + sizeof(double)) +
                   std::uint64_t{n_lines} * 2 * sizeof(std::uint32_t);
  bytes.triangles = n * (kCorners + sizeof(float) + (is_of_lists() ? sizeof(std::uint32_t) : 0));
  bytes.neighbours = is_of_lists() ? 0 : n * kCorners;
  if (has_links(encoding))
    bytes.links = (n + n_levels()) * sizeof(std::uint64_t) + n_all_links() * sizeof(std::uint32_t);
  return bytes;
}

delaunay::Tin numbered_mesh(const Pyramid& pyramid, std::size_t level) {
  delaunay::Tin mesh;
  if (!pyramid.head.is_of_lists()) {
    mesh.triangles = pyramid.levels[level].triangles;
    mesh.errors = pyramid.levels[level].errors;
    return mesh;
  }
  mesh.triangles.reserve(pyramid.head.n_in_mesh[level]);
  mesh.errors.reserve(pyramid.head.n_in_mesh[level]);
  for (std::size_t made = 0; made <= level; ++made) {
    const PyramidLevel& list = pyramid.levels[made];
    for (std::size_t t = 0; t < list.triangles.size(); ++t) {
      if (list.deaths[t] <= level) continue;
      mesh.triangles.push_back(list.triangles[t]);
      mesh.errors.push_back(list.errors[t]);
    }
  }
  return mesh;
}

MeshFacts facts_of(const Pyramid& pyramid, const delaunay::Tin& mesh) {
  delaunay::Tin placed;
  placed.triangles = mesh.triangles;
  insertions::place_vertices(pyramid.vertices, pyramid.heights, placed);
  const TinAngles angles = measure_angles(placed, pyramid.head.source.frame, {});
  const float largest = *std::ranges::max_element(mesh.errors);
  return {static_cast<double>(largest), angles.smallest, angles.median};
}

delaunay::Tin tin_of_level(const Pyramid& pyramid, std::size_t level, delaunay::TinLinks links) {
  delaunay::Tin tin = numbered_mesh(pyramid, level);
  if (links == delaunay::TinLinks::left_out)
    tin.errors.clear();
  else
    tin.twins = pyramid.head.is_of_lists() ? delaunay::find_twins(tin.triangles)
                                           : pyramid.levels[level].twins;
  insertions::place_vertices(pyramid.vertices, pyramid.heights, tin);
  return tin;
}

}  // namespace lode::delaunay_pyramid

#include "lode/api/tetra_info.h"

#include <utility>

#include "lode/core/mesh.h"
#include "lode/mappers/mesh_gradients.h"
#include "lode/models/tetra_mt/gradient_codes.h"

namespace lode {
namespace {

std::vector<MeshRegion> regions_of(std::span<const std::int64_t> ids,
                                   std::span<const std::string> names) {
  std::vector<MeshRegion> regions;
  for (std::size_t i = 0; i < ids.size(); ++i)
    regions.push_back({ids[i], names.empty() ? std::string() : names[i]});
  return regions;
}

}  // namespace

std::vector<MeshRegion> named_regions(std::span<const std::int64_t> ids,
                                      std::span<const std::string> names) {
  std::vector<MeshRegion> regions = regions_of(ids, names);
  std::erase_if(regions, [](const MeshRegion& region) { return region.name.empty(); });
  return regions;
}

TetraInfo info_of(const tetra_mt::midpoint::ForestHead& head) {
  std::vector<TetraFieldInfo> fields;
  for (const tetra_mt::midpoint::ForestField& field : head.fields)
    fields.push_back({field.name, field.type, field.low, field.high, ErrorPlace::at_samples,
                      field.base_error, field.time, field.base_world_error});
  return {.placement = Placement::midpoint,
          .n_vertices = head.n_vertices,
          .n_cells = head.n_cells,
          .n_base_cells = head.n_base_cells,
          .n_nodes = head.n_nodes(),
          .fields = std::move(fields),
          .bounds = head.box,
          .boundary_deviation = head.boundary_deviation,
          .record = head.record,
          .regions = regions_of(head.region_ids, head.region_names),
          .patches = head.patches};
}

std::vector<std::uint32_t> gradient_codes(const TetraMesh& mesh, std::size_t field,
                                          std::span<const std::uint32_t> vertices,
                                          Threads threads) {
  SimplexMesh all;
  all.positions = mesh.positions;
  all.values = mesh.fields[field].values;
  all.tetrahedra = mesh.tetrahedra;
  const std::vector<Vec3f> gradients = vertex_gradients(all, threads);
  std::vector<std::uint32_t> codes(vertices.size());
  parallel_for(codes.size(), threads, tetra_mt::kPageNodes, [&](std::size_t v, int) {
    codes[v] = tetra_mt::gradient_code(gradients[vertices[v]]);
  });
  return codes;
}

TetraInfo info_of(const tetra_mt::HierarchyHead& head) {
  std::vector<TetraFieldInfo> fields;
  for (const tetra_mt::HierarchyHead::Field& field : head.fields)
    fields.push_back({field.name, field.type, field.low, field.high,
                      field.has_errors_everywhere ? ErrorPlace::everywhere : ErrorPlace::at_samples,
                      field.base_error, field.time, field.base_world_error});
  return {.n_vertices = head.n_vertices(),
          .n_cells = head.n_cells,
          .n_base_cells = head.n_base_cells,
          .n_nodes = head.shape.n_nodes,
          .fields = std::move(fields),
          .bounds = {head.lower, head.upper},
          .boundary_deviation = head.boundary_deviation,
          .record = head.record,
          .regions = regions_of(head.region_ids, head.region_names),
          .patches = head.patches};
}

}  // namespace lode

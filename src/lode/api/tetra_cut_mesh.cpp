#include "lode/api/tetra_cut_mesh.h"

#include <algorithm>
#include <functional>

namespace lode {
namespace {

using tetra_mt::HierarchyHead;
using tetra_mt::kNone;
using tetra_mt::PackedHierarchy;
using tetra_mt::TetraCut;

/// Slots of the cells of a cut by their last vertex: as vertices are numbered along a curve in
/// space, cells that are near come near, whatever the order in which they were made.
std::vector<std::uint32_t> sorted_cells(const TetraCut& cut, std::uint32_t n_vertices) {
  std::vector<std::uint32_t> begins(std::size_t{n_vertices} + 1, 0);
  for (const TetraCut::Cell& cell : cut.slots())
    if (cut.is_inside(cell)) ++begins[std::ranges::max(cell.corners) + std::size_t{1}];
  for (std::size_t v = 1; v < begins.size(); ++v) begins[v] += begins[v - 1];
  std::vector<std::uint32_t> slots(begins.back());
  for (std::uint32_t slot = 0; slot < cut.slots().size(); ++slot) {
    const TetraCut::Cell& cell = cut.slots()[slot];
    if (cut.is_inside(cell)) slots[begins[std::ranges::max(cell.corners)]++] = slot;
  }
  return slots;
}

}  // namespace

std::vector<std::uint32_t> fill_mesh(const PackedHierarchy& hierarchy, const TetraFieldUse& fields,
                                     const TetraCut& cut, SimplexMesh& mesh) {
  mesh = {};
  std::vector<std::uint32_t> vertex_ids;
  std::vector<std::uint32_t> numbers(hierarchy.head().n_vertices(), kNone);
  const std::vector<HierarchyHead::Field>& heads = hierarchy.head().fields;
  for (const std::size_t field : fields.along)
    mesh.attributes.push_back({heads[field].name, heads[field].has_narrow_values, {}});
  const auto error_of = [&](const TetraCut::Cell& cell, std::size_t field) {
    return cell.maker == kNone ? 0.0F : hierarchy.facts(cell.maker, field).error;
  };
  for (const std::uint32_t slot : sorted_cells(cut, hierarchy.head().n_vertices())) {
    const TetraCut::Cell& cell = cut.slots()[slot];
    mesh.tetrahedra.push_back(cell.corners);
    mesh.errors.push_back(error_of(cell, fields.measured));
    for (std::size_t i = 0; i < fields.along.size(); ++i)
      mesh.attributes[i].errors.push_back(error_of(cell, fields.along[i]));
    if (hierarchy.head().shape.n_regions > 1)
      mesh.regions.push_back(hierarchy.head().region_ids[cell.region]);
    for (const std::uint32_t v : cell.corners) numbers[v] = 0;
  }
  for (std::uint32_t v = 0; v < numbers.size(); ++v) {
    if (numbers[v] == kNone) continue;
    numbers[v] = static_cast<std::uint32_t>(vertex_ids.size());
    vertex_ids.push_back(v);
    mesh.positions.push_back(hierarchy.position(v));
    mesh.values.push_back(hierarchy.value(v, fields.measured));
  }
  for (auto& t : mesh.tetrahedra)
    for (std::uint32_t& v : t) v = numbers[v];
  mesh.has_narrow_values = heads[fields.measured].has_narrow_values;
  for (std::size_t i = 0; i < fields.along.size(); ++i) {
    Attribute& attribute = mesh.attributes[i];
    for (const std::uint32_t v : vertex_ids)
      attribute.values.push_back(hierarchy.value(v, fields.along[i]));
    for (const float error : attribute.errors)
      attribute.error = std::max(attribute.error, static_cast<double>(error));
  }
  return vertex_ids;
}

std::vector<std::uint32_t> fill_mesh(const tetra_mt::midpoint::MidpointCut& cut,
                                     SimplexMesh& mesh) {
  const tetra_mt::midpoint::Hierarchy& hierarchy = cut.hierarchy();
  mesh = {};
  std::vector<std::uint32_t> slots;
  for (std::uint32_t slot = 0; slot < cut.slots().size(); ++slot)
    if (cut.is_inside(cut.slots()[slot])) slots.push_back(slot);
  std::ranges::sort(slots, {}, [&](std::uint32_t slot) {
    tetra_mt::Tetrahedron corners = cut.slots()[slot].corners;
    std::ranges::sort(corners, std::greater());
    return corners;
  });
  std::vector<std::uint32_t> numbers(hierarchy.n_labels(), kNone);
  for (const std::uint32_t slot : slots) {
    const auto& cell = cut.slots()[slot];
    const std::uint32_t maker = cut.maker(cell);
    mesh.tetrahedra.push_back(cell.corners);
    mesh.errors.push_back(maker == kNone ? 0 : cut.facts(NodeId{maker}).error);
    if (hierarchy.region_ids.size() > 1) mesh.regions.push_back(hierarchy.region_ids[cell.region]);
    for (const std::uint32_t v : cell.corners) numbers[v] = 0;
  }
  std::vector<std::uint32_t> labels;
  for (std::uint32_t label = 0; label < numbers.size(); ++label) {
    if (numbers[label] == kNone) continue;
    numbers[label] = static_cast<std::uint32_t>(labels.size());
    labels.push_back(label);
    mesh.positions.push_back(cut.position(label));
    mesh.values.push_back(cut.value(label));
  }
  for (auto& t : mesh.tetrahedra)
    for (std::uint32_t& v : t) v = numbers[v];
  return labels;
}

}  // namespace lode

#include "lode/api/tetra_cut_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <span>
#include <utility>

#include "lode/api/tetra_info.h"
#include "lode/models/tetra_mt/space_curve.h"

namespace lode {
namespace {

using tetra_mt::FaceKey;
using tetra_mt::HierarchyHead;
using tetra_mt::kNone;
using tetra_mt::PackedHierarchy;
using tetra_mt::SpaceCurve;
using tetra_mt::TetraCut;

/// Vertices that cells of a cut have, along a curve in space. The hierarchy has them along that one
/// in a few bands, which are merged.
std::vector<std::uint32_t> sorted_vertices(const PackedHierarchy& hierarchy, const TetraCut& cut) {
  std::vector<std::uint8_t> is_used(hierarchy.head().n_vertices(), 0);
  for (const TetraCut::Cell& cell : cut.slots())
    if (cut.is_inside(cell))
      for (const std::uint32_t v : cell.corners) is_used[v] = 1;
  struct Placed {
    std::uint64_t place;
    std::uint32_t vertex;
  };
  const SpaceCurve curve(std::array{hierarchy.head().lower, hierarchy.head().upper});
  std::vector<Placed> placed;
  std::vector<std::size_t> begins;  // of bands, and the end
  for (std::uint32_t v = 0; v < is_used.size(); ++v) {
    if (is_used[v] == 0) continue;
    const std::uint64_t place = curve(hierarchy.position(v));
    if (placed.empty() || place < placed.back().place) begins.push_back(placed.size());
    placed.push_back({place, v});
  }
  begins.push_back(placed.size());
  const auto at = [&](std::size_t band) {
    return placed.begin() + static_cast<std::ptrdiff_t>(begins[std::min(band, begins.size() - 1)]);
  };
  for (std::size_t step = 1; step + 1 < begins.size(); step *= 2)
    for (std::size_t band = 0; band + step < begins.size(); band += 2 * step)
      std::inplace_merge(at(band), at(band + step), at(band + 2 * step),
                         [](const Placed& a, const Placed& b) { return a.place < b.place; });
  std::vector<std::uint32_t> vertices;
  vertices.reserve(placed.size());
  for (const Placed& p : placed) vertices.push_back(p.vertex);
  return vertices;
}

/// Corners ascending, but for the last two where that would turn the cell round: the same ones,
/// whatever was applied and undone before.
tetra_mt::Tetrahedron in_order(tetra_mt::Tetrahedron corners) {
  bool is_turned = false;
  const auto order = [&](std::uint32_t& a, std::uint32_t& b) {
    is_turned ^= a > b;
    const std::uint32_t less = std::min(a, b);
    b = std::max(a, b);
    a = less;
  };
  order(corners[0], corners[1]);
  order(corners[2], corners[3]);
  order(corners[0], corners[2]);
  order(corners[1], corners[3]);
  order(corners[1], corners[2]);
  const std::uint32_t both = is_turned ? corners[2] ^ corners[3] : 0;
  corners[2] ^= both;
  corners[3] ^= both;
  return corners;
}

/// Slots of the cells of a cut by the last of the numbers that their corners get, and where those
/// of each number end: cells that are near come near.
struct SlotsByLast {
  std::vector<std::uint32_t> slots;
  std::vector<std::uint32_t> ends;
};

SlotsByLast sorted_slots(const TetraCut& cut, std::span<const std::uint32_t> numbers,
                         std::size_t n_vertices) {
  const auto last_of = [&](const TetraCut::Cell& cell) {
    std::uint32_t last = 0;
    for (const std::uint32_t v : cell.corners) last = std::max(last, numbers[v]);
    return last;
  };
  SlotsByLast sorted{.slots = {}, .ends = std::vector<std::uint32_t>(n_vertices + 1, 0)};
  std::vector<std::uint32_t>& ends = sorted.ends;  // of those before, while they are filled
  for (const TetraCut::Cell& cell : cut.slots())
    if (cut.is_inside(cell)) ++ends[last_of(cell) + std::size_t{1}];
  for (std::size_t v = 1; v < ends.size(); ++v) ends[v] += ends[v - 1];
  sorted.slots.resize(ends.back());
  for (std::uint32_t slot = 0; slot < cut.slots().size(); ++slot) {
    const TetraCut::Cell& cell = cut.slots()[slot];
    if (cut.is_inside(cell)) sorted.slots[ends[last_of(cell)]++] = slot;
  }
  return sorted;
}

/// A cell in_order() of the numbers that its corners get, and where the cut has it.
struct NumberedCell {
  tetra_mt::Tetrahedron corners;
  std::uint32_t slot;

  [[nodiscard]] bool is_before(const NumberedCell& other) const {
    const auto pair = [](std::uint32_t a, std::uint32_t b) { return std::uint64_t{a} << 32U | b; };
    const std::uint64_t mine = pair(corners[0], corners[1]);
    const std::uint64_t theirs = pair(other.corners[0], other.corners[1]);
    return mine != theirs ? mine < theirs
                          : pair(corners[2], corners[3]) < pair(other.corners[2], other.corners[3]);
  }
};

/// Visits the cells of a cut by the last of their corners, then by the others: the same order, in
/// whatever order they were made.
template <typename Visit>
void visit_cells(const TetraCut& cut, std::span<const std::uint32_t> numbers,
                 std::size_t n_vertices, const Visit& visit) {
  const SlotsByLast sorted = sorted_slots(cut, numbers, n_vertices);
  std::vector<NumberedCell> near;
  std::size_t next = 0;
  for (std::size_t v = 0; v < n_vertices; ++v) {
    near.clear();
    for (; next < sorted.ends[v]; ++next) {
      const std::uint32_t slot = sorted.slots[next];
      tetra_mt::Tetrahedron corners = cut.slots()[slot].corners;
      for (std::uint32_t& corner : corners) corner = numbers[corner];
      near.push_back({in_order(corners), slot});
    }
    std::ranges::sort(near, [](const auto& a, const auto& b) { return a.is_before(b); });
    for (const NumberedCell& cell : near) visit(cell);
  }
}

/// Of the last cell, which is that of a slot: its faces on the boundary that are of a patch.
void add_patch_sides(const TetraCut& cut, std::uint32_t slot,
                     std::span<const std::uint32_t> numbers, SimplexMesh& mesh) {
  const TetraCut::Cell& cell = cut.slots()[slot];
  for (std::uint32_t corner = 0; corner < 4; ++corner) {
    const std::uint32_t number = mesh.tetrahedra.back()[corner];
    const auto at =
        std::ranges::find_if(cell.corners, [&](std::uint32_t v) { return numbers[v] == number; });
    const std::uint32_t across = cell.across[static_cast<std::size_t>(at - cell.corners.begin())];
    if (across == kNone || cut.is_inside(cut.slots()[across])) continue;
    const std::uint32_t mark = cut.region(across);
    if (mark > 0)
      mesh.patch_sides.push_back(
          {static_cast<std::uint32_t>(mesh.tetrahedra.size() - 1), corner, mark - 1});
  }
}

using MarkedFaces = std::vector<std::pair<FaceKey, std::uint32_t>>;

/// patch_mark()s of the faces on the boundary, ascending.
MarkedFaces marked_faces(const tetra_mt::midpoint::MidpointCut& cut) {
  const std::uint32_t outside = cut.head().outside();
  MarkedFaces faces;
  for (const auto& cell : cut.slots()) {
    const auto at = std::ranges::find(cell.corners, outside) - cell.corners.begin();
    if (cell.corners[0] == kNone || at == 4 || cell.region == 0) continue;
    const auto face = tetra_mt::others(cell.corners, static_cast<std::size_t>(at));
    faces.emplace_back(tetra_mt::face_key(face[0], face[1], face[2]), cell.region);
  }
  std::ranges::sort(faces);
  return faces;
}

/// Of the last cell, whose corners are still labels.
void add_patch_sides(const MarkedFaces& faces, SimplexMesh& mesh) {
  for (std::uint32_t corner = 0; corner < 4; ++corner) {
    const auto [a, b, c] = face_across(mesh.tetrahedra.back(), corner);
    const FaceKey key = tetra_mt::face_key(a, b, c);
    const auto at = std::ranges::lower_bound(faces, key, {}, &MarkedFaces::value_type::first);
    if (at != faces.end() && at->first == key)
      mesh.patch_sides.push_back(
          {static_cast<std::uint32_t>(mesh.tetrahedra.size() - 1), corner, at->second - 1});
  }
}

/// Of those inside, the largest labels first.
std::vector<std::uint32_t> slots_by_corners(const tetra_mt::midpoint::MidpointCut& cut) {
  std::vector<std::uint32_t> slots;
  for (std::uint32_t slot = 0; slot < cut.slots().size(); ++slot)
    if (cut.is_inside(cut.slots()[slot])) slots.push_back(slot);
  std::ranges::sort(slots, {}, [&](std::uint32_t slot) {
    tetra_mt::Tetrahedron corners = cut.slots()[slot].corners;
    std::ranges::sort(corners, std::greater());
    return corners;
  });
  return slots;
}

/// As float32.
float not_below(double value) {
  const auto near = static_cast<float>(value);
  return static_cast<double>(near) < value
             ? std::nextafter(near, std::numeric_limits<float>::infinity())
             : near;
}

}  // namespace

std::vector<std::uint32_t> fill_mesh(const PackedHierarchy& hierarchy, const TetraFieldUse& fields,
                                     const TetraCut& cut, const CellErrorReads& reads,
                                     SimplexMesh& mesh) {
  mesh = {};
  std::vector<std::uint32_t> vertex_ids = sorted_vertices(hierarchy, cut);
  std::vector<std::uint32_t> numbers(hierarchy.head().n_vertices(), kNone);
  for (std::uint32_t i = 0; i < vertex_ids.size(); ++i) numbers[vertex_ids[i]] = i;
  const std::vector<HierarchyHead::Field>& heads = hierarchy.head().fields;
  mesh.patches = hierarchy.head().patches;
  mesh.region_names = named_regions(hierarchy.head().region_ids, hierarchy.head().region_names);
  const bool has_regions = hierarchy.head().region_ids.size() > 1 || !mesh.region_names.empty();
  for (const std::size_t field : fields.along)
    mesh.attributes.push_back({heads[field].name, heads[field].has_narrow_values, {}});
  const auto error_of = [&](std::uint32_t slot, std::size_t field) {
    const std::uint32_t maker = cut.maker(slot);
    if (maker == kNone) return 0.0F;
    if (!hierarchy.has_facts(maker, field) && !reads.may_read()) {
      const double base = heads[field].base_error;
      return not_below(field == fields.measured ? std::min(base, reads.bound) : base);
    }
    return hierarchy.facts(maker, field).error;
  };
  visit_cells(cut, numbers, vertex_ids.size(), [&](const NumberedCell& cell) {
    const std::uint32_t slot = cell.slot;
    mesh.tetrahedra.push_back(cell.corners);
    mesh.errors.push_back(error_of(slot, fields.measured));
    for (std::size_t i = 0; i < fields.along.size(); ++i)
      mesh.attributes[i].errors.push_back(error_of(slot, fields.along[i]));
    if (has_regions) mesh.regions.push_back(hierarchy.head().region_ids[cut.region(slot)]);
    if (!mesh.patches.empty()) add_patch_sides(cut, slot, numbers, mesh);
  });
  for (const std::uint32_t v : vertex_ids) {
    mesh.positions.push_back(hierarchy.position(v));
    mesh.values.push_back(hierarchy.value(v, fields.measured));
  }
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

Result<std::vector<std::uint32_t>> fill_mesh(const tetra_mt::midpoint::MidpointCut& cut,
                                             const TetraFieldUse& fields, SimplexMesh& mesh) {
  const tetra_mt::midpoint::ForestHead& head = cut.head();
  mesh = {};
  mesh.patches = head.patches;
  mesh.region_names = named_regions(head.region_ids, head.region_names);
  const bool has_regions = head.region_ids.size() > 1 || !mesh.region_names.empty();
  for (const std::size_t field : fields.along)
    mesh.attributes.push_back({head.fields[field].name, false, {}});
  const MarkedFaces faces = marked_faces(cut);
  std::vector<std::uint32_t> numbers(head.n_labels(), kNone);
  for (const std::uint32_t slot : slots_by_corners(cut)) {
    const auto& cell = cut.slots()[slot];
    const std::uint32_t maker = cut.maker(cell);
    mesh.tetrahedra.push_back(in_order(cell.corners));
    mesh.errors.push_back(maker == kNone ? 0 : cut.facts(NodeId{maker}).error);
    for (std::size_t i = 0; i < fields.along.size(); ++i)
      mesh.attributes[i].errors.push_back(
          maker == kNone ? 0 : cut.facts(NodeId{maker}, fields.along[i]).error);
    if (has_regions) mesh.regions.push_back(head.region_ids[cell.region]);
    if (!faces.empty()) add_patch_sides(faces, mesh);
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
  for (std::size_t i = 0; i < fields.along.size(); ++i) {
    Attribute& attribute = mesh.attributes[i];
    LODE_TRY(attribute.values, cut.values(labels, fields.along[i]));
    for (const float error : attribute.errors)
      attribute.error = std::max(attribute.error, static_cast<double>(error));
  }
  return labels;
}

}  // namespace lode

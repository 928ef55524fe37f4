#include "lode/render/cell_links.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace lode {
namespace {

/// A face of a cell by its two larger corners; those of one smallest corner are side by side.
struct FaceUse {
  std::uint32_t middle;
  std::uint32_t largest;
  std::uint32_t cell_corner;  ///< 4 · cell + the corner across.
};

struct SortedFace {
  std::uint32_t smallest;
  std::uint32_t middle;
  std::uint32_t largest;
};

std::uint64_t pair_of(std::uint32_t low, std::uint32_t high) {
  return low | std::uint64_t{high} << 32;
}

SortedFace face_across(const std::array<std::uint32_t, 4>& cell, std::size_t corner) {
  std::uint32_t a = cell[(corner + 1) % 4];
  std::uint32_t b = cell[(corner + 2) % 4];
  std::uint32_t c = cell[(corner + 3) % 4];
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  return {a, b, c};
}

Result<void> check_cells(const SimplexMesh& mesh) {
  constexpr std::size_t kMaxCells = std::size_t{1} << 29;
  if (mesh.tetrahedra.size() > kMaxCells)
    return fail("mesh: expected at most {} tetrahedra, got {}", kMaxCells, mesh.tetrahedra.size());
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    const auto& cell = mesh.tetrahedra[t];
    for (std::size_t i = 0; i < 4; ++i) {
      if (cell[i] >= mesh.positions.size())
        return fail("mesh: tetrahedron {} names vertex {}, expected one of {}", t, cell[i],
                    mesh.positions.size());
      for (std::size_t j = 0; j < i; ++j) {
        if (cell[i] == cell[j])
          return fail("mesh: expected four corners, tetrahedron {} has vertex {} twice", t,
                      cell[i]);
      }
    }
  }
  return {};
}

/// All uses of faces, by smallest corner; those of vertex v are first[v] <= i < first[v + 1].
struct FaceUses {
  std::vector<std::size_t> first;
  std::vector<FaceUse> uses;
};

FaceUses collect_faces(const SimplexMesh& mesh) {
  FaceUses faces;
  faces.first.assign(mesh.positions.size() + 2, 0);
  for (const auto& cell : mesh.tetrahedra)
    for (std::size_t i = 0; i < 4; ++i) ++faces.first[face_across(cell, i).smallest + 2];
  for (std::size_t v = 2; v < faces.first.size(); ++v) faces.first[v] += faces.first[v - 1];
  faces.uses.resize(4 * mesh.tetrahedra.size());
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    for (std::size_t i = 0; i < 4; ++i) {
      const SortedFace face = face_across(mesh.tetrahedra[t], i);
      faces.uses[faces.first[face.smallest + 1]++] = {face.middle, face.largest,
                                                      static_cast<std::uint32_t>(4 * t + i)};
    }
  }
  return faces;
}

/// By corner, see LinkedCell.
using Across = std::array<std::uint32_t, 4>;

/// Links the faces of one smallest corner that have exactly two cells.
void link_faces(FaceUse* begin, FaceUse* end, std::vector<Across>& across) {
  std::sort(begin, end, [](const FaceUse& a, const FaceUse& b) {
    return std::pair(a.middle, a.largest) < std::pair(b.middle, b.largest);
  });
  for (const FaceUse* face = begin; face != end;) {
    const FaceUse* next = face + 1;
    while (next != end && next->middle == face->middle && next->largest == face->largest) ++next;
    if (next - face == 2) {
      across[face[0].cell_corner / 4][face[0].cell_corner % 4] = face[1].cell_corner / 4;
      across[face[1].cell_corner / 4][face[1].cell_corner % 4] = face[0].cell_corner / 4;
    }
    face = next;
  }
}

}  // namespace

Result<CellLinks> link_cells(const SimplexMesh& mesh, Threads threads) {
  LODE_CHECK(check_cells(mesh));
  CellLinks links;
  std::vector<Across> across(mesh.tetrahedra.size());
  for (Across& cell : across) cell.fill(CellLinks::kOuter);
  FaceUses faces = collect_faces(mesh);
  parallel_for(mesh.positions.size(), threads, 4096, [&](std::size_t v, int) {
    link_faces(faces.uses.data() + faces.first[v], faces.uses.data() + faces.first[v + 1], across);
  });
  links.cells.resize(mesh.tetrahedra.size());
  for (std::size_t t = 0; t < links.cells.size(); ++t) {
    const auto& corners = mesh.tetrahedra[t];
    for (std::size_t i = 0; i < 4; ++i) {
      if (across[t][i] != CellLinks::kOuter) continue;
      across[t][i] += static_cast<std::uint32_t>(links.outer_faces.size());
      links.outer_faces.push_back(
          {{corners[(i + 1) % 4], corners[(i + 2) % 4], corners[(i + 3) % 4]},
           static_cast<std::uint32_t>(t)});
    }
    links.cells[t] = {{pair_of(corners[0], corners[1]), pair_of(corners[2], corners[3]),
                       pair_of(across[t][0], across[t][1]), pair_of(across[t][2], across[t][3])}};
  }
  return links;
}

}  // namespace lode

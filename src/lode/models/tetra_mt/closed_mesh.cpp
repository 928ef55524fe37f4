#include "lode/models/tetra_mt/closed_mesh.h"

#include <algorithm>
#include <utility>

namespace lode::tetra_mt {
namespace {

/// A face, by the smallest of its corners: the others ascending, and whose it is.
struct Face {
  std::uint32_t middle;
  std::uint32_t largest;
  std::uint32_t tetrahedron;
  std::uint32_t place;  ///< Of the corner that it lacks.
};

/// All faces, in the order of their smallest corners.
struct SortedFaces {
  std::vector<std::uint64_t> begins;
  std::vector<Face> faces;
};

std::array<std::uint32_t, 3> sorted(std::array<std::uint32_t, 3> v) {
  if (v[0] > v[1]) std::swap(v[0], v[1]);
  if (v[1] > v[2]) std::swap(v[1], v[2]);
  if (v[0] > v[1]) std::swap(v[0], v[1]);
  return v;
}

SortedFaces sort_faces(std::uint32_t n_vertices, std::span<const Tetrahedron> tetrahedra) {
  SortedFaces result;
  result.begins.assign(std::size_t{n_vertices} + 1, 0);
  for (const Tetrahedron& t : tetrahedra)
    for (std::size_t place = 0; place < 4; ++place)
      ++result.begins[sorted(others(t, place))[0] + std::size_t{1}];
  for (std::size_t i = 1; i < result.begins.size(); ++i) result.begins[i] += result.begins[i - 1];
  result.faces.resize(4 * tetrahedra.size());
  std::vector<std::uint64_t> ends(result.begins.begin(), result.begins.end() - 1);
  for (std::uint32_t i = 0; i < tetrahedra.size(); ++i)
    for (std::uint32_t place = 0; place < 4; ++place) {
      const auto face = sorted(others(tetrahedra[i], place));
      result.faces[ends[face[0]]++] = {face[1], face[2], i, place};
    }
  return result;
}

/// Those with the same smallest corner, each; then equal ones are side by side.
void sort_within(SortedFaces& sorted, Threads threads) {
  parallel_for(sorted.begins.size() - 1, threads, 1024, [&](std::size_t v, int) {
    std::sort(sorted.faces.begin() + static_cast<std::ptrdiff_t>(sorted.begins[v]),
              sorted.faces.begin() + static_cast<std::ptrdiff_t>(sorted.begins[v + 1]),
              [](const Face& a, const Face& b) {
                return std::pair(a.middle, a.largest) < std::pair(b.middle, b.largest);
              });
  });
}

/// The end of the faces that are equal to the one at a place.
std::uint64_t end_of_equal(const SortedFaces& sorted, std::uint64_t first, std::uint64_t end) {
  const Face& face = sorted.faces[first];
  std::uint64_t next = first + 1;
  while (next < end && sorted.faces[next].middle == face.middle &&
         sorted.faces[next].largest == face.largest)
    ++next;
  return next;
}

/// The one across the face that lacks a corner, with the vertex outside in its place.
Tetrahedron across(const Tetrahedron& t, std::uint32_t place, std::uint32_t outside) {
  const auto face = others(t, place);
  return {outside, face[0], face[2], face[1]};
}

}  // namespace

Result<void> close_boundary(std::uint32_t n_vertices, std::vector<Tetrahedron>& tetrahedra,
                            Threads threads) {
  SortedFaces sorted = sort_faces(n_vertices, tetrahedra);
  std::vector<Tetrahedron> outer;
  sort_within(sorted, threads);
  for (std::uint32_t v = 0; v < n_vertices; ++v) {
    const auto end = sorted.begins[v + std::size_t{1}];
    for (std::uint64_t i = sorted.begins[v]; i < end;) {
      const Face& face = sorted.faces[i];
      const std::uint64_t next = end_of_equal(sorted, i, end);
      if (next - i > 2)
        return fail("expected faces of one or two tetrahedra, got one of {}: corners {}, {} and {}",
                    next - i, v, face.middle, face.largest);
      if (next - i == 1)
        outer.push_back(across(tetrahedra[face.tetrahedron], face.place, n_vertices));
      i = next;
    }
  }
  tetrahedra.insert(tetrahedra.end(), outer.begin(), outer.end());
  return {};
}

std::vector<std::array<std::uint32_t, 4>> find_across(std::span<const Tetrahedron> tetrahedra) {
  std::uint32_t n_smallest = 0;
  for (const Tetrahedron& t : tetrahedra)
    for (std::size_t place = 0; place < 4; ++place)
      n_smallest = std::max(n_smallest, std::ranges::min(others(t, place)) + 1);
  SortedFaces sorted = sort_faces(n_smallest, tetrahedra);
  sort_within(sorted, {1});
  std::vector<std::array<std::uint32_t, 4>> across(tetrahedra.size(), {kNone, kNone, kNone, kNone});
  for (std::size_t v = 0; v + 1 < sorted.begins.size(); ++v) {
    const std::uint64_t end = sorted.begins[v + 1];
    for (std::uint64_t i = sorted.begins[v]; i < end;) {
      const std::uint64_t next = end_of_equal(sorted, i, end);
      const Face& a = sorted.faces[i];
      const Face& b = sorted.faces[next - 1];
      if (next - i == 2) {
        across[a.tetrahedron][a.place] = b.tetrahedron;
        across[b.tetrahedron][b.place] = a.tetrahedron;
      }
      i = next;
    }
  }
  return across;
}

}  // namespace lode::tetra_mt

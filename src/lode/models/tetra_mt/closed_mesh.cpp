#include "lode/models/tetra_mt/closed_mesh.h"

#include <algorithm>
#include <atomic>
#include <compare>
#include <utility>

#include "lode/core/uninitialized_array.h"

namespace lode::tetra_mt {
namespace {

/// A face, by the smallest of its corners: the others ascending, and whose it is.
struct Face {
  std::uint32_t middle;
  std::uint32_t largest;
  std::uint32_t tetrahedron;
  std::uint32_t place;  ///< Of the corner that it lacks.

  auto operator<=>(const Face&) const = default;
};

/// All faces, in the order of their smallest corners.
struct SortedFaces {
  std::vector<std::uint64_t> begins;
  UninitializedArray<Face> faces;
};

/// With the smallest corner first: the three faces that have it, then the one that does not.
struct TetrahedronFaces {
  std::array<std::array<std::uint32_t, 3>, 4> corners;  ///< Ascending.
  std::array<std::uint32_t, 4> places;                  ///< Of the corners that they lack.
};

TetrahedronFaces faces_of(const Tetrahedron& t) {
  std::array<std::uint32_t, 4> order{0, 1, 2, 3};
  const auto sort_two = [&](std::size_t a, std::size_t b) {
    if (t[order[a]] > t[order[b]]) std::swap(order[a], order[b]);
  };
  sort_two(0, 1);
  sort_two(2, 3);
  sort_two(0, 2);
  sort_two(1, 3);
  sort_two(1, 2);
  const std::array<std::uint32_t, 4> v{t[order[0]], t[order[1]], t[order[2]], t[order[3]]};
  return {{{{v[0], v[1], v[2]}, {v[0], v[1], v[3]}, {v[0], v[2], v[3]}, {v[1], v[2], v[3]}}},
          {order[3], order[2], order[1], order[0]}};
}

/// Counts and places by atomics: those of one vertex come in any order, until they are sorted.
SortedFaces gather_faces(std::uint32_t n_vertices, std::span<const Tetrahedron> tetrahedra,
                         Threads threads) {
  constexpr std::size_t kGrain = 4096;
  SortedFaces result;
  result.begins.assign(std::size_t{n_vertices} + 1, 0);
  const auto add = [](std::uint64_t& to, std::uint64_t n) {
    return std::atomic_ref(to).fetch_add(n, std::memory_order_relaxed);
  };
  parallel_for(tetrahedra.size(), threads, kGrain, [&](std::size_t i, int) {
    const TetrahedronFaces faces = faces_of(tetrahedra[i]);
    add(result.begins[faces.corners[0][0] + std::size_t{1}], 3);
    add(result.begins[faces.corners[3][0] + std::size_t{1}], 1);
  });
  for (std::size_t i = 1; i < result.begins.size(); ++i) result.begins[i] += result.begins[i - 1];
  result.faces.resize(4 * tetrahedra.size());
  std::vector<std::uint64_t> ends(result.begins.begin(), result.begins.end() - 1);
  parallel_for(tetrahedra.size(), threads, kGrain, [&](std::size_t i, int) {
    const TetrahedronFaces faces = faces_of(tetrahedra[i]);
    const auto place = [&](std::uint64_t at, std::size_t k) {
      result.faces[at] = {faces.corners[k][1], faces.corners[k][2], static_cast<std::uint32_t>(i),
                          faces.places[k]};
    };
    const std::uint64_t first = add(ends[faces.corners[0][0]], 3);
    for (std::size_t k = 0; k < 3; ++k) place(first + k, k);
    place(add(ends[faces.corners[3][0]], 1), 3);
  });
  return result;
}

/// Those with the same smallest corner; then equal ones are side by side.
void sort_within(SortedFaces& sorted, std::size_t vertex) {
  std::sort(sorted.faces.begin() + static_cast<std::ptrdiff_t>(sorted.begins[vertex]),
            sorted.faces.begin() + static_cast<std::ptrdiff_t>(sorted.begins[vertex + 1]));
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

/// Appends what is outside of a vertex's faces, those whose smallest corner it is, to `outer`.
Result<void> find_outer(const SortedFaces& sorted, std::span<const Tetrahedron> tetrahedra,
                        std::uint32_t vertex, std::vector<Tetrahedron>& outer) {
  const auto n_vertices = static_cast<std::uint32_t>(sorted.begins.size() - 1);
  const std::uint64_t end = sorted.begins[vertex + std::size_t{1}];
  for (std::uint64_t i = sorted.begins[vertex]; i < end;) {
    const Face& face = sorted.faces[i];
    const std::uint64_t next = end_of_equal(sorted, i, end);
    if (next - i > 2)
      return fail("expected faces of one or two tetrahedra, got one of {}: corners {}, {} and {}",
                  next - i, vertex, face.middle, face.largest);
    if (next - i == 1)
      outer.push_back(across(tetrahedra[face.tetrahedron], face.place, n_vertices));
    i = next;
  }
  return {};
}

}  // namespace

Result<void> close_boundary(std::uint32_t n_vertices, std::vector<Tetrahedron>& tetrahedra,
                            Threads threads) {
  constexpr std::uint32_t kPart = 4096;  // vertices
  SortedFaces sorted = gather_faces(n_vertices, tetrahedra, threads);
  std::vector<std::vector<Tetrahedron>> outer(n_vertices / kPart + 1);
  std::vector<Result<void>> found(outer.size());
  parallel_for(outer.size(), threads, 1, [&](std::size_t part, int) {
    const auto first = static_cast<std::uint32_t>(part) * kPart;
    for (std::uint32_t v = first; v < n_vertices && v - first < kPart && found[part]; ++v) {
      sort_within(sorted, v);
      found[part] = find_outer(sorted, tetrahedra, v, outer[part]);
    }
  });
  for (const Result<void>& part : found) LODE_CHECK(part);
  for (const auto& part : outer) tetrahedra.insert(tetrahedra.end(), part.begin(), part.end());
  return {};
}

std::vector<std::array<std::uint32_t, 4>> find_across(std::span<const Tetrahedron> tetrahedra) {
  std::uint32_t n_smallest = 0;
  for (const Tetrahedron& t : tetrahedra)
    n_smallest = std::max(n_smallest, faces_of(t).corners[3][0] + 1);
  SortedFaces sorted = gather_faces(n_smallest, tetrahedra, {1});
  std::vector<std::array<std::uint32_t, 4>> across(tetrahedra.size(), {kNone, kNone, kNone, kNone});
  for (std::size_t v = 0; v + 1 < sorted.begins.size(); ++v) {
    sort_within(sorted, v);
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

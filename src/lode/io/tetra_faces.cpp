#include "lode/io/tetra_faces.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <tuple>

namespace lode::io {
namespace {

/// A face without its smallest point.
struct FaceEnd {
  std::uint32_t middle = 0;
  std::uint32_t largest = 0;
  std::uint32_t tetrahedron = 0;

  [[nodiscard]] bool is_at(const FaceEnd& other) const {
    return middle == other.middle && largest == other.largest;
  }
};

/// The face opposite to a corner, its points in their order.
std::array<std::uint32_t, 3> sorted_face(const Tetrahedron& t, std::size_t corner) {
  std::array<std::uint32_t, 3> face{};
  for (std::size_t i = 0; i < 3; ++i) face[i] = t[(corner + 1 + i) % 4];
  std::sort(face.begin(), face.end());
  return face;
}

/// Faces in groups by their smallest point.
struct FaceGroups {
  std::vector<std::size_t> begins;  ///< By point, and one more.
  std::vector<FaceEnd> faces;
};

FaceGroups group_faces(std::span<const Tetrahedron> tetrahedra, std::size_t n_points) {
  FaceGroups groups;
  groups.begins.resize(n_points + 2);
  for (const Tetrahedron& t : tetrahedra)
    for (std::size_t corner = 0; corner < 4; ++corner)
      ++groups.begins[sorted_face(t, corner)[0] + std::size_t{2}];
  std::partial_sum(groups.begins.begin(), groups.begins.end(), groups.begins.begin());
  groups.faces.resize(4 * tetrahedra.size());
  for (std::size_t i = 0; i < tetrahedra.size(); ++i)
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const auto [a, b, c] = sorted_face(tetrahedra[i], corner);
      // While groups are filled their begins stand one place further.
      groups.faces[groups.begins[a + std::size_t{1}]++] = {b, c, static_cast<std::uint32_t>(i)};
    }
  groups.begins.pop_back();
  return groups;
}

/// Sets of tetrahedra, each known by its smallest one.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parents_(n) {
    std::iota(parents_.begin(), parents_.end(), 0U);
  }

  [[nodiscard]] std::uint32_t find(std::uint32_t i) {
    while (parents_[i] != i) {
      parents_[i] = parents_[parents_[i]];
      i = parents_[i];
    }
    return i;
  }
  void join(std::uint32_t i, std::uint32_t k) {
    i = find(i);
    k = find(k);
    parents_[std::max(i, k)] = std::min(i, k);
  }

 private:
  std::vector<std::uint32_t> parents_;
};

void number_components(DisjointSets& sets, TetraFaces& result) {
  for (std::uint32_t i = 0; i < result.components.size(); ++i) {
    const std::uint32_t first = sets.find(i);
    result.components[i] = first == i ? result.n_components++ : result.components[first];
  }
}

}  // namespace

Result<TetraFaces> connect_faces(const std::string& path, const SplitCells& split,
                                 std::size_t n_points) {
  FaceGroups groups = group_faces(split.tetrahedra, n_points);
  DisjointSets sets(split.tetrahedra.size());
  TetraFaces result;
  for (std::size_t point = 0; point < n_points; ++point) {
    const std::span<FaceEnd> faces =
        std::span(groups.faces)
            .subspan(groups.begins[point], groups.begins[point + 1] - groups.begins[point]);
    std::sort(faces.begin(), faces.end(), [](const FaceEnd& a, const FaceEnd& b) {
      return std::tuple(a.middle, a.largest, a.tetrahedron) <
             std::tuple(b.middle, b.largest, b.tetrahedron);
    });
    for (std::size_t i = 0; i < faces.size();) {
      std::size_t end = i + 1;
      while (end < faces.size() && faces[end].is_at(faces[i])) ++end;
      if (end - i > 2)
        return fail(
            "{}: expected one or two cells at a face, got {} at points {}, {} and {}, among "
            "them cell {}",
            path, end - i, point, faces[i].middle, faces[i].largest,
            split.cells[faces[i].tetrahedron]);
      if (end - i == 2)
        sets.join(faces[i].tetrahedron, faces[i + 1].tetrahedron);
      else
        result.boundary.push_back(
            {static_cast<std::uint32_t>(point), faces[i].middle, faces[i].largest});
      i = end;
    }
  }
  result.components.resize(split.tetrahedra.size());
  number_components(sets, result);
  return result;
}

}  // namespace lode::io

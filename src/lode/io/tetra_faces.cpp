#include "lode/io/tetra_faces.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <span>
#include <string>
#include <tuple>
#include <utility>

namespace lode::io {
namespace {

/// A face without its smallest point.
struct FaceEnd {
  std::uint32_t middle = 0;
  std::uint32_t largest = 0;
  std::uint32_t tetrahedron = 0;
  bool is_odd = false;  ///< It sees them turn the other way.

  [[nodiscard]] bool is_at(const FaceEnd& other) const {
    return middle == other.middle && largest == other.largest;
  }
};

/// The face opposite to a corner, its points in their order.
struct SortedFace {
  std::array<std::uint32_t, 3> points;
  bool is_odd;  ///< As the tetrahedron has them, they turn the other way.
};

SortedFace sorted_face(const Tetrahedron& t, std::size_t corner) {
  SortedFace face{};
  for (std::size_t i = 0; i < 3; ++i) face.points[i] = t[(corner + 1 + i) % 4];
  // The corners behind the first and the third, in this order, turn as seen from the other side.
  face.is_odd = corner % 2 != 0;
  const auto put_in_order = [&](std::size_t i, std::size_t k) {
    if (face.points[i] <= face.points[k]) return;
    std::swap(face.points[i], face.points[k]);
    face.is_odd = !face.is_odd;
  };
  put_in_order(0, 1);
  put_in_order(1, 2);
  put_in_order(0, 1);
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
      ++groups.begins[sorted_face(t, corner).points[0] + std::size_t{2}];
  std::partial_sum(groups.begins.begin(), groups.begins.end(), groups.begins.begin());
  groups.faces.resize(4 * tetrahedra.size());
  for (std::size_t i = 0; i < tetrahedra.size(); ++i)
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const SortedFace face = sorted_face(tetrahedra[i], corner);
      const auto& [a, b, c] = face.points;
      // While groups are filled their begins stand one place further.
      groups.faces[groups.begins[a + std::size_t{1}]++] = {b, c, static_cast<std::uint32_t>(i),
                                                           face.is_odd};
    }
  groups.begins.pop_back();
  return groups;
}

/// Sets of tetrahedra, each known by its smallest one, and how each is wound against that one.
class WoundSets {
 public:
  explicit WoundSets(std::size_t n) : parents_(n), is_turned_(n, 0), is_orientable_(n, 1) {
    std::iota(parents_.begin(), parents_.end(), 0U);
  }

  /// What is found, and whether it is wound the other way than what was asked for.
  struct Found {
    std::uint32_t first;
    std::uint8_t is_turned;
  };
  [[nodiscard]] Found find(std::uint32_t i) {
    std::uint8_t is_turned = 0;
    while (parents_[i] != i) {
      const std::uint32_t up = parents_[i];
      // Its way becomes half as long.
      is_turned_[i] = static_cast<std::uint8_t>(is_turned_[i] ^ is_turned_[up]);
      parents_[i] = parents_[up];
      is_turned = static_cast<std::uint8_t>(is_turned ^ is_turned_[i]);
      i = parents_[i];
    }
    return {i, is_turned};
  }
  /// `is_turned`: of one against the other.
  void join(std::uint32_t i, std::uint32_t k, bool is_turned) {
    const Found a = find(i);
    const Found b = find(k);
    const auto between = static_cast<std::uint8_t>(a.is_turned ^ b.is_turned ^ (is_turned ? 1 : 0));
    const std::uint32_t first = std::min(a.first, b.first);
    const std::uint32_t last = std::max(a.first, b.first);
    if (first == last) {
      if (between != 0) is_orientable_[first] = 0;
      return;
    }
    parents_[last] = first;
    is_turned_[last] = between;
    is_orientable_[first] = static_cast<std::uint8_t>(is_orientable_[first] & is_orientable_[last]);
  }
  [[nodiscard]] std::uint8_t is_orientable(std::uint32_t first) const {
    return is_orientable_[first];
  }

 private:
  std::vector<std::uint32_t> parents_;
  std::vector<std::uint8_t> is_turned_;      ///< Against the parent.
  std::vector<std::uint8_t> is_orientable_;  ///< Of the smallest ones.
};

/// Faces with more than two cells, and cells that are there twice.
class Crowded {
 public:
  explicit Crowded(const SplitCells& split) : split_(split) {}

  void look_at(std::size_t point, std::span<const FaceEnd> ends) {
    if (ends.size() > 2 && n_faces_++ == 0)
      first_face_ = fmt::format("{} at points {}, {} and {}, among them cell {}", ends.size(),
                                point, ends[0].middle, ends[0].largest, cell_of(ends[0]));
    if (ends.size() == 2 && all_of(ends[0]) != all_of(ends[1])) return;
    if (ends.size() < 2) return;
    std::vector<FaceEnd> sorted(ends.begin(), ends.end());
    std::ranges::stable_sort(sorted, {}, [&](const FaceEnd& end) { return all_of(end); });
    for (std::size_t i = 1; i < sorted.size(); ++i)
      if (all_of(sorted[i - 1]) == all_of(sorted[i]) && n_ends_twice_++ == 0)
        first_twice_ = fmt::format("{} and {}", cell_of(sorted[i - 1]), cell_of(sorted[i]));
  }
  [[nodiscard]] Result<void> check(const std::string& path) const {
    if (n_ends_twice_ > 0)
      return fail(
          "{}: expected each cell once, got {} tetrahedra with the points of another; first: of "
          "cells {}",
          path, n_ends_twice_ / 4, first_twice_);
    if (n_faces_ > 0)
      return fail("{}: expected one or two cells at a face, got more at {}; first: {}", path,
                  n_faces_, first_face_);
    return {};
  }

 private:
  [[nodiscard]] std::uint32_t cell_of(const FaceEnd& end) const {
    return split_.cells[end.tetrahedron];
  }
  /// The same of two at a face if they have all corners in common.
  [[nodiscard]] std::uint32_t all_of(const FaceEnd& end) const {
    const auto& t = split_.tetrahedra[end.tetrahedron];
    return t[0] ^ t[1] ^ t[2] ^ t[3];
  }

  const SplitCells& split_;
  std::uint64_t n_faces_ = 0;
  std::uint64_t n_ends_twice_ = 0;  ///< Four of each.
  std::string first_face_;
  std::string first_twice_;
};

void number_components(WoundSets& sets, TetraFaces& result) {
  result.windings.resize(result.components.size());
  for (std::uint32_t i = 0; i < result.components.size(); ++i) {
    const auto [first, is_turned] = sets.find(i);
    if (first == i) result.is_orientable.push_back(sets.is_orientable(first));
    result.components[i] = first == i ? result.n_components++ : result.components[first];
    result.windings[i] = is_turned;
  }
}

}  // namespace

Result<TetraFaces> connect_faces(const std::string& path, const SplitCells& split,
                                 std::size_t n_points) {
  FaceGroups groups = group_faces(split.tetrahedra, n_points);
  Crowded crowded(split);
  WoundSets sets(split.tetrahedra.size());
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
      crowded.look_at(point, faces.subspan(i, end - i));
      if (end - i == 2)
        sets.join(faces[i].tetrahedron, faces[i + 1].tetrahedron,
                  faces[i].is_odd == faces[i + 1].is_odd);
      else if (end - i == 1)
        result.boundary.push_back(
            {static_cast<std::uint32_t>(point), faces[i].middle, faces[i].largest});
      i = end;
    }
  }
  LODE_CHECK(crowded.check(path));
  result.components.resize(split.tetrahedra.size());
  number_components(sets, result);
  return result;
}

}  // namespace lode::io

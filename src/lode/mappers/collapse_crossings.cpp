#include "lode/mappers/collapse_crossings.h"

#include <algorithm>
#include <exception>
#include <new>

#include "lode/mappers/box_pairs.h"
#include "lode/mappers/triangle_intersection.h"

namespace lode::simplification {
namespace {

/// How two triangles have corners in common.
struct Alignment {
  std::array<std::uint32_t, 3> s;  ///< Common corners first, in the same order.
  std::array<std::uint32_t, 3> t;
  std::size_t n_common = 0;
  bool is_false = false;  ///< Different vertices, one of them moved, have the same place.
};

Alignment align(const CollapseMesh& mesh, std::uint32_t first, std::uint32_t second) {
  Alignment a{mesh.triangles[first].v, mesh.triangles[second].v};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = a.n_common; j < 3; ++j) {
      const std::uint32_t v = a.s[i];
      const std::uint32_t w = a.t[j];
      if (v != w) {
        if (!(mesh.positions[v] == mesh.positions[w])) continue;
        a.is_false = a.is_false || mesh.last[v] != kNone || mesh.last[w] != kNone;
      }
      std::swap(a.s[i], a.s[a.n_common]);
      std::swap(a.t[j], a.t[a.n_common]);
      ++a.n_common;
      break;
    }
  return a;
}

bool cross(const CollapseMesh& mesh, std::uint32_t first, std::uint32_t second) {
  const Alignment a = align(mesh, first, second);
  if (a.is_false || a.n_common == 3) return true;
  const auto corners_of = [&](const std::array<std::uint32_t, 3>& v) -> TriangleCorners {
    return {mesh.positions[v[0]], mesh.positions[v[1]], mesh.positions[v[2]]};
  };
  const TriangleCorners s = corners_of(a.s);
  const TriangleCorners t = corners_of(a.t);
  if (a.n_common == 2) return triangles_meet_beyond_edge(s, t);
  return a.n_common == 1 ? triangles_meet_beyond_corner(s, t) : triangles_meet(s, t);
}

Box3f box_of(const CollapseMesh& mesh, std::uint32_t triangle) {
  const auto t = corners(mesh, triangle);
  Box3f box{t[0], t[0]};
  for (const Vec3f& p : t)
    for (std::size_t i = 0; i < 3; ++i) {
      box.lower[i] = std::min(box.lower[i], p[i]);
      box.upper[i] = std::max(box.upper[i], p[i]);
    }
  return box;
}

bool has_zero_area(const CollapseMesh& mesh, std::uint32_t triangle) {
  const auto t = corners(mesh, triangle);
  return lode::has_zero_area(t[0], t[1], t[2]);
}

/// Cells of a coarse lattice that some triangles' boxes touch.
class CoarseBoxes {
 public:
  CoarseBoxes(const CollapseMesh& mesh, std::span<const std::uint32_t> triangles) {
    if (triangles.empty()) return;
    std::vector<Box3f> boxes;
    boxes.reserve(triangles.size());
    for (const std::uint32_t t : triangles) boxes.push_back(box_of(mesh, t));
    lower_ = boxes.front().lower;
    Vec3f upper = boxes.front().upper;
    for (const Box3f& box : boxes)
      for (std::size_t i = 0; i < 3; ++i) {
        lower_[i] = std::min(lower_[i], box.lower[i]);
        upper[i] = std::max(upper[i], box.upper[i]);
      }
    const Vec3f size = upper - lower_;
    const float longest = std::max({size[0], size[1], size[2]});
    scale_ = longest > 0 ? static_cast<float>(kCells) / longest : 0;
    is_touched_.assign(std::size_t{kCells} * kCells * kCells, 0);
    for (const Box3f& box : boxes)
      visit(box, [&](std::size_t i) {
        is_touched_[i] = 1;
        return false;
      });
  }
  [[nodiscard]] bool may_meet(const Box3f& box) const {
    return !is_touched_.empty() && visit(box, [&](std::size_t i) { return is_touched_[i] != 0; });
  }

 private:
  static constexpr int kCells = 64;

  /// Rounding is monotone, so boxes that meet have a cell in common.
  [[nodiscard]] int index(float x, std::size_t i) const {
    return static_cast<int>(std::clamp((x - lower_[i]) * scale_, 0.0F, kCells - 1.0F));
  }
  template <typename Visit>
  bool visit(const Box3f& box, const Visit& visit_cell) const {
    for (int z = index(box.lower[2], 2); z <= index(box.upper[2], 2); ++z)
      for (int y = index(box.lower[1], 1); y <= index(box.upper[1], 1); ++y)
        for (int x = index(box.lower[0], 0); x <= index(box.upper[0], 0); ++x)
          if (visit_cell((static_cast<std::size_t>(z) * kCells + static_cast<std::size_t>(y)) *
                             kCells +
                         static_cast<std::size_t>(x)))
            return true;
    return false;
  }

  Vec3f lower_;
  float scale_ = 0;
  std::vector<std::uint8_t> is_touched_;
};

using Pairs = std::vector<std::array<std::uint32_t, 2>>;

Result<Pairs> find(const CollapseMesh& mesh, std::span<const std::uint32_t> live,
                   std::span<const std::uint32_t> triangles, Threads threads, Progress& progress) {
  std::vector<std::uint8_t> is_asked(mesh.triangles.size(), 0);
  for (const std::uint32_t t : triangles) is_asked[t] = 1;
  const CoarseBoxes near(mesh, triangles);
  struct Part {
    std::vector<std::uint32_t> numbers;
    std::vector<Box3f> boxes;
    Pairs flat;
  };
  constexpr std::size_t kPiece = 4096;
  std::vector<Part> parts((live.size() + kPiece - 1) / kPiece);
  parallel_for(parts.size(), threads, 1, [&](std::size_t i, int) {
    Part& part = parts[i];
    for (const std::uint32_t t :
         live.subspan(i * kPiece, std::min(kPiece, live.size() - i * kPiece))) {
      const Box3f box = box_of(mesh, t);
      if (is_asked[t] == 0 && !near.may_meet(box)) continue;
      if (has_zero_area(mesh, t)) {
        if (is_asked[t] != 0) part.flat.push_back({t, t});
        continue;
      }
      part.numbers.push_back(t);
      part.boxes.push_back(box);
    }
  });
  std::vector<std::uint32_t> numbers;
  std::vector<Box3f> boxes;
  Pairs found;
  for (const Part& part : parts) {
    numbers.insert(numbers.end(), part.numbers.begin(), part.numbers.end());
    boxes.insert(boxes.end(), part.boxes.begin(), part.boxes.end());
    found.insert(found.end(), part.flat.begin(), part.flat.end());
  }
  std::vector<Pairs> by_worker(static_cast<std::size_t>(n_workers(threads)));
  LODE_CHECK(visit_box_pairs(boxes, threads, progress, [&](auto pairs, int worker) {
    for (const auto& [i, j] : pairs) {
      const std::uint32_t s = numbers[i];
      const std::uint32_t t = numbers[j];
      if ((is_asked[s] | is_asked[t]) != 0 && cross(mesh, s, t))
        by_worker[static_cast<std::size_t>(worker)].push_back({s, t});
    }
  }));
  for (const Pairs& own : by_worker) found.insert(found.end(), own.begin(), own.end());
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

Result<Pairs> find_crossings(const CollapseMesh& mesh, std::span<const std::uint32_t> live,
                             std::span<const std::uint32_t> triangles, Threads threads,
                             Progress& progress) try {
  return find(mesh, live, triangles, threads, progress);
} catch (const std::bad_alloc&) {
  throw;
} catch (const std::exception& error) {
  return fail("simplification: an exact predicate failed: {}", error.what());
}

}  // namespace lode::simplification

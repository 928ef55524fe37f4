// L. De Floriani, "A pyramidal data structure for triangle-based surface description", IEEE CG&A 9
// (2), 1989, and M. Bertolotto, L. De Floriani, P. Marzano, "An efficient representation for
// pyramidal terrain models", 1994: location down interference links.
#include "lode/models/terrain/delaunay_pyramid/link_search.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "lode/delaunay/tin_links.h"
#include "lode/models/terrain/delaunay_pyramid/linked_levels.h"
#include "lode/models/terrain/insertions/extract.h"
#include "lode/models/terrain/insertions/place_tests.h"

namespace lode::delaunay_pyramid {
namespace {

using delaunay::LatticeCorners;
using delaunay::Point;
using delaunay::Tin;
using insertions::box_of;
using insertions::BoxTree;
using insertions::LatticeBox;

/// Whether links must lead on from what is met: they do to a place, which all of a triangle's
/// interior is round.
enum class Goal : std::uint8_t { place, way };

/// Goes down from level 0 to the triangles of a level that meet something.
class LinkSearch {
 public:
  LinkSearch(const PyramidFile& file, const LinkStart& start, std::size_t level)
      : levels_(file), level_(level), start_(start) {}

  /// meets(corners): where false, nothing that it is linked to does.
  template <typename Meets>
  Result<void> add(const LatticeBox& box, Goal goal, const Meets& meets) {
    std::vector<KeptTriangle> open;
    start_.boxes().for_each([&](const LatticeBox& other) { return other.meets(box); },
                            [&](std::uint32_t t) {
                              open.push_back({0, t});
                              return true;
                            });
    LODE_CHECK(leave_met(meets, open));
    std::set<KeptTriangle> seen;
    while (!open.empty()) {
      const KeptTriangle t = open.back();
      open.pop_back();
      LODE_TRY(const std::uint32_t end, levels_.end_of(t));
      if (end > level_) {
        found_.push_back(t);
        continue;
      }
      LODE_TRY(std::vector<KeptTriangle> linked, levels_.linked(t));
      LODE_CHECK(leave_met(meets, linked));
      if (linked.empty() && goal == Goal::place)
        return fail(
            "{}: level {}: triangle {}: expected links to all that meets it, got none to what "
            "holds a place in it",
            levels_.file().path(), t.level, t.number);
      for (const KeptTriangle& other : linked)
        if (seen.insert(other).second) open.push_back(other);
    }
    return {};
  }

  Result<Tin> take() {
    std::ranges::sort(found_);
    found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
    LODE_CHECK(check_apart());
    Tin tin;
    const double most = levels_.head().facts[level_].largest_error;
    for (const KeptTriangle& t : found_) {
      LODE_TRY(const auto corners, levels_.corners(t));
      LODE_TRY(const float error, levels_.error(t));
      if (static_cast<double>(error) > most)
        return fail("{}: level {}: expected errors up to {}, got {}", levels_.file().path(), level_,
                    most, error);
      tin.triangles.push_back(corners);
      tin.errors.push_back(error);
    }
    LODE_CHECK(place(tin));
    tin.twins = delaunay::find_twins(tin.triangles);
    return tin;
  }

 private:
  template <typename Meets>
  Result<void> leave_met(const Meets& meets, std::vector<KeptTriangle>& triangles) {
    std::vector<KeptTriangle> met;
    for (const KeptTriangle& t : triangles) {
      LODE_TRY(const LatticeCorners corners, levels_.places(t));
      if (meets(corners)) met.push_back(t);
    }
    triangles = std::move(met);
    return {};
  }

  /// What was found is parts of one mesh: no two overlap.
  Result<void> check_apart() {
    std::vector<LatticeCorners> all;
    for (const KeptTriangle& t : found_) {
      LODE_TRY(const LatticeCorners corners, levels_.places(t));
      all.push_back(corners);
    }
    std::ranges::sort(all, {}, [](const LatticeCorners& corners) {
      return insertions::place_along_z(corners[0]);
    });
    std::vector<LatticeBox> boxes;
    boxes.reserve(all.size());
    for (const LatticeCorners& corners : all) boxes.push_back(box_of(corners));
    const BoxTree tree(boxes);
    for (std::size_t i = 0; i < all.size(); ++i) {
      bool are_apart = true;
      tree.for_each([&](const LatticeBox& other) { return other.meets(boxes[i]); },
                    [&](std::uint32_t k) {
                      are_apart = k == i || !insertions::do_interiors_meet(all[i], all[k]);
                      return are_apart;
                    });
      if (!are_apart)
        return fail("{}: level {}: expected links to triangles of one mesh, got some that overlap",
                    levels_.file().path(), level_);
    }
    return {};
  }

  /// Numbers vertices anew, in rows, and takes over where they are.
  Result<void> place(Tin& tin) {
    std::vector<std::uint32_t> used;
    for (const auto& corners : tin.triangles)
      used.insert(used.end(), corners.begin(), corners.end());
    std::ranges::sort(used);
    used.erase(std::unique(used.begin(), used.end()), used.end());
    std::vector<delaunay::LatticePoint> vertices;
    std::vector<double> heights;
    for (const std::uint32_t v : used) {
      LODE_TRY(const auto p, levels_.vertex(v));
      LODE_TRY(const double z, levels_.height(v));
      vertices.push_back(p);
      heights.push_back(z);
    }
    for (auto& corners : tin.triangles)
      for (std::uint32_t& v : corners)
        v = static_cast<std::uint32_t>(std::ranges::lower_bound(used, v) - used.begin());
    insertions::place_vertices(vertices, heights, tin);
    return {};
  }

  LinkedLevels levels_;
  std::size_t level_;
  const LinkStart& start_;
  std::vector<KeptTriangle> found_;
};

}  // namespace

Result<LinkStart> LinkStart::read(const PyramidFile& file, Progress& progress) {
  LODE_TRY(const Pyramid first, file.read_mesh(0, progress));
  LinkStart start;
  std::vector<LatticeBox> boxes;
  for (const auto& [a, b, c] : first.levels[0].triangles) {
    boxes.push_back(box_of({first.vertices[a], first.vertices[b], first.vertices[c]}));
    start.box_.add(boxes.back());
  }
  start.boxes_ = BoxTree(std::move(boxes));
  return start;
}

Result<Tin> tin_around(const PyramidFile& file, const LinkStart& start, std::size_t level,
                       std::span<const Point> places, Progress& progress) {
  LinkSearch search(file, start, level);
  for (const Point& p : places) {
    if (progress.is_cancelled()) return cancelled_error();
    LODE_CHECK(search.add(
        insertions::box_round(p, p), Goal::place,
        [&](const LatticeCorners& corners) { return insertions::holds_place(corners, p); }));
  }
  return search.take();
}

Result<Tin> tin_along(const PyramidFile& file, const LinkStart& start, std::size_t level,
                      const Point& a, const Point& b, Progress& progress) {
  if (progress.is_cancelled()) return cancelled_error();
  LinkSearch search(file, start, level);
  const LatticeBox box = insertions::box_round(a, b);
  LODE_CHECK(search.add(box, Goal::way, [&](const LatticeCorners& corners) {
    return box_of(corners).meets(box) && !insertions::is_beside_line(corners, a, b);
  }));
  return search.take();
}

}  // namespace lode::delaunay_pyramid

#include "lode/models/terrain/insertions/local_selection.h"

#include <optional>
#include <utility>
#include <vector>

#include "lode/models/terrain/insertions/extract.h"
#include "lode/models/terrain/insertions/local_mesh.h"
#include "lode/models/terrain/insertions/local_search.h"
#include "lode/models/terrain/insertions/place_tests.h"

namespace lode::insertions {
namespace {

using delaunay::Point;

/// Applies nodes until no triangle wants more.
class DemandedTin {
 public:
  DemandedTin(const HistoryFile& file, const Demand& demand)
      : mesh_(file, file.n_nodes()), demand_(demand) {}

  Result<std::optional<delaunay::Tin>> run(delaunay::TinLinks links, std::uint32_t max_nodes,
                                           Progress& progress) {
    for (std::uint32_t t = 0; t < mesh_.n_triangles(); ++t) {
      if (progress.is_cancelled()) return cancelled_error();
      if (mesh_.triangle(t).removed_by != kNone || !is_wanted(t)) continue;
      LODE_TRY(const FileNode death, mesh_.death_of(t));
      // What it makes is looked at in its turn.
      if (death.time != kNone) LODE_CHECK(mesh_.apply_death_of(t));
      if (mesh_.n_applied() > max_nodes) return std::optional<delaunay::Tin>{};
    }
    std::vector<std::uint32_t> left;
    for (std::uint32_t t = 0; t < mesh_.n_triangles(); ++t)
      if (mesh_.triangle(t).removed_by == kNone) left.push_back(t);
    return std::optional(mesh_.to_tin(std::move(left), links));
  }

 private:
  [[nodiscard]] bool is_wanted(std::uint32_t t) const {
    const NodeFacts facts = facts_of(mesh_.file().base(), mesh_.corners_of(t), mesh_.heights_of(t),
                                     mesh_.triangle(t).error, demand_);
    return demand_.touches(facts) && to_rank(demand_(facts)) > 0;
  }

  LocalMesh mesh_;
  const Demand& demand_;
};

}  // namespace

Result<std::optional<delaunay::Tin>> select_tin(const HistoryFile& file, const Demand& demand,
                                                delaunay::TinLinks links, std::uint32_t max_nodes,
                                                Progress& progress) {
  return DemandedTin(file, demand).run(links, max_nodes, progress);
}

Result<delaunay::Tin> tin_around(const HistoryFile& file, std::uint32_t time,
                                 std::span<const Point> places, Progress& progress) {
  LocalSearch search(file, time);
  for (const Point& p : places) {
    if (progress.is_cancelled()) return cancelled_error();
    LODE_CHECK(search.add(
        box_round(p, p), [&](std::uint32_t t) { return holds_place(search.corners_of(t), p); },
        progress));
  }
  return search.take();
}

Result<delaunay::Tin> tin_along(const HistoryFile& file, std::uint32_t time, const Point& a,
                                const Point& b, Progress& progress) {
  if (progress.is_cancelled()) return cancelled_error();
  LocalSearch search(file, time);
  const LatticeBox box = box_round(a, b);
  LODE_CHECK(search.add(
      box,
      [&](std::uint32_t t) {
        const LatticeCorners corners = search.corners_of(t);
        return box_of(corners).meets(box) && !is_beside_line(corners, a, b);
      },
      progress));
  return search.take();
}

Result<std::optional<delaunay::Tin>> tin_within(const HistoryFile& file, std::uint32_t time,
                                                const Point& lower, const Point& upper,
                                                std::uint32_t max_nodes, Progress& progress) {
  if (progress.is_cancelled()) return cancelled_error();
  LocalSearch search(file, time, max_nodes);
  const LatticeBox box = box_round(lower, upper);
  LODE_CHECK(search.add(
      box, [&](std::uint32_t t) { return box_of(search.corners_of(t)).meets(box); }, progress));
  if (search.is_beyond()) return std::optional<delaunay::Tin>();
  return std::optional(search.take());
}

}  // namespace lode::insertions

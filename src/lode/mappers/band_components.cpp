#include "lode/mappers/band_components.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "lode/mappers/border_vertices.h"
#include "lode/mappers/box_pairs.h"

namespace lode {
namespace {

bool contains(const Box3f& outer, const Box3f& inner) {
  for (std::size_t i = 0; i < 3; ++i)
    if (inner.lower[i] < outer.lower[i] || inner.upper[i] > outer.upper[i]) return false;
  return true;
}

class ComponentFinder {
 public:
  ComponentFinder(const Surface& surface, const SurfaceBand& band)
      : surface_(surface), band_(band), numbers_(number_components(surface)) {}

  Result<BandComponents> run(Threads threads, Progress& progress) {
    find_boxes();
    may_go_.assign(numbers_.n, 1);
    keep_open();
    keep_with_fixed(progress);
    if (progress.is_cancelled()) return cancelled_error();
    LODE_CHECK(keep_round_kept(threads, progress));
    return BandComponents{std::move(numbers_), std::move(may_go_)};
  }

 private:
  void find_boxes();
  void keep_open();
  void keep_with_fixed(const Progress& progress);
  [[nodiscard]] Result<void> keep_round_kept(Threads threads, Progress& progress);

  const Surface& surface_;
  const SurfaceBand& band_;
  ComponentNumbers numbers_;
  std::vector<Box3f> boxes_;
  std::vector<std::uint8_t> may_go_;  ///< By component.
};

void ComponentFinder::find_boxes() {
  boxes_.resize(numbers_.n);
  std::vector<std::uint8_t> has_box(numbers_.n, 0);
  for (std::size_t v = 0; v < surface_.positions.size(); ++v) {
    const std::uint32_t c = numbers_.of_vertex[v];
    const Vec3f& p = surface_.positions[v];
    if (has_box[c] == 0) boxes_[c] = {p, p};
    has_box[c] = 1;
    for (std::size_t i = 0; i < 3; ++i) {
      boxes_[c].lower[i] = std::min(boxes_[c].lower[i], p[i]);
      boxes_[c].upper[i] = std::max(boxes_[c].upper[i], p[i]);
    }
  }
}

void ComponentFinder::keep_open() {
  const std::vector<std::uint8_t> is_border = find_border_vertices(surface_);
  for (std::size_t v = 0; v < is_border.size(); ++v)
    if (is_border[v] != 0) may_go_[numbers_.of_vertex[v]] = 0;
}

void ComponentFinder::keep_with_fixed(const Progress& progress) {
  for (const auto& t : surface_.triangles) {
    const std::uint32_t c = numbers_.of_vertex[t[0]];
    if (may_go_[c] == 0) continue;
    if (progress.is_cancelled()) return;
    std::array<Vec3d, 4> tetrahedron;
    tetrahedron[0] =
        band_.own_coordinates((widened(boxes_[c].lower) + widened(boxes_[c].upper)) * 0.5);
    for (std::size_t k = 0; k < 3; ++k)
      tetrahedron[k + 1] = band_.own_coordinates(widened(surface_.positions[t[k]]));
    if (band_.may_hold_fixed(tetrahedron)) may_go_[c] = 0;
  }
}

/// Another may lie inside, and would face the wrong way.
Result<void> ComponentFinder::keep_round_kept(Threads threads, Progress& progress) {
  std::vector<std::vector<IndexPair>> found(static_cast<std::size_t>(n_workers(threads)));
  LODE_CHECK(
      visit_box_pairs(boxes_, threads, progress, [&](std::span<const IndexPair> pairs, int worker) {
        auto& nested = found[static_cast<std::size_t>(worker)];
        for (const auto& [a, b] : pairs) {
          if (contains(boxes_[a], boxes_[b])) nested.push_back({a, b});
          if (contains(boxes_[b], boxes_[a])) nested.push_back({b, a});
        }
      }));
  for (bool changes = true; changes;) {
    changes = false;
    for (const auto& nested : found)
      for (const auto& [outer, inner] : nested)
        if (may_go_[outer] != 0 && may_go_[inner] == 0) {
          may_go_[outer] = 0;
          changes = true;
        }
  }
  return {};
}

}  // namespace

Result<BandComponents> find_components_in_band(const Surface& surface, const SurfaceBand& band,
                                               Threads threads, Progress& progress) {
  if (surface.triangles.empty()) return BandComponents{};
  return ComponentFinder(surface, band).run(threads, progress);
}

Result<Dropped> drop_components_in_band(Surface& surface, const SurfaceBand& band, Threads threads,
                                        Progress& progress) {
  LODE_TRY(const auto found, find_components_in_band(surface, band, threads, progress));
  return drop_components(surface, found.numbers, found.may_go);
}

}  // namespace lode

#include "lode/models/tetra_mt/brought_tetrahedra.h"

#include <algorithm>
#include <array>
#include <optional>

#include "lode/models/tetra_mt/base_order.h"
#include "lode/models/tetra_mt/interfaces.h"
#include "lode/models/tetra_mt/region_masks.h"

namespace lode::tetra_mt {
namespace {

void widen(Box3d& box, const Vec3d& p) {
  for (std::size_t i = 0; i < 3; ++i) {
    box.lower[i] = std::min(box.lower[i], p[i]);
    box.upper[i] = std::max(box.upper[i], p[i]);
  }
}

/// From how many each has to where each begins.
void add_up(std::vector<std::uint64_t>& begins) {
  for (std::size_t i = 1; i < begins.size(); ++i) begins[i] += begins[i - 1];
}

}  // namespace

BroughtTetrahedra::BroughtTetrahedra(const TetraMesh& mesh, const HalfEdgeCollapses& collapses,
                                     std::span<const std::uint32_t> numbers,
                                     std::span<const std::uint32_t> nodes, Hierarchy& result,
                                     Threads threads)
    : mesh_(mesh),
      collapses_(collapses),
      numbers_(numbers),
      nodes_(nodes),
      result_(result),
      threads_(threads),
      boxes_(nodes.size()),
      is_twice_(nodes.size(), 0) {
  std::uint32_t first = 0;
  for (const CollapseStars& stars : collapses.stars) {
    first_collapses_.push_back(first);
    first += static_cast<std::uint32_t>(stars.sizes.size());
  }
  result.targets.resize(nodes.size());
  for (auto* begins : {&result.child_begins, &result.maker_begins, &result.region_begins})
    begins->assign(nodes.size() + 1, 0);
  if (result.region_ids.size() > 1) result.region_masks.resize(nodes.size());
}

/// visit(part, worker) for all collapses, in any order.
template <typename Visit>
void BroughtTetrahedra::visit_parts(const Visit& visit) {
  parallel_for(collapses_.stars.size(), threads_, 1, [&](std::size_t piece, int worker) {
    const CollapseStars& stars = collapses_.stars[piece];
    std::size_t link = 0;
    std::size_t triangle = 0;
    std::size_t child = 0;
    for (std::size_t i = 0; i < stars.sizes.size(); ++i) {
      const CollapseStars::Size& size = stars.sizes[i];
      const std::size_t collapse = first_collapses_[piece] + i;
      Part part{nodes_[collapse],
                number(collapses_.collapses[collapse].kept),
                std::span(stars.link).subspan(link, size.n_link),
                std::span(stars.triangles).subspan(triangle, size.n_triangles),
                std::span(stars.children).subspan(child, size.n_children),
                std::span(stars.makers).subspan(triangle, size.n_triangles),
                {}};
      if (!stars.labels.empty())
        part.labels = std::span(stars.labels).subspan(triangle, size.n_triangles);
      visit(part, worker);
      link += size.n_link;
      triangle += size.n_triangles;
      child += size.n_children;
    }
  });
}

Result<void> BroughtTetrahedra::run() {
  visit_parts([&](const Part& part, int) { count(part); });
  add_up(result_.child_begins);
  add_up(result_.maker_begins);
  add_up(result_.region_begins);
  result_.children.resize(result_.child_begins.back());
  result_.makers.resize(result_.maker_begins.back());
  result_.regions.resize(result_.region_begins.back());
  std::vector<std::vector<Brought>> brought(static_cast<std::size_t>(n_workers(threads_)));
  visit_parts([&](const Part& part, int worker) {
    fill(part, brought[static_cast<std::size_t>(worker)]);
    fill_box(part);
    if (!result_.region_masks.empty()) fill_region_mask(part);
  });
  const auto twice = std::ranges::find(is_twice_, 1);
  if (twice != is_twice_.end())
    return fail("vertex {}: expected different tetrahedra, got two of the same corners",
                result_.n_base_vertices + (twice - is_twice_.begin()));
  take_base();
  return {};
}

/// Whether not all that it brings are of the region, or of the patch, of those that it replaces.
bool BroughtTetrahedra::has_regions_of_its_own(const Part& part) const {
  // Of those with a face, which stay.
  std::array<std::optional<std::uint32_t>, 2> common;
  const auto has_target = [&](std::size_t i) {
    return std::ranges::any_of(part.triangles[i], [&](std::uint8_t place) {
      return number(part.link[place]) == part.target;
    });
  };
  const auto common_of = [&](std::uint32_t label) -> auto& {
    return common[is_outside_label(label) ? 1 : 0];
  };
  for (std::size_t i = 0; i < part.labels.size(); ++i)
    if (!has_target(i)) common_of(part.labels[i]) = part.labels[i];
  return std::ranges::any_of(part.labels,
                             [&](std::uint32_t label) { return label != common_of(label); });
}

void BroughtTetrahedra::count(const Part& part) {
  const std::size_t next = part.node + std::size_t{1};
  result_.child_begins[next] = part.children.size();
  result_.maker_begins[next] = part.triangles.size();
  if (part.labels.empty() || !has_regions_of_its_own(part)) return;
  for (const auto& triangle : part.triangles)
    for (const std::uint8_t place : triangle)
      if (number(part.link[place]) == part.target) ++result_.region_begins[next];
}

void BroughtTetrahedra::fill(const Part& part, std::vector<Brought>& brought) {
  result_.targets[part.node] = part.target;
  brought.clear();
  std::array<std::uint32_t, 0x100> numbers;
  for (std::size_t i = 0; i < part.link.size(); ++i) numbers[i] = number(part.link[i]);
  for (std::uint32_t i = 0; i < part.triangles.size(); ++i) {
    std::array<std::uint32_t, 3> rest{kNone, kNone, kNone};
    std::size_t n = 0;
    for (const std::uint8_t place : part.triangles[i])
      if (numbers[place] != part.target) rest[n++] = numbers[place];
    brought.push_back({n == 2, face_key(rest[0], rest[1], rest[2]), i});
  }
  std::ranges::sort(brought, [](const Brought& a, const Brought& b) {
    return std::pair(a.has_target, a.key) < std::pair(b.has_target, b.key);
  });
  const auto twice = std::ranges::adjacent_find(brought, {}, &Brought::key);
  is_twice_[part.node] = twice == brought.end() ? 0 : 1;

  const auto child_begin = static_cast<std::ptrdiff_t>(result_.child_begins[part.node]);
  const auto children = std::span(result_.children)
                            .subspan(static_cast<std::size_t>(child_begin), part.children.size());
  for (std::size_t i = 0; i < children.size(); ++i)
    children[i] = numbers_[part.children[i]] - result_.n_base_vertices;
  std::ranges::sort(children);
  std::array<std::uint8_t, 0x100> places;
  places[CollapseStars::kReference] = Hierarchy::kReference;
  for (std::size_t i = 0; i < children.size(); ++i) {
    const std::uint32_t child = numbers_[part.children[i]] - result_.n_base_vertices;
    places[i] =
        static_cast<std::uint8_t>(std::ranges::lower_bound(children, child) - children.begin());
  }
  std::uint64_t to = result_.maker_begins[part.node];
  for (const Brought& b : brought) result_.makers[to++] = places[part.makers[b.place]];
  std::uint64_t region = result_.region_begins[part.node];
  if (region == result_.region_begins[part.node + std::size_t{1}]) return;
  for (const Brought& b : brought)
    if (b.has_target) {
      const std::uint32_t label = part.labels[b.place];
      result_.regions[region++] = is_outside_label(label) ? patch_mark(label) : label;
    }
}

void BroughtTetrahedra::fill_box(const Part& part) {
  const Vec3d& own = result_.positions[result_.n_base_vertices + part.node];
  Box3d& box = boxes_[part.node];
  box = {own, own};
  for (const std::uint32_t v : part.link)
    if (v < numbers_.size()) widen(box, mesh_.positions[v]);
}

/// Without labels all are of one region.
void BroughtTetrahedra::fill_region_mask(const Part& part) {
  std::uint64_t& mask = result_.region_masks[part.node];
  if (part.labels.empty()) mask = region_bit(mesh_.regions.empty() ? 0 : mesh_.regions.front());
  for (const std::uint32_t label : part.labels)
    if (!is_outside_label(label)) mask |= region_bit(label);
}

/// In the order in which files have it, which is made of those inside, then of those outside by the
/// faces on which they were.
void BroughtTetrahedra::take_base() {
  const auto maker = [&](std::uint32_t vertex) {
    return vertex == kNone ? kNone : numbers_[vertex] - result_.n_base_vertices;
  };
  const auto numbered = [&](Tetrahedron t) {
    for (std::uint32_t& v : t) v = number(v);
    return t;
  };
  const bool has_regions = result_.region_ids.size() > 1 || !result_.patches.empty();
  const std::uint32_t only = mesh_.regions.empty() ? 0 : mesh_.regions.front();
  result_.n_base_cells = collapses_.base.size();
  for (std::size_t i = 0; i < collapses_.base.size(); ++i) {
    result_.base.push_back(numbered(collapses_.base[i]));
    result_.base_makers.push_back(maker(collapses_.base_makers[i]));
    if (has_regions)
      result_.base_regions.push_back(collapses_.base_regions.empty() ? only
                                                                     : collapses_.base_regions[i]);
  }
  std::vector<std::pair<FaceKey, std::uint32_t>> outer;
  for (std::uint32_t i = 0; i < collapses_.outer_base.size(); ++i) {
    const auto& face = collapses_.outer_base[i].face;
    outer.emplace_back(face_key(number(face[0]), number(face[1]), number(face[2])), i);
  }
  std::ranges::sort(outer);
  for (const auto& [key, i] : outer) {
    result_.base.push_back(numbered(collapses_.outer_base[i].corners));
    result_.base_makers.push_back(maker(collapses_.outer_base[i].maker));
    if (has_regions) result_.base_regions.push_back(collapses_.outer_base[i].patch);
  }
  BaseTetrahedra ordered = in_base_order(
      {std::move(result_.base), std::move(result_.base_makers), std::move(result_.base_regions)});
  result_.base = std::move(ordered.corners);
  result_.base_makers = std::move(ordered.makers);
  result_.base_regions = std::move(ordered.regions);
}

}  // namespace lode::tetra_mt

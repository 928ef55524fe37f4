#include "lode/models/terrain/triangle_hierarchy/patch.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "lode/core/flat_index.h"
#include "lode/delaunay/lattice_mesh.h"

namespace lode::triangle_hierarchy {
namespace {

/// Samples in the triangles, those on edges more than once.
std::size_t count_samples_in(const ReferenceSurface& surface, const Patch& patch) {
  std::size_t n = 0;
  for (const auto& t : patch.triangles)
    n += surface.count_samples(
        {patch.places[t[0]].at, patch.places[t[1]].at, patch.places[t[2]].at});
  return n;
}

class PatchSelector {
 public:
  PatchSelector(const ReferenceSurface& surface, Patch patch, double limit, Outline outline)
      : surface_(surface), patch_(std::move(patch)), limit_(limit), outline_(outline) {}

  Result<SelectedPatch> run(Progress& progress) {
    // Where the mesh looks up places: as many as there may ever be.
    std::vector<LatticePoint> nodes;
    nodes.reserve(patch_.places.size() + count_samples_in(surface_, patch_));
    for (const Place& place : patch_.places) nodes.push_back(place.at);
    nodes.resize(nodes.capacity());
    delaunay::PointMesh mesh(delaunay::ListedNodes{nodes}, patch_.triangles);
    errors_.resize(mesh.triangles().size());
    for (std::uint32_t t = 0; t < errors_.size(); ++t) judge(mesh, t);
    while (!queue_.empty()) {
      const Entry worst = pop();
      if (!is_current(worst)) continue;
      if (patch_.places.size() % kPerCheck == 0 && progress.is_cancelled())
        return cancelled_error();
      const auto node = static_cast<std::uint32_t>(patch_.places.size());
      nodes[node] = worst.at;
      patch_.places.push_back({worst.at, surface_.height(worst.at)});
      const auto made = mesh.insert(node, worst.triangle);
      errors_.resize(mesh.triangles().size());
      for (const std::uint32_t t : made) judge(mesh, t);
    }
    return result(mesh);
  }

 private:
  static constexpr std::size_t kPerCheck = 1 << 12;

  struct Entry {
    double error;
    LatticePoint at;
    std::uint32_t triangle;

    bool operator<(const Entry& other) const {
      return std::tie(error, other.at.y, other.at.x, other.triangle) <
             std::tie(other.error, at.y, at.x, triangle);
    }
  };

  Entry pop() {
    std::pop_heap(queue_.begin(), queue_.end());
    const Entry worst = queue_.back();
    queue_.pop_back();
    return worst;
  }
  [[nodiscard]] bool is_current(const Entry& entry) const {
    const SampleErrors& now = errors_[entry.triangle];
    return now.inner == entry.error && now.at == entry.at;
  }

  void judge(const delaunay::PointMesh& mesh, std::uint32_t t) {
    const delaunay::LatticeTriangle& triangle = mesh.triangles()[t];
    EdgeSet open = kAllEdges;
    if (outline_ == Outline::fixed)
      for (unsigned i = 0; i < 3; ++i)
        if (triangle.twin[i] == delaunay::kNoHalfEdge)
          open = static_cast<EdgeSet>(open & ~(1U << i));
    errors_[t] = surface_.measure_samples(
        {patch_.places[triangle.corner[0]], patch_.places[triangle.corner[1]],
         patch_.places[triangle.corner[2]]},
        open);
    if (errors_[t].inner <= limit_) return;
    queue_.push_back({errors_[t].inner, errors_[t].at, t});
    std::push_heap(queue_.begin(), queue_.end());
  }

  [[nodiscard]] SelectedPatch result(const delaunay::PointMesh& mesh) {
    SelectedPatch made;
    patch_.triangles.clear();
    for (const delaunay::LatticeTriangle& triangle : mesh.triangles())
      patch_.triangles.push_back(triangle.corner);
    made.patch = std::move(patch_);
    made.sample_errors.reserve(errors_.size());
    for (const SampleErrors& errors : errors_) made.sample_errors.push_back(errors.closed);
    return made;
  }

  const ReferenceSurface& surface_;
  Patch patch_;
  double limit_;
  Outline outline_;
  std::vector<SampleErrors> errors_;  ///< By triangle.
  std::vector<Entry> queue_;          ///< A heap.
};

}  // namespace

Patch base_patch(const ReferenceSurface& surface) {
  Patch patch;
  FlatIndex numbers;
  for (const auto& corners : surface.base()) {
    std::array<std::uint32_t, 3> triangle{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto key = (std::uint64_t{static_cast<std::uint32_t>(corners[i].y)} << 32) |
                       static_cast<std::uint32_t>(corners[i].x);
      triangle[i] = numbers.find(key);
      if (triangle[i] != FlatIndex::kNone) continue;
      triangle[i] = static_cast<std::uint32_t>(patch.places.size());
      numbers.insert(key, triangle[i]);
      patch.places.push_back({corners[i], surface.height(corners[i])});
    }
    patch.triangles.push_back(triangle);
  }
  return patch;
}

Result<SelectedPatch> select_samples(const ReferenceSurface& surface, Patch patch, double limit,
                                     Outline outline, Progress& progress) {
  return PatchSelector(surface, std::move(patch), limit, outline).run(progress);
}

}  // namespace lode::triangle_hierarchy

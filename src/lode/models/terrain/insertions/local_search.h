#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"
#include "lode/models/terrain/insertions/box_tree.h"
#include "lode/models/terrain/insertions/local_mesh.h"

namespace lode::insertions {

/// Goes down from the base to the triangles of the last time that meet something.
class LocalSearch {
 public:
  LocalSearch(const HistoryFile& file, std::uint32_t time, std::uint32_t max_nodes = kNone)
      : mesh_(file, time), max_nodes_(max_nodes) {
    std::vector<LatticeBox> boxes;
    for (std::uint32_t t = 0; t < mesh_.n_triangles(); ++t)
      boxes.push_back(box_of(mesh_.corners_of(t)));
    boxes_ = BoxTree(std::move(boxes));
  }

  /// meets(t): where false, nothing that is made in its place does.
  template <typename Meets>
  Result<void> add(const LatticeBox& box, const Meets& meets, const Progress& progress) {
    ++round_;
    open_.clear();
    boxes_.for_each([&](const LatticeBox& other) { return other.meets(box); },
                    [&](std::uint32_t t) {
                      push(t, meets);
                      return true;
                    });
    while (!open_.empty() && !is_beyond()) {
      if (progress.is_cancelled()) return cancelled_error();
      const std::uint32_t t = open_.back();
      open_.pop_back();
      LODE_TRY(const FileNode death, mesh_.death_of(t));
      if (death.time == kNone) {
        found_.push_back(t);
        continue;
      }
      LODE_CHECK(mesh_.apply_death_of(t));
      const auto [begin, end] = mesh_.made_by(mesh_.triangle(t).removed_by);
      for (std::uint32_t made = begin; made < end; ++made) push(made, meets);
    }
    return {};
  }
  [[nodiscard]] LatticeCorners corners_of(std::uint32_t t) const { return mesh_.corners_of(t); }
  /// No sample that is handed down to what is made in the triangle's place is outside.
  [[nodiscard]] HeightRange heights_under(std::uint32_t t) const {
    const auto [lowest, highest] = std::ranges::minmax(mesh_.heights_of(t));
    const double error = mesh_.triangle(t).error;
    return {lowest - error, highest + error};
  }
  /// More nodes were applied than there may be: what was found is not all.
  [[nodiscard]] bool is_beyond() const { return mesh_.n_applied() > max_nodes_; }
  [[nodiscard]] delaunay::Tin take() {
    std::ranges::sort(found_);
    found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
    return mesh_.to_tin(std::move(found_), delaunay::TinLinks::kept);
  }

 private:
  template <typename Meets>
  void push(std::uint32_t t, const Meets& meets) {
    if (seen_.size() <= t) seen_.resize(mesh_.n_triangles());
    if (seen_[t] == round_) return;
    seen_[t] = round_;
    if (meets(t)) open_.push_back(t);
  }

  LocalMesh mesh_;
  std::uint32_t max_nodes_;
  BoxTree boxes_;  ///< Of the base's triangles.
  std::uint32_t round_ = 0;
  std::vector<std::uint32_t> seen_;  ///< By triangle: in which round it was.
  std::vector<std::uint32_t> open_;
  std::vector<std::uint32_t> found_;
};

}  // namespace lode::insertions

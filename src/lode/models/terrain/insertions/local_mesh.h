#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/result.h"
#include "lode/delaunay/grown_nodes.h"
#include "lode/delaunay/lattice_mesh.h"
#include "lode/delaunay/tin.h"
#include "lode/models/terrain/insertions/death_finder.h"
#include "lode/models/terrain/insertions/open_pages.h"
#include "lode/models/terrain/insertions/overlap.h"

namespace lode::insertions {

/// A triangle of the nodes that a question has applied, and what is known of it.
struct LocalTriangle {
  std::array<std::uint32_t, 3> corner;  ///< Vertices as the mesh numbers them.
  std::uint32_t birth = kNone;          ///< The node that made it; kNone: it is of the base.
  std::uint32_t place = 0;              ///< Among those that were made with it.
  float error = 0;
  FileNode death{};                  ///< If it is known.
  std::uint32_t looked_to = 0;       ///< Before this time nothing else removes it.
  std::uint32_t removed_by = kNone;  ///< The number of the node here that is applied.

  /// As History numbers triangles, by when they were made.
  [[nodiscard]] std::uint64_t order() const {
    const std::uint64_t time = birth == kNone ? 0 : std::uint64_t{birth} + 1;
    return time << 32 | place;
  }
};

/// A consistent set of a file's nodes, which grows as it is asked to, from the base on, and all
/// triangles on the way. Any such set makes the triangles that all nodes before would make
/// (docs/models/delaunay_pyramid.md): so which triangles there are, and what removes them, is known
/// from the pages near them. One thread's.
class LocalMesh {
 public:
  /// Of the nodes before `end`, as if there were no others. The file must outlive it.
  LocalMesh(const HistoryFile& file, std::uint32_t end);
  LocalMesh(const LocalMesh&) = delete;
  LocalMesh& operator=(const LocalMesh&) = delete;

  [[nodiscard]] const HistoryFile& file() const { return pages_.file(); }
  [[nodiscard]] std::uint32_t n_triangles() const {
    return static_cast<std::uint32_t>(triangles_.size());
  }
  [[nodiscard]] std::uint32_t n_applied() const {
    return static_cast<std::uint32_t>(first_made_.size() - 1);
  }
  [[nodiscard]] const LocalTriangle& triangle(std::uint32_t t) const { return triangles_[t]; }
  [[nodiscard]] LatticeCorners corners_of(std::uint32_t t) const;
  [[nodiscard]] std::array<double, 3> heights_of(std::uint32_t t) const;

  /// The node that removes a triangle; none where there is none.
  [[nodiscard]] Result<FileNode> death_of(std::uint32_t t);
  /// Applies that node, if it is not, after those that it depends on. Fails, naming the file, where
  /// one cannot be inserted.
  [[nodiscard]] Result<void> apply_death_of(std::uint32_t t);
  /// Of an applied node, by LocalTriangle::removed_by, the triangles that it made: from one number
  /// to before another.
  [[nodiscard]] std::array<std::uint32_t, 2> made_by(std::uint32_t node) const {
    return {first_made_[node], first_made_[node + 1]};
  }
  /// The TIN of some triangles, as tin_of() has it of those.
  [[nodiscard]] delaunay::Tin to_tin(std::vector<std::uint32_t> triangles,
                                     delaunay::TinLinks links) const;

 private:
  /// The node before a time that removes a triangle.
  [[nodiscard]] Result<FileNode> death_before(std::uint32_t t, std::uint32_t end);
  [[nodiscard]] Result<bool> is_ready(const FileNode& node, std::uint32_t t);
  [[nodiscard]] Result<void> want_neighbours(const FileNode& node, delaunay::LatticePoint p,
                                             std::uint32_t t);
  [[nodiscard]] Result<bool> gets_removed(const FileNode& node, delaunay::LatticePoint p,
                                          std::uint32_t outer,
                                          const std::array<delaunay::LatticePoint, 2>& edge);
  void find_removed(delaunay::LatticePoint p, std::uint32_t t);
  void add_removed_behind(delaunay::LatticePoint p, std::uint32_t slot);
  [[nodiscard]] Result<void> insert(const FileNode& node);
  [[nodiscard]] std::uint32_t find_seed(delaunay::LatticePoint p, bool begins_later) const;
  [[nodiscard]] Error not_insertable(const FileNode& node, delaunay::LatticePoint p) const;

  OpenPages pages_;
  DeathFinder deaths_;
  std::uint32_t end_;
  delaunay::InsertionRule rule_;
  std::vector<delaunay::LatticePoint> points_;
  std::vector<double> heights_;
  delaunay::NodeMesh<delaunay::GrownNodes> mesh_;
  std::vector<LocalTriangle> triangles_;
  std::vector<std::uint32_t> slot_of_;     ///< By triangle.
  std::vector<std::uint32_t> at_slot_;     ///< By slot of the mesh, the triangle there.
  std::vector<std::uint32_t> first_made_;  ///< By node applied, and one more.
  std::vector<std::uint32_t> removed_;     ///< What the node at hand removes.
  std::vector<std::uint32_t> wanted_;      ///< Triangles to be removed, the next one last.
};

}  // namespace lode::insertions

#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/delaunay/lattice_mesh.h"
#include "lode/delaunay/worst_sample.h"

namespace lode::delaunay {

/// strict: always the sample with the largest error of all. levels: errors fall by octaves, and
/// within one level samples are inserted where they lie close together, which keeps the work in
/// cache; about as many points. Large rasters are refined in parts, on all threads: the same mesh
/// for any number of them. tiles: of rasters, in levels, each tile on its own between fixed seams
/// (tile_insertion.h).
enum class InsertionOrder : std::uint8_t { levels, strict, tiles };
[[nodiscard]] constexpr const char* name_of(InsertionOrder order) {
  if (order == InsertionOrder::tiles) return "tiles";
  return order == InsertionOrder::strict ? "strict" : "levels";
}

/// Is told what happens to a mesh while samples are inserted. Triangles are judged by then:
/// `errors` are those of all samples in them, edges included, by triangle or in the order of the
/// slots; empty: they are what the mesh says.
template <typename Nodes>
class MeshObserver {
 public:
  virtual ~MeshObserver() = default;
  virtual void on_start(const NodeMesh<Nodes>& mesh, std::span<const float> errors) = 0;
  /// `slots`: of the new triangles; the first n_removed of them were those of removed ones, the
  /// very first of the one that `node` (its number in the mesh) lies in.
  virtual void on_insertion(const NodeMesh<Nodes>& mesh, std::uint32_t node,
                            std::span<const std::uint32_t> slots, std::size_t n_removed,
                            std::span<const float> errors) = 0;
};
using InsertionObserver = MeshObserver<LatticePacking>;
using PointObserver = MeshObserver<ListedNodes>;

struct GreedyOptions {
  double max_error = 0;  ///< >= 0: no sample errs by more in the end.
  std::uint64_t max_triangles = std::numeric_limits<std::uint64_t>::max();  ///< strict only
  InsertionOrder order = InsertionOrder::levels;
  InsertionObserver* observer = nullptr;  ///< Of rasters' samples; strict only.
  Threads threads{};                      ///< Of rasters' samples in levels.
  bool reports = true;                    ///< Progress; it is asked anyway whether to go on.
};

struct GreedyReport {
  std::uint64_t n_inserted = 0;
  double achieved_error = 0;    ///< No sample errs by more; rounded up.
  bool is_within_error = true;  ///< Else max_triangles ended it.
};

/// The Delaunay selector: inserts samples into a mesh until the vertical error |z - z'| of every
/// sample in it is at most max_error (M. Garland, P. Heckbert, "Fast polygonal approximation of
/// terrains and height fields", 1995; the refinement of L. De Floriani, B. Falcidieno, C.
/// Pienovi, 1985). Each triangle knows its worst sample, looked for when the triangle is made.
/// Equal errors are settled by position: rows first. `lower` and `upper`: of the
/// heights. All samples in the mesh's triangles must be finite. Not in tiles. Fails when cancelled.
template <typename T>
[[nodiscard]] Result<GreedyReport> insert_greedily(LatticeMesh& mesh, const SampleRows<T>& rows,
                                                   double lower, double upper,
                                                   const GreedyOptions& options,
                                                   Progress& progress);

}  // namespace lode::delaunay

#pragma once

// Geomorphs between two steps of refinement: the value at each new centre moves from the mean of
// its axis ends, which the coarser mesh has there, to its sample. Any value between gives a field
// that is continuous and linear on the finer mesh, so its isosurface is a manifold, and no vertex
// has to find its way. Borgo, Scopigno, Cignoni, Pascucci, "A Progressive Subdivision Paradigm"
// (2003), moves vertices instead, which works as long as no sign changes.

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "lode/core/flat_index.h"
#include "lode/core/progress.h"
#include "lode/core/surface.h"
#include "lode/mappers/lattice_frame.h"
#include "lode/mappers/simplex_isosurface.h"
#include "lode/models/diamond/refinable.h"

namespace lode::diamond {

/// The diamond hierarchy as an engine refines it, with a note of what is new.
template <int D>
class NotedRefinable : public Refinable<D> {
 public:
  explicit NotedRefinable(const Model<D>& model) : Refinable<D>(model) {}

  std::uint64_t apply(NodeId id) {
    added_.insert(static_cast<std::uint64_t>(id), 0);
    return Refinable<D>::apply(id);
  }
  std::uint64_t undo(NodeId id) {
    added_.erase(static_cast<std::uint64_t>(id));
    return Refinable<D>::undo(id);
  }
  /// The nodes applied since they were forgotten.
  [[nodiscard]] const FlatIndex& added() const { return added_; }
  void forget() { added_ = FlatIndex(); }

 private:
  FlatIndex added_;
};

struct MorphQuery {
  double isovalue = 0;
  bool with_normals = false;
};

/// One step of refinement of an isosurface (contour lines in 2D), and all that lies between its two
/// ends. Holds some 60 bytes a simplex that the surface crosses at any moment, or sweeps over;
/// nothing of the cut or the engine.
template <int D>
class MorphStep {
 public:
  /// `cut`: the finer one; `added`: its nodes that the coarser one does not have, by id. Where both
  /// are answers of isovalue_demand(), no moment reaches beyond the data: nodes at its end, and
  /// what they dominate, are refined in both or never crossed. One thread, some 100 ns a simplex of
  /// the cut. `nodes` must outlive it. Fails when cancelled, or too large to number.
  [[nodiscard]] static Result<MorphStep> find(const Refinable<D>& nodes, const Cut& cut,
                                              const FlatIndex& added, const MorphQuery& query,
                                              Progress& progress);

  /// The surface at moment 0 .. 1: at 0 the coarser one, on the finer mesh; at 1 the finer one as
  /// extract_isosurface() gives it, in another order, with origins where ends of edges keep their
  /// sides. Normals move likewise: as if the gradient were a field of its own.
  [[nodiscard]] Surface surface(double moment) const;

 private:
  using Corners = std::array<std::uint32_t, as_size(D) + 1>;
  struct Point {
    LatticeKey key = 0;
    double before = 0;  ///< Of the field on the coarser mesh.
    double after = 0;
    /// Shortest extents of the crossed simplices round it, for gradients.
    std::int32_t step_before = std::numeric_limits<std::int32_t>::max();
    std::int32_t step_after = std::numeric_limits<std::int32_t>::max();
    [[nodiscard]] double at(double moment) const {
      return moment >= 1 ? after : before + moment * (after - before);
    }
  };
  struct Slopes {
    Vec3f before;
    Vec3f after;
  };
  class Finder;

  MorphStep(const Refinable<D>& nodes, const MorphQuery& query);
  [[nodiscard]] std::uint32_t number_of(LatticeKey key) const { return number_at_.find(key); }
  void find_slopes(const FlatIndex& added);
  void add_vertices(const IsoPart<D>& part, Surface& surface) const;
  void add_origins(const IsoPart<D>& part, Surface& surface) const;
  void add_normals(const IsoPart<D>& part, double moment, Surface& surface) const;

  const Model<D>* model_;
  MorphQuery query_;
  LatticeFrame frame_;
  std::vector<Corners> leaves_;
  std::vector<Point> points_;
  std::vector<Slopes> slopes_;  ///< The field's, in grid axes; of each point, with normals.
  FlatIndex number_at_;         ///< Of points, by key.
};

extern template class MorphStep<2>;
extern template class MorphStep<3>;

}  // namespace lode::diamond

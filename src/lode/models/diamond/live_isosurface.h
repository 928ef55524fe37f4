#pragma once

// The isosurface of a cut, kept while the cut changes. Borgo, Scopigno, Cignoni, Pascucci, "A
// Progressive Subdivision Paradigm" (2003), section 4.2.1: a refined diamond inherits the vertices
// of its fathers and interpolates only those on the edges to its centre.

#include <array>
#include <cstdint>
#include <vector>

#include "lode/core/flat_index.h"
#include "lode/core/paged_array.h"
#include "lode/core/surface_batch.h"
#include "lode/mappers/iso_part.h"
#include "lode/models/diamond/refinable.h"

namespace lode::diamond {

/// Whether vertices are taken over from what is there. Off: a node makes all of its own, as
/// section 4.2.3's plain version does, for the same surface; `./dev bench papers` compares.
enum class Inheritance : std::uint8_t { on, off };

/// What keeping a surface has cost.
struct LiveCounts {
  std::uint64_t n_applied = 0;         ///< Nodes with a piece of the surface in them.
  std::uint64_t n_interpolations = 0;  ///< Vertices made.
  std::uint64_t n_without = 0;         ///< As many as without inheritance: all in those nodes.
};

/// One isosurface (contour lines in 2D) of a cut that is told node by node how it changes. Cells
/// lie in slots, four triangles (two lines) for the two simplices that a node passes to a child;
/// vertices in slots of their own, one for each crossed edge. Beyond the data, where a cut has not
/// been refined down to the border yet, the surface goes on in the extended field; simplices that
/// are part hole and part not have none until they are refined.
template <int D, typename Field = Model<D>>
class LiveIsosurface {
 public:
  /// At the base. Both must outlive it.
  LiveIsosurface(const Refinable<D, Field>& nodes, double isovalue, bool with_normals,
                 Inheritance inheritance = Inheritance::on);

  /// The node's parents are applied and it is not; the surface follows.
  void apply(NodeId id);
  /// The reverse; no node that depends on it is applied.
  void undo(NodeId id);

  [[nodiscard]] double isovalue() const { return isovalue_; }
  [[nodiscard]] const LiveCounts& counts() const { return counts_; }
  [[nodiscard]] std::size_t n_cells() const { return n_cells_; }
  [[nodiscard]] std::size_t n_vertices() const { return vertex_at_.size(); }

  /// The surface as it is, without unused slots.
  void write(Surface& surface) const;

  /// How many slots have changed since they were gathered.
  [[nodiscard]] std::size_t n_changed() const {
    return changed_vertices_.size() + changed_blocks_.size();
  }
  /// Moves up to `n_most` changed slots into a batch; true when none is left. A reader that has
  /// taken all batches that were complete has the surface as it is.
  bool gather(std::size_t n_most, SurfaceBatch& batch);
  /// Counts the slots of a batch that nobody has taken as changed again.
  void take_back(const SurfaceBatch& batch);

 private:
  using Cell = SurfaceBatch::Cell;
  static constexpr std::uint32_t kCellsPerBlock = D == 3 ? 4 : 2;
  static constexpr std::size_t kSteps = power(3, D);
  static constexpr LatticeKey kNoLink = ~LatticeKey{0};

  struct Vertex {
    LatticeKey key = 0;
    std::uint32_t n_uses = 0;  ///< Corners of cells; 0: unused.
    bool is_changed = false;
    Vec3f position;
    Vec3f normal;
  };
  struct Block {
    std::array<Cell, kCellsPerBlock> cells{};
    std::uint32_t n_cells = 0;
    bool is_changed = false;
  };
  struct Star;  // with samples; in the .cpp

  void load(const Diamond<D>& node, Star& star) const;
  template <typename Near>
  void load_values(const Near& near, Star& star) const;
  [[nodiscard]] bool is_present(const Simplex<D>& s) const;
  [[nodiscard]] LatticeKey link_of(const Star& star, const Index<D>& link_to) const;
  void add_unrefined(Star& star);
  void add_halves(Star& star);
  template <typename Piece>
  void add_piece(Star& star, const Piece& piece, LatticeKey link);
  void remove_link(LatticeKey link);
  std::uint32_t vertex_on(Star& star, std::size_t i, std::size_t j);
  std::uint32_t add_vertex(LatticeKey key);
  void interpolate(Vertex& vertex, const Star& star, std::size_t i, std::size_t j);
  void count(const Star& star);
  void free_unused();
  void mark_vertex(std::uint32_t slot);
  void mark_block(std::uint32_t block);
  void put(std::uint32_t block, Cell cell);

  const Refinable<D, Field>& nodes_;
  const Field& model_;
  LatticeFrame frame_;
  double isovalue_;
  bool with_normals_;
  Inheritance inheritance_;
  FlatIndex vertex_at_;  ///< By doubled midpoint.
  FlatIndex block_at_;   ///< By the sum of node and child.
  PagedArray<Vertex> vertices_;
  PagedArray<Block> blocks_;
  std::vector<std::uint32_t> free_vertices_;
  std::vector<std::uint32_t> free_blocks_;
  std::vector<std::uint32_t> changed_vertices_;
  std::vector<std::uint32_t> changed_blocks_;
  std::vector<std::uint32_t> unused_;  ///< Vertices that may have lost their last use.
  std::size_t n_cells_ = 0;
  LiveCounts counts_;
};

extern template class LiveIsosurface<2>;
extern template class LiveIsosurface<3>;

/// The diamond hierarchy with an isosurface that follows the engine.
template <int D, typename Field = Model<D>>
class LiveRefinable : public Refinable<D, Field> {
 public:
  /// `worlds`: as Refinable's, if any.
  template <typename... Worlds>
  explicit LiveRefinable(const Field& model, const Worlds&... worlds)
      : Refinable<D, Field>(model, worlds...) {}

  void follow(LiveIsosurface<D, Field>* surface) { surface_ = surface; }
  std::uint64_t apply(NodeId id) {
    if (surface_ != nullptr) surface_->apply(id);
    return Refinable<D, Field>::apply(id);
  }
  std::uint64_t undo(NodeId id) {
    if (surface_ != nullptr) surface_->undo(id);
    return Refinable<D, Field>::undo(id);
  }

 private:
  LiveIsosurface<D, Field>* surface_ = nullptr;
};

}  // namespace lode::diamond

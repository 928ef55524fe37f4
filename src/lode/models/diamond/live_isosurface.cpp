#include "lode/models/diamond/live_isosurface.h"

#include <bitset>

#include "lode/mappers/march_simplex.h"
#include "lode/models/diamond/near_samples.h"
#include "lode/models/diamond/normals.h"
#include "lode/models/diamond/paged_model.h"
#include "lode/models/diamond/star.h"

namespace lode::diamond {
namespace {

/// A simplex of a star or one of its halves: its corners as numbers of steps.
template <int D>
struct LivePiece {
  std::array<std::uint8_t, as_size(D) + 1> corner{};
  Index<D> link_to;    ///< The other node of its link, in half steps from the centre.
  Simplex<D> simplex;  ///< In steps.
  bool is_negative = false;
};

template <int D>
struct LiveTemplate {
  std::vector<std::uint8_t> used;  ///< Numbers of the steps its simplices have, not the centre.
  std::vector<LivePiece<D>> unrefined;             ///< Linked to parents.
  std::vector<LivePiece<D>> halves;                ///< Linked to children.
  std::vector<std::array<std::uint8_t, 2>> edges;  ///< Of the halves.
};

template <int D>
constexpr std::size_t number_of(const Index<D>& step) {
  return linear_index<D>(all_equal<D>(3), step + all_equal<D>(1));
}

template <int D>
bool is_negative(const Simplex<D>& s) {
  std::array<Index<D>, as_size(D)> edge;
  for (std::size_t j = 0; j < as_size(D); ++j) edge[j] = s.v[j + 1] - s.v[0];
  if constexpr (D == 3)
    return dot(cross(edge[0], edge[1]), edge[2]) < 0;
  else
    return edge[0][0] * edge[1][1] - edge[0][1] * edge[1][0] < 0;
}

template <int D>
LivePiece<D> make_piece(const Simplex<D>& s, const Index<D>& link_to) {
  LivePiece<D> piece;
  for (std::size_t i = 0; i <= as_size(D); ++i)
    piece.corner[i] = static_cast<std::uint8_t>(number_of<D>(s.v[i]));
  piece.link_to = link_to;
  piece.simplex = s;
  piece.is_negative = is_negative<D>(s);
  return piece;
}

/// Which parent a simplex comes from is its newest vertex: the centre of the next larger face, or
/// of a cube's simplex the corner after the first.
template <int D>
LiveTemplate<D> make_live_template(const Index<D>& axis) {
  LiveTemplate<D> result;
  std::array<bool, power(3, D)> is_used{};
  for (const Simplex<D>& s : star_of_axis<D>(axis).simplices) {
    const Index<D> parent = s.v[s.tag == D ? 1 : as_size(s.tag) + 1];
    result.unrefined.push_back(make_piece<D>(s, parent * 2));
    for (const Index<D>& v : s.v) is_used[number_of<D>(v)] = true;
    for (const Simplex<D>& half : bisect(s))
      result.halves.push_back(make_piece<D>(half, half.v[0] + half.v[as_size(half.tag)]));
  }
  for (const LivePiece<D>& half : result.halves)
    for (std::size_t i = 0; i <= as_size(D); ++i)
      for (std::size_t j = i + 1; j <= as_size(D); ++j)
        result.edges.push_back(
            {std::min(half.corner[i], half.corner[j]), std::max(half.corner[i], half.corner[j])});
  std::sort(result.edges.begin(), result.edges.end());
  result.edges.erase(std::unique(result.edges.begin(), result.edges.end()), result.edges.end());
  for (std::size_t i = 0; i < is_used.size(); ++i)
    if (is_used[i]) result.used.push_back(static_cast<std::uint8_t>(i));
  return result;
}

template <int D>
const LiveTemplate<D>& live_template(const Diamond<D>& d) {
  static const std::vector<LiveTemplate<D>> kTemplates = [] {
    std::vector<LiveTemplate<D>> all(power(3, D));
    for (std::size_t code = 0; code < all.size(); ++code) {
      const Index<D> axis = point_of<D>(all_equal<D>(3), code) - all_equal<D>(1);
      if (axis != Index<D>{}) all[code] = make_live_template<D>(axis);
    }
    return all;
  }();
  Index<D> step = axis_ends<D>(d)[0] - d.centre;
  for (std::size_t i = 0; i < as_size(D); ++i) step[i] >>= d.level;
  return kTemplates[number_of<D>(step)];
}

}  // namespace

/// A node's star with its samples.
template <int D, typename Field>
struct LiveIsosurface<D, Field>::Star {
  Diamond<D> node;
  LatticeKey centre = 0;
  const LiveTemplate<D>* shape = nullptr;
  std::array<double, kSteps> value;
  std::array<LatticeKey, kSteps> key;
  bool is_crossed = false;            ///< By the surface after bisection,
  bool is_crossed_before = false;     ///< and without it.
  std::bitset<kSteps * kSteps> made;  ///< Edges whose vertices it made, without inheritance.
};

template <int D, typename Field>
LiveIsosurface<D, Field>::LiveIsosurface(const Refinable<D, Field>& nodes, double isovalue,
                                         bool with_normals, Inheritance inheritance)
    : nodes_(nodes),
      model_(nodes.model()),
      frame_(LatticeFrame::of(model_.info.grid)),
      isovalue_(isovalue),
      with_normals_(with_normals),
      inheritance_(inheritance) {
  std::vector<NodeId> base;
  nodes_.add_base(base);
  for (const NodeId id : base) {
    Star star;
    load(diamond_of<D>(id), star);
    add_unrefined(star);
  }
}

template <int D, typename Field>
void LiveIsosurface<D, Field>::load(const Diamond<D>& node, Star& star) const {
  star.node = node;
  star.shape = &live_template<D>(node);
  visit_storage_type(model_.storage, [&]<typename T>() {
    load_values(NearSamples<D, T>(model_, node.centre, 1, node.level), star);
  });
}

template <int D, typename Field>
template <typename Near>
void LiveIsosurface<D, Field>::load_values(const Near& near, Star& star) const {
  std::size_t n_inside = 0;
  bool has_hole = false;
  const auto load_one = [&](std::size_t i) {
    const Index<D> steps = point_of<D>(all_equal<D>(3), i) - all_equal<D>(1);
    const Index<D> p = star.node.centre + steps * star.node.h();
    for (std::size_t a = 0; a < as_size(D); ++a)
      if (p[a] < 0) {  // outside the root cube: of no simplex in the data
        star.value[i] = std::numeric_limits<double>::quiet_NaN();
        return false;
      }
    star.key[i] = to_key(model_.axes.to_grid(p));
    star.value[i] = near_value(near, model_, p, steps);
    has_hole = has_hole || std::isnan(star.value[i]);
    return star.value[i] >= isovalue_;
  };
  std::size_t n_used = star.shape->used.size();
  for (const std::uint8_t i : star.shape->used) n_inside += load_one(i) ? 1 : 0;
  const std::size_t middle = number_of<D>({});
  const bool is_centre_inside = load_one(middle);
  star.centre = star.key[middle];
  star.is_crossed_before = has_hole || (n_inside > 0 && n_inside < n_used);
  n_inside += is_centre_inside ? 1 : 0;
  star.is_crossed = has_hole || (n_inside > 0 && n_inside < n_used + 1);
}

/// Whether a simplex with finite corners, at its place, has a piece of the domain and can be
/// interpolated in.
template <int D, typename Field>
bool LiveIsosurface<D, Field>::is_present(const Simplex<D>& s) const {
  if (!model_.shape.overlaps_data(bounds_of(s))) return false;
  if (!model_.has_holes()) return true;
  if (is_finest(s)) return !model_.is_removed_cell(bounds_of(s).lower);
  return std::isfinite(nodes_.facts(id_of<D>(s.bisection_point())).error);
}

template <int D, typename Field>
std::uint32_t LiveIsosurface<D, Field>::add_vertex(LatticeKey key) {
  std::uint32_t slot;
  if (free_vertices_.empty()) {
    slot = static_cast<std::uint32_t>(vertices_.size());
    vertices_.add();
  } else {
    slot = free_vertices_.back();
    free_vertices_.pop_back();
  }
  vertices_[slot].key = key;
  vertices_[slot].n_uses = 0;
  mark_vertex(slot);
  vertex_at_.insert(key, slot);
  return slot;
}

template <int D, typename Field>
void LiveIsosurface<D, Field>::interpolate(Vertex& vertex, const Star& star, std::size_t i,
                                           std::size_t j) {
  EdgePoint point = crossing(star.key[i], star.value[i], star.key[j], star.value[j], isovalue_);
  point.t = std::clamp(point.t, frame_.margin, 1 - frame_.margin);
  const Vec3d p = frame_.position(point.lattice_position());
  vertex.position = {
      {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}};
  if (with_normals_)
    visit_storage_type(model_.storage, [&]<typename T>() {
      vertex.normal = NormalSampler<D, T, Field>(model_).at(point);
    });
  ++counts_.n_interpolations;
}

template <int D, typename Field>
std::uint32_t LiveIsosurface<D, Field>::vertex_on(Star& star, std::size_t i, std::size_t j) {
  const LatticeKey key = star.key[i] + star.key[j];
  const std::uint32_t known = vertex_at_.find(key);
  if (known != FlatIndex::kNone && inheritance_ == Inheritance::on) return known;
  const std::uint32_t slot = known != FlatIndex::kNone ? known : add_vertex(key);
  if (inheritance_ == Inheritance::off) {
    const std::size_t edge = std::min(i, j) * kSteps + std::max(i, j);
    if (star.made[edge]) return slot;
    star.made.set(edge);
  }
  interpolate(vertices_[slot], star, i, j);
  return slot;
}

template <int D, typename Field>
void LiveIsosurface<D, Field>::put(std::uint32_t block, Cell cell) {
  blocks_[block].cells[blocks_[block].n_cells++] = cell;
  for (int i = 0; i < D; ++i) ++vertices_[cell[as_size(i)]].n_uses;
  ++n_cells_;
  mark_block(block);
}

/// Adds a piece's cells to the block of its link.
template <int D, typename Field>
template <typename Piece>
void LiveIsosurface<D, Field>::add_piece(Star& star, const Piece& piece, LatticeKey link) {
  std::size_t inside = 0;
  for (std::size_t i = 0; i <= as_size(D); ++i)
    inside |= static_cast<std::size_t>(star.value[piece.corner[i]] >= isovalue_) << i;
  if (inside == 0 || inside == (std::size_t{2} << D) - 1) return;
  for (const std::uint8_t i : piece.corner)
    if (std::isnan(star.value[i])) return;
  if (link == kNoLink || !is_present(placed(piece.simplex, star.node))) return;
  std::uint32_t block = block_at_.find(link);
  if (block == FlatIndex::kNone) {
    if (free_blocks_.empty()) {
      block = static_cast<std::uint32_t>(blocks_.size());
      blocks_.add();
    } else {
      block = free_blocks_.back();
      free_blocks_.pop_back();
    }
    block_at_.insert(link, block);
  }
  march_simplex<D>(
      inside, piece.is_negative != frame_.is_mirrored,
      [&](std::size_t i, std::size_t j) {
        return vertex_on(star, piece.corner[i], piece.corner[j]);
      },
      [&](const auto& cell) {
        if constexpr (D == 3)
          put(block, cell);
        else
          put(block, {cell[0], cell[1], cell[1]});
      });
}

template <int D, typename Field>
void LiveIsosurface<D, Field>::remove_link(LatticeKey link) {
  if (link == kNoLink) return;
  const std::uint32_t block = block_at_.erase(link);
  if (block == FlatIndex::kNone) return;
  for (std::uint32_t c = 0; c < blocks_[block].n_cells; ++c) {
    const Cell cell = std::exchange(blocks_[block].cells[c], SurfaceBatch::kRemoved);
    for (int i = 0; i < D; ++i)
      if (--vertices_[cell[as_size(i)]].n_uses == 0) unused_.push_back(cell[as_size(i)]);
    --n_cells_;
  }
  blocks_[block].n_cells = 0;
  free_blocks_.push_back(block);
  mark_block(block);
}

/// A link's name: the doubled midpoint of a node and a child of it, which is no other's. Below the
/// finest nodes there are unit cells instead: the lowest corner, and a mark. Outside the root cube
/// there is none.
template <int D, typename Field>
LatticeKey LiveIsosurface<D, Field>::link_of(const Star& star, const Index<D>& link_to) const {
  const Diamond<D>& node = star.node;
  Index<D> sum;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    sum[i] = 2 * node.centre[i] + ((link_to[i] * node.h()) >> 1);
    if (sum[i] < 0) return kNoLink;
  }
  const LatticeKey link = to_key(model_.axes.to_grid(sum));
  const bool is_cell = node.level == 0 && ((link_to[0] * node.h()) & 1) != 0;
  return is_cell ? link | LatticeKey{1} << 63 : link;
}

/// Without bisection: its simplices lie in the links from its parents.
template <int D, typename Field>
void LiveIsosurface<D, Field>::add_unrefined(Star& star) {
  if (!star.is_crossed_before) return;
  for (const auto& piece : star.shape->unrefined)
    add_piece(star, piece, link_of(star, piece.link_to));
}

template <int D, typename Field>
void LiveIsosurface<D, Field>::add_halves(Star& star) {
  if (!star.is_crossed) return;
  for (const auto& piece : star.shape->halves) add_piece(star, piece, link_of(star, piece.link_to));
}

/// What is added comes first: vertices that both have are inherited.
template <int D, typename Field>
void LiveIsosurface<D, Field>::apply(NodeId id) {
  Star star;
  load(diamond_of<D>(id), star);
  add_halves(star);
  if (star.is_crossed) count(star);
  if (star.is_crossed_before)
    for (const auto& piece : star.shape->unrefined) remove_link(link_of(star, piece.link_to));
  free_unused();
}

template <int D, typename Field>
void LiveIsosurface<D, Field>::undo(NodeId id) {
  Star star;
  load(diamond_of<D>(id), star);
  add_unrefined(star);
  if (star.is_crossed)
    for (const auto& piece : star.shape->halves) remove_link(link_of(star, piece.link_to));
  free_unused();
}

/// What it would cost to find all its vertices anew: 26, 18 and 34 edges, of which 8, 6 and 10 end
/// at the centre.
template <int D, typename Field>
void LiveIsosurface<D, Field>::count(const Star& star) {
  ++counts_.n_applied;
  for (const auto& [i, j] : star.shape->edges)
    counts_.n_without += (star.value[i] >= isovalue_) != (star.value[j] >= isovalue_) ? 1 : 0;
}

template <int D, typename Field>
void LiveIsosurface<D, Field>::free_unused() {
  for (const std::uint32_t slot : unused_) {
    if (vertices_[slot].n_uses > 0) continue;
    vertex_at_.erase(vertices_[slot].key);
    free_vertices_.push_back(slot);
    mark_vertex(slot);
  }
  unused_.clear();
}

template <int D, typename Field>
void LiveIsosurface<D, Field>::mark_vertex(std::uint32_t slot) {
  if (!std::exchange(vertices_[slot].is_changed, true)) changed_vertices_.push_back(slot);
}

template <int D, typename Field>
void LiveIsosurface<D, Field>::mark_block(std::uint32_t block) {
  if (!std::exchange(blocks_[block].is_changed, true)) changed_blocks_.push_back(block);
}

template <int D, typename Field>
void LiveIsosurface<D, Field>::write(Surface& surface) const {
  surface.clear();
  surface.origin = frame_.surface_origin;
  std::vector<std::uint32_t> id(vertices_.size());
  surface.positions.reserve(vertex_at_.size());
  for (std::size_t slot = 0; slot < vertices_.size(); ++slot) {
    const Vertex& vertex = vertices_[slot];
    if (vertex.n_uses == 0) continue;
    id[slot] = static_cast<std::uint32_t>(surface.positions.size());
    surface.positions.push_back(vertex.position);
    if (with_normals_) surface.normals.push_back(vertex.normal);
  }
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    for (std::uint32_t c = 0; c < blocks_[b].n_cells; ++c) {
      const Cell& cell = blocks_[b].cells[c];
      if constexpr (D == 3)
        surface.triangles.push_back({id[cell[0]], id[cell[1]], id[cell[2]]});
      else
        surface.lines.push_back({id[cell[0]], id[cell[1]]});
    }
}

template <int D, typename Field>
bool LiveIsosurface<D, Field>::gather(std::size_t n_most, SurfaceBatch& batch) {
  batch.origin = frame_.surface_origin;
  if (batch.cells.empty() && batch.vertices.empty()) {
    batch.vertices.reserve(changed_vertices_.size());
    batch.positions.reserve(changed_vertices_.size());
    if (with_normals_) batch.normals.reserve(changed_vertices_.size());
    batch.cells.reserve(kCellsPerBlock * changed_blocks_.size());
    batch.corners.reserve(kCellsPerBlock * changed_blocks_.size());
  }
  batch.n_vertex_slots = static_cast<std::uint32_t>(vertices_.size());
  batch.n_cell_slots = static_cast<std::uint32_t>(blocks_.size()) * kCellsPerBlock;
  for (; n_most > 0 && !changed_vertices_.empty(); --n_most) {
    const std::uint32_t slot = changed_vertices_.back();
    changed_vertices_.pop_back();
    Vertex& vertex = vertices_[slot];
    vertex.is_changed = false;
    if (vertex.n_uses == 0) {
      batch.removed_vertices.push_back(slot);
      continue;
    }
    batch.vertices.push_back(slot);
    batch.positions.push_back(vertex.position);
    if (with_normals_) batch.normals.push_back(vertex.normal);
  }
  for (; n_most > 0 && !changed_blocks_.empty(); --n_most) {
    const std::uint32_t block = changed_blocks_.back();
    changed_blocks_.pop_back();
    blocks_[block].is_changed = false;
    for (std::uint32_t c = 0; c < kCellsPerBlock; ++c) {
      batch.cells.push_back(block * kCellsPerBlock + c);
      batch.corners.push_back(blocks_[block].cells[c]);
    }
  }
  return n_changed() == 0;
}

template <int D, typename Field>
void LiveIsosurface<D, Field>::take_back(const SurfaceBatch& batch) {
  for (const std::uint32_t slot : batch.vertices) mark_vertex(slot);
  for (const std::uint32_t slot : batch.removed_vertices) mark_vertex(slot);
  for (const std::uint32_t cell : batch.cells) mark_block(cell / kCellsPerBlock);
}

template class LiveIsosurface<2>;
template class LiveIsosurface<3>;
template class LiveIsosurface<2, PagedModel<2>>;
template class LiveIsosurface<3, PagedModel<3>>;

}  // namespace lode::diamond

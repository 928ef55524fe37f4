#include "lode/mappers/mesh_isosurface.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>
#include <utility>

#include "lode/core/expects.h"
#include "lode/core/parallel_fill.h"
#include "lode/core/uninitialized_array.h"
#include "lode/mappers/crossed_edge.h"
#include "lode/mappers/march_simplex.h"
#include "lode/mappers/vertex_ids.h"

namespace lode {
namespace {

/// Cells that are marched together: their corners and edges stay in a core's own cache.
constexpr std::size_t kBlockCells = 8192;
constexpr std::size_t kMostParts = 256;

/// What one block of cells has of the surface.
struct MarchedBlock {
  std::vector<std::uint64_t> edges;  ///< Crossed, each once; those of part 0 first, and so on.
  std::vector<std::uint32_t> part_begins;  ///< By part, and one more: places in `edges`.
  std::vector<std::uint32_t> ids;          ///< By edge: its number in its part, then the vertex.
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Of places in `edges`.
  std::vector<std::uint32_t> cells;                     ///< By triangle, where cells have regions.
  std::size_t first_triangle = 0;
  float largest_error = 0;
};

/// Crossed edges of all blocks whose smaller end lies in one interval of the mesh's vertices.
struct EdgePart {
  std::vector<std::uint64_t> edges;  ///< By number.
  std::uint32_t first_id = 0;
};

/// Numbers a block's edges. It remembers the last one of each slot: edges that share one may get
/// several numbers, which parts make one.
class EdgeCache {
 public:
  void clear(std::size_t n_most) {
    keys_.fill(kNone);
    edges_.resize(n_most);
    n_edges_ = 0;
  }
  std::uint32_t find_or_add(std::uint64_t edge) {
    // The shift brings in edges that differ in high bits only.
    const std::uint64_t mixed = (edge ^ edge >> 32) * 0x9E3779B97F4A7C15ULL;
    const auto slot = static_cast<std::size_t>(mixed >> (64 - kBits));
    if (keys_[slot] == edge) return ids_[slot];
    keys_[slot] = edge;
    ids_[slot] = n_edges_;
    edges_[n_edges_] = edge;
    return n_edges_++;
  }
  [[nodiscard]] std::span<const std::uint64_t> edges() const {
    return std::span(edges_).first(n_edges_);
  }

 private:
  static constexpr unsigned kBits = 12;
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};  ///< No edge has equal ends.

  std::array<std::uint64_t, std::size_t{1} << kBits> keys_{};
  std::array<std::uint32_t, std::size_t{1} << kBits> ids_{};
  std::vector<std::uint64_t> edges_;
  std::uint32_t n_edges_ = 0;
};

/// What a thread needs to march a block, or to number a part.
struct MarchScratch {
  EdgeCache cache;
  VertexIds ids;
  std::vector<std::uint32_t> active;
  std::vector<std::uint32_t> places;
};

/// Marches blocks of cells side by side, each with edges of its own; then edges are made one and
/// numbered by parts, side by side too: by the blocks in their order, whoever marched them.
class MeshMarcher {
 public:
  MeshMarcher(const SimplexMesh& mesh, double isovalue, const MeshIsosurfaceOptions& options,
              Surface& surface);

  double run();

 private:
  [[nodiscard]] std::size_t n_blocks() const {
    return (mesh_.tetrahedra.size() + kBlockCells - 1) / kBlockCells;
  }
  [[nodiscard]] bool is_inside(std::uint32_t vertex) const { return inside_[vertex] != 0; }
  [[nodiscard]] std::size_t part_of(std::uint64_t edge) const { return edge >> 32 >> part_shift_; }
  [[nodiscard]] std::size_t inside_of(const std::array<std::uint32_t, 4>& cell) const;

  void find_inside();
  void find_active(std::size_t begin, std::size_t end, std::vector<std::uint32_t>& active) const;
  void march(std::size_t at, MarchScratch& scratch, MarchedBlock& block) const;
  void march_block(std::size_t at, MarchScratch& scratch, MarchedBlock& block) const;
  void sort_by_part(MarchScratch& scratch, MarchedBlock& block) const;
  void number_part(std::size_t at, VertexIds& ids);
  void make_room();
  void place_part(const EdgePart& part);
  void write_block(MarchedBlock& block);

  const SimplexMesh& mesh_;
  double isovalue_;
  MeshIsosurfaceOptions options_;
  Surface& surface_;
  unsigned part_shift_ = 0;
  UninitializedArray<std::uint8_t> inside_;  ///< By vertex: 1 where it has the isovalue or more.
  std::vector<MarchedBlock> blocks_;
  std::vector<EdgePart> parts_;
};

MeshMarcher::MeshMarcher(const SimplexMesh& mesh, double isovalue,
                         const MeshIsosurfaceOptions& options, Surface& surface)
    : mesh_(mesh), isovalue_(isovalue), options_(options), surface_(surface) {
  const std::size_t n_vertices = std::max<std::size_t>(mesh.positions.size(), 1);
  const std::size_t n_wanted = std::clamp<std::size_t>(n_blocks(), 1, kMostParts);
  while ((n_vertices - 1) >> part_shift_ >= n_wanted) ++part_shift_;
  parts_.resize(((n_vertices - 1) >> part_shift_) + 1);
  blocks_.resize(n_blocks());
}

void MeshMarcher::find_inside() {
  resize_anew(inside_, mesh_.values.size());
  for_each_piece(inside_.size(), options_.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) inside_[v] = mesh_.values[v] >= isovalue_ ? 1 : 0;
  });
}

std::size_t MeshMarcher::inside_of(const std::array<std::uint32_t, 4>& cell) const {
  const std::uint8_t* const inside = inside_.data();
  return static_cast<std::size_t>(inside[cell[0]] | inside[cell[1]] << 1 | inside[cell[2]] << 2 |
                                  inside[cell[3]] << 3);
}

/// Without branches, which would be guessed wrongly at every fifth cell or so.
void MeshMarcher::find_active(std::size_t begin, std::size_t end,
                              std::vector<std::uint32_t>& active) const {
  active.resize(kBlockCells);
  std::size_t n = 0;
  for (std::size_t at = begin; at < end; ++at) {
    active[n] = static_cast<std::uint32_t>(at);
    n += ((inside_of(mesh_.tetrahedra[at]) + 1) & 15) > 1 ? 1 : 0;
  }
  active.resize(n);
}

void MeshMarcher::march(std::size_t at, MarchScratch& scratch, MarchedBlock& block) const {
  const auto& cell = mesh_.tetrahedra[at];
  march_simplex<3>(
      inside_of(cell), false,
      [&](std::size_t i, std::size_t j) {
        return scratch.cache.find_or_add(edge_key(cell[i], cell[j]));
      },
      [&](const std::array<std::uint32_t, 3>& t) {
        block.triangles.push_back(t);
        if (!mesh_.regions.empty()) block.cells.push_back(static_cast<std::uint32_t>(at));
      });
  block.largest_error = std::max(block.largest_error, mesh_.errors[at]);
}

void MeshMarcher::march_block(std::size_t at, MarchScratch& scratch, MarchedBlock& block) const {
  const std::size_t begin = at * kBlockCells;
  find_active(begin, std::min(begin + kBlockCells, mesh_.tetrahedra.size()), scratch.active);
  if (scratch.active.empty()) return;
  scratch.cache.clear(4 * scratch.active.size());
  block.triangles.reserve(2 * scratch.active.size());
  for (const std::uint32_t cell : scratch.active) march(cell, scratch, block);
  sort_by_part(scratch, block);
}

/// Counts, adds up, writes: edges of a part stay in the order in which they were met.
void MeshMarcher::sort_by_part(MarchScratch& scratch, MarchedBlock& block) const {
  const std::span<const std::uint64_t> edges = scratch.cache.edges();
  std::vector<std::uint32_t>& begins = block.part_begins;
  begins.assign(parts_.size() + 1, 0);
  for (const std::uint64_t edge : edges) ++begins[part_of(edge)];
  std::uint32_t sum = 0;
  for (std::uint32_t& begin : begins) sum += std::exchange(begin, sum);
  scratch.places.resize(edges.size());
  block.edges.resize(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const std::uint32_t place = begins[part_of(edges[i])]++;
    scratch.places[i] = place;
    block.edges[place] = edges[i];
  }
  std::copy_backward(begins.begin(), begins.end() - 1, begins.end());
  begins.front() = 0;
  for (auto& triangle : block.triangles)
    for (std::uint32_t& v : triangle) v = scratch.places[v];
  block.ids.resize(edges.size());
}

void MeshMarcher::number_part(std::size_t at, VertexIds& ids) {
  ids.clear();
  for (MarchedBlock& block : blocks_) {
    if (block.edges.empty()) continue;
    for (std::uint32_t k = block.part_begins[at]; k < block.part_begins[at + 1]; ++k)
      block.ids[k] = ids.find_or_add(block.edges[k]).id;
  }
  parts_[at].edges = ids.keys();
}

void MeshMarcher::make_room() {
  std::size_t n_vertices = surface_.positions.size();
  for (EdgePart& part : parts_) {
    part.first_id = static_cast<std::uint32_t>(n_vertices);
    n_vertices += part.edges.size();
  }
  LODE_EXPECTS(n_vertices <= 0xFFFFFFFFU);
  std::size_t n_triangles = surface_.triangles.size();
  for (MarchedBlock& block : blocks_) {
    block.first_triangle = n_triangles;
    n_triangles += block.triangles.size();
  }
  resize_large(surface_.positions, n_vertices);
  if (options_.with_isovalues) resize_large(surface_.isovalues, n_vertices);
  if (!options_.gradients.empty()) resize_large(surface_.normals, n_vertices);
  if (surface_.attributes.empty())
    for (const Attribute& from : mesh_.attributes)
      surface_.attributes.push_back({from.name, false, {}, from.error});
  for (Attribute& to : surface_.attributes) resize_large(to.values, n_vertices);
  resize_large(surface_.triangles, n_triangles);
  if (!mesh_.regions.empty()) resize_large(surface_.regions, n_triangles);
}

/// From the lower value to the higher, so that a position does not depend on vertices' numbers.
void MeshMarcher::place_part(const EdgePart& part) {
  for (std::size_t k = 0; k < part.edges.size(); ++k) {
    auto low = static_cast<std::uint32_t>(part.edges[k] >> 32);
    auto high = static_cast<std::uint32_t>(part.edges[k]);
    if (is_inside(low)) std::swap(low, high);
    const Vec3d from = mesh_.positions[low] - surface_.origin;
    const Vec3d way = mesh_.positions[high] - mesh_.positions[low];
    const double t =
        crossing_of(isovalue_, mesh_.values[low], mesh_.values[high], way, options_.margin);
    surface_.positions[part.first_id + k] = narrowed(from + way * t);
    if (options_.with_isovalues) surface_.isovalues[part.first_id + k] = isovalue_;
    for (std::size_t i = 0; i < mesh_.attributes.size(); ++i) {
      const std::vector<double>& values = mesh_.attributes[i].values;
      surface_.attributes[i].values[part.first_id + k] = values[low] * (1 - t) + values[high] * t;
    }
    if (options_.gradients.empty()) continue;
    const Vec3d gradient =
        widened(options_.gradients[low]) * (1 - t) + widened(options_.gradients[high]) * t;
    surface_.normals[part.first_id + k] = narrowed(normalized(gradient * -1.0));
  }
}

void MeshMarcher::write_block(MarchedBlock& block) {
  if (block.edges.empty()) return;
  for (std::size_t p = 0; p < parts_.size(); ++p)
    for (std::uint32_t k = block.part_begins[p]; k < block.part_begins[p + 1]; ++k)
      block.ids[k] += parts_[p].first_id;
  for (std::size_t i = 0; i < block.triangles.size(); ++i) {
    const auto& [a, b, c] = block.triangles[i];
    surface_.triangles[block.first_triangle + i] = {block.ids[a], block.ids[b], block.ids[c]};
  }
  for (std::size_t i = 0; i < block.cells.size(); ++i)
    surface_.regions[block.first_triangle + i] = mesh_.regions[block.cells[i]];
}

double MeshMarcher::run() {
  find_inside();
  std::vector<MarchScratch> scratch(static_cast<std::size_t>(n_workers(options_.threads)));
  const auto of_worker = [&](int worker) -> MarchScratch& {
    return scratch[static_cast<std::size_t>(worker)];
  };
  parallel_for(blocks_.size(), options_.threads, 1, [&](std::size_t at, int worker) {
    march_block(at, of_worker(worker), blocks_[at]);
  });
  parallel_for(parts_.size(), options_.threads, 1,
               [&](std::size_t at, int worker) { number_part(at, of_worker(worker).ids); });
  make_room();
  parallel_for(parts_.size(), options_.threads, 1,
               [&](std::size_t at, int) { place_part(parts_[at]); });
  parallel_for(blocks_.size(), options_.threads, 1,
               [&](std::size_t at, int) { write_block(blocks_[at]); });
  float largest_error = 0;
  for (const MarchedBlock& block : blocks_)
    largest_error = std::max(largest_error, block.largest_error);
  return static_cast<double>(largest_error);
}

}  // namespace

double add_isosurface(const SimplexMesh& mesh, double isovalue,
                      const MeshIsosurfaceOptions& options, Surface& surface) {
  return MeshMarcher(mesh, isovalue, options, surface).run();
}

double rounding_margin(std::span<const Vec3d> positions, const Vec3d& origin) {
  double largest = 0;
  for (const Vec3d& p : positions)
    for (std::size_t i = 0; i < 3; ++i) largest = std::max(largest, std::abs(p[i] - origin[i]));
  return largest * 0x1p-20;
}

}  // namespace lode

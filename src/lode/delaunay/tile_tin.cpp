#include <algorithm>
#include <cstddef>

#include "lode/delaunay/numbered_nodes.h"
#include "lode/delaunay/tile_insertion.h"

namespace lode::delaunay {
namespace {

/// Puts the pieces of tiles together.
class TileJoiner {
 public:
  TileJoiner(SeamedTiles& tiles, Threads threads)
      : tiles_(tiles),
        threads_(threads),
        packing_(tiles.layout.columns().back() + 1),
        nodes_(packing_.pack({tiles.layout.columns().back(), tiles.layout.rows().back()})) {}

  Tin run() {
    std::size_t n = 0;
    bool has_links = false;
    for (const TilePiece& piece : tiles_.pieces) {
      first_.push_back(n);
      n += piece.corners.size();
      has_links = has_links || !piece.twins.empty();
    }
    number_vertices();
    resize_large(tin_.triangles, n);
    if (has_links) {
      resize_large(tin_.twins, n);
      resize_large(tin_.errors, n);
    }
    parallel_for(tiles_.pieces.size(), threads_, 1,
                 [&](std::size_t tile, int /*worker*/) { add_piece(tile); });
    if (has_links) link_seams();
    return std::move(tin_);
  }

 private:
  void number_vertices() {
    parallel_for(tiles_.pieces.size(), threads_, 1, [&](std::size_t tile, int /*worker*/) {
      for (const auto& triangle : tiles_.pieces[tile].corners)
        for (const std::uint32_t corner : triangle) nodes_.add_shared(corner);
    });
    resize_large(tin_.vertices, nodes_.number());
    constexpr std::size_t kWords = 4096;
    parallel_for(nodes_.n_words(), threads_, kWords, [&](std::size_t word, int /*worker*/) {
      nodes_.for_each_in(word, [&](std::uint32_t node, std::uint32_t number) {
        tin_.vertices[number] = packing_.unpack(node);
      });
    });
  }
  void add_piece(std::size_t tile) {
    TilePiece& piece = tiles_.pieces[tile];
    const std::size_t first = first_[tile];
    for (std::size_t t = 0; t < piece.corners.size(); ++t)
      for (std::size_t i = 0; i < 3; ++i)
        tin_.triangles[first + t][i] = nodes_.number_of(piece.corners[t][i]);
    for (std::size_t t = 0; t < piece.twins.size(); ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t twin = piece.twins[t][i];
        tin_.twins[first + t][i] =
            twin == kNoHalfEdge ? twin : twin + 4 * static_cast<std::uint32_t>(first);
      }
    std::ranges::copy(piece.errors, tin_.errors.begin() + static_cast<std::ptrdiff_t>(first));
    piece = {};
  }
  /// Edges with nothing behind them that are the same, seen from the tiles on either side. Few of
  /// them are on the outline.
  void link_seams() {
    struct OpenEdge {
      std::uint64_t ends;
      std::uint32_t half_edge;
    };
    std::vector<OpenEdge> open;
    for (std::uint32_t t = 0; t < tin_.twins.size(); ++t)
      for (std::uint32_t i = 0; i < 3; ++i) {
        if (tin_.twins[t][i] != kNoHalfEdge) continue;
        const std::uint32_t a = tin_.triangles[t][i];
        const std::uint32_t b = tin_.triangles[t][(i + 1) % 3];
        open.push_back({(std::uint64_t{std::min(a, b)} << 32) | std::max(a, b), 4 * t + i});
      }
    std::ranges::sort(open, {}, &OpenEdge::ends);
    for (std::size_t i = 0; i + 1 < open.size(); ++i) {
      if (open[i].ends != open[i + 1].ends) continue;
      const std::uint32_t a = open[i].half_edge;
      const std::uint32_t b = open[i + 1].half_edge;
      tin_.twins[a / 4][a % 4] = b;
      tin_.twins[b / 4][b % 4] = a;
    }
  }

  SeamedTiles& tiles_;
  Threads threads_;
  LatticePacking packing_;
  NumberedNodes nodes_;
  std::vector<std::size_t> first_;
  Tin tin_;
};

}  // namespace

Tin to_tin(SeamedTiles& tiles, Threads threads) { return TileJoiner(tiles, threads).run(); }

}  // namespace lode::delaunay

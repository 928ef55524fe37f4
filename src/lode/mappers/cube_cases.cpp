#include "lode/mappers/cube_cases.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>
#include <vector>

namespace lode {
namespace {

/// An edge of the cell whose lowest corner is even: even end, odd end.
using Ends = std::array<CellCorner, 2>;
using Loop = std::vector<Ends>;
using PatchTriangle = std::array<Ends, 3>;
using Patch = std::vector<PatchTriangle>;

constexpr Ends kBodyDiagonal{0, 7};

bool is_grid_edge(const Ends& e) { return std::has_single_bit(static_cast<unsigned>(e[0] ^ e[1])); }

/// Whether both lie in one face of the cell.
bool share_face(const Ends& a, const Ends& b) {
  const unsigned all = a[0] & a[1] & b[0] & b[1];
  const unsigned any = static_cast<unsigned>(a[0] | a[1] | b[0] | b[1]);
  return (all | (~any & 7U)) != 0;
}

/// Whether both are edges of one tetrahedron, whose corners are a chain: F is constant on a chord
/// between them.
bool share_tetrahedron(const Ends& a, const Ends& b) {
  return std::ranges::all_of(a, [&](unsigned p) {
    return std::ranges::all_of(b, [&](unsigned q) { return (p & q) == p || (p & q) == q; });
  });
}

/// The tetrahedra's patch in a cell: where it ends, piece by piece.
class TetrahedraPatch {
 public:
  explicit TetrahedraPatch(const KuhnCubeCase& c) : case_(c) {
    for (std::size_t i = 0; i < c.n_edges; ++i) piece_[i] = i;
    std::array<std::array<bool, 19>, 19> runs{};
    for (std::size_t t = 0; t < c.n_triangles; ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t from = c.triangles[t][i];
        const std::size_t to = c.triangles[t][(i + 1) % 3];
        runs[from][to] = true;
        join(piece_[from], piece_[to]);
      }
    next_.fill(kNone);
    for (std::size_t a = 0; a < c.n_edges; ++a)
      for (std::size_t b = 0; b < c.n_edges; ++b)
        if (runs[a][b] && !runs[b][a]) next_[a] = b;
  }

  /// Of each piece the loops, without the vertices on face diagonals, as the piece's own triangles
  /// run.
  [[nodiscard]] std::vector<std::vector<Loop>> pieces() {
    std::vector<std::vector<Loop>> result;
    for (std::size_t piece = 0; piece < case_.n_edges; ++piece) {
      std::vector<Loop> loops;
      for (std::size_t a = 0; a < case_.n_edges; ++a)
        if (piece_[a] == piece && next_[a] != kNone) loops.push_back(take_loop(a));
      if (!loops.empty()) result.push_back(loops);
    }
    return result;
  }

 private:
  static constexpr std::size_t kNone = 19;

  void join(std::size_t a, std::size_t b) {
    for (std::size_t i = 0; i < case_.n_edges; ++i)
      if (piece_[i] == b) piece_[i] = a;
  }

  Loop take_loop(std::size_t at) {
    Loop loop;
    while (next_[at] != kNone) {
      const Ends ends = edge_corners(case_.edges[at]);
      if (is_grid_edge(ends)) loop.push_back(ends);
      at = std::exchange(next_[at], kNone);
    }
    return loop;
  }

  const KuhnCubeCase& case_;
  std::array<std::size_t, 19> piece_{};
  std::array<std::size_t, 19> next_{};  ///< Along the patch's boundary.
};

/// All triangulations of the part of a disc's loop from i to j, without chords in faces.
std::vector<Patch> triangulations(const Loop& loop, std::size_t i, std::size_t j) {
  if (j - i < 2) return {Patch{}};
  const auto is_allowed = [&](std::size_t a, std::size_t b) {
    return b - a == 1 || !share_face(loop[a], loop[b]);
  };
  std::vector<Patch> result;
  for (std::size_t k = i + 1; k < j; ++k) {
    if (!is_allowed(i, k) || !is_allowed(k, j)) continue;
    const auto highs = triangulations(loop, k, j);
    for (const Patch& low : triangulations(loop, i, k))
      for (const Patch& high : highs) {
        Patch& patch = result.emplace_back(low);
        patch.insert(patch.end(), high.begin(), high.end());
        patch.push_back({loop[i], loop[k], loop[j]});
      }
  }
  return result;
}

/// Annuli between loops of equal length whose triangles stand on one and the other by turns.
std::vector<Patch> annuli(const Loop& a, const Loop& b) {
  const std::size_t n = a.size();
  std::vector<Patch> result;
  for (std::size_t shift = 0; shift < n; ++shift) {
    Patch patch;
    bool is_allowed = true;
    for (std::size_t i = 0; i < n; ++i) {
      const Ends& top = b[(shift + n - i) % n];
      const Ends& before = b[(shift + 2 * n - i - 1) % n];
      const Ends& next = a[(i + 1) % n];
      patch.push_back({a[i], next, top});
      patch.push_back({before, top, next});
      is_allowed = is_allowed && !share_face(next, top) && !share_face(next, before);
    }
    if (is_allowed) result.push_back(patch);
  }
  return result;
}

/// Of a triangle between the middles of edges, as integers.
std::array<int, 3> normal_of(const PatchTriangle& t) {
  const auto side = [&](std::size_t end, std::size_t axis) {
    const auto middle = [&](const Ends& e) { return (e[0] >> axis & 1) + (e[1] >> axis & 1); };
    return middle(t[end]) - middle(t[0]);
  };
  std::array<int, 3> n{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const std::size_t k = (i + 2) % 3;
    n[i] = side(1, j) * side(2, k) - side(1, k) * side(2, j);
  }
  return n;
}

int dot(const std::array<int, 3>& a, const std::array<int, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// How good a triangulation is. Only folded ones can cut themselves, wherever on their edges the
/// vertices are; chords within a tetrahedron stay on F = c, and flat ones near it.
struct Quality {
  bool is_folded = false;  ///< Two neighbours' normals are more than 127 degrees apart.
  int n_exact = 0;         ///< Chords within one tetrahedron.
  double bend = 0;         ///< 1 - cosine between neighbours, added up.

  [[nodiscard]] bool is_better_than(const Quality& other) const {
    if (is_folded != other.is_folded) return other.is_folded;
    if (n_exact != other.n_exact) return n_exact > other.n_exact;
    return bend < other.bend - 1e-9;
  }
};

Quality quality_of(const Patch& patch) {
  Quality quality;
  for (std::size_t i = 0; i < patch.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      std::vector<Ends> common;
      for (const Ends& e : patch[i])
        if (std::ranges::find(patch[j], e) != patch[j].end()) common.push_back(e);
      if (common.size() != 2) continue;
      const auto m = normal_of(patch[i]);
      const auto n = normal_of(patch[j]);
      const int mn = dot(m, n);
      const int squares = dot(m, m) * dot(n, n);
      if (mn < 0 && 25 * mn * mn > 9 * squares) quality.is_folded = true;
      if (share_tetrahedron(common[0], common[1])) ++quality.n_exact;
      quality.bend += 1 - mn / std::sqrt(static_cast<double>(squares));
    }
  return quality;
}

/// Between the loop and the vertex on the body diagonal: what lies in a cell's faces is seen from
/// inside without overlap.
Patch fan(const Loop& loop) {
  Patch patch;
  for (std::size_t i = 0; i < loop.size(); ++i)
    patch.push_back({loop[i], loop[(i + 1) % loop.size()], kBodyDiagonal});
  return patch;
}

Patch best_patch(const std::vector<Loop>& loops) {
  const auto all = loops.size() == 2 ? annuli(loops[0], loops[1])
                                     : triangulations(loops[0], 0, loops[0].size() - 1);
  if (all.empty()) return fan(loops[0]);
  const Patch* best = nullptr;
  Quality quality;
  for (const Patch& patch : all) {
    const Quality other = quality_of(patch);
    if (best != nullptr && !other.is_better_than(quality)) continue;
    best = &patch;
    quality = other;
  }
  return *best;
}

std::array<Patch, 256> make_patches() {
  std::array<Patch, 256> patches;
  for (std::size_t corners = 0; corners < patches.size(); ++corners)
    for (const auto& loops : TetrahedraPatch(kuhn_cube_cases(0, false)[corners]).pieces()) {
      const Patch piece = best_patch(loops);
      patches[corners].insert(patches[corners].end(), piece.begin(), piece.end());
    }
  return patches;
}

/// Of cells whose lowest corner is even along all axes.
const std::array<Patch, 256>& patches() {
  static const std::array<Patch, 256> kPatches = make_patches();
  return kPatches;
}

KuhnCubeCase to_case(const Patch& patch, unsigned parity, bool flip) {
  KuhnCubeCase result;
  const auto number_of = [&](const Ends& e) {
    const CellEdge edge =
        cell_edge(static_cast<CellCorner>(e[0] ^ parity), static_cast<CellCorner>(e[1] ^ parity));
    const auto end = result.edges.begin() + result.n_edges;
    const auto at = std::find(result.edges.begin(), end, edge);
    if (at == end) result.edges[result.n_edges++] = edge;
    return static_cast<std::uint8_t>(at - result.edges.begin());
  };
  for (const PatchTriangle& t : patch) {
    const std::uint8_t a = number_of(t[0]);
    const std::uint8_t b = number_of(t[1]);
    const std::uint8_t c = number_of(t[2]);
    result.triangles[result.n_triangles++] = {a, flip ? c : b, flip ? b : c};
  }
  return result;
}

KuhnCubeCases make_cases(unsigned parity, bool is_mirrored) {
  const bool flip = ((std::popcount(parity) & 1) != 0) != is_mirrored;
  KuhnCubeCases cases;
  for (unsigned even = 0; even < cases.size(); ++even) {
    unsigned corners = 0;
    for (unsigned k = 0; k < 8; ++k) corners |= (even >> k & 1) << (k ^ parity);
    cases[corners] = to_case(patches()[even], parity, flip);
  }
  return cases;
}

std::array<KuhnCubeCases, 16> make_all_cases() {
  std::array<KuhnCubeCases, 16> all;
  for (unsigned i = 0; i < all.size(); ++i) all[i] = make_cases(i % 8, i >= 8);
  return all;
}

}  // namespace

const KuhnCubeCases& cube_cases(int parity, bool is_mirrored) {
  static const std::array<KuhnCubeCases, 16> kCases = make_all_cases();
  return kCases[static_cast<std::size_t>(parity) + (is_mirrored ? 8U : 0U)];
}

bool needs_body_vertex(unsigned corners) {
  const auto& patch = patches()[corners];
  return std::ranges::any_of(
      patch, [](const PatchTriangle& t) { return std::ranges::find(t, kBodyDiagonal) != t.end(); });
}

}  // namespace lode

#include "lode/models/terrain/right_triangle_bisection/nested_errors.h"

#include <array>

namespace lode::bisection {
namespace {

/// Nodes of a reach and kind, as they are joined one after the other.
struct Pass {
  std::int32_t reach = 1;
  NodeKind kind = NodeKind::square;
  /// How many rows away children of children of ... are at most.
  std::int32_t depends = 1;

  [[nodiscard]] std::int32_t to_children() const {
    return kind == NodeKind::square ? reach : reach / 2;
  }
};

/// Those that move most of the memory: they go through it together, row by row.
constexpr std::array<Pass, 7> kFinePasses{{{1, NodeKind::square, 1},
                                           {2, NodeKind::side, 2},
                                           {2, NodeKind::square, 4},
                                           {4, NodeKind::side, 6},
                                           {4, NodeKind::square, 10},
                                           {8, NodeKind::side, 14},
                                           {8, NodeKind::square, 22}}};
constexpr std::int32_t kFirstCoarseReach = 16;
constexpr std::int32_t kChunkRows = 128;  ///< More than twice as far as fine passes depend.
constexpr std::int32_t kStepRows = 16;

class Nesting {
 public:
  Nesting(const Lattice& lattice, float* errors)
      : lattice_(lattice),
        last_(lattice.last()),
        stride_(lattice.stride()),
        errors_(errors),
        n_rows_(std::min(lattice.side(), lattice.last().y + lattice.side() / 2) + 1) {}

  void run(Threads threads) const {
    const auto n_chunks = static_cast<std::size_t>((last_.y + kChunkRows) / kChunkRows);
    parallel_for(n_chunks, threads, 1, [&](std::size_t i, int) {
      chunk(static_cast<std::int32_t>(i) * kChunkRows, i + 1 == n_chunks);
    });
    parallel_for(n_chunks - 1, threads, 1, [&](std::size_t i, int) {
      const std::int32_t seam = (static_cast<std::int32_t>(i) + 1) * kChunkRows;
      for (const Pass& pass : kFinePasses) rows(pass, seam - pass.depends, seam + pass.depends);
    });
    for (std::int32_t reach = kFirstCoarseReach; 2 * reach <= lattice_.side(); reach *= 2)
      for (const NodeKind kind : {NodeKind::side, NodeKind::square})
        rows({reach, kind}, 0, n_rows_);
  }

 private:
  /// What depends on no row of other chunks.
  void chunk(std::int32_t begin, bool is_last) const {
    const std::int32_t end = is_last ? n_rows_ : begin + kChunkRows;
    std::array<std::int32_t, kFinePasses.size()> next{};
    for (std::size_t p = 0; p < next.size(); ++p)
      next[p] = begin == 0 ? 0 : begin + kFinePasses[p].depends;
    for (std::int32_t known = begin + kStepRows; known < end + kStepRows; known += kStepRows)
      for (std::size_t p = 0; p < next.size(); ++p) {
        const bool is_end = known >= end;
        const std::int32_t to =
            is_end && is_last ? end : std::min(known, end) - kFinePasses[p].depends;
        rows(kFinePasses[p], next[p], to);
        next[p] = std::max(next[p], to);
      }
  }

  /// Of rows [begin, end).
  void rows(const Pass& pass, std::int32_t begin, std::int32_t end) const {
    if (2 * pass.reach > lattice_.side()) return;
    const std::int32_t above = std::min({end, n_rows_, last_.y + pass.reach});
    for (std::int32_t y = (std::max(begin, 0) + pass.reach - 1) / pass.reach * pass.reach;
         y < above; y += pass.reach)
      row(pass, y);
  }

  void row(const Pass& pass, std::int32_t y) const {
    std::int32_t x = first_column(y, pass.reach, pass.kind);
    if (x < 0) return;
    const std::int32_t away = pass.to_children();
    const std::int32_t step = 2 * pass.reach;
    const std::int32_t end = std::min(lattice_.side() + 1, last_.x + pass.reach);
    if (y >= away && y + away <= last_.y) {
      if (x < away) join_children({x, y}), x += step;
      const std::int64_t a = pass.kind == NodeKind::square ? away : away * (stride_ + 1);
      const std::int64_t b = pass.kind == NodeKind::square ? away * stride_ : away * (stride_ - 1);
      float* const at = errors_ + y * stride_;
      const std::int32_t inside = std::min(end, last_.x - away + 1);
      for (; x < inside; x += step) {
        float* const error = at + x;
        *error = std::max(std::max(std::max(error[-a], error[a]), std::max(error[-b], error[b])),
                          *error);
      }
    }
    for (; x < end; x += step) join_children({x, y});
  }

  /// Of any node.
  void join_children(LatticePoint node) const {
    const Diamond diamond(node);
    float& error = errors_[lattice_.index(node)];
    for (const LatticePoint child : diamond.children())
      if (lattice_.has_node(child, diamond.child_reach()))
        error = std::max(error, errors_[lattice_.index(child)]);
  }

  const Lattice& lattice_;
  LatticePoint last_;
  std::int64_t stride_;
  float* errors_;
  std::int32_t n_rows_;
};

}  // namespace

void nest_errors(const Lattice& lattice, Threads threads, float* errors) {
  Nesting(lattice, errors).run(threads);
}

}  // namespace lode::bisection

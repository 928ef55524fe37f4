#pragma once

#include <algorithm>
#include <limits>

#include "lode/core/parallel.h"
#include "lode/models/diamond/model.h"
#include "lode/models/diamond/nesting_rows.h"
#include "lode/models/diamond/range_code.h"

namespace lode::diamond {

/// Joins every node's attributes with its children's, which are already joined: level by level,
/// tier by tier, row by row. All values are as stored; encoding keeps order, so the join of codes
/// is the code of the join. `Field` is a LatticeField with levels, and samples at least of those
/// that are nested.
template <int D, typename Field>
class NestingPass {
 public:
  /// Completes field.levels from `first` on to before `end`. Errors are own ones so far. Ranges are
  /// missing, and the level below is complete; but where `first` is not 1, nodes of the lowest
  /// tier have been joined with that level already.
  NestingPass(Field& field, int first, int end, Threads threads)
      : field_(field),
        first_(first),
        end_(end),
        threads_(threads),
        reference_(field.range_reference()),
        mark_holes_(field.has_holes()) {}

  void run() {
    for (int level = first_; level < end_; ++level) {
      clear_points(level);
      for (int tier = D - 1; tier >= 0; --tier)
        for (const std::int32_t parity : {1, 0}) run_rows(level, tier, parity);
    }
  }

 private:
  /// The nodes of a tier whose x is even (parity 0) or odd (1). Rows are read whole, also where
  /// their points are no children: those are complete too, as odd x go first.
  void run_rows(int level, int tier, std::int32_t parity) {
    const Index<D> dims = field_.shape.grid_dims(level);
    parallel_for(n_rows(dims), threads_, 16, [&](std::size_t number, int) {
      const Index<D> row = point_of<D>(dims, number * as_size(dims[0]));
      if (n_odd(row) + parity == D - tier) run_row(level, row, parity);
    });
  }

  static std::size_t n_rows(const Index<D>& dims) { return n_points<D>(dims) / as_size(dims[0]); }

  static int n_odd(const Index<D>& q) {
    int n = 0;
    for (std::size_t i = 0; i < as_size(D); ++i) n += q[i] & 1;
    return n;
  }

  /// Points that are samples of coarser levels are no nodes of this one.
  void clear_points(int level) {
    const Index<D> dims = field_.shape.grid_dims(level);
    NodeLevel& nodes = field_.levels[as_size(level)];
    parallel_for(n_rows(dims), threads_, 16, [&](std::size_t number, int) {
      const std::size_t first = number * as_size(dims[0]);
      if (n_odd(point_of<D>(dims, first)) > 0) return;
      for (std::size_t x = 0; x < as_size(dims[0]); x += 2) {
        nodes.error[first + x] = 0;
        nodes.low[first + x] = std::numeric_limits<float>::infinity();
        nodes.high[first + x] = -std::numeric_limits<float>::infinity();
      }
    });
  }

  void run_row(int level, const Index<D>& row, std::int32_t parity) {
    Index<D> q = row;
    q[0] = parity;
    const Index<D> dims = field_.shape.grid_dims(level);
    const std::size_t first = linear_index<D>(dims, row);
    NodeLevel& nodes = field_.levels[as_size(level)];
    const bool is_lowest = n_odd(q) == 1;
    if (!is_lowest || level == 1 || level != first_)
      join_children(
          is_lowest ? cubes_of(level, q) : children_in_level(level, q), as_size(dims[0]),
          as_size(parity),
          {nodes.error.data() + first, nodes.low.data() + first, nodes.high.data() + first});
    q[0] = std::max(parity, first_beyond_data(level, row));
    q[0] += (q[0] ^ parity) & 1;
    for (; q[0] < dims[0]; q[0] += 2)
      join_vertices(diamond_at<D>(q * (std::int32_t{1} << level)), nodes.low[first + as_size(q[0])],
                    nodes.high[first + as_size(q[0])]);
  }

  [[nodiscard]] AttributeRow row_at(int level, const Index<D>& dims, const Index<D>& row) const {
    const NodeLevel& nodes = field_.levels[as_size(level)];
    const std::size_t at = linear_index<D>(dims, row);
    return {nodes.error.data() + at, nodes.low.data() + at, nodes.high.data() + at};
  }

  /// Children in the same level: one step along each odd axis.
  [[nodiscard]] ChildRows children_in_level(int level, const Index<D>& q) const {
    const Index<D> dims = field_.shape.grid_dims(level);
    ChildRows children;
    children.places = (q[0] & 1) != 0 ? ChildPlaces::at_and_round : ChildPlaces::at_x;
    children.n = as_size(dims[0]);
    for (std::size_t i = 1; i < as_size(D); ++i) {
      if ((q[i] & 1) == 0) continue;
      for (const std::int32_t step : {-1, 1}) {
        Index<D> child = q;
        child[0] = 0;
        child[i] += step;
        if (child[i] >= 0 && child[i] < dims[i]) children.add(row_at(level, dims, child));
      }
    }
    return children;
  }

  /// Children that are cubes of the next finer level: half a step along all axes. The finest one
  /// has one entry per cube instead of a grid.
  [[nodiscard]] ChildRows cubes_of(int level, const Index<D>& q) const {
    const Index<D> dims = field_.shape.attribute_dims(level - 1);
    const bool is_finest = level == 1;
    const std::int32_t scale = is_finest ? 1 : 2;
    ChildRows children;
    children.places = is_finest ? ChildPlaces::cubes : ChildPlaces::halves;
    children.n = as_size(dims[0]);
    for (std::uint32_t corner = 0; corner < 1U << D; corner += 2) {
      Index<D> row;
      bool exists = true;
      for (std::size_t i = 1; i < as_size(D); ++i) {
        const bool is_above = (corner >> i & 1U) != 0;
        row[i] = q[i] * scale + (!is_above ? -1 : is_finest ? 0 : 1);
        exists = exists && row[i] >= 0 && row[i] < dims[i];
      }
      if (exists) children.add(row_at(level - 1, dims, row));
    }
    return children;
  }

  /// The first x of a row from which domains reach beyond the data.
  [[nodiscard]] std::int32_t first_beyond_data(int level, const Index<D>& row) const {
    for (std::size_t i = 1; i < as_size(D); ++i)
      if (((row[i] + 1) << level) > field_.shape.dims[i] - 1) return 0;
    return (field_.shape.dims[0] - 1) >> level;
  }

  /// Values beyond the data are no samples of any child, but the surface meets them.
  void join_vertices(const Diamond<D>& d, float& low, float& high) const {
    join_value(d.centre, low, high);
    for (const Index<D>& v : domain_vertices<D>(d)) join_value(v, low, high);
  }

  void join_value(const Index<D>& p, float& low, float& high) const {
    const double v = field_.value(p);
    if (mark_holes_ && field_.is_hole(v)) return;
    const double relative = v - reference_;  // exact above a reference of 0
    const bool is_inside =
        relative > static_cast<double>(low) && relative < static_cast<double>(high);
    if (is_inside || (reference_ == 0 && relative == static_cast<double>(low))) return;
    low = std::min(low, range_down(v, reference_));
    high = std::max(high, range_up(v, reference_));
  }

  Field& field_;
  int first_;
  int end_;
  Threads threads_;
  double reference_;
  bool mark_holes_;
};

}  // namespace lode::diamond

#include "lode/models/diamond/world_pass.h"

#include <memory>

#include "lode/models/diamond/sample_rows.h"

namespace lode::diamond {
namespace {

/// One block of a level's grid after the other.
template <int D, typename C, typename Field>
class OwnWorlds {
 public:
  OwnWorlds(const Field& field, int level, std::span<const ErrorCode> own, ErrorCode nothing,
            UninitializedArray<WorldCode>& worlds)
      : field_(field),
        level_(level),
        own_(own),
        nothing_(nothing),
        worlds_(worlds),
        dims_(field.shape.grid_dims(level)),
        block_(WorldScale<D, C>(field)),
        values_(n_points<D>(all_equal<D>(kWorldSamples<D>)) + kRowPadding),
        errors_(n_points<D>(all_equal<D>(kWorldNodes<D>)) + kRowPadding) {}

  void run(const Index<D>& base) {
    base_ = base;
    if (!put_errors()) return;
    visit_storage_type(field_.storage, [&]<typename T>() { put_values<T>(); });
    block_.find_own();
    raise();
  }

 private:
  /// body(p) for the first point of each row of a cube of `edge` points from `first` on.
  template <typename Body>
  static void for_each_row_of(std::int32_t edge, std::int32_t first, const Body& body) {
    Index<D> rows = all_equal<D>(edge);
    rows[0] = 1;
    for (std::size_t r = 0; r < n_points<D>(rows); ++r)
      body(point_of<D>(rows, r) + all_equal<D>(first));
  }
  /// Whether a row of the block has points of the grid.
  [[nodiscard]] bool is_on_grid(const Index<D>& p) const {
    for (std::size_t i = 1; i < as_size(D); ++i)
      if (base_[i] + p[i] < 0 || base_[i] + p[i] >= dims_[i]) return false;
    return true;
  }

  /// Of an axis's grid points those whose nodes have simplices in the data.
  [[nodiscard]] std::int32_t n_in_data(std::size_t axis) const {
    const std::int32_t last = field_.shape.dims[axis] - 1;
    return std::min(dims_[axis], ((last + (1 << level_) - 1) >> level_) + 1);
  }

  /// False where no node has an error. Those beyond the data have none of their own.
  bool put_errors() {
    C* to = errors_.data();
    bool is_any = false;
    const std::int32_t n = std::clamp(n_in_data(0) - base_[0], 0, kWorldNodes<D>);
    for_each_row_of(kWorldNodes<D>, 0, [&](const Index<D>& p) {
      std::int32_t x = 0;
      bool is_in_data = true;
      for (std::size_t i = 1; i < as_size(D); ++i)
        is_in_data = is_in_data && base_[i] + p[i] < n_in_data(i);
      if (is_in_data)
        for (const ErrorCode* from = own_.data() + linear_index<D>(dims_, base_ + p); x < n; ++x) {
          to[x] = from[x] > nothing_ ? static_cast<C>(decode_error(from[x])) : C(0);
          is_any = is_any || from[x] > nothing_;
        }
      std::fill(to + x, to + kWorldNodes<D>, C(0));
      to += kWorldNodes<D>;
    });
    if (is_any) block_.put_errors(errors_.data());
    return is_any;
  }

  template <typename T>
  void put_values() {
    constexpr C kNone = std::numeric_limits<C>::quiet_NaN();
    std::array<T, as_size(kWorldSamples<D>)> samples;
    C* to = values_.data();
    // Of the block's points -1 .. kWorldNodes those on the grid.
    const std::int32_t first = base_[0] > 0 ? 0 : 1;
    const std::int32_t n = std::min(kWorldNodes<D> + 1, dims_[0] - base_[0]) + 1 - first;
    for_each_row_of(kWorldSamples<D>, -1, [&](const Index<D>& p) {
      std::fill_n(to, kWorldSamples<D>, kNone);
      if (is_on_grid(p)) {
        Index<D> q = base_ + p;
        q[0] += first;
        copy_samples<T, D>(field_, q * (1 << level_), n, 1 << level_, samples.data());
        for (std::int32_t x = 0; x < n; ++x) {
          const T sample = samples[as_size(x)];
          const bool is_hole = field_.has_holes() && field_.is_hole(static_cast<double>(sample));
          to[first + x] = is_hole ? kNone : static_cast<C>(sample);
        }
      }
      to += kWorldSamples<D>;
    });
    block_.put_values(values_.data());
  }

  /// Points on its upper border are another block's, unless the grid ends there.
  void raise() {
    Index<D> n;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      const std::int32_t rest = dims_[i] - base_[i];
      n[i] = rest <= kWorldNodes<D> ? rest : kBrickEdge<D>;
    }
    Index<D> rows = n;
    rows[0] = 1;
    for (std::size_t r = 0; r < n_points<D>(rows); ++r) {
      Index<D> p = point_of<D>(rows, r);
      WorldCode* const to = worlds_.data() + linear_index<D>(dims_, base_ + p);
      std::int32_t odd = 0;
      for (std::size_t i = 1; i < as_size(D); ++i) odd |= p[i] & 1;
      for (p[0] = 1 - odd; p[0] < 2; ++p[0])
        if (p[0] < n[0])
          raise_codes(block_.shares_from(p), as_size((n[0] - p[0] + 1) / 2), 2, to + p[0]);
    }
  }

  const Field& field_;
  int level_;
  std::span<const ErrorCode> own_;
  ErrorCode nothing_;
  UninitializedArray<WorldCode>& worlds_;
  Index<D> dims_;
  WorldBlock<D, C> block_;
  std::vector<C> values_;
  std::vector<C> errors_;
  Index<D> base_;
};

/// The levels' nodes row by row: those of a tier whose x is odd, then those whose x is even. Rows
/// are read whole, also where their points are no children: nobody writes to those meanwhile.
template <int D>
class WorldNesting {
 public:
  WorldNesting(const Shape<D>& shape, int first, Threads threads, WorldErrors& worlds)
      : shape_(shape), first_(first), worlds_(worlds), scratch_(as_size(n_workers(threads))) {}

  void run(int level, Threads threads) {
    const Index<D> dims = shape_.grid_dims(level);
    const std::size_t n_rows = n_points<D>(dims) / as_size(dims[0]);
    for (int tier = D - 1; tier >= 0; --tier)
      for (const std::int32_t parity : {1, 0})
        parallel_for(n_rows, threads, 16, [&](std::size_t number, int worker) {
          Index<D> q = point_of<D>(dims, number * as_size(dims[0]));
          q[0] = parity;
          int n_odd = 0;
          for (const std::int32_t x : q.v) n_odd += x & 1;
          if (n_odd != D - tier) return;
          if (n_odd > 1)
            join_level(level, dims, q, scratch_[as_size(worker)]);
          else if (level == 1 || level > first_)
            join_cubes(level, dims, q, scratch_[as_size(worker)]);
        });
  }

 private:
  static void join(const WorldCode* __restrict from, std::size_t n, WorldCode* __restrict to) {
    for (std::size_t i = 0; i < n; ++i) to[i] = std::max(to[i], from[i]);
  }

  /// Children in the same level: one step along each odd axis.
  void join_level(int level, const Index<D>& dims, const Index<D>& q,
                  std::vector<WorldCode>& largest) {
    UninitializedArray<WorldCode>& worlds = worlds_[as_size(level)];
    const auto n = as_size(dims[0]);
    largest.assign(n, 0);
    Index<D> row = q;
    row[0] = 0;
    WorldCode* const own = worlds.data() + linear_index<D>(dims, row);
    for (std::size_t i = 1; i < as_size(D); ++i) {
      if ((q[i] & 1) == 0) continue;
      for (const std::int32_t step : {-1, 1}) {
        Index<D> child = row;
        child[i] += step;
        if (child[i] >= 0 && child[i] < dims[i])
          join(worlds.data() + linear_index<D>(dims, child), n, largest.data());
      }
    }
    const WorldCode* __restrict const below = largest.data();
    if ((q[0] & 1) != 0)  // n is odd
      for (std::size_t x = 1; x < n; x += 2)
        own[x] = std::max(std::max(own[x], below[x]), std::max(own[x - 1], own[x + 1]));
    else
      for (std::size_t x = 0; x < n; x += 2) own[x] = std::max(own[x], below[x]);
  }

  /// Children that are cubes of the next finer level: half a step along all axes.
  void join_cubes(int level, const Index<D>& dims, const Index<D>& q,
                  std::vector<WorldCode>& largest) {
    const Index<D> fine = shape_.attribute_dims(level - 1);
    const bool is_finest = level == 1;  // one entry a cube instead of a grid
    const std::int32_t scale = is_finest ? 1 : 2;
    const std::int32_t above = is_finest ? 0 : 1;
    const auto n = as_size(fine[0]);
    largest.assign(as_size(scale * dims[0]) + 2, 0);
    for (std::uint32_t corner = 0; corner < 1U << D; corner += 2) {
      Index<D> row;
      bool exists = true;
      for (std::size_t i = 1; i < as_size(D); ++i) {
        row[i] = q[i] * scale + ((corner >> i & 1U) != 0 ? above : -1);
        exists = exists && row[i] >= 0 && row[i] < fine[i];
      }
      if (!exists) continue;
      // From x = -1 on.
      join(worlds_[as_size(level - 1)].data() + linear_index<D>(fine, row), n, largest.data() + 1);
    }
    Index<D> row = q;
    row[0] = 0;
    WorldCode* const own = worlds_[as_size(level)].data() + linear_index<D>(dims, row);
    const WorldCode* __restrict const lower = largest.data();
    const WorldCode* __restrict const upper = lower + above + 1;
    for (std::int32_t x = q[0]; x < dims[0]; x += 2)
      own[x] = std::max(own[x], one_level_up(std::max(lower[x * scale], upper[x * scale])));
  }

  const Shape<D>& shape_;
  int first_;
  WorldErrors& worlds_;
  std::vector<std::vector<WorldCode>> scratch_;  ///< Per worker.
};

}  // namespace

template <int D, typename C, typename Field>
void raise_to_own_worlds(const Field& field, int level, std::span<const ErrorCode> own,
                         double slack, Threads threads, UninitializedArray<WorldCode>& worlds) {
  const Index<D> dims = field.shape.grid_dims(level);
  Index<D> blocks;
  for (std::size_t i = 0; i < as_size(D); ++i)
    blocks[i] = std::max(1, (dims[i] - 2) / kBrickEdge<D> + 1);
  // Slack is added to each, and what is no more than that may be rounding; each is rounded up.
  const ErrorCode nothing = tolerance_code(2 * slack * (1 + 1.0 / 64));
  using Pass = OwnWorlds<D, C, Field>;
  std::vector<std::unique_ptr<Pass>> passes(as_size(n_workers(threads)));
  parallel_for(n_points<D>(blocks), threads, 1, [&](std::size_t i, int worker) {
    auto& pass = passes[as_size(worker)];
    if (!pass) pass = std::make_unique<Pass>(field, level, own, nothing, worlds);
    pass->run(point_of<D>(blocks, i) * kBrickEdge<D>);
  });
}

template <int D>
void nest_worlds(const Shape<D>& shape, int first, int end, Threads threads, WorldErrors& worlds) {
  WorldNesting<D> nesting(shape, first, threads, worlds);
  for (int level = first; level < end; ++level) nesting.run(level, threads);
}

#define LODE_INSTANTIATE(D, C)                                                                   \
  template void raise_to_own_worlds<D, C, Model<D>>(const Model<D>&, int,                        \
                                                    std::span<const ErrorCode>, double, Threads, \
                                                    UninitializedArray<WorldCode>&);             \
  template void raise_to_own_worlds<D, C, CoarseField<D>>(const CoarseField<D>&, int,            \
                                                          std::span<const ErrorCode>, double,    \
                                                          Threads, UninitializedArray<WorldCode>&)
LODE_INSTANTIATE(2, float);
LODE_INSTANTIATE(2, double);
LODE_INSTANTIATE(3, float);
LODE_INSTANTIATE(3, double);
#undef LODE_INSTANTIATE
template void nest_worlds<2>(const Shape<2>&, int, int, Threads, WorldErrors&);
template void nest_worlds<3>(const Shape<3>&, int, int, Threads, WorldErrors&);

}  // namespace lode::diamond

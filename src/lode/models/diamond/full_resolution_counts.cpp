#include "lode/models/diamond/full_resolution_counts.h"

#include <cstring>
#include <limits>
#include <memory>
#include <type_traits>

#include "lode/models/diamond/cell_rows.h"
#include "lode/models/diamond/crossing_nets.h"

namespace lode::diamond {
namespace {

constexpr std::size_t kBrickRow = as_size(kBrickSamples<3>);

/// Ranks of samples among up to kMostRanked isovalues.
template <typename T>
class SampleRanks {
 public:
  explicit SampleRanks(const IsovalueList& isovalues) : isovalues_(isovalues) {
    if constexpr (kHasTable) {
      table_.resize(std::size_t{1} << (8 * sizeof(T)));
      for (std::size_t i = 0; i < table_.size(); ++i)
        table_[i] = rank_of(static_cast<double>(kLowest) + static_cast<double>(i));
    }
  }

  [[nodiscard]] std::int8_t operator()(T sample) const {
    if constexpr (kHasTable)
      return table_[static_cast<std::size_t>(sample - kLowest)];
    else
      return rank_of(static_cast<double>(sample));
  }

 private:
  static constexpr bool kHasTable = std::is_integral_v<T>;
  static constexpr T kLowest = std::numeric_limits<T>::lowest();

  [[nodiscard]] std::int8_t rank_of(double value) const {
    return static_cast<std::int8_t>(isovalues_.rank(value));
  }

  const IsovalueList& isovalues_;
  std::vector<std::int8_t> table_;  ///< By sample, from the lowest on.
};

/// What the nets of samples add up to by rank: triangles in the upper half of each number, edges in
/// the lower one. Neighbours go to different copies, as they often have one rank.
class RankSums {
 public:
  void add(std::size_t x, std::int8_t rank, std::int8_t triangles, std::int8_t edges) {
    sums_[x % kCopies][static_cast<std::size_t>(rank)] +=
        std::int64_t{triangles} * kUpper + std::int64_t{edges};
  }

  /// Passes them on. At least once a brick: the halves hold no more.
  void move_to(CrossingSums& sums) {
    for (std::size_t rank = 0; rank <= kMostRanked; ++rank) {
      std::int64_t both = 0;
      for (auto& copy : sums_) both += std::exchange(copy[rank], 0);
      if (both == 0) continue;
      const auto edges = static_cast<std::int32_t>(static_cast<std::uint64_t>(both) & 0xFFFFFFFFU);
      sums.add_cells(rank, (both - edges) / kUpper);
      sums.add_vertices(rank, edges);
    }
  }

 private:
  static constexpr std::size_t kCopies = 4;
  static constexpr std::int64_t kUpper = std::int64_t{1} << 32;

  std::array<std::array<std::int64_t, kMostRanked + 1>, kCopies> sums_{};
};

/// Eight of a row's nets at a time.
std::uint64_t eight_of(const NetSlice::Row& nets, std::size_t at) {
  std::uint64_t bits;
  std::memcpy(&bits, nets.data() + at, sizeof(bits));
  return bits;
}

/// Goes through bricks slice by slice, two at a time.
template <typename T>
class BrickCounter {
 public:
  BrickCounter(const Model<3>& model, const SampleRanks<T>& ranks, std::size_t n_isovalues)
      : model_(model), ranks_(ranks), sums_(n_isovalues) {}

  void count(const Index<3>& brick) {
    samples_ = reinterpret_cast<const T*>(model_.brick(linear_index<3>(model_.brick_dims, brick)));
    for (std::size_t i = 0; i < 3; ++i) {
      last_[i] = model_.shape.dims[i] - 1 - brick[i] * kBrickEdge<3>;
      n_cells_[i] = std::min(last_[i], kBrickEdge<3>);
    }
    fill_ranks(0);
    slice(0).clear();
    for (std::int32_t z = 0; z < n_cells_[2]; ++z) {
      fill_ranks(z + 1);
      slice(z + 1).clear();
      add_crossing_nets({slice(z), slice(z + 1), n_cells_[0], n_cells_[1], (z & 1) != 0});
      add_last_edges(z);
      add_sums(slice(z));
    }
    if (last_[2] == n_cells_[2]) add_last_edges(n_cells_[2]);
    add_sums(slice(n_cells_[2]));
    rank_sums_.move_to(sums_);
  }
  [[nodiscard]] const CrossingSums& sums() const { return sums_; }

 private:
  NetSlice& slice(std::int32_t z) { return slices_[as_size(z & 1)]; }

  void fill_ranks(std::int32_t z) {
    const T* from = samples_ + as_size(z) * kBrickRow * kBrickRow;
    std::int8_t* to = slice(z).rank.data();
    for (std::size_t y = 0; y < kBrickRow; ++y, from += kBrickRow, to += NetSlice::kStride)
      for (std::size_t x = 0; x < kBrickRow; ++x) to[x] = ranks_(from[x]);
  }

  /// The edges that begin at a slice's samples with which no cell begins: those at the data's ends.
  void add_last_edges(std::int32_t z) {
    const bool is_last_z = z == last_[2];
    const bool has_last_x = n_cells_[0] == last_[0];
    const std::int32_t end_y = n_cells_[1] + (n_cells_[1] == last_[1] ? 1 : 0);
    const std::int32_t end_x = n_cells_[0] + (has_last_x ? 1 : 0);
    for (std::int32_t y = 0; y < end_y; ++y) {
      const bool is_last_row = is_last_z || y == last_[1];
      if (!is_last_row && !has_last_x) continue;
      for (std::int32_t x = is_last_row ? 0 : last_[0]; x < end_x; ++x) add_edges({{x, y, z}});
    }
  }

  /// An edge of each of the seven directions whose end lies in the data: the diagonal of an edge,
  /// face or cell from its even corner to its odd one.
  void add_edges(const Index<3>& p) {
    for (std::uint32_t along = 1; along < 8; ++along) {
      Index<3> even = p;
      Index<3> odd = p;
      bool exists = true;
      for (std::size_t i = 0; i < 3; ++i) {
        if (((along >> i) & 1U) == 0) continue;
        even[i] += even[i] & 1;
        odd[i] |= 1;
        exists = exists && p[i] < last_[i];
      }
      if (exists) add_edge(even, odd);
    }
  }
  void add_edge(const Index<3>& a, const Index<3>& b) {
    const std::size_t at_a = place_of(a);
    const std::size_t at_b = place_of(b);
    const std::int8_t rank_a = slice(a[2]).rank[at_a];
    const std::int8_t rank_b = slice(b[2]).rank[at_b];
    if (rank_a == rank_b) return;
    const int sign = rank_a < rank_b ? 1 : -1;
    std::int8_t& edges_a = slice(a[2]).left_edges[at_a];
    std::int8_t& edges_b = slice(b[2]).left_edges[at_b];
    edges_a = static_cast<std::int8_t>(edges_a + sign);
    edges_b = static_cast<std::int8_t>(edges_b - sign);
  }
  static std::size_t place_of(const Index<3>& p) {
    return as_size(p[1]) * NetSlice::kStride + as_size(p[0]);
  }

  void add_sums(const NetSlice& nets) {
    for (std::size_t y = 0; y < kBrickRow; ++y)
      for (std::size_t x = 0; x < kBrickRow; x += 8) {
        const std::size_t at = y * NetSlice::kStride + x;
        if ((eight_of(nets.left_triangles, at) | eight_of(nets.right_triangles, at) |
             eight_of(nets.left_edges, at) | eight_of(nets.right_edges, at)) == 0)
          continue;
        for (std::size_t i = at; i < at + std::min<std::size_t>(8, kBrickRow - x); ++i)
          rank_sums_.add(i, nets.rank[i],
                         static_cast<std::int8_t>(nets.left_triangles[i] + nets.right_triangles[i]),
                         static_cast<std::int8_t>(nets.left_edges[i] + nets.right_edges[i]));
      }
  }

  const Model<3>& model_;
  const SampleRanks<T>& ranks_;
  const T* samples_ = nullptr;
  Index<3> last_;     ///< The data's last sample, in the brick's coordinates, and
  Index<3> n_cells_;  ///< how many cells of it the brick has, along each axis.
  std::array<NetSlice, 2> slices_{};
  RankSums rank_sums_;
  CrossingSums sums_;
};

/// Where a brick's nested range is stored: the level of its cube, or of the root.
std::pair<int, std::size_t> node_of_brick(const ToleranceSelection<3>& selection,
                                          const Index<3>& brick) {
  const int level = std::min(kBrickLevel<3>, selection.model().shape.n_levels - 1);
  Diamond<3> d{brick * kBrickEdge<3>, level, 0, 7};
  for (std::size_t i = 0; i < 3; ++i) d.centre[i] += d.h();
  return {level, selection.index_of(d)};
}

/// At most kMostRanked isovalues.
CrossingSums count_ranked(const Model<3>& model, const IsovalueList& isovalues, Threads threads,
                          Progress& progress) {
  const ManySelection<3> selection(model, isovalues, 0);
  CrossingSums sums(isovalues.size());
  visit_storage_type(model.storage, [&]<typename T>() {
    const SampleRanks<T> ranks(isovalues);
    std::vector<std::unique_ptr<BrickCounter<T>>> counters(as_size(n_workers(threads)));
    parallel_for(model.n_bricks(), threads, 1, [&](std::size_t i, int worker) {
      if (progress.is_cancelled()) return;
      const Index<3> brick = point_of<3>(model.brick_dims, i);
      const auto node = node_of_brick(selection, brick);
      if (!selection.is_active(node.first, node.second)) return;
      auto& counter = counters[as_size(worker)];
      if (!counter) counter = std::make_unique<BrickCounter<T>>(model, ranks, isovalues.size());
      counter->count(brick);
    });
    for (const auto& counter : counters)
      if (counter) sums.add(counter->sums());
  });
  return sums;
}

}  // namespace

CrossingSums count_full_resolution(const Model<3>& model, const IsovalueList& isovalues,
                                   Threads threads, Progress& progress) {
  CrossingSums sums(isovalues.size());
  for (std::size_t first = 0; first < isovalues.size(); first += kMostRanked)
    sums.add(count_ranked(model, isovalues.part(first, kMostRanked), threads, progress), first);
  return sums;
}

CrossingSums::Counts count_full_resolution(const Model<3>& model, double isovalue, Threads threads,
                                           Progress& progress) {
  const Selection<3> selection(model, isovalue, 0);
  std::uint64_t n_bricks_read = 0;
  const SignField field = sign_field(selection, threads, n_bricks_read);
  constexpr std::size_t kSlicesAtOnce = 8;
  struct Worker {
    CrossingSums::Counts counts;
    std::vector<RowStart> starts;
  };
  std::vector<Worker> workers(as_size(n_workers(threads)));
  parallel_for(as_size(field.dims[2]), threads, kSlicesAtOnce, [&](std::size_t z, int worker) {
    if (progress.is_cancelled()) return;
    auto& [counts, starts] = workers[as_size(worker)];
    starts.resize(as_size(field.dims[1]));
    const SliceCounts n =
        count_slice(field, static_cast<std::int32_t>(z), SurfaceStyle::tetra, starts.data());
    counts.cells += n.triangles;
    counts.vertices += n.vertices;
  });
  CrossingSums::Counts total;
  for (const auto& [counts, starts] : workers) {
    total.cells += counts.cells;
    total.vertices += counts.vertices;
  }
  return total;
}

}  // namespace lode::diamond

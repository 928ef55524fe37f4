#include "lode/models/diamond/coarse_field.h"

namespace lode::diamond {

template <int D>
CoarseField<D> CoarseField<D>::make(const VolumeInfo& info, bool is_built) {
  CoarseField field;
  field.set_info(info);
  field.levels.resize(as_size(field.shape.n_levels));
  field.worlds.resize(field.levels.size());
  if (!field.is_needed()) return field;
  field.dims = field.shape.grid_dims(kKeptLevel);
  field.samples.resize(n_points<D>(field.dims) * field.sample_size());
  for (int level = kKeptLevel; level < field.shape.n_levels; ++level) {
    const std::size_t n = n_points<D>(field.shape.grid_dims(level));
    NodeLevel& nodes = field.levels[as_size(level)];
    nodes.error.assign(n, 0);
    nodes.low.assign(n, std::numeric_limits<float>::infinity());
    nodes.high.assign(n, -std::numeric_limits<float>::infinity());
    if (is_built) field.worlds[as_size(level)].assign(n, 0);
  }
  if (is_built) field.finest_own.assign(field.levels[as_size(kKeptLevel)].error.size(), 0);
  return field;
}

template <int D>
std::uint64_t CoarseField<D>::n_bytes(const VolumeInfo& info, bool is_built) {
  const std::uint64_t node_bytes =
      sizeof(ErrorCode) + 2 * sizeof(float) + (is_built ? sizeof(WorldCode) : 0);
  const Shape<D> shape = shape_of<D>(info.grid.dims);
  if (shape.n_levels <= kKeptLevel) return 0;
  std::uint64_t n = n_points<D>(shape.grid_dims(kKeptLevel)) *
                    (size_of(storage_type(info.type)) + (is_built ? sizeof(ErrorCode) : 0));
  for (int level = kKeptLevel; level < shape.n_levels; ++level)
    n += n_points<D>(shape.grid_dims(level)) * node_bytes;
  return n;
}

template <int D>
void CoarseField<D>::put_samples(const LatticeBox<D>& box, const std::byte* values) {
  if (!is_needed()) return;
  const std::size_t size = this->sample_size();
  const auto place = [&](std::size_t axis, std::int32_t q) {
    return std::min(q << kKeptLevel, shape.dims[axis] - 1);
  };
  // The grid points whose samples the box has.
  LatticeBox<D> grid;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    const auto first_from = [&](std::int32_t p) {
      std::int32_t q = 0;
      while (q < dims[i] && place(i, q) < p) ++q;
      return q;
    };
    grid.lower[i] = first_from(box.lower[i]);
    grid.upper[i] = first_from(box.upper[i]);
    if (grid.lower[i] == grid.upper[i]) return;
  }
  const Index<D> edges = box.upper - box.lower;
  const Index<D> points = grid.upper - grid.lower;
  for (std::size_t n = 0; n < n_points<D>(points); ++n) {
    const Index<D> q = grid.lower + point_of<D>(points, n);
    Index<D> p;
    for (std::size_t i = 0; i < as_size(D); ++i) p[i] = place(i, q[i]);
    std::memcpy(samples.data() + linear_index<D>(dims, q) * size,
                values + linear_index<D>(edges, p - box.lower) * size, size);
  }
}

template <int D>
void CoarseField<D>::join(const CoarseField& other) {
  for (std::size_t level = 0; level < levels.size(); ++level) {
    NodeLevel& to = levels[level];
    const NodeLevel& from = other.levels[level];
    for (std::size_t i = 0; i < to.error.size(); ++i) {
      to.error[i] = std::max(to.error[i], from.error[i]);
      to.low[i] = std::min(to.low[i], from.low[i]);
      to.high[i] = std::max(to.high[i], from.high[i]);
    }
    for (std::size_t i = 0; i < worlds[level].size(); ++i)
      worlds[level][i] = std::max(worlds[level][i], other.worlds[level][i]);
  }
  for (std::size_t i = 0; i < finest_own.size(); ++i)
    finest_own[i] = std::max(finest_own[i], other.finest_own[i]);
}

template <int D>
double CoarseField<D>::base_error() const {
  if (!shape.has_cells()) return 0;
  const int level = shape.n_levels - 1;
  const std::size_t at = linear_index<D>(shape.grid_dims(level), all_equal<D>(1));
  return static_cast<double>(decode_error(levels[as_size(level)].error[at]));
}

template struct CoarseField<2>;
template struct CoarseField<3>;

}  // namespace lode::diamond

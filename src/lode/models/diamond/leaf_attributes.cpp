#include "lode/models/diamond/leaf_attributes.h"

#include <type_traits>

#include "lode/models/diamond/range_code.h"
#include "lode/models/diamond/row_codes.h"

namespace lode::diamond {
namespace {

template <int D>
std::array<std::ptrdiff_t, as_size(D)> strides(std::int32_t edge) {
  std::array<std::ptrdiff_t, as_size(D)> s;
  s[0] = 1;
  for (std::size_t i = 1; i < as_size(D); ++i) s[i] = s[i - 1] * edge;
  return s;
}

/// Calls body(row) for every row of the box [0, edge)^D at coordinate 0 = 0.
template <int D, typename F>
void for_each_row(std::int32_t edge, const F& body) {
  Index<D> p;
  while (true) {
    body(p);
    std::size_t i = 1;
    for (; i < as_size(D); ++i) {
      if (++p[i] < edge) break;
      p[i] = 0;
    }
    if (i == as_size(D)) return;
  }
}

template <int D>
std::size_t offset_of(const Index<D>& p, const std::array<std::ptrdiff_t, as_size(D)>& s) {
  std::ptrdiff_t offset = 0;
  for (std::size_t i = 0; i < as_size(D); ++i) offset += p[i] * s[i];
  return static_cast<std::size_t>(offset);
}

/// Midpoint errors of every sample of the brick; 0 at all-even points, beyond the data, and where
/// a hole is involved. At step 1 the parity of a point decides its axis.
template <int D, typename V>
void find_midpoint_errors(const Model<D>& model, const Index<D>& base, const V* values,
                          std::vector<V>& out) {
  out.resize(kBrickSize<D> + kRowPadding);
  const auto stride = strides<D>(kLeafEdge<D>);
  const Index<D> ones = all_equal<D>(1);
  const std::int32_t n = std::min(kBrickSamples<D>, model.shape.dims[0] - base[0]);
  // Rows in ascending order: what one writes beyond its end, the next one puts right.
  for_each_row<D>(kBrickSamples<D>, [&](const Index<D>& row) {
    V* const error = out.data() + model.brick_offset(row);
    bool is_beyond = false;
    std::ptrdiff_t across = 0;  // from a point to the first axis end, without the x part
    for (std::size_t i = 1; i < as_size(D); ++i) {
      is_beyond = is_beyond || base[i] + row[i] >= model.shape.dims[i];
      if ((row[i] & 1) != 0) across += (row[i] & 3) == 1 ? -stride[i] : stride[i];
    }
    const std::int32_t n_real = is_beyond ? 0 : n;
    if (n_real > 0)
      midpoint_errors(values + offset_of<D>(row + ones, stride), across, as_size(n_real), error);
    std::fill(error + n_real, error + kBrickSamples<D>, V(0));
  });
}

/// out[x] = the bits of all 2^D points from p + (x, 0, ..) on, each of which has its bits in a cube
/// of edge `edge`; n of them, and one more is written.
template <int D>
void join_bits(const std::vector<std::uint8_t>& bits, std::int32_t edge, const Index<D>& p,
               std::size_t n, std::uint8_t* out) {
  const auto stride = strides<D>(edge);
  const std::uint8_t* const first = bits.data() + offset_of<D>(p, stride);
  std::copy_n(first, n + 1, out);
  for (std::size_t corner = 1; corner < power(2, D - 1); ++corner) {
    const std::uint8_t* row = first;
    for (std::size_t i = 1; i < as_size(D); ++i)
      if ((corner >> (i - 1) & 1U) != 0) row += stride[i];
    for (std::size_t x = 0; x <= n; ++x) out[x] |= row[x];
  }
  for (std::size_t x = 0; x < n; ++x) out[x] |= out[x + 1];
}

/// Bits of unit cells: what their corners are; none: beyond the data.
constexpr std::uint8_t kFinite = 1;
constexpr std::uint8_t kHole = 2;

/// The corners of the cells of a brick and one layer round it.
template <int D, typename V>
std::vector<std::uint8_t> find_cells(const Model<D>& model, const Index<D>& base, const V* values) {
  constexpr std::int32_t kCells = kLeafEdge<D> - 1;
  std::vector<std::uint8_t> corners(n_points<D>(all_equal<D>(kLeafEdge<D>)));
  for (std::size_t i = 0; i < corners.size(); ++i)
    corners[i] = std::isnan(values[i]) ? kHole : kFinite;
  std::vector<std::uint8_t> cells(n_points<D>(all_equal<D>(kCells)));
  std::array<std::uint8_t, as_size(kLeafEdge<D>)> joined;
  // Cell x lies at base - 1 + x.
  const std::int32_t begin = std::max(0, 1 - base[0]);
  const std::int32_t end = std::min(kCells, model.shape.dims[0] - base[0]);
  for_each_row<D>(kCells, [&](const Index<D>& p) {
    for (std::size_t i = 1; i < as_size(D); ++i) {
      const std::int32_t lower = base[i] + p[i] - 1;
      if (lower < 0 || lower >= model.shape.dims[i] - 1) return;
    }
    join_bits<D>(corners, kLeafEdge<D>, p, as_size(kCells), joined.data());
    if (begin < end)
      std::copy(joined.begin() + begin, joined.begin() + end,
                cells.begin() + static_cast<std::ptrdiff_t>(offset_of<D>(p, strides<D>(kCells)) +
                                                            as_size(begin)));
  });
  return cells;
}

/// Makes the error infinite at each finest node (one odd coordinate) round which cells have holes
/// and finite samples: see LatticeField::is_mixed().
template <int D, typename V>
void mark_mixed_nodes(const Model<D>& model, const Index<D>& base, const V* values,
                      std::vector<V>& errors) {
  const std::vector<std::uint8_t> cells = find_cells<D>(model, base, values);
  std::array<std::uint8_t, as_size(kBrickSamples<D>) + 1> round;
  for_each_row<D>(kBrickSamples<D>, [&](const Index<D>& p) {
    std::int32_t n_odd = 0;
    for (std::size_t i = 1; i < as_size(D); ++i) n_odd += p[i] & 1;
    if (n_odd > 1) return;
    join_bits<D>(cells, kLeafEdge<D> - 1, p, as_size(kBrickSamples<D>), round.data());
    V* const error = errors.data() + model.brick_offset(p);
    for (std::size_t x = n_odd == 0 ? 1 : 0; x < as_size(kBrickSamples<D>); x += 2)
      if (round[x] == (kFinite | kHole)) error[x] = std::numeric_limits<V>::infinity();
  });
}

/// Of the rows of points through a row of cubes of side 2, the largest errors at each x.
template <int D, typename V>
void row_errors(const std::vector<V>& midpoint, const Index<D>& cube, V* largest) {
  std::array<const V*, power(3, D - 1)> rows;
  std::size_t n = 0;
  for_each_row<D>(3, [&](const Index<D>& o) {
    rows[n++] = midpoint.data() + Model<D>::brick_offset(cube * 2 + o);
  });
  largest_of(rows, as_size(kBrickSamples<D>), largest);
}

/// Whether offset o from the centre of a cube of side 2 is in its nested domain: the union of
/// the finest nodes on the cube's edges.
template <int D>
constexpr bool is_in_nested_domain(const Index<D>& o) {
  for (std::size_t axis = 0; axis < as_size(D); ++axis) {
    bool is_end = o[axis] == 1 || o[axis] == -1;
    bool is_ring = o[axis] == 0;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      if (i == axis) continue;
      is_end = is_end && (o[i] == 1 || o[i] == -1);
      is_ring = is_ring && o[i] >= -2 && o[i] <= 2;
    }
    if (is_end || is_ring) return true;
  }
  return false;
}

/// The nested domain of a cube of side 2, as rows round its centre.
template <int D>
RowStencil nested_domain_rows() {
  RowStencil rows;
  const auto stride = strides<D>(kLeafEdge<D>);
  for_each_row<D>(5, [&](const Index<D>& corner) {
    std::ptrdiff_t offset = 0;
    int reach = -1;
    Index<D> o;
    for (std::size_t i = 1; i < as_size(D); ++i) {
      o[i] = corner[i] - 2;
      offset += o[i] * stride[i];
    }
    for (o[0] = 0; o[0] <= 2; ++o[0])
      if (is_in_nested_domain<D>(o)) reach = o[0];
    if (reach >= 0) rows[as_size(reach)].push_back(offset);
  });
  return rows;
}

/// Stores attributes, rounded as NodeLevel says. What is computed in float32 is exact there, and so
/// are its ranges above a reference of 0.
template <int D, typename V>
struct RowEncoder {
  SampleScale<D, V> scale;
  double slack;
  double reference;

  [[nodiscard]] ErrorCode error(V e) const {
    if constexpr (kIsExact) return encode_error(scale.error(e));
    return encode_error(float_up(static_cast<double>(e) + slack));
  }
  [[nodiscard]] float low(V v) const {
    if constexpr (kIsExact) return scale.value(v);
    return range_down(static_cast<double>(v), reference);
  }
  [[nodiscard]] float high(V v) const {
    if constexpr (kIsExact) return scale.value(v);
    return range_up(static_cast<double>(v), reference);
  }
  /// Those of n cubes: `largest` as row_errors() gives it, the ranges of its points.
  void encode(const V* largest, const V* lows, const V* highs, std::size_t n, ErrorCode* error_to,
              float* low_to, float* high_to) const {
    if constexpr (kIsExact) {
      const LeafPoints<V> points{largest, lows, highs, scale.value(V(0)), scale.error(V(1))};
      encode_leaf_row(points, n, error_to, low_to, high_to);
    } else {
      for (std::size_t x = 0; x < n; ++x) {
        error_to[x] = error(std::max({largest[2 * x], largest[2 * x + 1], largest[2 * x + 2]}));
        low_to[x] = low(lows[2 * x + 1]);
        high_to[x] = high(highs[2 * x + 1]);
      }
    }
  }

 private:
  static constexpr bool kIsExact = !std::is_same_v<V, double>;
};

}  // namespace

template <int D, typename V>
LeafPass<D, V>::LeafPass(const Model<D>& model, double slack, NodeLevel& out,
                         UninitializedArray<WorldCode>* worlds)
    : model_(model), slack_(slack), out_(out), worlds_(worlds) {
  if (worlds != nullptr) world_block_.emplace(WorldScale<D, C>(model));
  static_assert(as_size(kLeafEdge<D>) <= kMaxRow);
  if constexpr (!std::is_same_v<V, double>)
    LODE_EXPECTS(slack == 0 && model.range_reference() == 0);
}

template <int D, typename V>
void LeafPass<D, V>::run_brick(const Index<D>& brick, const V* values, bool has_holes) {
  static const RowStencil kStencil = nested_domain_rows<D>();
  const Index<D> base = brick * kBrickEdge<D>;
  find_midpoint_errors<D>(model_, base, values, midpoint_);
  if constexpr (std::is_floating_point_v<V>)
    if (has_holes) mark_mixed_nodes<D>(model_, base, values, midpoint_);
  if (worlds_ != nullptr) find_worlds(brick, values);
  const RowEncoder<D, V> encoder{SampleScale<D, V>(model_), slack_, model_.range_reference()};
  const auto stride = strides<D>(kLeafEdge<D>);
  const Index<D> dims = model_.shape.attribute_dims(0);
  const std::int32_t first = brick[0] * kLeafCubes<D>;
  const auto n = static_cast<std::size_t>(std::clamp(dims[0] - first, 0, kLeafCubes<D>));
  for_each_row<D>(kLeafCubes<D>, [&](const Index<D>& cube) {
    const Index<D> global = brick * kLeafCubes<D> + cube;
    std::ptrdiff_t row = 0;
    for (std::size_t i = 1; i < as_size(D); ++i) {
      if (global[i] >= dims[i]) return;
      row += (2 * cube[i] + 2) * stride[i];
    }
    std::array<V, as_size(kBrickSamples<D>) + 2 * kRowPadding> error;
    std::array<V, as_size(kLeafEdge<D>) + 2 * kRowPadding> low;
    std::array<V, as_size(kLeafEdge<D>) + 2 * kRowPadding> high;
    row_errors<D>(midpoint_, cube, error.data());
    extremes_round(values + row, kStencil, as_size(kLeafEdge<D>), has_holes, low.data(),
                   high.data());
    const std::size_t at = linear_index<D>(dims, global);  // points of the row are stored at + 1
    encoder.encode(error.data(), low.data() + 1, high.data() + 1, n, out_.error.data() + at,
                   out_.low.data() + at, out_.high.data() + at);
  });
}

/// Held in V both values and errors are as many times what they are.
template <int D, typename V>
void LeafPass<D, V>::find_worlds(const Index<D>& brick, const V* values) {
  const Index<D> base = brick * kBrickEdge<D>;
  const Index<D> grid = model_.shape.grid_dims(0);
  world_block_->put_values(values);
  Index<D> lower;
  for (std::size_t i = 0; i < as_size(D); ++i) lower[i] = base[i] > 0 ? -1 : 0;
  world_block_->hide_outside(lower, grid - base - all_equal<D>(1));
  world_block_->put_errors(midpoint_.data());
  world_block_->find_nested();
  for_each_row<D>(kLeafCubes<D>, [&](const Index<D>& cube) {
    const Index<D> dims = model_.shape.attribute_dims(0);
    Index<D> global = brick * kLeafCubes<D> + cube;
    for (std::size_t i = 1; i < as_size(D); ++i)
      if (global[i] >= dims[i]) return;
    const auto n = static_cast<std::size_t>(std::clamp(dims[0] - global[0], 0, kLeafCubes<D>));
    WorldCode* const out = worlds_->data() + linear_index<D>(dims, global);
    std::fill_n(out, n, WorldCode{0});
    raise_codes(world_block_->shares_from(cube * 2 + all_equal<D>(1)), n, 1, out);
  });
}

template <int D, typename V>
void LeafPass<D, V>::run_uniform_brick(const Index<D>& brick, V lowest, V highest) {
  const RowEncoder<D, V> encoder{SampleScale<D, V>(model_), slack_, model_.range_reference()};
  const ErrorCode error = encoder.error(V(0));
  const float low = encoder.low(lowest);
  const float high = encoder.high(highest);
  const Index<D> dims = model_.shape.attribute_dims(0);
  const std::int32_t first = brick[0] * kLeafCubes<D>;
  const auto n = static_cast<std::size_t>(std::clamp(dims[0] - first, 0, kLeafCubes<D>));
  for_each_row<D>(kLeafCubes<D>, [&](const Index<D>& cube) {
    const Index<D> global = brick * kLeafCubes<D> + cube;
    for (std::size_t i = 1; i < as_size(D); ++i)
      if (global[i] >= dims[i]) return;
    const std::size_t at = linear_index<D>(dims, global);
    std::fill_n(out_.error.begin() + static_cast<std::ptrdiff_t>(at), n, error);
    std::fill_n(out_.low.begin() + static_cast<std::ptrdiff_t>(at), n, low);
    std::fill_n(out_.high.begin() + static_cast<std::ptrdiff_t>(at), n, high);
    if (worlds_ != nullptr) std::fill_n(worlds_->data() + at, n, WorldCode{0});
  });
}

template class LeafPass<2, Step>;
template class LeafPass<3, Step>;
template class LeafPass<2, float>;
template class LeafPass<3, float>;
template class LeafPass<2, double>;
template class LeafPass<3, double>;

}  // namespace lode::diamond

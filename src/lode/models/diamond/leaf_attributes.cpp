#include "lode/models/diamond/leaf_attributes.h"

#include "lode/models/diamond/range_code.h"

namespace lode::diamond {
namespace {

/// Edge of the sample array: a brick and one layer round it. Local coordinate p is at p + 1.
template <int D>
inline constexpr std::int32_t kEdge = kBrickSamples<D> + 2;

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

/// |F - mean of the axis ends| along one row of samples: at even x the ends lie at -across and
/// +across, at odd x also to the sides. Each parity is computed for the whole row, then taken.
template <int D, typename C>
void row_midpoint_errors(const C* v, std::ptrdiff_t across, std::int32_t n, C* error) {
  using Row = std::array<C, as_size(kBrickSamples<D>)>;
  const auto find = [&](std::ptrdiff_t to_end, Row& out) {
    for (std::int32_t x = 0; x < n; ++x) {
      const C e = std::abs(v[x] - (v[x + to_end] + v[x - to_end]) * C(0.5));
      out[as_size(x)] = e >= C(0) ? e : C(0);
    }
  };
  Row even;
  Row first;   // x ≡ 1 mod 4
  Row second;  // x ≡ 3 mod 4
  find(across, even);
  find(across - 1, first);
  find(across + 1, second);
  if (across != 0)
    for (std::int32_t x = 0; x < n; x += 2) error[x] = even[as_size(x)];
  for (std::int32_t x = 1; x < n; x += 4) error[x] = first[as_size(x)];
  for (std::int32_t x = 3; x < n; x += 4) error[x] = second[as_size(x)];
}

/// Midpoint errors of every sample of the brick; 0 at all-even points, beyond the data, and where
/// a hole is involved. At step 1 the parity of a point decides its axis.
template <int D, typename C>
void midpoint_errors(const Model<D>& model, const Index<D>& base, const C* values,
                     std::vector<C>& out) {
  out.assign(kBrickSize<D>, C(0));
  const auto stride = strides<D>(kEdge<D>);
  const Index<D> ones = [] {
    Index<D> v;
    for (std::size_t i = 0; i < as_size(D); ++i) v[i] = 1;
    return v;
  }();
  const std::int32_t n = std::min(kBrickSamples<D>, model.shape.dims[0] - base[0]);
  for_each_row<D>(kBrickSamples<D>, [&](const Index<D>& row) {
    std::ptrdiff_t across = 0;  // from a point to the first axis end, without the x part
    for (std::size_t i = 1; i < as_size(D); ++i) {
      if (base[i] + row[i] >= model.shape.dims[i]) return;
      if ((row[i] & 1) != 0) across += (row[i] & 3) == 1 ? -stride[i] : stride[i];
    }
    row_midpoint_errors<D>(values + offset_of<D>(row + ones, stride), across, n,
                           out.data() + model.brick_offset(row));
  });
}

/// Makes the error infinite at each finest node (one odd coordinate) round which some cells are
/// removed and some are not: its simplices are mixed.
template <int D, typename C>
void mark_mixed_nodes(const Model<D>& model, const Index<D>& base, const C* values,
                      std::vector<C>& errors) {
  enum : std::uint8_t { absent, present, removed };
  const std::int32_t edge = kBrickEdge<D> + 2;  // cells -1 .. kBrickEdge
  const auto stride = strides<D>(kEdge<D>);
  const auto cell_stride = strides<D>(edge);
  std::vector<std::uint8_t> cells(n_points<D>([&] {
                                    Index<D> v;
                                    for (std::size_t i = 0; i < as_size(D); ++i) v[i] = edge;
                                    return v;
                                  }()),
                                  absent);
  for_each_row<D>(edge, [&](Index<D> p) {
    for (; p[0] < edge; ++p[0]) {
      bool is_real = true;
      for (std::size_t i = 0; i < as_size(D); ++i) {
        const std::int32_t lower = base[i] + p[i] - 1;
        is_real = is_real && lower >= 0 && lower < model.shape.dims[i] - 1;
      }
      if (!is_real) continue;
      bool is_removed = false;
      for (int corner = 0; corner < (1 << D); ++corner) {
        Index<D> q = p;
        for (int i = 0; i < D; ++i) q[as_size(i)] += (corner >> i) & 1;
        is_removed = is_removed || std::isnan(values[offset_of<D>(q, stride)]);
      }
      cells[offset_of<D>(p, cell_stride)] = is_removed ? removed : present;
    }
  });
  for_each_row<D>(kBrickSamples<D>, [&](Index<D> p) {
    for (; p[0] < kBrickSamples<D>; ++p[0]) {
      int n_odd = 0;
      for (std::size_t i = 0; i < as_size(D); ++i) n_odd += p[i] & 1;
      if (n_odd != 1) continue;
      bool has[3] = {false, false, false};
      for (int corner = 0; corner < (1 << D); ++corner) {
        Index<D> q = p;  // cell lowest corner p - 1 + bit, stored at + 1
        for (int i = 0; i < D; ++i) q[as_size(i)] += (corner >> i) & 1;
        has[cells[offset_of<D>(q, cell_stride)]] = true;
      }
      if (has[present] && has[removed])
        errors[model.brick_offset(p)] = std::numeric_limits<C>::infinity();
    }
  });
}

/// Errors of one row of cubes of side 2: the largest over their points.
template <int D, typename C>
void row_errors(const std::vector<C>& midpoint, const Index<D>& cube, C* out) {
  std::array<C, as_size(kBrickSamples<D>)> largest{};
  for_each_row<D>(3, [&](const Index<D>& o) {
    const C* m = midpoint.data() + Model<D>::brick_offset(cube * 2 + o);
    for (std::size_t x = 0; x < largest.size(); ++x) largest[x] = std::max(largest[x], m[x]);
  });
  for (std::size_t x = 0; x < as_size(kLeafCubes<D>); ++x)
    out[x] = std::max({largest[2 * x], largest[2 * x + 1], largest[2 * x + 2]});
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

/// One row of the nested domain: where it lies, and how far it reaches in x.
struct StencilRow {
  std::ptrdiff_t offset;
  int reach;
};

template <int D>
std::vector<StencilRow> nested_domain_rows() {
  std::vector<StencilRow> rows;
  const auto stride = strides<D>(kEdge<D>);
  for_each_row<D>(5, [&](const Index<D>& corner) {
    StencilRow row{0, -1};
    Index<D> o;
    for (std::size_t i = 1; i < as_size(D); ++i) {
      o[i] = corner[i] - 2;
      row.offset += o[i] * stride[i];
    }
    for (o[0] = 0; o[0] <= 2; ++o[0])
      if (is_in_nested_domain<D>(o)) row.reach = o[0];
    if (row.reach >= 0) rows.push_back(row);
  });
  return rows;
}

/// Ranges of one row of cubes: per reach the extremes over the stencil's rows, then over x.
template <int D, typename C>
void row_ranges(const C* centre_row, const std::vector<StencilRow>& rows, C* low, C* high) {
  constexpr C kInfinity = std::numeric_limits<C>::infinity();
  std::array<std::array<C, as_size(kEdge<D>)>, 3> lows;
  std::array<std::array<C, as_size(kEdge<D>)>, 3> highs;
  for (std::size_t reach = 0; reach < 3; ++reach) {
    lows[reach].fill(kInfinity);
    highs[reach].fill(-kInfinity);
  }
  for (const StencilRow& row : rows) {
    const C* v = centre_row + row.offset;
    C* l = lows[as_size(row.reach)].data();
    C* h = highs[as_size(row.reach)].data();
    for (std::size_t x = 0; x < as_size(kEdge<D>); ++x) {  // comparisons with NaN are false
      l[x] = v[x] < l[x] ? v[x] : l[x];
      h[x] = v[x] > h[x] ? v[x] : h[x];
    }
  }
  for (std::size_t cube = 0; cube < as_size(kLeafCubes<D>); ++cube) {
    const std::size_t x = 2 * cube + 2;  // centre 2·cube + 1, stored at + 1
    C l = std::min({lows[0][x], lows[1][x], lows[2][x], lows[1][x - 1], lows[1][x + 1]});
    C h = std::max({highs[0][x], highs[1][x], highs[2][x], highs[1][x - 1], highs[1][x + 1]});
    for (const std::size_t at : {x - 2, x - 1, x + 1, x + 2}) {
      l = std::min(l, lows[2][at]);
      h = std::max(h, highs[2][at]);
    }
    low[cube] = l;
    high[cube] = h;
  }
}

}  // namespace

template <int D, typename C>
void put_leaf_attributes(const Model<D>& model, const Index<D>& brick, const C* values,
                         double slack, NodeLevel& out) {
  static const std::vector<StencilRow> stencil = nested_domain_rows<D>();
  const Index<D> base = brick * kBrickEdge<D>;
  std::vector<C> midpoint;
  midpoint_errors<D>(model, base, values, midpoint);
  if (model.has_holes()) mark_mixed_nodes<D>(model, base, values, midpoint);
  const double reference = model.range_reference();
  const auto stride = strides<D>(kEdge<D>);
  const Index<D> dims = model.shape.attribute_dims(0);
  const std::int32_t first = brick[0] * kLeafCubes<D>;
  const auto n = static_cast<std::size_t>(std::clamp(dims[0] - first, 0, kLeafCubes<D>));
  for_each_row<D>(kLeafCubes<D>, [&](const Index<D>& cube) {
    const Index<D> global = brick * kLeafCubes<D> + cube;
    std::ptrdiff_t row = 0;
    for (std::size_t i = 1; i < as_size(D); ++i) {
      if (global[i] >= dims[i]) return;
      row += (2 * cube[i] + 2) * stride[i];
    }
    std::array<C, as_size(kLeafCubes<D>)> error;
    std::array<C, as_size(kLeafCubes<D>)> low;
    std::array<C, as_size(kLeafCubes<D>)> high;
    row_errors<D>(midpoint, cube, error.data());
    row_ranges<D>(values + row, stencil, low.data(), high.data());
    const std::size_t at = linear_index<D>(dims, global);
    for (std::size_t x = 0; x < n; ++x) {
      out.error[at + x] = encode_error(float_up(static_cast<double>(error[x]) + slack));
      out.low[at + x] = range_down(static_cast<double>(low[x]), reference);
      out.high[at + x] = range_up(static_cast<double>(high[x]), reference);
    }
  });
}

template void put_leaf_attributes<2, float>(const Model<2>&, const Index<2>&, const float*, double,
                                            NodeLevel&);
template void put_leaf_attributes<3, float>(const Model<3>&, const Index<3>&, const float*, double,
                                            NodeLevel&);
template void put_leaf_attributes<2, double>(const Model<2>&, const Index<2>&, const double*,
                                             double, NodeLevel&);
template void put_leaf_attributes<3, double>(const Model<3>&, const Index<3>&, const double*,
                                             double, NodeLevel&);

}  // namespace lode::diamond

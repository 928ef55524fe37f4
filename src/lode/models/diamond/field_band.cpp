#include "lode/models/diamond/field_band.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "lode/mappers/lattice_frame.h"
#include "lode/models/diamond/cell_neighbours.h"
#include "lode/models/diamond/cell_pieces.h"
#include "lode/models/diamond/model_samples.h"

namespace lode::diamond {
namespace {

/// How near to a tetrahedron a sample counts as in it, in steps of the lattice. Coordinates are
/// found in doubles from floats.
constexpr double kNear = 1e-6;
/// How far beside the lattice's border float32 may put what is on it, in LatticeFrame::rounding.
constexpr double kUlpsBeside = 4;
/// Points that are looked at, along an edge, and how much of the limit they may take: what lies
/// between them may take more.
constexpr double kPointsPerStep = 2;
constexpr double kTrialShare = 0.85;
constexpr std::int32_t kEdge = kBrickEdge<3>;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A bit for each sample of a volume, by rows of 64.
class SampleBits {
 public:
  explicit SampleBits(const Index<3>& dims)
      : dims_(dims),
        stride_(as_size(dims[0]) / 64 + 1),
        words_(stride_ * as_size(dims[1]) * as_size(dims[2]), 0) {}

  [[nodiscard]] std::uint64_t* row(std::int32_t y, std::int32_t z) {
    return words_.data() + (as_size(z) * as_size(dims_[1]) + as_size(y)) * stride_;
  }
  [[nodiscard]] const std::uint64_t* row(std::int32_t y, std::int32_t z) const {
    return words_.data() + (as_size(z) * as_size(dims_[1]) + as_size(y)) * stride_;
  }
  /// Whether one from x = first to last is set.
  [[nodiscard]] static bool is_any_set(const std::uint64_t* row, std::int32_t first,
                                       std::int32_t last) {
    for (std::int32_t word = first >> 6; word <= last >> 6; ++word) {
      std::uint64_t bits = row[word];
      if (word == first >> 6) bits &= ~std::uint64_t{0} << (first & 63);
      if (word == last >> 6) bits &= ~std::uint64_t{0} >> (63 - (last & 63));
      if (bits != 0) return true;
    }
    return false;
  }

 private:
  Index<3> dims_;
  std::size_t stride_;
  std::vector<std::uint64_t> words_;
};

template <typename T>
class FieldBand final : public SurfaceBand {
 public:
  FieldBand(const Model<3>& model, double isovalue, double error, Threads threads)
      : model_(model),
        samples_(model),
        dims_(model.shape.dims),
        frame_(LatticeFrame::of(model.info.grid)),
        isovalue_(isovalue),
        error_(error),
        within_(dims_),
        fixed_(dims_) {
    const double scale = 1 / determinant(frame_.to_world);
    const Mat3 cofactor = cofactors(frame_.to_world);
    for (std::size_t i = 0; i < 3; ++i) to_lattice_.rows[i] = cofactor.column(i) * scale;
    find_rounding();
    // Row by row of bricks, as words of a row of samples belong to two of them.
    const std::size_t n = as_size(model.brick_dims[0]);
    parallel_for(model.n_bricks() / n, threads, 1, [&](std::size_t row, int) {
      for (std::size_t x = 0; x < n; ++x) find_bits(row * n + x);
    });
  }

  [[nodiscard]] double limit() const override { return error_; }
  [[nodiscard]] Vec3d own_coordinates(const Vec3d& position) const override;
  [[nodiscard]] unsigned border_planes(const Vec3d& point) const override;
  [[nodiscard]] bool may_hold_fixed(const std::array<Vec3d, 4>& tetrahedron) const override;
  [[nodiscard]] bool seems_within(const Vec3d& apex,
                                  std::span<const std::array<Vec3d, 2>> fan) const override;
  [[nodiscard]] double largest_deviation(const std::array<Vec3d, 3>& triangle) const override;

 private:
  void find_rounding();
  void find_bits(std::size_t brick);
  [[nodiscard]] bool is_inside(const Vec3d& point) const;
  [[nodiscard]] bool is_within(const Vec3d& point) const;
  [[nodiscard]] bool is_cell_within(const Index<3>& cell) const;
  [[nodiscard]] double value_at(const Vec3d& point) const;
  [[nodiscard]] double deviation_in(const Index3& cell, const Piece& piece) const;

  const Model<3>& model_;
  ModelSamples<3> samples_;
  Index<3> dims_;
  LatticeFrame frame_;
  Mat3 to_lattice_;
  double isovalue_;
  double error_;
  double rounding_ = 0;  ///< Of coordinates, in lattice steps: from doubles alone.
  SampleBits within_;    ///< In the band.
  SampleBits fixed_;     ///< Outside it; holes are neither.
};

/// Where float32 put it beside the lattice's border, on that: there samples are to be passed or
/// not.
template <typename T>
Vec3d FieldBand<T>::own_coordinates(const Vec3d& position) const {
  const double near = kUlpsBeside * frame_.rounding;
  Vec3d p = to_lattice_ * (position - frame_.origin);
  for (std::size_t i = 0; i < 3; ++i) {
    const double end = static_cast<double>(dims_[i] - 1);
    if (std::abs(p[i]) <= near) p[i] = 0;
    if (std::abs(p[i] - end) <= near) p[i] = end;
  }
  return p;
}

template <typename T>
void FieldBand<T>::find_rounding() {
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d extent = frame_.to_world.column(i) * static_cast<double>(dims_[i]);
    largest += length(extent);
  }
  largest += length(frame_.origin);
  double slope = 0;
  for (const Vec3d& row : to_lattice_.rows) slope = std::max(slope, length(row));
  rounding_ = 0x1p-48 * slope * largest;
}

template <typename T>
void FieldBand<T>::find_bits(std::size_t brick) {
  const Index<3> at = point_of<3>(model_.brick_dims, brick);
  const Index<3> lower = at * kEdge;
  // Rows between bricks belong to the last that has them: others may be writing them.
  Index<3> n;
  for (std::size_t i = 0; i < 3; ++i) {
    const bool is_whole = i == 0 || at[i] + 1 == model_.brick_dims[i];
    n[i] = std::min(is_whole ? kBrickSamples<3> : kEdge, dims_[i] - lower[i]);
  }
  const T* const samples = reinterpret_cast<const T*>(model_.brick(brick));
  for (std::int32_t z = 0; z < n[2]; ++z)
    for (std::int32_t y = 0; y < n[1]; ++y) {
      const T* const row = samples + Model<3>::brick_offset({{0, y, z}});
      std::uint64_t within = 0;
      std::uint64_t fixed = 0;
      for (std::int32_t x = 0; x < n[0]; ++x) {
        const auto value = static_cast<double>(row[x]);
        const double deviation = std::abs(value - isovalue_);
        const bool is_hole = model_.is_hole(value);
        within |= std::uint64_t{!is_hole && deviation <= error_} << x;
        fixed |= std::uint64_t{!is_hole && deviation > error_} << x;
      }
      for (SampleBits* bits : {&within_, &fixed_}) {
        std::uint64_t* words = bits->row(lower[1] + y, lower[2] + z) + lower[0] / 64;
        const std::uint64_t found = bits == &within_ ? within : fixed;
        words[0] |= found << (lower[0] & 63);
        if ((lower[0] & 63) != 0 && n[0] > 32) words[1] |= found >> 32;
      }
    }
}

template <typename T>
bool FieldBand<T>::is_cell_within(const Index<3>& cell) const {
  std::uint64_t all = 3;
  for (std::int32_t dz = 0; dz < 2; ++dz)
    for (std::int32_t dy = 0; dy < 2; ++dy) {
      const std::uint64_t* row = within_.row(cell[1] + dy, cell[2] + dz);
      const std::int32_t x = cell[0];
      std::uint64_t bits = row[x >> 6] >> (x & 63);
      if ((x & 63) == 63) bits |= row[(x >> 6) + 1] << 1;
      all &= bits;
    }
  return all == 3;
}

/// Linear on the Kuhn simplices from a cell's all-even corner to the all-odd one: from there one
/// axis after the other, the largest coordinate first. Without branches, as none could be foreseen.
template <typename T>
double FieldBand<T>::value_at(const Vec3d& point) const {
  constexpr std::array<std::ptrdiff_t, 3> kSteps{1, kBrickSamples<3>,
                                                 kBrickSamples<3> * kBrickSamples<3>};
  std::array<std::ptrdiff_t, 3> steps{};
  std::array<double, 3> local{};
  std::size_t brick = 0;
  std::ptrdiff_t even = 0;
  for (std::size_t i = 3; i-- > 0;) {
    const std::int32_t cell = std::clamp(static_cast<std::int32_t>(point[i]), 0, dims_[i] - 2);
    const std::int32_t odd = cell & 1;
    const double x = std::clamp(point[i] - static_cast<double>(cell), 0.0, 1.0);
    const double sign = static_cast<double>(1 - 2 * odd);
    local[i] = static_cast<double>(odd) + sign * x;
    steps[i] = (1 - 2 * odd) * kSteps[i];
    even += (cell % kEdge + odd) * kSteps[i];
    brick = brick * as_size(model_.brick_dims[i]) + as_size(cell / kEdge);
  }
  const auto [x, y, z] = local;
  const std::size_t order =
      std::size_t{x >= y} | std::size_t{y >= z} << 1 | std::size_t{x >= z} << 2;
  // By x >= y, y >= z and x >= z; two of the eight cannot be.
  constexpr std::array<std::size_t, 8> kLargest{2, 2, 1, 2, 2, 0, 1, 0};
  constexpr std::array<std::size_t, 8> kSmallest{0, 1, 0, 2, 0, 1, 2, 2};
  const double most = std::max({x, y, z});
  const double least = std::min({x, y, z});
  const double middle = std::max(std::min(x, y), std::min(std::max(x, y), z));
  const T* const sample = reinterpret_cast<const T*>(model_.brick(brick)) + even;
  const std::ptrdiff_t across = steps[0] + steps[1] + steps[2];
  return static_cast<double>(sample[0]) * (1 - most) +
         static_cast<double>(sample[steps[kLargest[order]]]) * (most - middle) +
         static_cast<double>(sample[across - steps[kSmallest[order]]]) * (middle - least) +
         static_cast<double>(sample[across]) * least;
}

template <typename T>
bool FieldBand<T>::is_within(const Vec3d& point) const {
  return std::abs(value_at(point) - isovalue_) <= kTrialShare * error_;
}

/// How many parts of an edge to look at.
int n_parts(const Vec3d& edge) {
  return static_cast<int>(std::clamp(std::ceil(kPointsPerStep * length(edge)), 2.0, 256.0));
}

template <typename T>
bool FieldBand<T>::seems_within(const Vec3d& apex,
                                std::span<const std::array<Vec3d, 2>> fan) const {
  if (!is_inside(apex) || !is_within(apex)) return false;
  for (const auto& [a, b] : fan) {
    const Vec3d u = a - apex;
    const int n = n_parts(u);
    for (int i = 1; i < n; ++i)
      if (!is_within(apex + u * (static_cast<double>(i) / n))) return false;
  }
  for (const auto& [a, b] : fan) {
    const Vec3d u = a - apex;
    const Vec3d v = b - apex;
    const int n = std::max({3, n_parts(u), n_parts(v), n_parts(b - a)});
    for (int i = 1; i < n; ++i)
      for (int j = 1; i + j < n; ++j)
        if (!is_within(apex + u * (static_cast<double>(i) / n) + v * (static_cast<double>(j) / n)))
          return false;
  }
  return true;
}

template <typename T>
unsigned FieldBand<T>::border_planes(const Vec3d& point) const {
  unsigned planes = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (point[i] == 0) planes |= 1U << (2 * i);
    if (point[i] == static_cast<double>(dims_[i] - 1)) planes |= 2U << (2 * i);
  }
  return planes;
}

/// What lies between two planes: n . p from `low` to `high`.
struct Slab {
  Vec3d normal;
  double low = 0;
  double high = 0;
};

/// A tetrahedron as what lies in four slabs, a little larger, relative to its first corner; right
/// for flat ones too.
std::array<Slab, 4> slabs_of(const std::array<Vec3d, 4>& corners, double largest) {
  std::array<Slab, 4> slabs;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3d a = corners[(i + 1) % 4] - corners[0];
    const Vec3d b = corners[(i + 2) % 4] - corners[0];
    const Vec3d c = corners[(i + 3) % 4] - corners[0];
    const Vec3d n = cross(b - a, c - a);
    const double at_face = dot(n, a);
    const double at_corner = dot(n, corners[i] - corners[0]);
    const double slack = kNear * length(n) + 1e-12 * largest * largest * largest;
    slabs[i] = {n, std::min(at_face, at_corner) - slack, std::max(at_face, at_corner) + slack};
  }
  return slabs;
}

template <typename T>
bool FieldBand<T>::may_hold_fixed(const std::array<Vec3d, 4>& tetrahedron) const {
  std::array<std::int32_t, 3> first{};
  std::array<std::int32_t, 3> last{};
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [low, high] =
        std::minmax({tetrahedron[0][i], tetrahedron[1][i], tetrahedron[2][i], tetrahedron[3][i]});
    const double end = static_cast<double>(dims_[i] - 1);
    first[i] = static_cast<std::int32_t>(std::clamp(std::ceil(low - kNear), 0.0, end + 1));
    last[i] = static_cast<std::int32_t>(std::clamp(std::floor(high + kNear), -1.0, end));
    if (first[i] > last[i]) return false;
    largest = std::max(largest, high - low);
  }
  std::array<Slab, 4> slabs;
  bool has_slabs = false;
  for (std::int32_t z = first[2]; z <= last[2]; ++z)
    for (std::int32_t y = first[1]; y <= last[1]; ++y) {
      const std::uint64_t* row = fixed_.row(y, z);
      if (!SampleBits::is_any_set(row, first[0], last[0])) continue;
      if (!has_slabs) slabs = slabs_of(tetrahedron, largest);
      has_slabs = true;
      // Of the row, relative to the first corner.
      double from = static_cast<double>(first[0]) - tetrahedron[0][0];
      double to = static_cast<double>(last[0]) - tetrahedron[0][0];
      for (const Slab& slab : slabs) {
        const double here = slab.normal[1] * (static_cast<double>(y) - tetrahedron[0][1]) +
                            slab.normal[2] * (static_cast<double>(z) - tetrahedron[0][2]);
        const double step = slab.normal[0];
        if (std::abs(step) * (largest + 1) < 1e-300) {
          if (here < slab.low || here > slab.high) to = from - 1;
          continue;
        }
        const double one = (slab.low - here) / step;
        const double other = (slab.high - here) / step;
        from = std::max(from, std::min(one, other));
        to = std::min(to, std::max(one, other));
      }
      if (!(from <= to)) continue;
      const auto x0 = static_cast<std::int32_t>(std::ceil(from + tetrahedron[0][0] - kNear));
      const auto x1 = static_cast<std::int32_t>(std::floor(to + tetrahedron[0][0] + kNear));
      if (x0 <= x1 && SampleBits::is_any_set(row, std::max(x0, first[0]), std::min(x1, last[0])))
        return true;
    }
  return false;
}

template <typename T>
bool FieldBand<T>::is_inside(const Vec3d& point) const {
  for (std::size_t i = 0; i < 3; ++i)
    if (!(point[i] >= 0 && point[i] <= static_cast<double>(dims_[i] - 1))) return false;
  return true;
}

template <typename T>
double FieldBand<T>::largest_deviation(const std::array<Vec3d, 3>& triangle) const {
  if (!std::ranges::all_of(triangle, [&](const Vec3d& p) { return is_inside(p); }))
    return kInfinity;
  double largest = 0;
  visit_cells(Piece(triangle), dims_, [&](const Index3& cell, const Piece& piece) {
    const double here = is_cell_within(cell) ? error_ : deviation_in(cell, piece);
    largest = std::max(largest, here);
  });
  return largest;
}

template <typename T>
double FieldBand<T>::deviation_in(const Index3& cell, const Piece& piece) const {
  CellField field(samples_, cell, isovalue_);
  if (field.is_removed()) {
    // On the border of a present cell, give or take rounding, the field is that cell's.
    const Vec3d near{{kNear, kNear, kNear}};
    const auto present = find_near_cell(samples_, cell, piece, near, CellState::present);
    if (!present) return kInfinity;
    field = CellField(samples_, *present, isovalue_);
  }
  Piece local;
  for (std::size_t i = 0; i < piece.size(); ++i) local.add(field.to_local(piece[i]));
  double largest = 0;
  visit_kuhn_simplices(local, [&](const Piece& part) {
    for (std::size_t i = 0; i < part.size(); ++i)
      largest = std::max(largest, std::abs(field.value_at(part[i])));
  });
  return largest + field.magnitude() * (0x1p-49 + 6 * rounding_);
}

}  // namespace

std::unique_ptr<SurfaceBand> make_field_band(const Model<3>& model, double isovalue, double error,
                                             Threads threads) {
  return visit_storage_type(model.storage, [&]<typename T>() -> std::unique_ptr<SurfaceBand> {
    return std::make_unique<FieldBand<T>>(model, isovalue, error, threads);
  });
}

}  // namespace lode::diamond

#include "lode/models/diamond/field_band.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "lode/mappers/lattice_frame.h"
#include "lode/models/diamond/cell_neighbours.h"
#include "lode/models/diamond/cell_pieces.h"
#include "lode/models/diamond/model_samples.h"
#include "lode/models/diamond/sample_bits.h"

namespace lode::diamond {
namespace {

/// How far beside a cell's border a point may be that is on it, in steps of the lattice.
constexpr double kNear = 1e-6;
/// How far beside the lattice's border float32 may put what is on it, in LatticeFrame::rounding.
constexpr double kUlpsBeside = 4;
/// Points that are looked at, along an edge, and how much of the limit they may take: what lies
/// between them may take more.
constexpr double kPointsPerStep = 2;
constexpr double kTrialShare = 0.85;
constexpr std::int32_t kEdge = kBrickEdge<3>;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Which cells of a part are known.
class KnownCells {
 public:
  explicit KnownCells(FieldPart& part)
      : blocks_(FieldPart::block_dims(part.model.shape.dims)),
        is_known_(std::move(part.is_known)) {}

  [[nodiscard]] bool is_all() const { return is_known_.empty(); }
  [[nodiscard]] bool contain(const Index<3>& cell) const {
    if (is_all()) return true;
    Index<3> block;
    for (std::size_t i = 0; i < 3; ++i) block[i] = cell[i] >> FieldPart::kBlockLevel;
    return is_known_[linear_index<3>(blocks_, block)] != 0;
  }
  /// Sets the bits of their corners.
  void mark(SampleBits& bits) const;

 private:
  Index<3> blocks_;
  std::vector<std::uint8_t> is_known_;
};

void KnownCells::mark(SampleBits& bits) const {
  constexpr std::int32_t kBlock = 1 << FieldPart::kBlockLevel;
  for (std::size_t i = 0; i < is_known_.size(); ++i) {
    if (is_known_[i] == 0) continue;
    const Index<3> lower = point_of<3>(blocks_, i) * kBlock;
    std::array<std::int32_t, 3> end{};
    for (std::size_t a = 0; a < 3; ++a) end[a] = std::min(lower[a] + kBlock + 1, bits.dims()[a]);
    const std::uint64_t row = (std::uint64_t{1} << (end[0] - lower[0])) - 1;
    for (std::int32_t z = lower[2]; z < end[2]; ++z)
      for (std::int32_t y = lower[1]; y < end[1]; ++y)
        SampleBits::set(bits.row(y, z), lower[0], row);
  }
}

/// A part's samples, by its own lattice; those beside its known cells are holes.
class PartSamples final : public FieldSamples {
 public:
  PartSamples(const Model<3>& model, const SampleBits* known) : samples_(model), known_(known) {}
  [[nodiscard]] const RegularGrid& grid() const override { return samples_.grid(); }
  [[nodiscard]] double sample(const Index3& index) const override {
    if (known_ != nullptr &&
        !SampleBits::is_any_set(known_->row(index[1], index[2]), index[0], index[0]))
      return std::numeric_limits<double>::quiet_NaN();
    return samples_.sample(index);
  }

 private:
  ModelSamples<3> samples_;
  const SampleBits* known_;
};

template <typename T>
class FieldBand final : public SurfaceBand {
 public:
  FieldBand(FieldPart part, double isovalue, double error, Threads threads)
      : model_(part.model),
        dims_(model_.shape.dims),
        known_(part),
        known_bits_(known_.is_all() ? Index<3>{{1, 1, 1}} : dims_),
        samples_(model_, known_.is_all() ? nullptr : &known_bits_),
        frame_(LatticeFrame::of(part.grid)),
        origin_(part.origin),
        field_dims_(part.grid.dims),
        isovalue_(isovalue),
        error_(error),
        within_(dims_),
        fixed_(dims_) {
    const double scale = 1 / determinant(frame_.to_world);
    const Mat3 cofactor = cofactors(frame_.to_world);
    for (std::size_t i = 0; i < 3; ++i) to_lattice_.rows[i] = cofactor.column(i) * scale;
    find_rounding();
    known_.mark(known_bits_);
    // Row by row of bricks, as words of a row of samples belong to two of them.
    const std::size_t n = as_size(model_.brick_dims[0]);
    parallel_for(model_.n_bricks() / n, threads, 1, [&](std::size_t row, int) {
      for (std::size_t x = 0; x < n; ++x) find_bits(row * n + x);
    });
  }
  FieldBand(const FieldBand&) = delete;
  FieldBand& operator=(const FieldBand&) = delete;

  [[nodiscard]] double limit() const override { return error_; }
  [[nodiscard]] Vec3d own_coordinates(const Vec3d& position) const override;
  [[nodiscard]] unsigned border_planes(const Vec3d& point) const override;
  [[nodiscard]] bool may_hold_fixed(const std::array<Vec3d, 4>& tetrahedron) const override {
    return fixed_.meets(tetrahedron);
  }
  [[nodiscard]] bool seems_within(const Vec3d& apex,
                                  std::span<const std::array<Vec3d, 2>> fan) const override;
  [[nodiscard]] double largest_deviation(const std::array<Vec3d, 3>& triangle) const override;

 private:
  void find_rounding();
  void find_bits(std::size_t brick);
  /// Where the field's border is, on the part's lattice; the part may end before.
  [[nodiscard]] double lower_border(std::size_t axis) const { return -origin_[axis]; }
  [[nodiscard]] double upper_border(std::size_t axis) const {
    return field_dims_[axis] - 1 - origin_[axis];
  }
  [[nodiscard]] bool is_inside(const Vec3d& point) const;
  [[nodiscard]] bool is_within(const Vec3d& point) const;
  [[nodiscard]] double value_at(const Vec3d& point) const;
  [[nodiscard]] double deviation_in(const Index3& cell, const Piece& piece) const;

  const Model<3>& model_;
  Index<3> dims_;
  KnownCells known_;
  SampleBits known_bits_;  ///< Where not all is known.
  PartSamples samples_;
  LatticeFrame frame_;  ///< The field's.
  Index<3> origin_;
  Index3 field_dims_;
  Mat3 to_lattice_;
  double isovalue_;
  double error_;
  double rounding_ = 0;  ///< Of coordinates, in lattice steps: from doubles alone.
  SampleBits within_;    ///< In the band.
  SampleBits fixed_;     ///< Outside it, or not known; holes are neither.
};

/// Where float32 put it beside the lattice's border, on that: there samples are to be passed or
/// not.
template <typename T>
Vec3d FieldBand<T>::own_coordinates(const Vec3d& position) const {
  const double near = kUlpsBeside * frame_.rounding;
  Vec3d p = to_lattice_ * (position - frame_.origin);
  for (std::size_t i = 0; i < 3; ++i) {
    p[i] -= origin_[i];
    if (std::abs(p[i] - lower_border(i)) <= near) p[i] = lower_border(i);
    if (std::abs(p[i] - upper_border(i)) <= near) p[i] = upper_border(i);
  }
  return p;
}

template <typename T>
void FieldBand<T>::find_rounding() {
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d extent = frame_.to_world.column(i) * static_cast<double>(field_dims_[i]);
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
      std::uint64_t known = (std::uint64_t{1} << n[0]) - 1;
      const std::uint64_t all = known;
      if (!known_.is_all())
        known &= known_bits_.get(known_bits_.row(lower[1] + y, lower[2] + z), lower[0]);
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
      SampleBits::set(within_.row(lower[1] + y, lower[2] + z), lower[0], within & known);
      SampleBits::set(fixed_.row(lower[1] + y, lower[2] + z), lower[0],
                      (fixed & known) | (all & ~known));
    }
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
  if (!known_.is_all()) {
    Index<3> cell;
    for (std::size_t i = 0; i < 3; ++i)
      cell[i] = std::clamp(static_cast<std::int32_t>(point[i]), 0, dims_[i] - 2);
    if (!known_.contain(cell)) return false;
  }
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
  // One point of each first: it may be enough to say no.
  for (const auto& [a, b] : fan)
    if (!is_within((apex + a + b) * (1.0 / 3))) return false;
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
    if (point[i] == lower_border(i)) planes |= 1U << (2 * i);
    if (point[i] == upper_border(i)) planes |= 2U << (2 * i);
  }
  return planes;
}

/// The domain, and the part.
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
    const double here = within_.has_cell(cell) ? error_ : deviation_in(cell, piece);
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

Index<3> FieldPart::block_dims(const Index<3>& dims) {
  Index<3> blocks;
  for (std::size_t i = 0; i < 3; ++i)
    blocks[i] = std::max(1, (dims[i] + (1 << kBlockLevel) - 2) >> kBlockLevel);
  return blocks;
}

std::unique_ptr<SurfaceBand> make_field_band(const Model<3>& model, double isovalue, double error,
                                             Threads threads) {
  return make_field_band({.model = model, .grid = model.info.grid, .origin = {}, .is_known = {}},
                         isovalue, error, threads);
}

std::unique_ptr<SurfaceBand> make_field_band(FieldPart part, double isovalue, double error,
                                             Threads threads) {
  return visit_storage_type(part.model.storage, [&]<typename T>() -> std::unique_ptr<SurfaceBand> {
    return std::make_unique<FieldBand<T>>(std::move(part), isovalue, error, threads);
  });
}

}  // namespace lode::diamond

#include "lode/models/diamond/part_reads.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>
#include <vector>

#include "lode/models/diamond/part_overlap.h"

namespace lode::diamond {
namespace {

using io::IndexRange;

/// Units that are shared may take so many times what a source holds, and some are still there when
/// they are wanted: 640³ uint8 in 27 parts and units of 128³ share 84 MB, of which a source of 63
/// MB reads 18 % of the field again; the spool would move 32 %.
constexpr double kMostOverHeld = 1.5;

/// What parts read along an axis, ascending. Where parts have the field's whole width, each of a
/// column takes over what the one before has read.
template <int D>
std::vector<IndexRange> ranges_along(std::size_t axis, const Shape<D>& shape,
                                     std::int32_t chunks_per_part) {
  const Index<D> n = chunk_counts<D>(shape);
  if (axis == kLastAxis<D> && chunks_per_part >= n[0]) return {{0, shape.dims[axis]}};
  const std::int32_t step = axis == 0 ? chunks_per_part : 1;
  std::vector<IndexRange> ranges;
  for (std::int32_t first = 0; first < n[axis]; first += step) {
    LatticeBox<D> chunks{{}, all_equal<D>(1)};
    chunks.lower[axis] = first;
    chunks.upper[axis] = std::min(first + step, n[axis]);
    const LatticeBox<D> samples = PartPlan<D>::of(shape, chunks).samples;
    ranges.push_back({samples.lower[axis], samples.upper[axis]});
  }
  return ranges;
}

double round_up(std::int32_t i, std::int32_t unit) {
  const std::int64_t n_units = (static_cast<std::int64_t>(i) + unit - 1) / unit;
  return static_cast<double>(n_units * unit);
}

double round_down(std::int32_t i, std::int32_t unit) { return static_cast<double>(i - i % unit); }

/// Samples of the units that the longest of the ranges meets.
double longest(const std::vector<IndexRange>& ranges, std::int32_t unit) {
  double n = 0;
  for (const IndexRange& range : ranges)
    n = std::max(n, round_up(range.upper, unit) - round_down(range.lower, unit));
  return n;
}

/// Samples of the units that two neighbours meet, at most.
double shared(const std::vector<IndexRange>& ranges, std::int32_t unit) {
  double n = 0;
  for (std::size_t i = 0; i + 1 < ranges.size(); ++i)
    n = std::max(n, round_up(ranges[i].upper, unit) - round_down(ranges[i + 1].lower, unit));
  return n;
}

}  // namespace

template <int D>
Result<std::unique_ptr<io::BorderSpool>> spool_borders(VolumeSource& source,
                                                       std::int32_t chunks_per_part,
                                                       const std::string& path) {
  const VolumeInfo& info = source.info();
  const AxisMap<D> axes = AxisMap<D>::of(info.grid.dims);
  const Shape<D> shape = shape_of<D>(info.grid.dims);
  const ReadUnit unit = source.read_unit();
  io::PartedReads reads;
  reads.slice_axis = axes.axis[kLastAxis<D>];
  std::array<std::int32_t, as_size(D)> units{};
  std::array<std::vector<IndexRange>, as_size(D)> ranges;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    units[i] = unit.dims[as_size(axes.axis[i])];
    ranges[i] = ranges_along<D>(i, shape, chunks_per_part);
  }
  for (std::size_t i = 0; i < as_size(D); ++i) {
    // The next part in x comes at once, the next one along the last axis after a row of parts.
    double n = static_cast<double>(size_of(info.type)) * shared(ranges[i], units[i]);
    for (std::size_t j = 0; j < as_size(D); ++j)
      if (j != i) n *= j == 0 ? round_up(shape.dims[0], units[0]) : longest(ranges[j], units[j]);
    const bool comes_soon = i == 0 || i == kLastAxis<D>;
    if (!comes_soon || n > kMostOverHeld * static_cast<double>(source.memory_bytes()))
      reads.parts[as_size(axes.axis[i])] = ranges[i];
  }
  std::error_code status;
  const std::string beside = std::filesystem::absolute(path, status).parent_path().string();
  return io::BorderSpool::make(source, reads, beside.empty() ? "." : beside);
}

template Result<std::unique_ptr<io::BorderSpool>> spool_borders<2>(VolumeSource&, std::int32_t,
                                                                   const std::string&);
template Result<std::unique_ptr<io::BorderSpool>> spool_borders<3>(VolumeSource&, std::int32_t,
                                                                   const std::string&);

}  // namespace lode::diamond

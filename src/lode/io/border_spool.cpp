#include "lode/io/border_spool.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

#include "lode/core/out_of_memory.h"

namespace lode::io {
namespace {

std::size_t n_of(const IndexRange& range) { return static_cast<std::size_t>(range.size()); }

/// Where the rows along x of some ranges lie among the samples of others that hold them.
class RowPlaces {
 public:
  RowPlaces(const std::array<IndexRange, 3>& part, const std::array<IndexRange, 3>& whole)
      : part_(part), whole_(whole) {}

  [[nodiscard]] std::size_t of(std::int32_t row, std::int32_t slice) const {
    const auto y = static_cast<std::size_t>(row - whole_[1].lower);
    const auto z = static_cast<std::size_t>(slice - whole_[2].lower);
    return (z * n_of(whole_[1]) + y) * n_of(whole_[0]) +
           static_cast<std::size_t>(part_[0].lower - whole_[0].lower);
  }
  /// Rows follow each other without gaps.
  [[nodiscard]] bool are_joined() const { return part_[0] == whole_[0]; }

 private:
  std::array<IndexRange, 3> part_;
  std::array<IndexRange, 3> whole_;
};

}  // namespace

Result<std::unique_ptr<BorderSpool>> BorderSpool::make(VolumeSource& source,
                                                       const PartedReads& reads,
                                                       const std::string& directory) {
  const ReadUnit unit = source.read_unit();
  Plans plans;
  bool keeps_any = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    plans[axis] = BorderPlan({reads.parts[axis], unit.dims[axis], unit.stored_share});
    keeps_any = keeps_any || !plans[axis].kept().empty();
  }
  if (!keeps_any) return std::unique_ptr<BorderSpool>();
  auto tally = std::make_shared<IoTally>();
  LODE_TRY(SpoolFile spool, SpoolFile::create(directory, tally));
  return std::unique_ptr<BorderSpool>(
      new BorderSpool(source, reads, std::move(plans), std::move(spool), std::move(tally)));
}

BorderSpool::BorderSpool(VolumeSource& source, const PartedReads& reads, Plans plans,
                         SpoolFile spool, IoTallyPtr tally)
    : source_(source),
      reads_(reads),
      order_(reads.slice_axis == 2 ? std::array<std::size_t, 3>{0, 1, 2}
                                   : std::array<std::size_t, 3>{0, 2, 1}),
      spool_(std::move(spool)),
      tally_(std::move(tally)) {
  for (std::size_t i = 0; i < 3; ++i) plans_[i] = std::move(plans[order_[i]]);
  all_ = ranges_of(source.info().grid.index_box());
  LODE_EXPECTS(reads.slice_axis == 2 || all_[1].size() == 1);
}

BorderSpool::Ranges BorderSpool::ranges_of(const IndexBox& box) const {
  Ranges ranges;
  for (std::size_t i = 0; i < 3; ++i) ranges[i] = {box.lower[order_[i]], box.upper[order_[i]]};
  return ranges;
}

IndexBox BorderSpool::box_of(const Ranges& ranges) const {
  IndexBox box;
  for (std::size_t i = 0; i < 3; ++i) {
    box.lower[order_[i]] = ranges[i].lower;
    box.upper[order_[i]] = ranges[i].upper;
  }
  return box;
}

IoCounts BorderSpool::io() const {
  IoCounts counts = source_.io();
  counts.n_spool_bytes_written += tally_->n_spool_bytes_written;
  counts.n_spool_bytes_read += tally_->n_spool_bytes_read;
  return counts;
}

void BorderSpool::begin_part(const IndexBox& samples) {
  is_parted_ = true;
  const Ranges ranges = ranges_of(samples);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::vector<IndexRange>& parts = reads_.parts[order_[i]];
    const auto found = std::find(parts.begin(), parts.end(), ranges[i]);
    part_[i] = found == parts.end() ? 0 : static_cast<int>(found - parts.begin());
  }
}

Result<void> BorderSpool::read(const IndexBox& box, std::span<std::byte> out) try {
  if (!is_parted_) {
    LODE_CHECK(source_.read(box, out));
    keep(box, out);
    return {};
  }
  const Ranges whole = ranges_of(box);
  const auto n_kept = static_cast<std::int32_t>(slices_.size());
  if (box.is_empty() || whole[2].upper > n_kept) return source_.read(box, out);
  std::array<std::vector<Run>, 3> runs;
  for (std::size_t i = 0; i < 3; ++i) runs[i] = plans_[i].runs_of(whole[i], part_[i]);
  for (const Run& z : runs[2])
    for (const Run& y : runs[1])
      for (const Run& x : runs[0]) {
        const bool is_kept = std::max({x.kept, y.kept, z.kept}) != Run::kFromSource;
        LODE_CHECK(is_kept ? read_spool({x, y, z}, whole, out)
                           : read_source({x.range, y.range, z.range}, whole, out));
      }
  return {};
} catch (const std::bad_alloc&) {
  return out_of_memory("read samples of border layers");
}

/// Slices that are not the next ones are read again when they are wanted.
void BorderSpool::keep(const IndexBox& box, std::span<const std::byte> slices) {
  const Ranges ranges = ranges_of(box);
  const auto next = static_cast<std::int32_t>(slices_.size());
  if (ranges[0] != all_[0] || ranges[1] != all_[1] || ranges[2].lower != next) return;
  slices_.reserve(n_of(all_[2]));
  const std::size_t n_bytes = n_of(all_[0]) * n_of(all_[1]) * sample_size();
  // Where there is no room for the spool, the parts read the source again.
  for (std::size_t i = 0; i < n_of(ranges[2]) && !is_full_; ++i)
    is_full_ = !keep_slice(slices.subspan(i * n_bytes, n_bytes));
}

/// All of it, or rows and then columns; see place_in_slice().
Result<void> BorderSpool::keep_slice(std::span<const std::byte> slice) {
  const std::uint64_t begin = spool_.size();
  const std::size_t row = n_of(all_[0]) * sample_size();
  if (plans_[2].keeps(static_cast<std::int32_t>(slices_.size()))) {
    LODE_CHECK(spool_.append(slice));
  } else {
    for (const IndexRange& rows : plans_[1].kept())
      LODE_CHECK(spool_.append(
          slice.subspan(static_cast<std::size_t>(rows.lower) * row, n_of(rows) * row)));
    for (const IndexRange& columns : plans_[0].kept()) {
      buffer_.clear();
      for (std::size_t y = 0; y < n_of(all_[1]); ++y) {
        const auto first =
            slice.begin() + static_cast<std::ptrdiff_t>(
                                y * row + static_cast<std::size_t>(columns.lower) * sample_size());
        buffer_.insert(buffer_.end(), first,
                       first + static_cast<std::ptrdiff_t>(n_of(columns) * sample_size()));
      }
      LODE_CHECK(spool_.append(buffer_));
    }
  }
  slices_.push_back(begin);
  return {};
}

Result<void> BorderSpool::read_source(const Ranges& part, const Ranges& whole,
                                      std::span<std::byte> out) {
  if (part == whole) return source_.read(box_of(part), out);
  const std::size_t row = n_of(part[0]) * sample_size();
  buffer_.resize(n_of(part[2]) * n_of(part[1]) * row);
  LODE_CHECK(source_.read(box_of(part), buffer_));
  const RowPlaces places(part, whole);
  const std::byte* from = buffer_.data();
  for (std::int32_t z = part[2].lower; z < part[2].upper; ++z)
    for (std::int32_t y = part[1].lower; y < part[1].upper; ++y, from += row)
      std::memcpy(out.data() + places.of(y, z) * sample_size(), from, row);
  return {};
}

BorderSpool::Place BorderSpool::place_in_slice(const std::array<Run, 3>& runs,
                                               std::int32_t slice) const {
  const auto x = static_cast<std::size_t>(runs[0].range.lower);
  const auto y = static_cast<std::size_t>(runs[1].range.lower);
  const std::size_t width = n_of(all_[0]);
  if (plans_[2].keeps(slice)) return {y * width + x, width};
  std::size_t first = 0;
  for (std::size_t i = 0; i < plans_[1].kept().size(); ++i) {
    const IndexRange& rows = plans_[1].kept()[i];
    if (static_cast<int>(i) == runs[1].kept)
      return {first + (y - static_cast<std::size_t>(rows.lower)) * width + x, width};
    first += n_of(rows) * width;
  }
  for (std::size_t i = 0;; ++i) {
    const IndexRange& columns = plans_[0].kept()[i];
    const std::size_t n = n_of(columns);
    if (static_cast<int>(i) == runs[0].kept)
      return {first + y * n + x - static_cast<std::size_t>(columns.lower), n};
    first += n_of(all_[1]) * n;
  }
}

Result<void> BorderSpool::read_spool(const std::array<Run, 3>& runs, const Ranges& whole,
                                     std::span<std::byte> out) {
  const Ranges part{runs[0].range, runs[1].range, runs[2].range};
  const std::size_t row = n_of(part[0]) * sample_size();
  const RowPlaces places(part, whole);
  for (std::int32_t z = part[2].lower; z < part[2].upper; ++z) {
    const Place place = place_in_slice(runs, z);
    const std::uint64_t first = slices_[static_cast<std::size_t>(z)] + place.first * sample_size();
    const std::size_t pitch = place.pitch * sample_size();
    std::byte* to = out.data() + places.of(part[1].lower, z) * sample_size();
    if (pitch == row && places.are_joined()) {
      LODE_CHECK(spool_.read(first, {to, n_of(part[1]) * row}));
      continue;
    }
    if (pitch == row) {
      buffer_.resize(n_of(part[1]) * row);
      LODE_CHECK(spool_.read(first, buffer_));
      for (std::size_t y = 0; y < n_of(part[1]); ++y)
        std::memcpy(to + y * n_of(whole[0]) * sample_size(), buffer_.data() + y * row, row);
      continue;
    }
    for (std::size_t y = 0; y < n_of(part[1]); ++y)
      LODE_CHECK(spool_.read(first + y * pitch, {to + y * n_of(whole[0]) * sample_size(), row}));
  }
  return {};
}

}  // namespace lode::io

#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "lode/core/volume.h"
#include "lode/io/border_plan.h"
#include "lode/io/spool_file.h"

namespace lode::io {

/// How a volume is read: once in whole slices, in ascending order; then part by part.
struct PartedReads {
  int slice_axis = 2;  ///< z, or y where there is one z only.
  /// What the parts read along each axis, ascending; one range where all of them read the same.
  std::array<std::vector<IndexRange>, 3> parts;
};

/// A source that decodes whole units (read_unit()) which several parts need: what the others read
/// of a unit is kept in a spool file when the first pass has it, so that one part decodes it again,
/// at most (BorderPlan). Where the disk has no room for it, the rest is decoded as often as it is
/// asked for. Any box may be read at any time and has the samples of the source; what is
/// not in the spool yet comes from there. Of a slice all that is kept along x and y lies together.
class BorderSpool final : public VolumeSource {
 public:
  /// Null where nothing is worth keeping: among others for units of one sample. Fails when
  /// `directory` takes no file. `source` must outlive it.
  [[nodiscard]] static Result<std::unique_ptr<BorderSpool>> make(VolumeSource& source,
                                                                 const PartedReads& reads,
                                                                 const std::string& directory);

  /// From here on reads are for the part that reads these samples; before, they are for none and
  /// kept. The pass before must have ended.
  void begin_part(const IndexBox& samples);

  [[nodiscard]] const VolumeInfo& info() const override { return source_.info(); }
  [[nodiscard]] Result<void> read(const IndexBox& box, std::span<std::byte> out) override;
  [[nodiscard]] IoCounts io() const override;
  [[nodiscard]] std::uint64_t memory_bytes() const override { return source_.memory_bytes(); }
  [[nodiscard]] ReadUnit read_unit() const override { return source_.read_unit(); }
  void obey(const Progress* progress) override { source_.obey(progress); }

 private:
  using Run = BorderPlan::Run;
  using Plans = std::array<BorderPlan, 3>;
  /// In the order x, the other axis of a slice, the axis of slices.
  using Ranges = std::array<IndexRange, 3>;

  BorderSpool(VolumeSource& source, const PartedReads& reads, Plans plans, SpoolFile spool,
              IoTallyPtr tally);
  void keep(const IndexBox& box, std::span<const std::byte> slices);
  [[nodiscard]] Result<void> keep_slice(std::span<const std::byte> slice);
  [[nodiscard]] Result<void> read_source(const Ranges& part, const Ranges& whole,
                                         std::span<std::byte> out);
  [[nodiscard]] Result<void> read_spool(const std::array<Run, 3>& runs, const Ranges& whole,
                                        std::span<std::byte> out);
  /// In samples of what is kept of a slice.
  struct Place {
    std::size_t first = 0;  ///< The first one that is wanted,
    std::size_t pitch = 0;  ///< and from there to the next row.
  };
  [[nodiscard]] Place place_in_slice(const std::array<Run, 3>& runs, std::int32_t slice) const;
  [[nodiscard]] Ranges ranges_of(const IndexBox& box) const;
  [[nodiscard]] IndexBox box_of(const Ranges& ranges) const;
  [[nodiscard]] std::size_t sample_size() const { return size_of(source_.info().type); }

  VolumeSource& source_;
  PartedReads reads_;
  std::array<std::size_t, 3> order_;  ///< Axes as in Ranges.
  Plans plans_;
  Ranges all_;
  SpoolFile spool_;
  IoTallyPtr tally_;
  bool is_full_ = false;  ///< Nothing more is kept.
  bool is_parted_ = false;
  std::array<int, 3> part_{};          ///< Number along each axis.
  std::vector<std::uint64_t> slices_;  ///< Where what is kept of each slice begins.
  std::vector<std::byte> buffer_;
};

}  // namespace lode::io

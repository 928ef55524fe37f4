#pragma once

#include <array>
#include <map>
#include <memory>
#include <utility>

#include "lode/core/volume.h"

namespace lode::io::test {

/// A volume in memory that is read in whole units, as chunks of a file are, and counts them. Keeps
/// none from one read to the next.
class UnitSource final : public VolumeSource {
 public:
  UnitSource(const Volume& volume, const Index3& unit, double stored_share = 1)
      : source_(make_memory_source(volume)), unit_{.dims = unit, .stored_share = stored_share} {}

  [[nodiscard]] const VolumeInfo& info() const override { return source_->info(); }
  [[nodiscard]] Result<void> read(const IndexBox& box, std::span<std::byte> out) override {
    if (!box.is_empty()) count(box);
    return source_->read(box, out);
  }
  [[nodiscard]] ReadUnit read_unit() const override { return unit_; }
  [[nodiscard]] std::uint64_t memory_bytes() const override { return held_; }
  /// What it says that it keeps.
  void hold(std::uint64_t n_bytes) { held_ = n_bytes; }
  [[nodiscard]] IoCounts io() const override {
    return {.n_file_bytes_read = n_bytes_, .n_spool_bytes_written = 0, .n_spool_bytes_read = 0};
  }

  /// How often each unit was read since the last call, by its position.
  [[nodiscard]] std::map<std::array<std::int32_t, 3>, int> take_counts() {
    return std::exchange(counts_, {});
  }

 private:
  void count(const IndexBox& box) {
    IndexBox units;
    for (std::size_t i = 0; i < 3; ++i) {
      units.lower[i] = box.lower[i] / unit_.dims[i];
      units.upper[i] = (box.upper[i] - 1) / unit_.dims[i] + 1;
    }
    for (std::int32_t z = units.lower[2]; z < units.upper[2]; ++z)
      for (std::int32_t y = units.lower[1]; y < units.upper[1]; ++y)
        for (std::int32_t x = units.lower[0]; x < units.upper[0]; ++x) ++counts_[{x, y, z}];
    const IndexBox unit{{}, unit_.dims};
    n_bytes_ +=
        static_cast<std::uint64_t>(units.n_samples() * unit.n_samples()) * size_of(info().type);
  }

  std::unique_ptr<VolumeSource> source_;
  ReadUnit unit_;
  std::uint64_t held_ = 0;
  std::map<std::array<std::int32_t, 3>, int> counts_;
  std::uint64_t n_bytes_ = 0;
};

}  // namespace lode::io::test

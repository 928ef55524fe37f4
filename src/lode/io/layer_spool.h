#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lode/core/volume.h"
#include "lode/io/spool_file.h"

namespace lode::io {

/// A source that decodes whole units (read_unit()) and has no memory for one layer of them along x
/// and y, so that slice after slice would decode each unit again and again. Here the first read of
/// a slice decodes its layer once, in tiles of as many units as the source holds, into a spool file
/// that has the samples from then on. Where the disk has no room for a layer, the source is read.
class LayerSpool final : public VolumeSource {
 public:
  /// The source itself where it has room for a layer, or units have a single slice. Fails when
  /// `directory` takes no file.
  [[nodiscard]] static Result<std::unique_ptr<VolumeSource>> wrap(
      std::unique_ptr<VolumeSource> source, const std::string& directory);

  [[nodiscard]] const VolumeInfo& info() const override { return source_->info(); }
  [[nodiscard]] Result<void> read(const IndexBox& box, std::span<std::byte> out) override;
  [[nodiscard]] IoCounts io() const override;
  [[nodiscard]] std::uint64_t memory_bytes() const override { return source_->memory_bytes(); }

 private:
  LayerSpool(std::unique_ptr<VolumeSource> source, const Index3& tile, SpoolFile spool,
             IoTallyPtr tally);
  /// Whether the layer is in the file by now; false: there was no room.
  [[nodiscard]] Result<bool> spool_layer(std::int32_t layer);
  [[nodiscard]] Result<bool> spool_tile(const IndexBox& tile);
  [[nodiscard]] Result<void> read_tile(const IndexBox& tile, std::uint64_t begin,
                                       const IndexBox& box, std::span<std::byte> out) const;
  [[nodiscard]] std::vector<IndexBox> tiles_of(std::int32_t layer) const;
  [[nodiscard]] std::size_t sample_size() const { return size_of(info().type); }

  std::unique_ptr<VolumeSource> source_;
  Index3 tile_;  ///< Samples: whole units, one along z.
  SpoolFile spool_;
  IoTallyPtr tally_;
  bool is_full_ = false;                           ///< Nothing more is kept.
  std::vector<std::vector<std::uint64_t>> tiles_;  ///< Where they begin, by layer; empty: not kept.
  std::vector<std::byte> buffer_;
};

}  // namespace lode::io

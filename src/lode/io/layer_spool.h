#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lode/core/volume.h"
#include "lode/io/packed_spool.h"

namespace lode::io {

/// A source that decodes whole units (read_unit()) and has no memory for one layer of them along x
/// and y, so that slice after slice would decode each unit again and again. Here the first read of
/// a slice decodes its layer once, in tiles of as many units as the source holds, into a spool file
/// that has the samples from then on. Where the disk gets so full that what is made of the samples
/// might not fit beside it, the spool is given up and the source is read.
class LayerSpool final : public VolumeSource {
 public:
  /// The source itself where it has room for a layer, or units have a single slice. Fails when
  /// `directory` takes no file.
  [[nodiscard]] static Result<std::unique_ptr<VolumeSource>> wrap(
      std::unique_ptr<VolumeSource> source, const std::string& directory);

  [[nodiscard]] const VolumeInfo& info() const override { return source_->info(); }
  [[nodiscard]] Result<void> read(const IndexBox& box, std::span<std::byte> out) override;
  [[nodiscard]] IoCounts io() const override;
  [[nodiscard]] std::uint64_t memory_bytes() const override;
  void obey(const Progress* progress) override { progress_ = progress; }

 private:
  LayerSpool(std::unique_ptr<VolumeSource> source, const Index3& tile, std::string directory,
             PackedSpool spool, IoTallyPtr tally);
  /// Where the layer's tiles begin in the file, once they are there; null: there is no room.
  [[nodiscard]] Result<const std::vector<std::uint64_t>*> spool_layer(std::int32_t layer);
  [[nodiscard]] Result<bool> spool_tile(const IndexBox& tile);
  [[nodiscard]] bool leaves_room() const;
  [[nodiscard]] Result<void> read_tile(const IndexBox& tile, std::uint64_t begin,
                                       const IndexBox& box, std::span<std::byte> out);
  [[nodiscard]] std::vector<IndexBox> tiles_of(std::int32_t layer) const;
  [[nodiscard]] std::size_t sample_size() const { return size_of(info().type); }

  std::unique_ptr<VolumeSource> source_;
  Index3 tile_;                ///< Samples: whole units, one along z.
  std::int32_t n_slices_ = 1;  ///< Of a tile that are read at a time.
  std::string directory_;
  std::optional<PackedSpool> spool_;  ///< None: it was given up.
  IoTallyPtr tally_;
  const Progress* progress_ = nullptr;
  std::map<std::int32_t, std::vector<std::uint64_t>> tiles_;  ///< Where they begin, by layer.
  std::vector<std::byte> buffer_;
};

}  // namespace lode::io

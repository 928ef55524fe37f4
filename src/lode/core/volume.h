#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/regular_grid.h"
#include "lode/core/result.h"
#include "lode/core/scalar_type.h"
#include "lode/core/units.h"

namespace lode {

/// What a scalar volume is, without its samples.
struct VolumeInfo {
  RegularGrid grid;
  ScalarType type = ScalarType::uint8;
  std::string field_name;        ///< Empty when the file names none.
  std::optional<double> nodata;  ///< Samples equal to this are holes (as non-finite ones are).
  Units units{};

  friend bool operator==(const VolumeInfo&, const VolumeInfo&) = default;
};

/// Bytes that a source has moved so far. Spools are files without a name, in which a source keeps
/// what it cannot decode twice.
struct IoCounts {
  std::uint64_t n_file_bytes_read = 0;  ///< Of foreign files: headers, samples, compressed bytes.
  std::uint64_t n_spool_bytes_written = 0;
  std::uint64_t n_spool_bytes_read = 0;

  friend bool operator==(const IoCounts&, const IoCounts&) = default;
};

/// What a source reads and decodes as a whole, however little of it is asked for.
struct ReadUnit {
  Index3 dims{{1, 1, 1}};   ///< Samples; units begin at multiples of them.
  double stored_share = 1;  ///< About how many bytes are read for a byte of its samples.
  /// What one takes in memory, decoded; 0: its samples. More where other channels come with them.
  std::uint64_t decoded_bytes = 0;
};

/// A scalar volume that hands out boxes of samples: the only way the build sees its input.
/// read() may be called from one thread at a time, in any order; ascending z is fastest.
class VolumeSource {
 public:
  virtual ~VolumeSource() = default;

  [[nodiscard]] virtual const VolumeInfo& info() const = 0;
  /// Fills `out` with the samples of `box` (inside the grid), native byte order, x fastest.
  /// `out` has box.n_samples() · size_of(type) bytes.
  [[nodiscard]] virtual Result<void> read(const IndexBox& box, std::span<std::byte> out) = 0;
  /// What was moved since the source was opened, with the opening; nothing for samples in memory.
  /// May be asked from any thread, also during a read.
  [[nodiscard]] virtual IoCounts io() const { return {}; }
  /// Bytes of memory that it takes at most, its caller's buffers aside: what is decoded and kept.
  [[nodiscard]] virtual std::uint64_t memory_bytes() const { return 0; }
  [[nodiscard]] virtual ReadUnit read_unit() const { return {}; }
  /// From now on reads that take long may end early, with an error, once `progress` is cancelled;
  /// null: none does. It must outlive them.
  virtual void obey(const Progress* /*progress*/) {}
};

/// A volume whose samples are all in memory, x fastest, native byte order.
struct Volume {
  VolumeInfo info;
  std::vector<std::byte> samples;  ///< info.grid.n_samples() · size_of(info.type) bytes.

  template <typename T>
  [[nodiscard]] std::span<const T> as() const {
    LODE_EXPECTS(scalar_type_of<T> == info.type);
    return {reinterpret_cast<const T*>(samples.data()), samples.size() / sizeof(T)};
  }
};

/// Serves boxes from a Volume; `volume` must outlive the source.
[[nodiscard]] std::unique_ptr<VolumeSource> make_memory_source(const Volume& volume);

/// Reads a whole source into memory.
[[nodiscard]] Result<Volume> read_all(VolumeSource& source);

/// Makes a Volume from typed samples (dims[0]·dims[1]·dims[2] of them), for tests and examples.
template <typename T>
[[nodiscard]] Volume make_volume(const RegularGrid& grid, std::span<const T> samples) {
  LODE_EXPECTS(static_cast<std::int64_t>(samples.size()) == grid.n_samples());
  Volume volume{{.grid = grid, .type = scalar_type_of<T>, .field_name = {}, .nodata = {}}, {}};
  const auto bytes = std::as_bytes(samples);
  volume.samples.assign(bytes.begin(), bytes.end());
  return volume;
}

}  // namespace lode

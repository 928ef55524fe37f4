#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/regular_grid.h"
#include "lode/core/result.h"
#include "lode/core/scalar_type.h"
#include "lode/core/volume.h"

namespace lode::io {

enum class ByteOrder { little, big };

/// What a file of bare samples cannot say about itself; x varies fastest.
struct RawLayout {
  Index3 dims{{0, 0, 0}};
  ScalarType type = ScalarType::uint8;
  Vec3d spacing{{1, 1, 1}};  ///< A negative one mirrors its axis.
  Vec3d origin{{0, 0, 0}};
  ByteOrder byte_order = ByteOrder::little;
};

/// The length of a vector, taken as the scalar.
struct Magnitude {};

/// Which scalar of a vector field is read: a component, counted from 0, or the magnitude.
using ComponentChoice = std::variant<int, Magnitude>;

struct ReadOptions {
  std::optional<std::string> field;          ///< Needed where the file holds several arrays.
  std::optional<ComponentChoice> component;  ///< Needed for vectors and for channels.
  std::optional<int> time;                   ///< Step, from 0; needed where there are several.
  std::optional<double> nodata;              ///< Finite: this value marks holes.
  std::optional<RawLayout> raw;              ///< Needed by, and only for, files of bare samples.
  /// Samples that the file holds encoded are decoded into memory while opening when all of them,
  /// decoded, take at most so many bytes; beyond that while reading, and into a spool file unless
  /// the file lets small pieces be decoded on their own, as VTK XML does.
  std::size_t memory_limit = std::numeric_limits<std::size_t>::max();
  /// Of spool files, which have no name there and vanish with the source. Empty: TMPDIR, else /tmp.
  std::string spool_directory;
  /// Most bytes of decoded chunks that a source made of chunks keeps for the next read.
  std::size_t cache_limit = std::numeric_limits<std::size_t>::max();
  Threads threads;  ///< For decoding, where a format is made of chunks.
  Units units{};    ///< Those that are not empty stand for what the file says.
};

/// What a foreign file says beside VolumeInfo.
struct FileDescription {
  std::string format;               ///< "NRRD, gzip", ...
  std::string frame_note;           ///< How the file names its frame, or that it does not.
  std::vector<std::string> fields;  ///< Names of its point arrays; one empty name if unnamed.
  int n_components = 1;             ///< Of the field that `field` picks, else of the first.
  int n_times = 1;
  RegularGrid grid;
  ScalarType type = ScalarType::uint8;  ///< As stored, before any slope; of the same field.
  Units units{};                        ///< Likewise.
};

/// Whether open_volume() takes a file of that name, or is a directory; any other needs options.raw.
[[nodiscard]] bool is_volume_path(const std::string& path);

/// Opens a volume for reading; the format follows from the extension: .nrrd .nhdr .mha .mhd .nii
/// .nii.gz .hdr .img .vti .vtr .vtk, and .raw .raw.gz or any other one with options.raw. A
/// directory is a Zarr array, a group of them or an OME-Zarr image. Uncompressed samples stay in
/// the file and are read box by box, and so are the chunks of Zarr; compressed and text ones, and
/// those of several data files, are read into memory here, while they fit options.memory_limit.
/// Compressed ones beyond it are decoded as far as reads reach, and damage appears at the read that
/// reaches it; text ones beyond it are refused. Fails, naming the file, on anything missing,
/// truncated, malformed or ambiguous (several fields, components or times and no choice).
[[nodiscard]] Result<std::unique_ptr<VolumeSource>> open_volume(const std::string& path,
                                                                const ReadOptions& options);

/// Reads a file's header only; options.field, .raw and .memory_limit are used, the rest ignored.
[[nodiscard]] Result<FileDescription> describe_volume(const std::string& path,
                                                      const ReadOptions& options);

}  // namespace lode::io

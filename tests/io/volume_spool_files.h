#pragma once

#include <sys/resource.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tests/io/volume_test_files.h"

namespace lode::io::test {

/// Of every spooled volume: a few times what the spool's buffer holds.
constexpr Index3 kSpoolDims{{64, 50, 48}};

/// Bytes that deflate cannot make smaller, always the same.
std::string noise(std::size_t n);

/// Names and bytes; the last is opened.
using SpoolFiles = std::vector<std::pair<std::string, std::string>>;

/// A volume of kSpoolDims that is decoded rather than read where it is.
struct SpoolSeed {
  std::string name;
  std::function<SpoolFiles()> make_files;  ///< Each test runs alone, and needs few of them.
  ReadOptions options;
  std::uint64_t n_bytes = 0;  ///< Of the decoded samples: all components and times.
  bool is_spooled = true;     ///< Else decoded again for every read, beyond the memory limit.

  /// Read first to find the header, and once more with the samples, as far as the file reaches.
  std::uint64_t header_piece = std::uint64_t{1} << 16;

  /// Read by opening and one pass upwards through the volume.
  [[nodiscard]] std::uint64_t most_file_bytes(const SpoolFiles& files) const;
};

std::vector<SpoolSeed> spool_seeds();
/// Those whose samples lie in several files.
std::vector<SpoolSeed> part_spool_seeds();
/// Those in VTK XML files, whose counts tell at opening that a file is too short.
std::vector<SpoolSeed> vtk_spool_seeds();

/// Header and zlib blocks of `block` bytes each, as VTK writes them with UInt32 counts.
struct VtkBlocked {
  std::string header;
  std::string blocks;
};
VtkBlocked vtk_blocked(const std::string& bytes, std::size_t block);

/// An ImageData file of kSpoolDims samples of 16 bits.
struct VtkText {
  std::string root;      ///< More attributes of the root.
  std::string array;     ///< More attributes of the array.
  std::string content;   ///< Of the array.
  std::string appended;  ///< The whole element.
};
std::string vtk_image(const VtkText& text);

/// Attributes.
constexpr const char* kVtkZlib = " compressor=\"vtkZLibDataCompressor\"";
constexpr const char* kVtkAppended = "format=\"appended\" offset=\"0\"";
constexpr const char* kVtkBinary = "format=\"binary\"";

/// The options with a memory limit that no volume keeps to.
ReadOptions spooling(ReadOptions options, const std::string& directory);

/// The samples of a box, whose read must succeed.
std::vector<std::byte> read_box(VolumeSource& source, const IndexBox& box);

/// A limit of file sizes while it lives: the one full disk that every machine has.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(std::uint64_t n_bytes);
  ~FileSizeLimit();
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  void (*handler_)(int);
  rlimit before_{};
};

}  // namespace lode::io::test

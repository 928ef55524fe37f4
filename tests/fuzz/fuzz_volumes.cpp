// Foreign volumes: the input is the file. It is opened and read, whole or, where it promises very
// much, at its two ends; then again with samples decoded while reading instead of while opening,
// which must come to the same.
#include <algorithm>
#include <optional>
#include <vector>

#include "lode/io/volume_reader.h"
#include "tests/fuzz/fuzz_files.h"
#include "tests/fuzz/fuzz_parts.h"

namespace lode::fuzz {
namespace {

/// A volume promises this many samples at most if it is read whole: files that compress well, and
/// those that consist of a fill value, may promise what no memory holds.
constexpr std::int64_t kMaxSamples = 1 << 20;

using Samples = std::vector<std::byte>;

Result<Samples> read_ends(const std::string& path, const io::ReadOptions& options) {
  LODE_TRY(const auto source, io::open_volume(path, options));
  const VolumeInfo& info = source->info();
  const bool is_large = info.grid.n_samples() > kMaxSamples;
  Samples all;
  for (const bool is_end : {false, true}) {
    IndexBox box = info.grid.index_box();
    for (std::size_t i = 0; i < 3 && is_large; ++i) {
      if (is_end)
        box.lower[i] = std::max(box.upper[i] - 8, 0);
      else
        box.upper[i] = std::min(box.upper[i], 8);
    }
    Samples samples(static_cast<std::size_t>(box.n_samples()) * size_of(info.type));
    LODE_CHECK(source->read(box, samples));
    all.insert(all.end(), samples.begin(), samples.end());
    if (!is_large) break;
  }
  return all;
}

/// That of the input, or the one that the input says its samples are in.
void check_message(const Error& error) {
  expect(error.message.find('/') < error.message.find(": "), "an error begins with a file's name",
         error.message);
}

/// Errors may differ: what is decoded later is found to be damaged later.
void read_volume(const std::string& path, io::ReadOptions options = {}) {
  const auto described = io::describe_volume(path, options);
  if (!described) check_message(described.error());
  options.component = 0;
  options.time = 0;
  const auto samples = read_ends(path, options);
  if (!samples) check_message(samples.error());
  options.memory_limit = 1;
  options.spool_directory = fuzz_directory().path("");
  const auto spooled = read_ends(path, options);
  if (samples && spooled)
    expect(*samples == *spooled, "decoding while reading gives what decoding while opening gave");
}

void read_file(const std::string& name, Input input) {
  read_volume(fuzz_directory().write(name, input));
}

/// A directory with two files in it.
void read_directory(const std::string& first, const std::string& second, Input input) {
  const auto parts = split(input);
  const FuzzDirectory& directory = fuzz_directory();
  directory.write("zarr/" + first, parts.first);
  directory.write("zarr/" + second, parts.second);
  read_volume(directory.path("zarr"));
}

}  // namespace

/// A header may name its own file as that of its data.
void run_nrrd(Input input) { read_file("a.nhdr", input); }
void run_metaimage(Input input) { read_file("a.mha", input); }
void run_vtk_legacy(Input input) { read_file("a.vtk", input); }

void run_nifti(Input input) {
  read_file("a.nii", input);
  read_file("a.nii.gz", input);
}

void run_vtk_xml(Input input) { read_file("a.vti", input); }

/// The metadata, and one chunk.
void run_zarr_v2(Input input) { read_directory(".zarray", "0.0.0", input); }
void run_zarr_v3(Input input) { read_directory("zarr.json", "c/0/0/0", input); }
/// The metadata of an image, and of its finest array, whose chunks are missing.
void run_ome_zarr(Input input) { read_directory("zarr.json", "s0/zarr.json", input); }

}  // namespace lode::fuzz

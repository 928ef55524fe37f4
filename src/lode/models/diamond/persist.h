#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lode/core/progress.h"
#include "lode/models/diamond/model.h"
#include "lode/models/diamond/summary.h"
#include "lode/store/reader.h"

namespace lode::diamond {

/// The name of the model in a .lode file: "diamond2d" or "diamond3d".
template <int D>
[[nodiscard]] std::string model_name();

/// What a file says of its model beside the blocks (docs/format.md, section 7).
struct Metadata {
  VolumeInfo info;
  Summary summary;
};

[[nodiscard]] std::vector<std::byte> encode_metadata(const Metadata& metadata);
/// What is known before any error is: all of them as infinite. The bytes that indexes of blocks
/// have.
[[nodiscard]] std::vector<std::byte> encode_early_metadata(const VolumeInfo& info,
                                                           const FieldStats& stats);

/// Reads the metadata of a diamond2d or diamond3d, and no block. Fails, naming the file, on sizes,
/// ranges, counts and errors that no model has, on bytes too few or too many, and where the blocks
/// cannot hold the samples, so that memory may be taken for what it says; where the directory was
/// rebuilt, where a file of that size could not. Whether the summary is true, load() and
/// rebuild_check() find out.
[[nodiscard]] Result<Metadata> read_metadata(const store::Reader& reader);

/// Whether the file's errors are what they are today: of fields with holes they were finite where
/// cells were removed, in files without kFeatureRemovedCells.
[[nodiscard]] bool has_current_errors(const store::Reader& reader, const Metadata& metadata);
/// Fails unless they are. Salvage finds errors anew and needs not ask.
[[nodiscard]] Result<void> check_current(const store::Reader& reader, const Metadata& metadata);

/// Whether the file has world errors: those from before there were any have not.
[[nodiscard]] bool has_worlds(const store::Reader& reader);

/// Writes the model as blocks, chunk by chunk, along a space-filling curve inside a level
/// (docs/format.md). The bytes depend on the model only.
template <int D>
[[nodiscard]] Result<void> save(const Model<D>& model, const std::string& path, Threads threads,
                                Progress& progress);

/// Loads a whole model. Every block is checked, samples beyond the data against the nearest ones in
/// it, and the metadata's summary against what the blocks give.
template <int D>
[[nodiscard]] Result<Model<D>> load(const store::Reader& reader, Threads threads,
                                    Progress& progress);

/// Bytes a file's blocks take on disk: samples, and everything else, by level (finest first).
struct StoredBytes {
  std::uint64_t samples = 0;
  std::uint64_t attributes = 0;
  std::vector<std::uint64_t> by_level;
};
[[nodiscard]] StoredBytes stored_bytes(const store::Reader& reader);

}  // namespace lode::diamond

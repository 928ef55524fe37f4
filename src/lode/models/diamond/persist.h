#pragma once

#include <string>

#include "lode/core/progress.h"
#include "lode/models/diamond/model.h"
#include "lode/store/reader.h"

namespace lode::diamond {

/// The name of the model in a .lode file: "diamond2d" or "diamond3d".
template <int D>
[[nodiscard]] std::string model_name();

/// Writes the model as blocks, coarse levels first, along a space-filling curve inside a level
/// (docs/format.md). The bytes depend on the model only.
template <int D>
[[nodiscard]] Result<void> save(const Model<D>& model, const std::string& path, Threads threads,
                                Progress& progress);

/// Loads a whole model; every block is checked.
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

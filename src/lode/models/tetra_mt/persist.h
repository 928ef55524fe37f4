#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lode/core/progress.h"
#include "lode/models/tetra_mt/packed_hierarchy.h"

namespace lode::tetra_mt {

/// The model's name in files.
inline constexpr std::string_view kModelName = "tetra_mt";

/// What has been read of a file since it was opened.
struct FileReads {
  std::uint64_t n_bytes = 0;
  std::uint64_t file_size = 0;
};

/// A hierarchy whose pages come from a file.
struct OpenedHierarchy {
  PackedHierarchy hierarchy;
  /// Of a field, at the vertices of a page of nodes, or, numbered after those, of the base's. Null
  /// of a lean file, as are the mesh's numbers.
  std::function<Result<std::vector<std::uint32_t>>(std::size_t field, std::uint32_t page)>
      gradients;
  /// By vertex: its number in the mesh that was read.
  std::function<Result<std::vector<std::uint32_t>>()> mesh_vertices;
  std::function<FileReads()> reads;
};

/// gradient_code() of a field's gradients, by vertex.
using GradientsOf = std::function<std::vector<std::uint32_t>(std::size_t field)>;

/// Writes a hierarchy as docs/format.md says, whole or not at all. `gradients`: null for a lean
/// file, without these and the mesh's numbers of its vertices. Returns the size of the file.
[[nodiscard]] Result<std::uint64_t> save(const Hierarchy& hierarchy, std::uint64_t n_cells,
                                         const GradientsOf& gradients, const std::string& path,
                                         Threads threads, Progress& progress);

/// Whether a file is a .lode file of this model; also false where it cannot be read.
[[nodiscard]] bool is_model_of(const std::string& path);

/// Reads what is there from the beginning, the base; pages are read when they are looked at. Fails
/// on all that is not as docs/format.md says, naming the file and what was expected.
[[nodiscard]] Result<OpenedHierarchy> open(const std::string& path);

}  // namespace lode::tetra_mt

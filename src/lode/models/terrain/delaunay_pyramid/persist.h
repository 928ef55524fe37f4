#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/delaunay_pyramid/history.h"

namespace lode::delaunay_pyramid {

/// The model's name in files.
inline constexpr std::string_view kModelName = "delaunay_pyramid";

inline constexpr std::uint32_t kMaxLevels = 4096;

/// A history, and the tolerances that it was made for: each finer than the one before.
struct Pyramid {
  History history;
  std::vector<double> levels;
};

/// Writes a pyramid as docs/format.md says, whole or not at all. No triangle but the base's is in
/// the file: the vertices in their order make them again. Returns the size of the file.
[[nodiscard]] Result<std::uint64_t> save(const Pyramid& pyramid, const std::string& path,
                                         Progress& progress);

/// Whether a file is a .lode file of this model; also false where it cannot be read.
[[nodiscard]] bool is_model_of(const std::string& path);

/// Reads all of it and inserts the vertices again, with exact predicates: the triangles are those
/// of a Delaunay triangulation whatever the file says. Fails on all that is not as docs/format.md
/// says, naming the file and what was expected.
[[nodiscard]] Result<Pyramid> open(const std::string& path, Progress& progress);

}  // namespace lode::delaunay_pyramid

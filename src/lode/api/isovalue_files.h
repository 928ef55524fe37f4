#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "lode/api/dataset.h"
#include "lode/io/surface_file.h"

namespace lode {

/// Several isovalues' surfaces go to files of their own, each named by a path that ends as `path`.
/// Whether one extraction makes them all: where their cut is to be a common one (max_distance,
/// keep_topology), or simplification is to see them all, so that none passes through another; and
/// of a file's parts, which are read once then, in formats that are written piece by piece.
/// Otherwise each extracted by itself lies in the same cut as the others; but not where it is
/// simplified within a max_error, which takes one isovalue: those may meet where the bands do.
[[nodiscard]] Result<bool> are_extracted_together(const Dataset& dataset,
                                                  const ExtractOptions& options,
                                                  const std::string& path, Progress& progress);

/// Extracts all isovalues at once, each into a file of its own, written whole or not at all: the
/// parts of the surface that extract() gives. `paths`: one for each isovalue, in their order, of
/// one format. `note(report, isovalue)` is what a file says of itself; the report is of all.
[[nodiscard]] Result<ExtractReport> extract_to_files(
    const Dataset& dataset, const ExtractOptions& options, std::span<const std::string> paths,
    const std::function<io::SurfaceWriteOptions(const ExtractReport&, double isovalue)>& note,
    Progress& progress);

/// Writes a surface's isovalues into files of their own, each whole or not at all; what is written
/// before one fails stays. `paths`: one for each isovalue, in their order; `note(isovalue)` is what
/// a file says of itself. Vertices must have isovalues; values, errors and further fields are left
/// out.
[[nodiscard]] Result<void> write_isovalue_files(
    const Surface& all, std::span<const double> isovalues, std::span<const std::string> paths,
    const std::function<io::SurfaceWriteOptions(double isovalue)>& note, Progress& progress);

/// Refuses isovalues that a file of this name cannot tell apart: .glb has them as float32.
[[nodiscard]] Result<void> check_isovalues_of(const std::string& path,
                                              std::vector<double> isovalues);

/// Surfaces of one isovalue each, read from a file each, one behind the other as extract() gives
/// them. Refuses another number of isovalues than of paths, and files that were placed differently.
[[nodiscard]] Result<Surface> read_isovalue_files(std::span<const std::string> paths,
                                                  std::span<const double> isovalues);

}  // namespace lode

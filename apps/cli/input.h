#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "command.h"
#include "lode/api/files.h"

namespace lode::cli {

/// The options that say how a file is to be read, as typed: all but the last are of foreign files.
struct ReadingArguments {
  std::string field;
  std::vector<std::string> with;       ///< Further fields of a mesh of cells,
  std::vector<std::string> deforming;  ///< and those that --warp needs.
  std::string component;
  std::string time;
  std::string nodata;
  std::string dims;
  std::string type;
  std::string spacing;
  std::string origin;
  std::string byte_order;
  std::string length_unit;
  std::string value_unit;
  std::string weld;  ///< This and the next two are of meshes of cells.
  std::string weld_values;
  std::string linearise;
  std::string region_field;
  std::vector<std::string> only_regions;
  std::string solution;  ///< Of MEDIT meshes.
  std::string placement;
  std::string order;
  bool is_fast = false;
  bool has_space_errors = false;  ///< Of a mesh of cells that is built; as far as queries need it.
  bool salvage = false;

  /// Names of the options that are there, but for --salvage: "--field, --dims".
  [[nodiscard]] std::string given() const;
  [[nodiscard]] bool is_empty() const { return given().empty(); }
  /// --component as the number that an axis stands for, "magnitude", or as it is.
  [[nodiscard]] std::string component_number() const;
};

void add_reading_options(CLI::App& app, ReadingArguments& arguments);

[[nodiscard]] Result<ReadOptions> to_read_options(const ReadingArguments& arguments,
                                                  Threads threads);

/// Refuses options for files of the other kind: they would silently do nothing.
[[nodiscard]] Result<void> check_reading_options(const ReadingArguments& arguments,
                                                 const std::string& path);

/// A model ready for queries, and how it came to be.
struct Input {
  Dataset dataset;
  DatasetInfo info;
  double open_seconds = 0;  ///< Reading, and building where it was needed.
  bool was_built = false;   ///< From a foreign file, in memory.
};

/// Of a .lode file that cannot be opened why, and of what is no volume by its name what else there
/// is: whoever meant terrain or a mesh needs to know that.
[[nodiscard]] Result<void> check_is_volume(const std::string& path,
                                           const ReadingArguments& reading);
/// The same, or that an --isovalue is missing.
[[nodiscard]] Error no_isovalue(const std::string& path, const ReadingArguments& reading);

/// Fails on a mesh of cells, naming it.
[[nodiscard]] Result<void> expect_no_mesh(const std::string& path);

/// open_volume() after expect_no_mesh().
[[nodiscard]] Result<std::unique_ptr<VolumeSource>> open_foreign_volume(const std::string& path,
                                                                        const ReadOptions& options);

/// Looks at what a file holds before the work starts, and may refuse it.
using AcceptVolume = std::function<Result<void>(const VolumeInfo&)>;

/// Opens a .lode file, of which nothing is read yet unless it is salvaged, or builds a foreign one
/// in memory and says so on stderr.
[[nodiscard]] Result<Input> open_input(Session& session, const std::string& path,
                                       const ReadingArguments& arguments,
                                       const AcceptVolume& accept = {});
/// The same, with all of a .lode file read: for what looks at everything.
[[nodiscard]] Result<Input> load_input(Session& session, const std::string& path,
                                       const ReadingArguments& arguments,
                                       const AcceptVolume& accept = {});

/// The keys that start what `lode extract` reports, whatever kind its answer is.
[[nodiscard]] Json extract_head(const std::string& input_path, const Input& input,
                                const std::vector<std::string>& outputs);

/// Where a limit was asked for, as typed, that a hierarchy which is built in memory does not keep.
void warn_of_limit(Session& session, const std::string& memory_limit, const Input& input);

/// What is behind the first words of a file's comment: ", lengths in mm", or nothing.
[[nodiscard]] std::string units_comment(const Input& input);

/// Refuses two outputs in one place and an output that would replace an input.
[[nodiscard]] Result<void> check_paths_differ(const std::vector<std::string>& inputs,
                                              const std::vector<std::string>& outputs);

}  // namespace lode::cli

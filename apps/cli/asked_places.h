#pragma once

#include <string>
#include <vector>

#include "command.h"
#include "lode/api/terrain_tin.h"

namespace lode::cli {

/// Places that a question is about, as typed.
struct AskedPlaces {
  std::string file;
  std::vector<std::string> typed;
  std::string crs;
};

/// POINTS.csv, --at and --places-crs.
void add_asked_places(CLI::App& app, AskedPlaces& arguments);
/// Looks at the arguments alone. `input`: the file that is asked.
[[nodiscard]] Result<void> check_asked_places(const AskedPlaces& arguments,
                                              const std::string& input);
/// Those typed, then those of the file, as they are given.
[[nodiscard]] Result<std::vector<Place>> read_asked_places(const AskedPlaces& arguments);
/// The files that are read: the input, and that of places where there is one.
[[nodiscard]] std::vector<std::string> asked_inputs(const AskedPlaces& arguments,
                                                    const std::string& input);
/// inside, gap or outside.
[[nodiscard]] const char* status_name(TerrainHeight::Where where);

}  // namespace lode::cli

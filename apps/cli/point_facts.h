#pragma once

#include <string>

#include "command.h"
#include "lode/api/files.h"
#include "text.h"

namespace lode::cli {

/// The keys and rows of scattered points: how many, what was left out and why, which share a
/// position, and the lattice that they are on.
void add_point_facts(const PointFacts& facts, Json& json, Table& table);

/// Warns of heights that are no longer those of the file's points, of points that were moved, and
/// of a CRS that could not be read.
void warn_of_points(const PointFacts& facts, const std::string& path, RepeatedHeights repeated,
                    Session& session);

}  // namespace lode::cli

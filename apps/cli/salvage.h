#pragma once

#include <string>

#include "command.h"
#include "lode/api/salvage.h"
#include "text.h"

namespace lode::cli {

/// Says on stderr what was lost of a file: that is never silent.
void warn_of_damage(Session& session, const std::string& path, const SalvageReport& report);

/// What `lode extract --salvage` adds to any answer within `achieved` of the filled field: the key
/// "salvage" and rows; nothing where `report` is null.
void add_salvage(Json& json, const SalvageReport* report, double achieved);
void add_salvage(Table& table, const SalvageReport* report, double achieved);

/// For the comment in an output, after what it says of errors; empty for null.
[[nodiscard]] std::string salvage_comment(const SalvageReport* report);

/// The error of a query, which says how to go on where it is of a damaged block of the file.
[[nodiscard]] Error suggest_salvage(const Error& error, const std::string& path);

}  // namespace lode::cli

#pragma once

#include <string>

namespace lode::fuzz {

/// Writes a seed into the corpus of a harness.
void keep(const std::string& harness, const std::string& name, const std::string& bytes);

/// Two parts, as split() takes them apart.
[[nodiscard]] std::string joined(const std::string& first, const std::string& second);

/// Of what reads meshes of cells, with their solutions, and scattered points.
void keep_meshes();
void keep_points();

}  // namespace lode::fuzz

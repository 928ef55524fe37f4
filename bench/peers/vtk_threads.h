#pragma once

#include <string>

namespace lode::bench {

/// Limits VTK's filters to n threads.
void limit_vtk_threads(int n);

/// VTK's parallel backend and how many threads it will use.
[[nodiscard]] std::string vtk_backend();
[[nodiscard]] int n_vtk_threads();

}  // namespace lode::bench

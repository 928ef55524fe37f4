#pragma once

#include <string>

namespace lode::vtk_import {

/// Throws std::runtime_error where a block of an Exodus II file has elements whose nodes VTK's
/// reader does not take all of: it would go through them in steps of another length, and make cells
/// of any nodes. Says nothing of files that are no netCDF: the reader does.
void check_exodus_elements(const std::string& path);

}  // namespace lode::vtk_import

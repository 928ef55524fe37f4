#pragma once

#include <vtkDataObject.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <cstdint>
#include <string>
#include <vector>

namespace lode::vtk_import {

/// Whether the blocks of a reader's output have one list of points between them, or each its own.
enum class BlockPoints : std::uint8_t { own, shared };

/// A block that has cells of three dimensions.
struct Block {
  std::string name;  ///< Empty where it has none.
  std::int64_t region = 0;
  std::int64_t n_cells = 0;
};

/// A block of faces on these.
struct NamedPatch {
  std::string name;
  std::int64_t id = 0;
  std::int64_t n_faces = 0;
};

struct Flattened {
  vtkSmartPointer<vtkUnstructuredGrid> grid;
  std::vector<Block> blocks;  ///< None of a grid that is alone.
  std::vector<NamedPatch> patches;
  int n_left_out = 0;  ///< Blocks without either.
  std::int64_t n_faces_left_out = 0;
};

/// Makes one grid of all blocks that have solid cells: points, cells and all numeric arrays, with
/// NaN where a block lacks one, 0 for ghost arrays. Cells of curvilinear blocks become hexahedra;
/// those with a hidden point are hidden. Of the cells, RegionId is that of the blocks where all
/// have it, else their ObjectId, else 1, 2, ..., and the grid's field data have, as RegionIds and
/// RegionNames, the names of blocks that are a region of their own; a grid that is alone keeps its
/// arrays, and those that are of no points or cells, as they are. Blocks of faces are patches:
/// append_patches(). Throws std::runtime_error where nothing solid is there, and where blocks that
/// share points have different ones.
[[nodiscard]] Flattened flatten(vtkDataObject& data, BlockPoints points);

}  // namespace lode::vtk_import

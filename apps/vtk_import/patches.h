#pragma once

#include <vtkDataSet.h>
#include <vtkSmartPointer.h>

#include <string>
#include <vector>

#include "flatten.h"

namespace lode::vtk_import {

/// A block of faces: what a part of the boundary may be.
struct FaceBlock {
  vtkSmartPointer<vtkDataSet> data;
  std::string name;
};

/// Whether a block has cells of two dimensions, and none of three.
[[nodiscard]] bool has_faces(vtkDataSet& data);

/// Appends the faces of blocks to a grid of solid cells, and gives all its cells PatchId: 0 of
/// solid ones, else the block's ObjectId where all blocks have different ones from 1 on, or 1, 2,
/// ... Of blocks with points of their own, corners are the grid's points at the same place; faces
/// without such, and blocks without such faces, are left out and counted.
void append_patches(const std::vector<FaceBlock>& blocks, BlockPoints points, Flattened& made);

}  // namespace lode::vtk_import

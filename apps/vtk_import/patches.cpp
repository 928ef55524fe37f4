#include "patches.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkGenericCell.h>
#include <vtkIdList.h>
#include <vtkTypeInt64Array.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <unordered_map>

namespace lode::vtk_import {
namespace {

constexpr const char* kPatches = "PatchId";
constexpr const char* kObjectIds = "ObjectId";

using Place = std::array<double, 3>;

struct PlaceHash {
  std::size_t operator()(const Place& p) const {
    std::size_t hash = 0;
    for (const double x : p) hash = hash * 1000003 + std::hash<double>()(x == 0 ? 0.0 : x);
    return hash;
  }
};

/// The grid's points by where they are; of several the first.
using PointsByPlace = std::unordered_map<Place, vtkIdType, PlaceHash>;

Place place_of(vtkDataSet& data, vtkIdType point) {
  Place p{};
  data.GetPoint(point, p.data());
  return p;
}

PointsByPlace by_place(vtkDataSet& grid) {
  PointsByPlace points;
  for (vtkIdType i = 0; i < grid.GetNumberOfPoints(); ++i) points.emplace(place_of(grid, i), i);
  return points;
}

int dimension_of(int type) {
  const auto cell = vtkSmartPointer<vtkCell>::Take(vtkGenericCell::InstantiateCell(type));
  return cell == nullptr ? 0 : cell->GetCellDimension();
}

/// A block's own number, where it has one.
std::int64_t object_of(const FaceBlock& block) {
  vtkDataArray* const ids = block.data->GetCellData()->GetArray(kObjectIds);
  if (ids == nullptr || ids->GetNumberOfTuples() == 0) return 0;
  const double id = ids->GetTuple1(0);
  constexpr double kMost = 0x1p53;
  return id == std::trunc(id) && std::abs(id) < kMost ? static_cast<std::int64_t>(id) : 0;
}

std::vector<std::int64_t> numbers_of(const std::vector<FaceBlock>& blocks) {
  std::vector<std::int64_t> numbers;
  numbers.reserve(blocks.size());
  for (const FaceBlock& block : blocks) numbers.push_back(object_of(block));
  std::vector<std::int64_t> sorted = numbers;
  std::sort(sorted.begin(), sorted.end());
  const bool are_good = (sorted.empty() || sorted.front() > 0) &&
                        std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end();
  if (!are_good)
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<std::int64_t>(i) + 1;
  return numbers;
}

/// Cells that have come since an array was filled have nothing in it.
void fill_up(vtkUnstructuredGrid& grid) {
  vtkCellData& cells = *grid.GetCellData();
  for (int i = 0; i < cells.GetNumberOfArrays(); ++i) {
    vtkDataArray* const array = cells.GetArray(i);
    if (array == nullptr) continue;
    const bool is_floating =
        array->GetDataType() == VTK_FLOAT || array->GetDataType() == VTK_DOUBLE;
    const std::vector<double> none(static_cast<std::size_t>(array->GetNumberOfComponents()),
                                   is_floating ? std::numeric_limits<double>::quiet_NaN() : 0.0);
    while (array->GetNumberOfTuples() < grid.GetNumberOfCells())
      array->InsertNextTuple(none.data());
  }
}

}  // namespace

bool has_faces(vtkDataSet& data) {
  bool has = false;
  for (vtkIdType i = 0; i < data.GetNumberOfCells(); ++i) {
    const int dimension = dimension_of(data.GetCellType(i));
    if (dimension == 3) return false;
    has = has || dimension == 2;
  }
  return has;
}

void append_patches(const std::vector<FaceBlock>& blocks, BlockPoints points, Flattened& made) {
  if (blocks.empty()) return;
  vtkUnstructuredGrid& grid = *made.grid;
  const bool is_shared = points == BlockPoints::shared;
  const PointsByPlace places = is_shared ? PointsByPlace() : by_place(grid);
  const auto patches = vtkSmartPointer<vtkTypeInt64Array>::New();
  patches->SetName(kPatches);
  for (vtkIdType i = 0; i < grid.GetNumberOfCells(); ++i) patches->InsertNextValue(0);
  const std::vector<std::int64_t> numbers = numbers_of(blocks);
  const auto list = vtkSmartPointer<vtkIdList>::New();
  const auto point_of = [&](vtkDataSet& data, vtkIdType point) -> vtkIdType {
    if (is_shared) return point < grid.GetNumberOfPoints() ? point : -1;
    const auto at = places.find(place_of(data, point));
    return at == places.end() ? -1 : at->second;
  };
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    vtkDataSet& data = *blocks[b].data;
    const vtkIdType before = grid.GetNumberOfCells();
    for (vtkIdType i = 0; i < data.GetNumberOfCells(); ++i) {
      if (dimension_of(data.GetCellType(i)) != 2) continue;
      data.GetCellPoints(i, list);
      bool is_there = true;
      for (vtkIdType k = 0; k < list->GetNumberOfIds(); ++k) {
        list->SetId(k, point_of(data, list->GetId(k)));
        is_there = is_there && list->GetId(k) >= 0;
      }
      if (!is_there) {
        ++made.n_faces_left_out;
        continue;
      }
      grid.InsertNextCell(data.GetCellType(i), list);
      patches->InsertNextValue(numbers[b]);
    }
    const vtkIdType n = grid.GetNumberOfCells() - before;
    if (n > 0)
      made.patches.push_back({blocks[b].name, numbers[b], n});
    else
      ++made.n_left_out;
  }
  if (made.patches.empty()) return;
  fill_up(grid);
  grid.GetCellData()->AddArray(patches);
}

}  // namespace lode::vtk_import

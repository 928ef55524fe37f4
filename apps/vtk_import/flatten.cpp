#include "flatten.h"

#include <vtkCellData.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkFieldData.h>
#include <vtkGenericCell.h>
#include <vtkIdList.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkMultiPieceDataSet.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStringArray.h>
#include <vtkStructuredGrid.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include "patches.h"

namespace lode::vtk_import {
namespace {

constexpr const char* kGhosts = "vtkGhostType";
constexpr const char* kBlanking = "IBlank";  // of PLOT3D; what it hides the ghost array says
constexpr const char* kRegions = "RegionId";
constexpr const char* kObjects = "ObjectId";

/// A block on its way into the grid.
struct Leaf {
  vtkSmartPointer<vtkDataSet> data;
  std::string name;
  vtkIdType first_point = 0;
  vtkIdType first_cell = 0;
};

vtkIdType n_solid_structured(vtkStructuredGrid& grid) {
  std::array<int, 3> dims{};
  grid.GetDimensions(dims.data());
  vtkIdType n = 1;
  for (const int d : dims) n *= std::max(d - 1, 0);
  return n;
}

bool is_solid_type(int type) {
  const auto cell = vtkSmartPointer<vtkCell>::Take(vtkGenericCell::InstantiateCell(type));
  return cell != nullptr && cell->GetCellDimension() == 3;
}

bool has_solid_cells(vtkDataSet& data) {
  if (auto* const grid = vtkStructuredGrid::SafeDownCast(&data))
    return n_solid_structured(*grid) > 0;
  int last = -1;
  for (vtkIdType i = 0; i < data.GetNumberOfCells(); ++i) {
    const int type = data.GetCellType(i);
    if (type != last && is_solid_type(type)) return true;
    last = type;
  }
  return false;
}

/// What a reader gives, block by block.
struct Leaves {
  std::vector<Leaf> solid;
  std::vector<FaceBlock> faces;
  int n_left_out = 0;
};

void add_leaf(vtkDataObject* data, std::string name, Leaves& leaves) {
  auto* const set = vtkDataSet::SafeDownCast(data);
  if (set != nullptr && has_solid_cells(*set)) {
    leaves.solid.push_back({set, std::move(name)});
  } else if (set != nullptr && has_faces(*set)) {
    leaves.faces.push_back({set, std::move(name)});
  } else {
    ++leaves.n_left_out;
  }
}

constexpr const char* kInternal = "Internal";  // of a zone of CGNS, beside its patches

void add_pieces(vtkMultiPieceDataSet& pieces, const std::string& name, Leaves& leaves) {
  for (unsigned i = 0; i < pieces.GetNumberOfPieces(); ++i)
    if (vtkDataObject* const piece = pieces.GetPieceAsDataObject(i)) add_leaf(piece, name, leaves);
}

void add_blocks(vtkMultiBlockDataSet& blocks, const std::string& own_name, Leaves& leaves) {
  for (unsigned i = 0; i < blocks.GetNumberOfBlocks(); ++i) {
    vtkDataObject* const block = blocks.GetBlock(i);
    if (block == nullptr) continue;
    const char* given = nullptr;
    if (blocks.HasMetaData(i) != 0) given = blocks.GetMetaData(i)->Get(vtkCompositeDataSet::NAME());
    const std::string name = given == nullptr ? "" : given;
    if (auto* const inner = vtkMultiBlockDataSet::SafeDownCast(block))
      add_blocks(*inner, name, leaves);
    else if (auto* const pieces = vtkMultiPieceDataSet::SafeDownCast(block))
      add_pieces(*pieces, name, leaves);
    else
      add_leaf(block, name == kInternal ? own_name : name, leaves);
  }
}

bool is_single(vtkDataObject& data) { return vtkDataSet::SafeDownCast(&data) != nullptr; }

Leaves leaves_of(vtkDataObject& data) {
  Leaves leaves;
  if (auto* const blocks = vtkMultiBlockDataSet::SafeDownCast(&data))
    add_blocks(*blocks, "", leaves);
  else
    add_leaf(&data, "", leaves);
  return leaves;
}

void append_points(BlockPoints kind, std::vector<Leaf>& leaves, vtkUnstructuredGrid& grid) {
  const auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  for (Leaf& leaf : leaves) {
    const vtkIdType n = leaf.data->GetNumberOfPoints();
    if (kind == BlockPoints::shared && &leaf != leaves.data()) {
      if (n != points->GetNumberOfPoints())
        throw std::runtime_error("expected blocks with the same points, got different ones");
      continue;
    }
    leaf.first_point = points->GetNumberOfPoints();
    points->Resize(leaf.first_point + n);
    for (vtkIdType i = 0; i < n; ++i) points->InsertNextPoint(leaf.data->GetPoint(i));
  }
  grid.SetPoints(points);
}

void append_hexahedra(vtkStructuredGrid& block, vtkIdType first_point, vtkUnstructuredGrid& grid) {
  std::array<int, 3> dims{};
  block.GetDimensions(dims.data());
  const auto id = [&](vtkIdType x, vtkIdType y, vtkIdType z) {
    return first_point + (z * dims[1] + y) * dims[0] + x;
  };
  for (vtkIdType z = 0; z + 1 < dims[2]; ++z)
    for (vtkIdType y = 0; y + 1 < dims[1]; ++y)
      for (vtkIdType x = 0; x + 1 < dims[0]; ++x) {
        const std::array<vtkIdType, 8> corners{
            id(x, y, z),     id(x + 1, y, z),     id(x + 1, y + 1, z),     id(x, y + 1, z),
            id(x, y, z + 1), id(x + 1, y, z + 1), id(x + 1, y + 1, z + 1), id(x, y + 1, z + 1)};
        grid.InsertNextCell(VTK_HEXAHEDRON, 8, corners.data());
      }
}

/// A polyhedron's list: the number of faces, and each as its number of corners and these.
void shift_faces(vtkIdList& list, vtkIdType first_point) {
  vtkIdType at = 1;
  for (vtkIdType face = 0; face < list.GetId(0); ++face) {
    const vtkIdType n = list.GetId(at++);
    for (vtkIdType i = 0; i < n; ++i, ++at) list.SetId(at, list.GetId(at) + first_point);
  }
}

void append_cells(Leaf& leaf, vtkUnstructuredGrid& grid) {
  leaf.first_cell = grid.GetNumberOfCells();
  if (auto* const block = vtkStructuredGrid::SafeDownCast(leaf.data))
    return append_hexahedra(*block, leaf.first_point, grid);
  auto* const unstructured = vtkUnstructuredGrid::SafeDownCast(leaf.data);
  const auto list = vtkSmartPointer<vtkIdList>::New();
  for (vtkIdType i = 0; i < leaf.data->GetNumberOfCells(); ++i) {
    const int type = leaf.data->GetCellType(i);
    if (type == VTK_POLYHEDRON && unstructured != nullptr) {
      unstructured->GetFaceStream(i, list);
      shift_faces(*list, leaf.first_point);
    } else {
      leaf.data->GetCellPoints(i, list);
      for (vtkIdType k = 0; k < list->GetNumberOfIds(); ++k)
        list->SetId(k, list->GetId(k) + leaf.first_point);
    }
    grid.InsertNextCell(type, list);
  }
}

/// Hides the cells of a curvilinear block that have a hidden point. In other grids Lode does.
void hide_cells(vtkStructuredGrid& block) {
  auto* const points = vtkUnsignedCharArray::SafeDownCast(block.GetPointData()->GetArray(kGhosts));
  if (points == nullptr) return;
  auto* old = vtkUnsignedCharArray::SafeDownCast(block.GetCellData()->GetArray(kGhosts));
  const auto cells = vtkSmartPointer<vtkUnsignedCharArray>::New();
  cells->SetName(kGhosts);
  const auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->Allocate(block.GetNumberOfCells());
  append_hexahedra(block, 0, *grid);
  const auto corners = vtkSmartPointer<vtkIdList>::New();
  for (vtkIdType i = 0; i < grid->GetNumberOfCells(); ++i) {
    unsigned char ghost = old == nullptr ? 0 : old->GetValue(i);
    grid->GetCellPoints(i, corners);
    for (const vtkIdType corner : *corners)
      if ((points->GetValue(corner) & vtkDataSetAttributes::HIDDENPOINT) != 0)
        ghost |= vtkDataSetAttributes::HIDDENCELL;
    cells->InsertNextValue(ghost);
  }
  block.GetPointData()->RemoveArray(kGhosts);
  block.GetCellData()->AddArray(cells);
}

/// An array as the blocks have it.
struct Column {
  int type = 0;
  int n_components = 0;
  bool is_everywhere = true;
};

bool is_floating(int type) { return type == VTK_FLOAT || type == VTK_DOUBLE; }

vtkDataSetAttributes& attributes_of(const Leaf& leaf, int association) {
  return *leaf.data->GetAttributes(association);
}

std::map<std::string, Column> columns_of(const std::vector<Leaf>& leaves, int association) {
  std::map<std::string, Column> columns;
  for (const Leaf& leaf : leaves) {
    vtkDataSetAttributes& attributes = attributes_of(leaf, association);
    for (int i = 0; i < attributes.GetNumberOfArrays(); ++i) {
      vtkDataArray* const array = attributes.GetArray(i);
      if (array == nullptr || array->GetName() == nullptr) continue;
      if (std::string(array->GetName()) == kBlanking) continue;
      const auto [at, is_new] = columns.try_emplace(
          array->GetName(), Column{array->GetDataType(), array->GetNumberOfComponents()});
      if (!is_new && at->second.type != array->GetDataType()) at->second.type = VTK_DOUBLE;
      if (!is_new && at->second.n_components != array->GetNumberOfComponents())
        throw std::runtime_error(std::string("expected the array ") + array->GetName() +
                                 " to have as many components in all blocks, got different ones");
    }
  }
  for (auto& [name, column] : columns)
    for (const Leaf& leaf : leaves)
      if (attributes_of(leaf, association).GetArray(name.c_str()) == nullptr)
        column.is_everywhere = false;
  return columns;
}

/// VTK's reader of Exodus files makes a vector NAME_ of NAME_x, NAME_y and NAME_z.
std::string name_of(const std::string& name, const std::map<std::string, Column>& columns) {
  const bool is_joined = name.size() > 1 && name.back() == '_' && columns.at(name).n_components > 1;
  const std::string shorter = name.substr(0, name.size() - 1);
  return is_joined && !columns.contains(shorter) ? shorter : name;
}

vtkSmartPointer<vtkDataArray> joined(const std::vector<Leaf>& leaves, int association,
                                     const std::string& name, const Column& column) {
  const bool is_ghosts = name == kGhosts;
  const bool needs_nan = !column.is_everywhere && !is_ghosts && !is_floating(column.type);
  auto made = vtkSmartPointer<vtkDataArray>::Take(
      vtkDataArray::CreateDataArray(needs_nan ? VTK_DOUBLE : column.type));
  made->SetName(name.c_str());
  made->SetNumberOfComponents(column.n_components);
  const std::vector<double> none(static_cast<std::size_t>(column.n_components),
                                 is_ghosts ? 0 : std::numeric_limits<double>::quiet_NaN());
  for (const Leaf& leaf : leaves) {
    vtkDataArray* const from = attributes_of(leaf, association).GetArray(name.c_str());
    const vtkIdType n = leaf.data->GetNumberOfElements(association);
    if (from != nullptr) made->InsertTuples(made->GetNumberOfTuples(), n, 0, from);
    for (vtkIdType i = 0; from == nullptr && i < n; ++i) made->InsertNextTuple(none.data());
  }
  return made;
}

/// Of the grid's cells: what an array says in whole numbers; none where it does not.
vtkSmartPointer<vtkTypeInt64Array> whole_regions(vtkDataArray* given) {
  if (given == nullptr || given->GetNumberOfComponents() != 1) return nullptr;
  auto regions = vtkSmartPointer<vtkTypeInt64Array>::New();
  for (vtkIdType i = 0; i < given->GetNumberOfTuples(); ++i) {
    const double region = given->GetTuple1(i);
    if (region != std::trunc(region)) return nullptr;
    regions->InsertNextValue(static_cast<vtkTypeInt64>(region));
  }
  return regions;
}

/// Whether a reader made the name up: what VTK calls blocks of Exodus files that have none.
bool is_made_up(const std::string& name) {
  return name.empty() || name.starts_with("Unnamed block ID:");
}

/// As RegionIds and RegionNames of the grid's field data: names of blocks whose cells, and no
/// others, are one region.
void add_region_names(vtkTypeInt64Array& regions, const std::vector<Leaf>& leaves,
                      vtkUnstructuredGrid& grid) {
  constexpr std::size_t kSeveral = std::numeric_limits<std::size_t>::max();
  std::map<vtkTypeInt64, std::size_t> block_of;
  std::vector<int> n_regions(leaves.size());
  for (std::size_t b = 0; b < leaves.size(); ++b) {
    std::set<vtkTypeInt64> found;
    for (vtkIdType i = 0; i < leaves[b].data->GetNumberOfCells(); ++i)
      found.insert(regions.GetValue(leaves[b].first_cell + i));
    n_regions[b] = static_cast<int>(found.size());
    for (const vtkTypeInt64 region : found)
      if (!block_of.try_emplace(region, b).second) block_of[region] = kSeveral;
  }
  const auto ids = vtkSmartPointer<vtkTypeInt64Array>::New();
  const auto names = vtkSmartPointer<vtkStringArray>::New();
  ids->SetName("RegionIds");
  names->SetName("RegionNames");
  for (const auto& [region, b] : block_of) {
    if (b == kSeveral || n_regions[b] != 1 || is_made_up(leaves[b].name)) continue;
    ids->InsertNextValue(region);
    names->InsertNextValue(leaves[b].name);
  }
  if (ids->GetNumberOfTuples() == 0) return;
  grid.GetFieldData()->AddArray(ids);
  grid.GetFieldData()->AddArray(names);
}

/// Gives the grid's cells their RegionId, and says which block has which.
void add_regions(const std::vector<Leaf>& leaves, Flattened& made) {
  vtkCellData& cells = *made.grid->GetCellData();
  vtkSmartPointer<vtkTypeInt64Array> regions = whole_regions(cells.GetArray(kRegions));
  if (regions == nullptr) regions = whole_regions(cells.GetArray(kObjects));
  if (regions == nullptr) {
    regions = vtkSmartPointer<vtkTypeInt64Array>::New();
    for (std::size_t b = 0; b < leaves.size(); ++b)
      for (vtkIdType i = 0; i < leaves[b].data->GetNumberOfCells(); ++i)
        regions->InsertNextValue(static_cast<vtkTypeInt64>(b) + 1);
  }
  regions->SetName(kRegions);
  cells.RemoveArray(kObjects);
  cells.AddArray(regions);  // in place of what had its name
  for (const Leaf& leaf : leaves)
    made.blocks.push_back(
        {leaf.name, regions->GetValue(leaf.first_cell), leaf.data->GetNumberOfCells()});
  add_region_names(*regions, leaves, *made.grid);
}

}  // namespace

Flattened flatten(vtkDataObject& data, BlockPoints points) {
  Flattened made;
  made.grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  const Leaves found = leaves_of(data);
  std::vector<Leaf> leaves = found.solid;
  made.n_left_out = found.n_left_out;
  if (leaves.empty())
    throw std::runtime_error("expected blocks with cells of three dimensions, got none");
  vtkIdType n_cells = 0;
  for (const Leaf& leaf : leaves) n_cells += leaf.data->GetNumberOfCells();
  made.grid->Allocate(n_cells);
  append_points(points, leaves, *made.grid);
  for (Leaf& leaf : leaves) {
    append_cells(leaf, *made.grid);
    if (auto* const block = vtkStructuredGrid::SafeDownCast(leaf.data)) hide_cells(*block);
  }
  vtkCellData& cells = *made.grid->GetCellData();
  const bool is_exodus = points == BlockPoints::shared;
  const auto add_columns = [&leaves, is_exodus](int association, vtkDataSetAttributes& attributes) {
    const std::map<std::string, Column> columns = columns_of(leaves, association);
    for (const auto& [name, column] : columns) {
      const auto array = joined(leaves, association, name, column);
      if (is_exodus) array->SetName(name_of(name, columns).c_str());
      attributes.AddArray(array);
    }
  };
  add_columns(vtkDataObject::CELL, cells);
  if (is_single(data))
    made.grid->SetFieldData(leaves[0].data->GetFieldData());
  else
    add_regions(leaves, made);
  if (points == BlockPoints::shared) leaves.resize(1);
  add_columns(vtkDataObject::POINT, *made.grid->GetPointData());
  append_patches(found.faces, points, made);
  return made;
}

}  // namespace lode::vtk_import

#include "lode/io/grid_pieces.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "lode/io/mesh_checks.h"
#include "lode/io/mesh_ghosts.h"
#include "lode/io/mesh_pieces.h"

namespace lode::io {
namespace {

/// A box of places, points or cells, inside a larger one.
struct PlacedBox {
  Index3 dims;
  std::array<std::int64_t, 3> at{};
  Index3 within;
};

template <typename F>
void for_each_place(const PlacedBox& box, F&& visit) {
  std::size_t from = 0;
  for (std::int64_t z = 0; z < box.dims[2]; ++z)
    for (std::int64_t y = 0; y < box.dims[1]; ++y)
      for (std::int64_t x = 0; x < box.dims[0]; ++x) {
        const std::int64_t row = (box.at[2] + z) * box.within[1] + box.at[1] + y;
        visit(from++, static_cast<std::size_t>(row * box.within[0] + box.at[0] + x));
      }
}

/// Places of one kind, as far as pieces have filled them.
struct GridFill {
  const std::string& path;
  Index3 dims;
  std::vector<std::uint8_t> is_filled;
  std::vector<MeshField> fields;
};

/// Room for fields like those of a piece.
GridFill make_fill(const std::string& path, const Index3& dims, std::size_t n,
                   const std::vector<MeshField>& like) {
  GridFill fill{.path = path, .dims = dims, .is_filled = {}, .fields = {}};
  fill.is_filled.resize(n);
  for (const MeshField& field : like) {
    fill.fields.push_back({field.name, field.type, field.n_components, {}});
    fill.fields.back().values.resize(n * static_cast<std::size_t>(field.n_components));
  }
  return fill;
}

/// Fills places that are empty where `accepts(from)`, and tells `visit(from, to)`.
template <typename Accepts, typename F>
Result<void> fill_places(const std::vector<MeshField>& piece, const PlacedBox& box, GridFill& fill,
                         Accepts&& accepts, F&& visit) {
  LODE_TRY(const auto sources, matching_fields(fill.path, fill.fields, piece));
  for_each_place(box, [&](std::size_t from, std::size_t to) {
    if (fill.is_filled[to] != 0 || !accepts(from)) return;
    fill.is_filled[to] = 1;
    for (std::size_t i = 0; i < sources.size(); ++i) {
      const auto n = static_cast<std::size_t>(fill.fields[i].n_components);
      for (std::size_t k = 0; k < n; ++k)
        fill.fields[i].values[to * n + k] = sources[i]->values[from * n + k];
    }
    visit(from, to);
  });
  return {};
}

Result<void> check_filled(const GridFill& fill, std::string_view what) {
  const auto hole = std::find(fill.is_filled.begin(), fill.is_filled.end(), 0);
  if (hole == fill.is_filled.end()) return {};
  return fail("{}: expected Pieces that cover the whole extent, got none with {} {}", fill.path,
              what, hole - fill.is_filled.begin());
}

Result<PlacedBox> place_piece(const std::string& path, const VtkExtent& whole,
                              const VtkExtent& piece) {
  PlacedBox box{.dims = piece.dims, .within = whole.dims};
  for (std::size_t i = 0; i < 3; ++i) {
    box.at[i] = piece.first[i] - whole.first[i];
    if (box.at[i] < 0 || box.at[i] + piece.dims[i] > whole.dims[i])
      return fail("{}: expected Pieces inside the whole extent, got one from {} along axis {}",
                  path, piece.first[i], "xyz"[i]);
  }
  return box;
}

/// Values of the cells of all pieces: of their own ones first.
Result<void> fill_cells(const std::vector<GridPiece>& pieces, const std::vector<PlacedBox>& boxes,
                        GridFill& fill) {
  for (const bool takes_ghosts : {false, true})
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const std::vector<MeshField>& fields = pieces[i].content.cell_fields;
      const std::size_t ghosts = find_ghost_type(fields);
      const auto accepts = [&](std::size_t from) {
        return takes_ghosts || ghosts == fields.size() ||
               !is_ghost(fields[ghosts]
                             .values[from * static_cast<std::size_t>(fields[ghosts].n_components)]);
      };
      PlacedBox box = boxes[i];
      box.dims = cell_dims(box.dims);
      box.within = cell_dims(box.within);
      LODE_CHECK(fill_places(fields, box, fill, accepts, [](std::size_t, std::size_t) {}));
    }
  return check_filled(fill, "cell");
}

/// Fails before anything as large as the extent is made when the pieces cannot cover it.
Result<void> check_cover(const std::string& path, std::uint64_t n,
                         const std::vector<GridPiece>& pieces) {
  std::uint64_t n_given = 0;
  for (const GridPiece& piece : pieces) n_given += piece.content.points.size();
  if (n_given >= n) return {};
  return fail("{}: expected Pieces that cover the whole extent of {} points, got {} points", path,
              n, n_given);
}

}  // namespace

Result<std::uint64_t> count_places(const std::string& path, const Index3& dims) {
  std::uint64_t n = 1;
  for (const std::int32_t dim : dims.v) {
    n *= static_cast<std::uint64_t>(dim);
    if (n > kMaxMeshCount)
      return fail("{}: expected at most {} points, got {} x {} x {}", path, kMaxMeshCount, dims[0],
                  dims[1], dims[2]);
  }
  return n;
}

Index3 cell_dims(const Index3& dims) { return dims - Index3{{1, 1, 1}}; }

Result<void> check_solid(const std::string& path, const Index3& dims) {
  for (const std::int32_t dim : dims.v)
    if (dim < 2)
      return fail("{}: expected a grid of at least 2 points along each axis, got {} x {} x {}",
                  path, dims[0], dims[1], dims[2]);
  return {};
}

void make_hexahedra(const Index3& dims, CellMesh& mesh) {
  const Index3 cells = cell_dims(dims);
  const auto nx = static_cast<std::uint32_t>(dims[0]);
  const auto nxy = nx * static_cast<std::uint32_t>(dims[1]);
  const PlacedBox box{.dims = cells, .within = dims};
  mesh.begins = {0};
  for_each_place(box, [&](std::size_t /*cell*/, std::size_t point) {
    const auto a = static_cast<std::uint32_t>(point);
    for (const std::uint32_t b : {a, a + nxy})
      for (const std::uint32_t corner : {b, b + 1, b + 1 + nx, b + nx})
        mesh.corners.push_back(corner);
    mesh.begins.push_back(mesh.corners.size());
    mesh.types.push_back(static_cast<std::uint8_t>(CellType::hexahedron));
  });
}

Result<CellMesh> join_grid(const std::string& path, const VtkExtent& extent,
                           std::vector<GridPiece>&& pieces) {
  LODE_CHECK(check_solid(path, extent.dims));
  LODE_TRY(const std::uint64_t n, count_places(path, extent.dims));
  LODE_CHECK(check_cover(path, n, pieces));
  std::vector<PlacedBox> boxes;
  for (const GridPiece& piece : pieces) {
    LODE_TRY(const PlacedBox box, place_piece(path, extent, piece.extent));
    boxes.push_back(box);
  }
  CellMesh mesh;
  mesh.path = path;
  mesh.points.resize(static_cast<std::size_t>(n));
  const CellMesh& like = pieces.front().content;
  GridFill points = make_fill(path, extent.dims, mesh.points.size(), like.point_fields);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const CellMesh& piece = pieces[i].content;
    LODE_CHECK(fill_places(
        piece.point_fields, boxes[i], points, [](std::size_t) { return true; },
        [&](std::size_t from, std::size_t to) { mesh.points[to] = piece.points[from]; }));
  }
  LODE_CHECK(check_filled(points, "point"));
  make_hexahedra(extent.dims, mesh);
  GridFill cells = make_fill(path, cell_dims(extent.dims), mesh.n_cells(), like.cell_fields);
  LODE_CHECK(fill_cells(pieces, boxes, cells));
  mesh.point_fields = std::move(points.fields);
  mesh.cell_fields = std::move(cells.fields);
  return mesh;
}

}  // namespace lode::io

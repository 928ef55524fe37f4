// Foreign meshes of cells, with solutions of their own file, and scattered points: what is read is
// whole, and tetrahedra are made of it or not.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "lode/core/height_points.h"
#include "lode/io/mesh_reader.h"
#include "lode/io/point_reader.h"
#include "lode/io/tetrahedra.h"
#include "tests/fuzz/fuzz_files.h"
#include "tests/fuzz/fuzz_parts.h"

namespace lode::fuzz {
namespace {

void expect_names(const std::string& message, const std::string& path) {
  expect(message.find(path) != std::string::npos, "an error names the file", message);
}

void check_fields(const std::vector<MeshField>& fields, std::size_t n) {
  for (const MeshField& field : fields)
    expect(field.n_components >= 1 &&
               field.values.size() == n * static_cast<std::size_t>(field.n_components),
           "a field has values for all", field.name);
}

void check_cells(const CellMesh& mesh) {
  expect(mesh.begins.size() == mesh.n_cells() + 1 && mesh.begins.back() == mesh.corners.size(),
         "cells have all corners");
  for (const std::uint32_t corner : mesh.corners)
    expect(corner < mesh.points.size(), "corners are points");
  for (const Vec3d& p : mesh.points)
    for (const double x : p.v) expect(std::isfinite(x), "positions are finite");
  check_fields(mesh.point_fields, mesh.points.size());
  check_fields(mesh.cell_fields, mesh.n_cells());
}

void check_tetrahedra(const TetraMesh& mesh) {
  const std::size_t n = mesh.positions.size();
  for (const auto& tetrahedron : mesh.tetrahedra)
    for (const std::uint32_t v : tetrahedron) expect(v < n, "corners are vertices");
  for (const PatchFace& face : mesh.patch_faces)
    expect(face.patch < mesh.patches.size(), "faces have patches");
  expect(mesh.regions.empty() || mesh.regions.size() == mesh.tetrahedra.size(), "a region each");
  for (const std::uint32_t region : mesh.regions)
    expect(region < mesh.region_ids.size(), "regions have numbers");
  expect(mesh.region_names.empty() || mesh.region_names.size() == mesh.region_ids.size(),
         "a name of each region, or none");
  check_fields(mesh.fields, n);
}

void read_mesh(const std::string& path, const io::MeshReadOptions& options) {
  auto mesh = io::read_cell_mesh(path, options);
  if (!mesh) {
    const std::string& message = mesh.error().message;
    const bool names_solution =
        !options.solution.empty() && message.find(options.solution) != std::string::npos;
    return names_solution ? void() : expect_names(message, path);
  }
  check_cells(*mesh);
  const auto made = io::to_tetrahedra(std::move(*mesh), {.weld_distance = 0, .weld_values = 1});
  if (!made) return expect_names(made.error().message, path);
  check_tetrahedra(made->mesh);
}

}  // namespace

/// The file, of any of the formats: which one it is follows from its content.
void run_cell_mesh(Input input) { read_mesh(fuzz_directory().write("m.meshb", input), {}); }

/// A MEDIT mesh, and its solution.
void run_medit_solution(Input input) {
  const auto [mesh, solution] = split(input);
  read_mesh(fuzz_directory().write("s.meshb", mesh),
            {.solution = fuzz_directory().write("values.solb", solution)});
}

/// LAS, or else text.
void run_points(Input input) {
  const std::string start(reinterpret_cast<const char*>(input.data()),
                          std::min<std::size_t>(4, input.size()));
  const std::string path = fuzz_directory().write(start == "LASF" ? "p.las" : "p.csv", input);
  Progress progress;
  const auto read = io::read_points(path, {}, progress);
  if (!read) return expect_names(read.error().message, path);
  expect(!read->points.empty(), "there are points");
  for (const Vec3d& p : read->points)
    for (const double x : p.v) expect(std::isfinite(x), "points are finite");
  const auto placed = to_height_points(read->points, read->lattice, RepeatedHeights::mean);
  if (!placed) return;
  for (const LatticePoint& node : placed->nodes)
    expect(node.x >= 0 && node.y >= 0 && node.x < placed->n_columns && node.y < placed->n_rows,
           "nodes are of the lattice");
}

}  // namespace lode::fuzz

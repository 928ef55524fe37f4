#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tests/io/cell_mesh_files.h"
#include "tests/oracles/random.h"

namespace lode::io::test {

/// What a random mesh of cubes, [0, n]^3 in all, is made of.
struct MixedOptions {
  std::uint64_t seed = 0;
  int n = 4;
  bool has_turned_wedges = false;  ///< Wound so that the first triangle faces away.
  bool is_mirrored = false;
  bool has_polyhedra = true;  ///< Else hexahedra in their place, and in that of voxels.
};

/// Cubes of which some are hexahedra or voxels, some polyhedra, some six pyramids, and columns of
/// which are two wedges each. Inner points are jittered, and all are numbered at random. The field
/// f is 3 x - 2 y + z + 1.
class MixedMesh {
 public:
  explicit MixedMesh(const MixedOptions& options);
  [[nodiscard]] const CellMesh& mesh() const { return mesh_; }

 private:
  using Cube = std::array<std::uint32_t, 8>;

  void make_points();
  [[nodiscard]] std::uint32_t id(int x, int y, int z) const;
  [[nodiscard]] Cube cube(int x, int y, int z) const;
  void add_column(int x, int y, std::uint64_t kind);
  void add_wedge(std::array<std::uint32_t, 6> w);
  void add_cube(const Cube& c, std::uint64_t kind);
  [[nodiscard]] static std::vector<std::vector<std::uint32_t>> faces_of(const Cube& c);
  /// Faces that begin anywhere, some wound the other way.
  std::vector<std::vector<std::uint32_t>> turned_faces(const Cube& c);
  void add_pyramids(const Cube& c);
  void number_points();

  MixedOptions options_;
  oracles::Random random_;
  CellMesh mesh_;
};

/// The same cells with a node in the middle of each edge, and in that of each face with four
/// corners and each hexahedron if they are full: as VTK numbers them. Those within [0, n]^3 are up
/// to 0.05 aside along each axis; with an n of 0 none is.
[[nodiscard]] CellMesh quadratic_of(const CellMesh& linear, bool is_full, double n);

}  // namespace lode::io::test

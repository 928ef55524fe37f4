#pragma once

// A mesh of simplices as the contract tests look at it: slow, and independent of every model.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <vector>

namespace lode::test {

struct MeshVertex {
  std::array<double, 3> position{};
  double value = 0;

  friend bool operator<(const MeshVertex& a, const MeshVertex& b) {
    return a.position < b.position;
  }
  friend bool operator==(const MeshVertex& a, const MeshVertex& b) {
    return a.position == b.position;
  }
};

struct Mesh {
  using Cell = std::vector<MeshVertex>;

  int dimension = 3;
  std::vector<Cell> cells;

  /// Faces and how many cells have each: 2, or 1 at the end of the mesh.
  [[nodiscard]] std::map<std::vector<MeshVertex>, int> faces() const {
    std::map<std::vector<MeshVertex>, int> count;
    for (const Cell& cell : cells)
      for (std::size_t skip = 0; skip < cell.size(); ++skip) {
        std::vector<MeshVertex> face;
        for (std::size_t i = 0; i < cell.size(); ++i)
          if (i != skip) face.push_back(cell[i]);
        std::sort(face.begin(), face.end());
        ++count[face];
      }
    return count;
  }

  /// The piecewise linear field at a point; nothing outside the mesh.
  [[nodiscard]] std::optional<double> value_at(const std::array<double, 3>& p) const {
    for (const Cell& cell : cells)
      if (const auto value = value_in(cell, p)) return value;
    return {};
  }

 private:
  /// By barycentric coordinates, from ratios of signed volumes.
  [[nodiscard]] std::optional<double> value_in(const Cell& cell,
                                               const std::array<double, 3>& p) const {
    const double whole = volume(cell);
    double value = 0;
    for (std::size_t i = 0; i < cell.size(); ++i) {
      Cell part = cell;
      part[i].position = p;
      const double weight = volume(part) / whole;
      if (weight < -1e-9) return {};
      value += weight * cell[i].value;
    }
    return value;
  }

  [[nodiscard]] double volume(const Cell& cell) const {
    std::array<std::array<double, 3>, 3> e{};
    for (std::size_t i = 1; i < cell.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) e[i - 1][k] = cell[i].position[k] - cell[0].position[k];
    if (dimension == 2) return e[0][0] * e[1][1] - e[0][1] * e[1][0];
    return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
           e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
           e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
  }
};

}  // namespace lode::test

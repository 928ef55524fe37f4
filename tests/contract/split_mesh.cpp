#include "tests/contract/split_mesh.h"

#include <algorithm>

#include "lode/core/expects.h"

namespace lode::test {

Triangle Triangle::of(Label a, Label b, Label c) {
  Triangle triangle{{a, b, c}};
  auto& corners = triangle.corners;
  std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  return triangle;
}

SplitMesh::SplitMesh(std::size_t n_labels, std::span<const Triangle> triangles) : stars_(n_labels) {
  for (const Triangle& triangle : triangles) add(triangle);
}

std::vector<Label> SplitMesh::neighbours(Label v) const {
  std::set<Label> found;
  for (const Triangle& triangle : stars_[v])
    found.insert(triangle.corners.begin(), triangle.corners.end());
  found.erase(v);
  return {found.begin(), found.end()};
}

std::vector<Triangle> SplitMesh::triangles() const {
  std::vector<Triangle> result;
  for (std::size_t v = 0; v < stars_.size(); ++v)
    for (const Triangle& triangle : stars_[v])
      if (triangle.corners[0] == v) result.push_back(triangle);
  return result;
}

void SplitMesh::replace(std::span<const Triangle> old, std::span<const Triangle> replacement) {
  for (const Triangle& triangle : old) remove(triangle);
  for (const Triangle& triangle : replacement) add(triangle);
}

void SplitMesh::add(const Triangle& triangle) {
  for (const Label v : triangle.corners) {
    const bool is_new = stars_[v].insert(triangle).second;
    LODE_EXPECTS(is_new);
  }
}

void SplitMesh::remove(const Triangle& triangle) {
  for (const Label v : triangle.corners) {
    const bool was_there = stars_[v].erase(triangle) == 1;
    LODE_EXPECTS(was_there);
  }
}

}  // namespace lode::test

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "lode/delaunay/predicates.h"
#include "lode/delaunay/tin.h"
#include "lode/locate/tin_locator.h"
#include "lode/models/terrain/insertions/history.h"

namespace lode::insertions {

/// Finds the triangle that a descent begins with.
class StartFinder {
 public:
  /// Of the mesh that descents begin at; corners are the history's vertices.
  StartFinder(const History& history, std::span<const std::array<std::uint32_t, 3>> triangles);

  /// The number of a triangle that holds p, by its place among those given; none outside.
  [[nodiscard]] std::optional<std::uint32_t> find(const delaunay::Point& p) const {
    return mesh_->locator.find(p);
  }
  [[nodiscard]] std::uint64_t n_bytes() const;

 private:
  struct Mesh {
    delaunay::Tin tin;
    TinLocator locator;

    explicit Mesh(delaunay::Tin given) : tin(std::move(given)), locator(tin) {}
  };
  std::unique_ptr<const Mesh> mesh_;
};

}  // namespace lode::insertions

#pragma once

// The diamond models as the contract tests see them.

#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "lode/models/diamond/build.h"
#include "lode/models/diamond/persist.h"
#include "lode/models/diamond/refinable.h"
#include "lode/store/reader.h"
#include "tests/contract/mesh.h"

namespace lode::test {

template <int D>
class DiamondContract {
 public:
  static constexpr int kDimension = D;
  /// Whatever a node needs has at least its error.
  static constexpr bool kIsNestedAlongParents = true;
  /// A random volume of an awkward shape.
  static DiamondContract make(std::uint32_t seed, Threads threads) {
    std::mt19937 random(seed);
    RegularGrid grid;
    grid.dims = D == 3 ? Index3{{11, 6, 9}} : Index3{{37, 1, 21}};
    grid.spacing = {{0.5, 1, 2}};
    std::vector<float> samples(static_cast<std::size_t>(grid.n_samples()));
    for (float& s : samples) s = static_cast<float>(random() % 1000) / 8;
    const Volume volume = make_volume<float>(grid, samples);
    const auto source = make_memory_source(volume);
    Progress progress;
    auto model = diamond::build<D>(*source, {.threads = threads}, progress);
    return DiamondContract(std::move(model).value());
  }

  Result<void> save(const std::string& path) const {
    Progress progress;
    return diamond::save<D>(*model_, path, {2}, progress);
  }
  static Result<DiamondContract> open(const std::string& path) {
    Progress progress;
    LODE_TRY(const auto reader, store::Reader::open(path));
    LODE_TRY(auto model, diamond::load<D>(reader, {2}, progress));
    return DiamondContract(std::move(model));
  }

  [[nodiscard]] diamond::Refinable<D> refinable() const { return diamond::Refinable<D>(*model_); }

  /// The mesh of a cut; each vertex's id is its place in the lattice.
  [[nodiscard]] Mesh mesh(const diamond::Refinable<D>& opened, const Cut& cut) const {
    Mesh mesh{D, {}};
    for (const diamond::Simplex<D>& s : opened.leaves(cut)) {
      Mesh::Cell cell;
      for (const auto& v : s.v) cell.push_back(vertex(v));
      mesh.cells.push_back(cell);
    }
    return mesh;
  }

  /// Whether a face may belong to one cell only: it bounds the root cube, or lies beyond the data
  /// (cells that miss the data are not part of a mesh).
  [[nodiscard]] bool may_end_at(const std::vector<MeshVertex>& face) const {
    for (int i = 0; i < D; ++i) {
      bool is_first = true;
      bool is_beyond = true;
      for (const MeshVertex& v : face) {
        const auto x = static_cast<std::int32_t>(v.position[diamond::as_size(i)]);
        is_first = is_first && x == 0;
        is_beyond = is_beyond && x >= model_->shape.dims[diamond::as_size(i)] - 1;
      }
      if (is_first || is_beyond) return true;
    }
    return false;
  }

  /// All samples, as vertices of the finest mesh.
  [[nodiscard]] std::vector<MeshVertex> samples() const {
    std::vector<MeshVertex> result;
    for (std::size_t i = 0; i < diamond::n_points<D>(model_->shape.dims); ++i)
      result.push_back(vertex(diamond::point_of<D>(model_->shape.dims, i)));
    return result;
  }

 private:
  explicit DiamondContract(diamond::Model<D> model)
      : model_(std::make_unique<diamond::Model<D>>(std::move(model))) {}

  [[nodiscard]] MeshVertex vertex(const diamond::Index<D>& p) const {
    MeshVertex v;
    for (std::size_t i = 0; i < diamond::as_size(D); ++i) v.position[i] = p[i];
    v.value = model_->value(p);
    return v;
  }

  std::unique_ptr<diamond::Model<D>> model_;
};

}  // namespace lode::test

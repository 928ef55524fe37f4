#include "lode/models/diamond/cube_cells.h"

#include <bit>
#include <memory>

#include "lode/models/diamond/brick_nodes.h"
#include "lode/models/diamond/model_samples.h"

namespace lode::diamond {
namespace {

/// Finds the cells of one brick after another.
class CellSearch {
 public:
  CellSearch(const Selection<3>& selection, const LatticeFrame& frame, double limit)
      : samples_(selection.model()),
        all_samples_(selection.model()),
        nodes_(selection),
        meter_(frame, selection.isovalue()),
        limit_(limit) {}

  /// Calls put(cell at the row's begin, whole cells within the limit, others that are met).
  template <typename Put>
  void run(const Index<3>& brick, std::span<const Simplex<3>> simplices, const Put& put) {
    samples_.open(brick);
    const bool is_known = nodes_.open(samples_, simplices);
    if (is_known && !nodes_.is_met()) return;
    Index<3> n;
    for (std::size_t i = 0; i < 3; ++i)
      n[i] = std::min(kBrickEdge<3>, nodes_.model().shape.dims[i] - 1 - samples_.base()[i]);
    for (std::int32_t z = 0; z < n[2]; ++z)
      for (std::int32_t y = 0; y < n[1]; ++y) {
        const Index<3> first = samples_.base() + Index<3>{{0, y, z}};
        if (!is_known) {
          put(first, std::uint32_t{0}, ~std::uint32_t{0});
          continue;
        }
        const std::uint32_t crossed = nodes_.crossed_cells(as_size(y), as_size(z));
        if (crossed == 0) continue;
        const std::uint32_t whole = crossed & whole_cells(as_size(y), as_size(z));
        put(first, within_limit(first, whole), crossed & ~whole);
      }
  }

 private:
  [[nodiscard]] std::uint32_t whole_cells(std::size_t y, std::size_t z) const {
    if (nodes_.finest() > 0) return 0;
    const auto axes = nodes_.simplices_along(y, z);
    return static_cast<std::uint32_t>(axes[0] & axes[1] & axes[2]);
  }
  std::uint32_t within_limit(const Index<3>& first, std::uint32_t cells) {
    for (std::uint32_t left = cells; left != 0; left &= left - 1) {
      Index3 cell = first;
      cell[0] += std::countr_zero(left);
      if (meter_.error_of(all_samples_, cell) > limit_) cells &= ~(left & (~left + 1));
    }
    return cells;
  }

  BrickSamples<3> samples_;
  ModelSamples<3> all_samples_;
  BrickNodes nodes_;
  CubeMeter meter_;
  double limit_;
};

}  // namespace

Result<CubeCells> CubeCells::find(const Selection<3>& selection, const CoarseCut<3>& cut,
                                  std::span<const BrickWork<3>> work, const LatticeFrame& frame,
                                  double limit, Threads threads, Progress& progress) {
  const Model<3>& model = selection.model();
  CubeCells result;
  for (std::size_t i = 0; i < 3; ++i) result.n_cells_[i] = model.shape.dims[i] - 1;
  result.n_words_ = as_size(model.brick_dims[0]);
  const auto n_y = as_size(result.n_cells_[1]);
  const auto n_z = as_size(result.n_cells_[2]);
  result.cubes_.resize(result.n_words_ * n_y * n_z);
  std::vector<std::uint32_t> others(result.cubes_.size());
  std::vector<std::unique_ptr<CellSearch>> workers(as_size(n_workers(threads)));
  parallel_for(work.size(), threads, 1, [&](std::size_t i, int worker) {
    if (progress.is_cancelled()) return;
    auto& search = workers[as_size(worker)];
    if (!search) search = std::make_unique<CellSearch>(selection, frame, limit);
    std::vector<Simplex<3>> simplices;
    for (std::size_t s = work[i].begin; s < work[i].end; ++s)
      simplices.push_back(cut.brick_simplices[s].second);
    search->run(point_of<3>(model.brick_dims, work[i].brick), simplices,
                [&](const Index<3>& first, std::uint32_t cubes, std::uint32_t rest) {
                  result.cubes_[result.word_of(first)] = cubes;
                  others[result.word_of(first)] = rest;
                });
  });
  if (progress.is_cancelled()) return cancelled_error();
  // Not beside others.
  parallel_for(n_z, threads, 8, [&](std::size_t z, int) {
    for (std::size_t y = 0; y < n_y; ++y)
      for (std::size_t word = 0; word < result.n_words_; ++word) {
        const std::size_t row = (z * n_y + y) * result.n_words_;
        const std::uint32_t* const other = others.data() + row + word;
        std::uint32_t beside = *other << 1 | *other >> 1;
        if (word > 0) beside |= other[-1] >> 31;
        if (word + 1 < result.n_words_) beside |= other[1] << 31;
        const auto row_step = static_cast<std::ptrdiff_t>(result.n_words_);
        const auto slice_step = static_cast<std::ptrdiff_t>(result.n_words_ * n_y);
        if (y > 0) beside |= other[-row_step];
        if (y + 1 < n_y) beside |= other[row_step];
        if (z > 0) beside |= other[-slice_step];
        if (z + 1 < n_z) beside |= other[slice_step];
        result.cubes_[row + word] &= ~beside;
      }
  });
  return result;
}

CubeDeviation CubeCells::measure(const Model<3>& model, const LatticeFrame& frame, double isovalue,
                                 Threads threads) const {
  const ModelSamples<3> samples(model);
  std::vector<CubeMeter> meters(as_size(n_workers(threads)), CubeMeter(frame, isovalue));
  parallel_for(as_size(n_cells_[2]), threads, 1, [&](std::size_t z, int worker) {
    for (std::int32_t y = 0; y < n_cells_[1]; ++y)
      for (std::size_t word = 0; word < n_words_; ++word) {
        const Index<3> first{
            {static_cast<std::int32_t>(32 * word), y, static_cast<std::int32_t>(z)}};
        for (std::uint32_t left = cubes_[word_of(first)]; left != 0; left &= left - 1) {
          Index3 cell = first;
          cell[0] += std::countr_zero(left);
          meters[as_size(worker)].add(samples, cell);
        }
      }
  });
  CubeDeviation deviation;
  for (const CubeMeter& meter : meters) deviation.join(meter.deviation());
  return deviation;
}

}  // namespace lode::diamond

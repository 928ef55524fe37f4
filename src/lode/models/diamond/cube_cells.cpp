#include "lode/models/diamond/cube_cells.h"

#include <bit>
#include <cmath>
#include <memory>

#include "lode/models/diamond/brick_nodes.h"
#include "lode/models/diamond/model_samples.h"

namespace lode::diamond {
namespace {

/// Those of one brick after another.
class SamplesOfBrick final : public FieldSamples {
 public:
  explicit SamplesOfBrick(const Model<3>& model) : model_(model), all_(model), samples_(model) {}

  void open(const Index<3>& brick) { samples_.open(brick); }
  [[nodiscard]] const BrickSamples<3>& brick() const { return samples_; }
  [[nodiscard]] const RegularGrid& grid() const override { return model_.info.grid; }
  [[nodiscard]] double sample(const Index3& index) const override {
    return samples_.value(samples_.point(index - samples_.base()).offset);
  }
  void find_corners(const Index3& even, const Index3& step,
                    std::array<double, 8>& values) const override {
    all_.find_corners(even, step, values);
  }
  [[nodiscard]] Index<3> n_cells() const {
    Index<3> n;
    for (std::size_t i = 0; i < 3; ++i)
      n[i] = std::min(kBrickEdge<3>, model_.shape.dims[i] - 1 - samples_.base()[i]);
    return n;
  }

 private:
  const Model<3>& model_;
  ModelSamples<3> all_;
  BrickSamples<3> samples_;
};

/// Calls visit(the cell at its begin) for each row of cells of the brick that is open.
template <typename Visit>
void visit_rows(const SamplesOfBrick& samples, const Visit& visit) {
  const Index<3> n = samples.n_cells();
  for (std::int32_t z = 0; z < n[2]; ++z)
    for (std::int32_t y = 0; y < n[1]; ++y) visit(samples.brick().base() + Index<3>{{0, y, z}});
}

/// Finds the cells of one brick after another.
class CellSearch {
 public:
  CellSearch(const Selection<3>& selection, const LatticeFrame& frame, const CubeLimit& limit,
             const NodeSet<3>* weak)
      : samples_(selection.model()),
        nodes_(selection),
        meter_(frame, selection.isovalue()),
        limit_(limit),
        weak_(weak) {}

  /// Calls put(cell at the row's begin, whole cells within the limit, others that are met).
  template <typename Put>
  void run(const CutBrick<3>& brick, const Put& put) {
    samples_.open(brick.brick);
    const bool is_known = nodes_.open(samples_.brick(), brick.simplices);
    // Of a file's bricks not all samples are there where no cell is crossed: no node as fine as
    // cells is refined in these.
    if (is_known && (!nodes_.is_met() || nodes_.finest() > 0)) return;
    visit_rows(samples_, [&](const Index<3>& first) {
      if (!is_known) {
        put(first, std::uint32_t{0}, ~std::uint32_t{0});
        return;
      }
      const Index<3> local = first - samples_.brick().base();
      const std::uint32_t crossed = nodes_.crossed_cells(as_size(local[1]), as_size(local[2]));
      if (crossed == 0) return;
      const std::uint32_t whole = crossed & whole_cells(as_size(local[1]), as_size(local[2]));
      put(first, within_limit(first, whole), crossed & ~whole);
    });
  }

 private:
  [[nodiscard]] std::uint32_t whole_cells(std::size_t y, std::size_t z) const {
    const auto axes = nodes_.simplices_along(y, z);
    return static_cast<std::uint32_t>(axes[0] & axes[1] & axes[2]);
  }
  std::uint32_t within_limit(const Index<3>& first, std::uint32_t cells) {
    if (limit_.is_none()) return cells;
    if (weak_ != nullptr && !std::isinf(limit_.distance)) cells &= ~weak_cells(first);
    for (std::uint32_t left = cells; left != 0; left &= left - 1) {
      Index3 cell = first;
      cell[0] += std::countr_zero(left);
      if (meter_.exceeds(samples_, cell, limit_)) cells &= ~(left & (~left + 1));
    }
    return cells;
  }
  /// Of a row those with a weak corner.
  [[nodiscard]] std::uint32_t weak_cells(const Index<3>& first) const {
    std::uint64_t samples = 0;
    for (std::int32_t dz = 0; dz < 2; ++dz)
      for (std::int32_t dy = 0; dy < 2; ++dy)
        samples |= weak_->row(first + Index<3>{{0, dy, dz}}, kBrickSamples<3>);
    return static_cast<std::uint32_t>(samples | samples >> 1);
  }

  SamplesOfBrick samples_;
  BrickNodes nodes_;
  CubeMeter meter_;
  CubeLimit limit_;
  const NodeSet<3>* weak_;
};

/// run(worker, brick) in parallel; a worker is made by make() when it is first needed.
template <typename Worker, typename Make, typename Run>
std::vector<std::unique_ptr<Worker>> for_each_brick(std::span<const CutBrick<3>> bricks,
                                                    Threads threads, const Make& make,
                                                    const Run& run) {
  std::vector<std::unique_ptr<Worker>> workers(as_size(n_workers(threads)));
  parallel_for(bricks.size(), threads, 1, [&](std::size_t i, int number) {
    auto& worker = workers[as_size(number)];
    if (!worker) worker = std::make_unique<Worker>(make());
    run(*worker, bricks[i]);
  });
  return workers;
}

}  // namespace

CubeCells::CubeCells(const Shape<3>& shape) {
  for (std::size_t i = 0; i < 3; ++i) n_cells_[i] = shape.dims[i] - 1;
  n_words_ = as_size(brick_counts<3>(shape)[0]);
}

CubeCells CubeCells::all(const Shape<3>& shape) {
  CubeCells result(shape);
  result.are_all_ = true;
  return result;
}

bool CubeCells::are_all(bool has_holes, const CubeLimit& limit) {
  return !has_holes && limit.is_none();
}

Result<CubeCells> CubeCells::find(const Selection<3>& selection,
                                  std::span<const CutBrick<3>> bricks, const LatticeFrame& frame,
                                  const CubeLimit& limit, const NodeSet<3>* weak, Threads threads,
                                  Progress& progress) {
  CubeCells result(selection.model().shape);
  result.cubes_.resize(result.n_words_ * as_size(result.n_cells_[1]) * as_size(result.n_cells_[2]));
  result.are_all_ = are_all(selection.model().has_holes(), limit);
  std::vector<std::uint32_t> others(result.cubes_.size());
  for_each_brick<CellSearch>(
      bricks, threads, [&] { return CellSearch(selection, frame, limit, weak); },
      [&](CellSearch& search, const CutBrick<3>& brick) {
        if (progress.is_cancelled()) return;
        search.run(brick, [&](const Index<3>& first, std::uint32_t cubes, std::uint32_t rest) {
          result.cubes_[result.word_of(first)] = cubes;
          others[result.word_of(first)] = rest;
        });
      });
  if (progress.is_cancelled()) return cancelled_error();
  if (!result.are_all_) result.leave_out_beside(others, threads);
  return result;
}

/// Those that share a face with others.
void CubeCells::leave_out_beside(std::span<const std::uint32_t> others, Threads threads) {
  const auto n_y = as_size(n_cells_[1]);
  const auto n_z = as_size(n_cells_[2]);
  parallel_for(n_z, threads, 8, [&](std::size_t z, int) {
    for (std::size_t y = 0; y < n_y; ++y)
      for (std::size_t word = 0; word < n_words_; ++word) {
        const std::size_t row = (z * n_y + y) * n_words_;
        const std::uint32_t* const other = others.data() + row + word;
        std::uint32_t beside = *other << 1 | *other >> 1;
        if (word > 0) beside |= other[-1] >> 31;
        if (word + 1 < n_words_) beside |= other[1] << 31;
        const auto row_step = static_cast<std::ptrdiff_t>(n_words_);
        const auto slice_step = static_cast<std::ptrdiff_t>(n_words_ * n_y);
        if (y > 0) beside |= other[-row_step];
        if (y + 1 < n_y) beside |= other[row_step];
        if (z > 0) beside |= other[-slice_step];
        if (z + 1 < n_z) beside |= other[slice_step];
        cubes_[row + word] &= ~beside;
      }
  });
}

CubeDeviation CubeCells::measure(const Selection<3>& selection, std::span<const CutBrick<3>> bricks,
                                 const LatticeFrame& frame, Threads threads) const {
  struct Worker {
    SamplesOfBrick samples;
    CubeMeter meter;
  };
  const auto workers = for_each_brick<Worker>(
      bricks, threads,
      [&] {
        return Worker{SamplesOfBrick(selection.model()), CubeMeter(frame, selection.isovalue())};
      },
      [&](Worker& worker, const CutBrick<3>& brick) {
        worker.samples.open(brick.brick);
        visit_rows(worker.samples, [&](const Index<3>& first) {
          for (std::uint32_t left = cubes_[word_of(first)]; left != 0; left &= left - 1) {
            Index3 cell = first;
            cell[0] += std::countr_zero(left);
            worker.meter.add(worker.samples, cell);
          }
        });
      });
  CubeDeviation deviation;
  for (const auto& worker : workers)
    if (worker) deviation.join(worker->meter.deviation());
  return deviation;
}

}  // namespace lode::diamond

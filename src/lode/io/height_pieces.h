#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"
#include "lode/io/proj_library.h"

namespace lode::io {

/// A run of places and heights, to be transformed in place.
struct HeightRun {
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> z;

  void clear() {
    x.clear();
    y.clear();
    z.clear();
  }
  void add(const Vec<double, 2>& at, double height) {
    x.push_back(at[0]);
    y.push_back(at[1]);
    z.push_back(height);
  }
};

/// Transforms pieces of heights in parallel, each thread with PROJ of its own.
class PieceTransformer {
 public:
  /// gather(piece, run) and scatter(piece, heights) are called once for each piece, in any order.
  using Gather = std::function<void(std::size_t, HeightRun&)>;
  using Scatter = std::function<void(std::size_t, const std::vector<double>&)>;

  /// For pieces up to so many at once. Without places heights are transformed alone. The
  /// transformation may go: each thread has a copy, made here, as what is copied is not said to be
  /// safe from several.
  static Result<std::unique_ptr<PieceTransformer>> make(const PJ* transformation, bool has_places,
                                                        std::size_t n_pieces) {
    auto made = std::unique_ptr<PieceTransformer>(new PieceTransformer(has_places));
    const std::size_t n = std::min(n_pieces, static_cast<std::size_t>(n_workers({})));
    for (std::size_t i = 0; i < n; ++i) {
      LODE_TRY(Worker worker, make_worker(transformation));
      made->workers_.push_back(std::move(worker));
    }
    return made;
  }

  /// Says nothing of how far it is, as what it does is a part of something else.
  void be_quiet() { reports_ = false; }

  Result<void> run(std::size_t n, const Gather& gather, const Scatter& scatter,
                   Progress& progress) {
    has_failed_ = false;
    error_.reset();
    std::atomic<std::size_t> n_done{0};
    parallel_for(n, {static_cast<int>(workers_.size())}, 1, [&](std::size_t piece, int number) {
      if (progress.is_cancelled() || has_failed_) return;
      Worker& worker = workers_[static_cast<std::size_t>(number)];
      worker.run.clear();
      gather(piece, worker.run);
      transform(worker);
      if (!has_failed_) scatter(piece, worker.run.z);
      if (reports_)
        progress.report("transforming", static_cast<double>(++n_done) / static_cast<double>(n));
    });
    if (progress.is_cancelled()) return cancelled_error();
    if (error_) return *error_;
    return {};
  }

 private:
  struct Worker {
    Proj proj;
    Proj::Object transformation;  ///< x before y.
    HeightRun run{};
  };

  explicit PieceTransformer(bool has_places) : has_places_(has_places) {}

  [[nodiscard]] static Result<Worker> make_worker(const PJ* transformation) {
    LODE_TRY(Proj proj, Proj::make());
    const ProjLibrary& library = proj.library();
    const Proj::Object copy = proj.own(library.clone(proj.context(), transformation));
    Proj::Object x_first =
        proj.own(copy ? library.with_x_first(proj.context(), copy.get()) : nullptr);
    if (!x_first) return fail("expected PROJ to copy a transformation, got: {}", proj.reason());
    return Worker{std::move(proj), std::move(x_first)};
  }

  void transform(Worker& worker) {
    HeightRun& run = worker.run;
    if (run.z.empty()) return;
    std::vector<double> x = run.x;
    std::vector<double> y = run.y;
    if (!has_places_) {
      std::ranges::fill(x, 0.0);
      std::ranges::fill(y, 0.0);
    }
    constexpr std::size_t kStep = sizeof(double);
    const std::size_t n = run.z.size();
    worker.proj.library().transform(worker.transformation.get(), PJ_FWD, x.data(), kStep, n,
                                    y.data(), kStep, n, run.z.data(), kStep, n, nullptr, 0, 0);
    for (std::size_t i = 0; i < n; ++i)
      if (!std::isfinite(run.z[i]))
        return refuse(
            fail("expected heights where the transformation has a grid, got one at {}, {} off it",
                 run.x[i], run.y[i]));
  }
  void refuse(Error error) {
    const std::scoped_lock lock(mutex_);
    if (!error_) error_ = std::move(error);
    has_failed_ = true;
  }

  bool has_places_;
  bool reports_ = true;
  std::vector<Worker> workers_;
  std::atomic<bool> has_failed_{false};
  std::mutex mutex_;
  std::optional<Error> error_;
};

}  // namespace lode::io

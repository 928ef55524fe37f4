#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>

#include "lode/api/dataset.h"
#include "lode/api/query.h"
#include "lode/core/surface_batch.h"
#include "lode/refine/standing.h"

namespace lode {

/// A query's surface on its way to the answer, step by step: what a session does, without a thread.
/// The model's dimension is hidden.
class LiveQuery {
 public:
  virtual ~LiveQuery() = default;

  /// From the next step on. Exactly one isovalue; the query has been checked.
  virtual void set_query(const Query& query) = 0;
  /// Whether set_query() would leave the surface as it is; else it starts over in new slots.
  [[nodiscard]] virtual bool keeps_surface(const Query& query) const = 0;
  /// False if nothing was left to do; see Standing::awaits_data.
  virtual bool step() = 0;
  /// Until data have come that it may go on with, or a moment.
  virtual void wait(std::chrono::steady_clock::time_point until) = 0;
  /// Calls `wake`, on another thread, whenever data have come; null: no more.
  virtual void on_data(std::function<void()> wake) = 0;
  /// Why data that it waits for will not come.
  [[nodiscard]] virtual std::optional<Error> fault() const = 0;
  [[nodiscard]] virtual Standing standing() const = 0;
  [[nodiscard]] virtual std::size_t n_cells() const = 0;
  [[nodiscard]] virtual std::size_t n_changed() const = 0;
  /// As LiveIsosurface's.
  virtual void write(Surface& surface) const = 0;
  virtual bool gather(std::size_t n_most, SurfaceBatch& batch) = 0;
  virtual void take_back(const SurfaceBatch& batch) = 0;
  /// The largest pixel error of what is left unrefined in sight; looks at all candidates.
  [[nodiscard]] virtual double achieved_px() const = 0;
  /// The share of the applied nodes that lie on the finest level.
  [[nodiscard]] virtual double finest_share() const = 0;
};

struct LiveQueryOptions {
  Normals normals = Normals::on;
  bool with_views = true;
  /// Bytes that pages of a file may take, those of all of a dataset's live queries together; the
  /// newest counts. 0: a quarter of the machine's memory. Each query may hold an equal share, and
  /// gives up what it wants least when others come (Standing::memory_met).
  std::uint64_t memory_limit = 0;
  /// Pages take half of a limit that is given: the rest is for cuts, whose budgets the caller sets.
  bool leaves_half = false;
};

/// A live query at the base, whatever the dataset's model; set_query() comes first. A file that is
/// not loaded is read as the query goes. Tolerances in pixels must be asked for only `with_views`:
/// those take world errors, which files have; of a model in memory they are found first. `dataset`
/// must outlive it.
[[nodiscard]] Result<std::unique_ptr<LiveQuery>> open_live_query(const Dataset& dataset,
                                                                 const LiveQueryOptions& options,
                                                                 Progress& progress);

/// Refuses queries that a live one cannot answer.
[[nodiscard]] Result<void> check_live_query(const Query& query, bool has_views);

}  // namespace lode

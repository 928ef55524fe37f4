#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "lode/api/dataset.h"
#include "lode/api/query.h"
#include "lode/core/surface_batch.h"
#include "lode/refine/standing.h"

namespace lode {

struct SessionOptions {
  Normals normals = Normals::on;
  /// Of a model in memory world errors are found when the session opens, which costs another build;
  /// without them tolerances in pixels are refused.
  bool with_views = true;
  std::uint64_t memory_limit = 0;  ///< As in LiveQueryOptions.
};

/// What has changed since the batch that was taken before, and what the surface then answers.
struct SessionBatch {
  std::uint64_t query = 0;  ///< The number that set_query() gave.
  Standing standing;        ///< Of the engine when the batch was complete.
  SurfaceBatch change;
  std::uint64_t generation = 0;  ///< Of the slots, see SurfaceBatch::starts_over.
  /// Why data that the query waits for (Standing::awaits_data) will not come: of a file. Or that
  /// there was no memory to go on: then it is the session's last batch.
  std::optional<Error> fault;
};

/// A surface that is refined by a thread of its own while another one shows it. At any moment the
/// batches taken so far add up to a consistent surface, that of some moment of one query; it may
/// reach beyond the data's border, where its nodes have not been refined yet (clip it there).
///
/// All members may be called from one thread that is not the session's; take() and set_query() do
/// one atomic exchange each and never wait. Changes of the query take effect at the next step; all
/// but a few steps are far shorter than a millisecond (docs/engine.md). Another isovalue starts
/// from the base, everything else from wherever the surface is. A file that is not loaded is read
/// as the query goes (see open_live_query()): no step waits for it. Where there is not enough
/// memory the session ends with a batch that says so; queries are refused from then on.
class Session {
 public:
  /// Starts refining. `dataset` must outlive the session; several may share it. Queries must have
  /// exactly one isovalue.
  [[nodiscard]] static Result<Session> open(const Dataset& dataset, const Query& query,
                                            const SessionOptions& options, Progress& progress);
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;
  /// Stops within a step.
  ~Session();

  /// Redirects the session and returns the query's number; the first query is number 1.
  [[nodiscard]] Result<std::uint64_t> set_query(const Query& query);

  /// The newest complete batch, or null if there is none that was not taken.
  [[nodiscard]] std::unique_ptr<SessionBatch> take();

 private:
  class Impl;
  explicit Session(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace lode

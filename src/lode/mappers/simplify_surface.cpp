#include "lode/mappers/simplify_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lode/core/stopwatch.h"
#include "lode/mappers/collapse_block.h"
#include "lode/mappers/collapse_crossings.h"
#include "lode/mappers/collapse_mesh.h"
#include "lode/mappers/collapse_partition.h"
#include "lode/mappers/collapse_proof.h"
#include "lode/mappers/collapse_turning.h"
#include "lode/mappers/collapse_undo.h"
#include "lode/mappers/collapse_units.h"

namespace lode {
namespace simplification {
namespace {

/// Blocks have about as many triangles: their data fit a core's cache, and their borders, where
/// nothing collapses until the next round, are short.
constexpr double kBlockTriangles = 8000;
/// Collapses and proofs: where a proof fails and collapses are taken back, others are tried.
constexpr int kPasses = 2;
/// Blocks of one round, in edges of those of the first: what is on their borders stays as it is.
/// They grow with what is left, and no border is where one of the rounds before was.
struct Round {
  double edge;
  double shift;
};
constexpr std::array<Round, 4> kFirstRounds{{{1, 0}, {1.5, 0.75}, {2, 0.5}, {2, 1.5}}};
constexpr std::array<Round, 1> kLaterRounds{{{2, 1}}};
/// How far attached vertices may be, of the distance allowed: what lies between them may be
/// farther. On bonsai at one voxel, 0.9 leaves fewer triangles than 1 and takes half the undoing.
constexpr double kReach = 0.9;

class Simplifier {
 public:
  /// `numbers`: of a piece; null for a whole surface.
  Simplifier(Surface& surface, const SimplifyOptions& options, std::vector<std::uint32_t>* numbers,
             Progress& progress)
      : surface_(surface),
        options_(options),
        numbers_(numbers),
        progress_(progress),
        mesh_(make_mesh(surface, options.threads)),
        closed_(surface) {}

  Result<SimplifyReport> run() {
    report_.max_distance = options_.max_distance;
    report_.triangles_before = surface_.triangles.size();
    has_reopened_ = true;
    for (int pass = 0; pass < kPasses && has_reopened_; ++pass) LODE_CHECK(run_pass(pass));
    if (meets_itself_already_) LODE_CHECK(count_input_crossings());
    const Stopwatch finishing;
    finish();
    report_.seconds.finish = finishing.seconds();
    report_.triangles = surface_.triangles.size();
    report_.collapses -= report_.undone;
    return report_;
  }

 private:
  /// What taking collapses back changes.
  struct State {
    UninitializedArray<Vec3f> positions;
    UninitializedArray<WorkTriangle> triangles;
    UninitializedArray<std::uint32_t> next_point;
    UninitializedArray<std::uint32_t> attached_to;
    UninitializedArray<std::uint32_t> last;
    SimplifyReport report;
  };

  Result<void> run_pass(int pass);
  [[nodiscard]] State state() const;
  void restore(State state);
  Result<void> collapse(int pass);
  void collapse_round(const Partition& partition, bool attaches, const BlockLimits& limits);
  [[nodiscard]] double reach() const;
  Result<bool> prove(std::uint32_t first);
  void add_live(std::span<const std::uint32_t> changed);
  void reopen(std::span<const std::uint32_t> changed);
  Result<void> count_input_crossings();
  void finish();
  void finish_vertices();

  Surface& surface_;
  const SimplifyOptions& options_;
  std::vector<std::uint32_t>* numbers_;
  Progress& progress_;
  CollapseMesh mesh_;
  ClosedComponents closed_;
  SimplifyReport report_;
  std::uint32_t next_collapse_ = 0;
  UndoOrder order_ = UndoOrder::splits;
  std::vector<std::uint32_t> live_;      ///< Triangles that are there, while they are proven.
  std::vector<std::uint8_t> is_open_;    ///< By vertex: to be tried in the next pass; empty: all.
  std::vector<std::uint8_t> is_failed_;  ///< By vertex: of a collapse that failed a proof.
  bool has_reopened_ = false;
  bool meets_itself_already_ = false;
};

/// In a band taking back may get stuck, which is rare: then the first pass takes back in the order
/// of stars from the beginning, and a later one leaves what the one before has proven.
Result<void> Simplifier::run_pass(int pass) {
  const bool may_stick = options_.band != nullptr && order_ == UndoOrder::splits;
  const std::uint32_t first = next_collapse_;
  const Stopwatch collapsing;
  std::optional<State> saved;
  if (may_stick && pass > 0) saved = state();
  LODE_CHECK(collapse(pass));
  report_.seconds.collapse += collapsing.seconds();
  if (may_stick && pass == 0) saved = state();
  const Stopwatch checking;
  LODE_TRY(const bool is_proven, prove(first));
  if (!is_proven) {
    restore(std::move(*saved));
    has_reopened_ = false;
    if (pass > 0) return {};
    order_ = UndoOrder::stars;
    LODE_CHECK(prove(first));
  }
  report_.seconds.check += checking.seconds();
  return {};
}

Simplifier::State Simplifier::state() const {
  return {mesh_.positions,   mesh_.triangles, mesh_.next_point,
          mesh_.attached_to, mesh_.last,      report_};
}

void Simplifier::restore(State state) {
  mesh_.positions = std::move(state.positions);
  mesh_.triangles = std::move(state.triangles);
  mesh_.next_point = std::move(state.next_point);
  mesh_.attached_to = std::move(state.attached_to);
  mesh_.last = std::move(state.last);
  report_ = state.report;
}

Result<void> Simplifier::collapse(int pass) {
  const double area = mean_area(surface_);
  const double edge = std::sqrt(kBlockTriangles * area);
  const auto [lower, upper] = bounds_of(surface_.positions);
  const BlockLimits limits{
      .distance = static_cast<float>(kReach * options_.max_distance),
      .band = options_.band,
      .area = static_cast<float>(area),
      .reach = static_cast<float>(reach()),
      .longest2 = static_cast<float>(options_.longest_edge * options_.longest_edge),
      .is_piece = numbers_ != nullptr,
      .lower = lower,
      .upper = upper,
      .domain = options_.domain};
  const std::span<const Round> rounds =
      pass == 0 ? std::span<const Round>(kFirstRounds) : std::span<const Round>(kLaterRounds);
  for (std::size_t i = 0; i < rounds.size(); ++i) {
    progress_.report("simplifying", static_cast<double>(i) / static_cast<double>(rounds.size()));
    const auto shift = static_cast<float>(edge * rounds[i].shift);
    Partition partition =
        make_partition(mesh_, {{{shift, shift, shift}}, static_cast<float>(edge * rounds[i].edge)},
                       options_.threads);
    if (pass > 0)
      for (std::size_t v = 0; v < is_failed_.size(); ++v) partition.is_locked[v] |= is_failed_[v];
    const bool attaches = pass == 0 && i == 0 && std::isfinite(options_.max_distance);
    collapse_round(partition, attaches, limits);
    if (progress_.is_cancelled()) return cancelled_error();
  }
  return {};
}

/// About how far the surface may move; in a band of unknown width, an edge.
double Simplifier::reach() const {
  if (std::isfinite(options_.max_distance)) return kReach * options_.max_distance;
  return 2 * std::sqrt(mean_area(surface_));
}

void Simplifier::collapse_round(const Partition& partition, bool attaches,
                                const BlockLimits& limits) {
  std::vector<std::uint32_t> first(partition.n_cells());
  for (std::size_t i = 0; i < first.size(); ++i) {
    first[i] = next_collapse_;
    next_collapse_ += static_cast<std::uint32_t>(partition.cell(i).size());  // at most one each
  }
  if (mesh_.collapses.size() < next_collapse_) mesh_.collapses.resize(next_collapse_);
  UninitializedArray<std::uint32_t> local(mesh_.positions.size());
  std::fill(local.begin(), local.end(), kNone);
  std::vector<std::unique_ptr<BlockSimplifier>> workers;
  workers.reserve(static_cast<std::size_t>(n_workers(options_.threads)));
  for (int i = 0; i < n_workers(options_.threads); ++i)
    workers.push_back(std::make_unique<BlockSimplifier>(mesh_, surface_.positions,
                                                        partition.is_locked, local, limits));
  std::vector<std::uint32_t> counts(first.size(), 0);
  parallel_for(first.size(), options_.threads, 1, [&](std::size_t i, int worker) {
    if (partition.cell(i).empty() || progress_.is_cancelled()) return;
    counts[i] = workers[static_cast<std::size_t>(worker)]->run(
        {partition.cell(i), first[i], attaches, is_open_}, progress_);
  });
  report_.collapses += std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  if (attaches) attach_rest(partition.between, mesh_);
}

/// Proves what collapses from `first` on have made, and takes back what fails; false where that
/// gets stuck.
Result<bool> Simplifier::prove(std::uint32_t first) {
  progress_.report("proving", 0);
  live_ = live_triangles(mesh_, options_.threads);
  CollapseUndo stars(mesh_, surface_, live_, order_, options_.band,
                     static_cast<float>(0.3 * options_.max_distance));
  CollapseProof proof(surface_, mesh_, stars, options_, 2.5 * std::sqrt(mean_area(surface_)), first,
                      progress_);
  std::vector<std::uint32_t> changed;
  for (const std::uint32_t t : live_) {
    const std::uint32_t maker = stars.maker(t);
    if (maker != kNone && maker >= first) changed.push_back(t);
  }
  is_open_.assign(mesh_.positions.size(), 0);
  is_failed_.resize(mesh_.positions.size(), 0);
  has_reopened_ = false;
  while (!changed.empty()) {
    if (progress_.is_cancelled()) return cancelled_error();
    LODE_TRY(auto bad, proof.find_bad(live_, changed));
    // When all else is proven, as that takes more back.
    if (bad.empty())
      for (const std::uint32_t v : closed_.removed_where_turned(mesh_, live_))
        bad.push_back(mesh_.last[v]);
    changed.clear();
    for (const std::uint32_t c : bad) {
      if (progress_.is_cancelled()) return cancelled_error();
      const Collapse& collapse = mesh_.collapses[c];
      if (mesh_.last[collapse.removed] != c) continue;  // another has taken it with it
      is_failed_[collapse.kept] = is_failed_[collapse.removed] = 1;
      report_.undone += stars.undo(c, changed);
      if (stars.is_stuck()) return false;
    }
    sort_unique(changed);
    add_live(changed);
    reopen(changed);
  }
  report_.proven_distance = std::max(report_.proven_distance, proof.proven_distance());
  report_.proven_error = std::max(report_.proven_error, proof.proven_error());
  meets_itself_already_ = meets_itself_already_ || proof.meets_itself_already();
  return true;
}

/// Undoing brings triangles back, and takes none away.
void Simplifier::add_live(std::span<const std::uint32_t> changed) {
  std::vector<std::uint32_t> all;
  all.reserve(live_.size() + changed.size());
  std::ranges::set_union(live_, changed, std::back_inserter(all));
  live_ = std::move(all);
}

/// Lets the next pass try other collapses here.
void Simplifier::reopen(std::span<const std::uint32_t> changed) {
  for (const std::uint32_t t : changed)
    for (const std::uint32_t v : mesh_.triangles[t].v) is_open_[v] = 1;
  has_reopened_ = has_reopened_ || !changed.empty();
}

Result<void> Simplifier::count_input_crossings() {
  live_ = live_triangles(mesh_, options_.threads);
  LODE_TRY(const auto crossings, find_crossings(mesh_, live_, live_, options_.threads, progress_));
  report_.input_crossings = crossings.size();
  return {};
}

void Simplifier::finish_vertices() {
  std::vector<Vec3f>& normals = surface_.normals;
  for (std::uint32_t v = 0; v < normals.size(); ++v)
    if (mesh_.is_removed(v)) {
      const std::uint32_t root = mesh_.root_of(v);
      normals[root] = normals[root] + normals[v];
    }
  for (std::uint32_t v = 0; v < normals.size(); ++v)
    if (mesh_.last[v] != kNone) normals[v] = normalized(normals[v]);
}

void Simplifier::finish() {
  // All the memory that is needed, while the surface is as it was.
  std::vector<std::uint32_t> number(mesh_.positions.size(), kNone);
  finish_vertices();
  std::uint32_t n = 0;
  for (std::uint32_t v = 0; v < number.size(); ++v) {
    if (mesh_.is_removed(v)) continue;
    surface_.positions[n] = mesh_.positions[v];
    if (!surface_.normals.empty()) surface_.normals[n] = surface_.normals[v];
    if (!surface_.isovalues.empty()) surface_.isovalues[n] = surface_.isovalues[v];
    number[v] = n++;
  }
  surface_.positions.resize(n);
  if (!surface_.normals.empty()) surface_.normals.resize(n);
  if (!surface_.isovalues.empty()) surface_.isovalues.resize(n);
  std::size_t n_triangles = 0;
  for (const WorkTriangle& t : mesh_.triangles)
    if (!t.is_dead())
      surface_.triangles[n_triangles++] = {number[t.v[0]], number[t.v[1]], number[t.v[2]]};
  surface_.triangles.resize(n_triangles);
  if (numbers_ != nullptr) *numbers_ = std::move(number);
}

Result<SimplifyReport> simplify(Surface& surface, const SimplifyOptions& options,
                                std::vector<std::uint32_t>* numbers, Progress& progress) {
  LODE_EXPECTS(surface.lines.empty() && surface.values.empty() && surface.origins.empty() &&
               surface.errors.empty());
  LODE_EXPECTS(options.max_distance > 0);
  LODE_EXPECTS(options.band != nullptr || std::isfinite(options.max_distance));
  if (surface.triangles.empty()) {
    SimplifyReport report;
    report.max_distance = options.max_distance;
    if (options.band != nullptr) report.max_error = options.band->limit();
    return report;
  }
  // Corners, and collapses that were tried, are numbered by 32 bits.
  constexpr std::size_t kMostTriangles = 800'000'000;
  if (surface.triangles.size() > kMostTriangles)
    return fail("simplification: expected at most {} triangles, got {}: give it a tolerance",
                kMostTriangles, surface.triangles.size());
  const UnitEdges units(surface);
  SimplifyOptions scaled = options;
  scaled.max_distance = units.to_units(options.max_distance);
  scaled.longest_edge = units.to_units(options.longest_edge);
  std::optional<ScaledBand> band;
  if (options.band != nullptr) scaled.band = &band.emplace(*options.band, units.from_units(1));
  std::optional<ConvexDomain> domain;
  if (options.domain != nullptr) {
    scaled.domain = &domain.emplace(*options.domain);
    for (Vec3d& along : domain->along) along = along * units.from_units(1);
  }
  LODE_TRY(SimplifyReport report, Simplifier(surface, scaled, numbers, progress).run());
  report.max_distance = options.max_distance;
  if (options.band != nullptr) report.max_error = options.band->limit();
  report.proven_distance = units.from_units(report.proven_distance);
  return report;
}

}  // namespace
}  // namespace simplification

void SimplifyReport::join(const SimplifyReport& other) {
  max_distance = std::max(max_distance, other.max_distance);
  start_distance = std::max(start_distance, other.start_distance);
  triangles_before += other.triangles_before;
  triangles += other.triangles;
  collapses += other.collapses;
  undone += other.undone;
  proven_distance = std::max(proven_distance, other.proven_distance);
  max_error = std::max(max_error, other.max_error);
  proven_error = std::max(proven_error, other.proven_error);
  components_dropped += other.components_dropped;
  triangles_dropped += other.triangles_dropped;
  input_crossings += other.input_crossings;
  by_pieces = by_pieces || other.by_pieces;
  seconds.collapse += other.seconds.collapse;
  seconds.check += other.seconds.check;
  seconds.finish += other.seconds.finish;
}

Result<SimplifyReport> simplify_surface(Surface& surface, const SimplifyOptions& options,
                                        Progress& progress) {
  return simplification::simplify(surface, options, nullptr, progress);
}

Result<SimplifyReport> simplify_piece(Surface& surface, const SimplifyOptions& options,
                                      std::vector<std::uint32_t>& numbers, Progress& progress) {
  numbers.resize(surface.positions.size());
  std::iota(numbers.begin(), numbers.end(), 0U);
  return simplification::simplify(surface, options, &numbers, progress);
}

}  // namespace lode

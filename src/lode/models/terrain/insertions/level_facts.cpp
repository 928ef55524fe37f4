#include <algorithm>

#include "lode/mappers/tin_quality.h"
#include "lode/models/terrain/insertions/extract.h"
#include "lode/models/terrain/insertions/persist.h"
#include "lode/models/terrain/insertions/tolerance_steps.h"

namespace lode::insertions {
namespace {

LevelFacts facts_at(const History& history, double tolerance, std::uint32_t time) {
  const delaunay::Tin tin = tin_at(history, time, delaunay::TinLinks::kept);
  const TinAngles angles = measure_angles(tin, history.frame, {});
  if (!history.is_worst_first())
    tolerance = static_cast<double>(*std::ranges::max_element(tin.errors));
  return {tolerance, static_cast<std::uint32_t>(tin.triangles.size()),
          static_cast<std::uint32_t>(tin.vertices.size()), angles.smallest, angles.median};
}

}  // namespace

Result<std::vector<LevelFacts>> find_facts(const LevelledHistory& levelled, Progress& progress) {
  const History& history = levelled.history;
  const std::vector<ToleranceStep> steps = find_tolerance_steps(history);
  std::vector<LevelFacts> facts;
  for (const double tolerance : levelled.levels) {
    if (progress.is_cancelled()) return cancelled_error();
    facts.push_back(facts_at(history, tolerance, step_within(steps, tolerance).time));
  }
  for (const std::uint32_t end : history.level_ends) {
    if (progress.is_cancelled()) return cancelled_error();
    facts.push_back(facts_at(history, 0, end));
  }
  return facts;
}

}  // namespace lode::insertions
